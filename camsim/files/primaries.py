"""Primaries and white of colours, as PNG, TIFF and OpenEXR note them beside the pixels."""

from __future__ import annotations

from collections.abc import Sequence

_SRGB = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)
_SAME = 5e-3


def other_than_srgb(x_y: Sequence[float], where: str) -> str:
    """Return what a file's colours are, in words, where they are not sRGB's; empty where they are, or none are said.

    x_y : x and y of red, green, blue and white, none where the file does not say them;  where: what noted them

    >>> other_than_srgb((0.64, 0.33, 0.21, 0.71, 0.15, 0.06, 0.3127, 0.329), "cHRM")
    'cHRM, other primaries or another white'
    """
    if not x_y or all(abs(one - its) <= _SAME for one, its in zip(x_y, _SRGB, strict=True)):
        return ""
    return f"{where}, other primaries or another white"
