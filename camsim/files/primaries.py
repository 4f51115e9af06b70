"""Primaries and white of colours, as stored by PNG, TIFF and OpenEXR."""

from __future__ import annotations

from collections.abc import Sequence

_SRGB = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)
_SAME = 5e-3


def other_than_srgb(x_y: Sequence[float], where: str) -> str:
    """Return a text on a file's primaries if they are not sRGB's; empty if they are, or are not stated.

    x_y : x and y of red, green, blue and white, empty if not stated;  where: name of their source

    >>> other_than_srgb((0.64, 0.33, 0.21, 0.71, 0.15, 0.06, 0.3127, 0.329), "cHRM")
    'cHRM, other primaries or another white'
    """
    if not x_y or all(abs(one - its) <= _SAME for one, its in zip(x_y, _SRGB, strict=True)):
        return ""
    return f"{where}, other primaries or another white"
