"""Colours of drawings: as sRGB, and as reflectances."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from camsim.errors import InvalidValueError
from camsim.spectra.curve import Spectrum
from camsim.spectra.rgb import linear_of_srgb, reflectance_of_rgb

Rgb: TypeAlias = tuple[int, int, int]


def rgb(text: str) -> Rgb:
    """Return a colour of CSS as sRGB of 8 bits.

    >>> rgb("#f80"), rgb("rgb(100%, 0%, 0%)"), rgb("rebeccapurple")
    ((255, 136, 0), (255, 0, 0), (102, 51, 153))
    """
    from PIL import ImageColor

    try:
        red, green, blue, *alpha = ImageColor.getrgb(text.strip().lower())
    except ValueError:
        raise InvalidValueError(f"{text[:40]!r} is no colour; write #rrggbb or a name of CSS") from None
    if alpha and alpha[0] != 255:
        raise InvalidValueError(f"the colour {text[:40]!r} is translucent; paint it in the colour that this makes")
    return red, green, blue


def reflectance(colour: Rgb) -> Spectrum:
    """Return the reflectance of a colour (``camsim.spectra.rgb``).

    >>> reflectance((255, 255, 255)), reflectance((0, 0, 0))
    (1.0, 0.0)
    """
    linear = linear_of_srgb(np.array(colour) / 255.0)
    return reflectance_of_rgb(linear.tolist(), "#{:02x}{:02x}{:02x}".format(*colour))
