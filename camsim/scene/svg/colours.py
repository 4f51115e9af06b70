"""Colours of drawings: as sRGB, and as reflectances."""

from __future__ import annotations

import re
from typing import TypeAlias

import numpy as np

from camsim.errors import InvalidValueError
from camsim.spectra.curve import Spectrum
from camsim.spectra.rgb import linear_of_srgb, reflectance_of_rgb

Rgb: TypeAlias = tuple[int, int, int]


def rgb(text: str) -> Rgb:
    """Return an opaque colour of CSS as sRGB of 8 bits.

    >>> rgb("#f80"), rgb("rgb(100%, 0%, 0%)"), rgb("rebeccapurple")
    ((255, 136, 0), (255, 0, 0), (102, 51, 153))
    """
    colour, opaque = rgb_and_alpha(text)
    if opaque < 1.0:
        raise InvalidValueError(f"the colour {text[:40]!r} is translucent; paint it in the colour that this makes")
    return colour


def rgb_and_alpha(text: str) -> tuple[Rgb, float]:
    """Return a colour of CSS as sRGB of 8 bits, and how opaque it is.

    >>> rgb_and_alpha("rgba(0, 64, 255, 0.25)"), rgb_and_alpha("#0000"), rgb_and_alpha("rgb(1 2 3 / 100%)")
    (((0, 64, 255), 0.25), ((0, 0, 0), 0.0), ((1, 2, 3), 1.0))
    """
    from PIL import ImageColor

    plain, alpha = text.strip().lower(), 1.0
    try:
        if match := re.fullmatch(r"(rgb|hsl)a?\(([^()]*)\)", plain):
            parts = re.split(r"[\s,/]+", match[2].strip())
            plain = f"{match[1]}({','.join(parts[:3])})"
            if len(parts) == 4:
                alpha = float(parts[3].removesuffix("%")) * (0.01 if parts[3].endswith("%") else 1.0)
            elif len(parts) != 3:
                raise ValueError
        red, green, blue, *more = ImageColor.getrgb(plain)
    except ValueError:
        raise InvalidValueError(f"{text[:40]!r} is no colour; write #rrggbb or a name of CSS") from None
    return (red, green, blue), min(max(more[0] / 255 if more else alpha, 0.0), 1.0)


def reflectance(colour: Rgb) -> Spectrum:
    """Return the reflectance of a colour (``camsim.spectra.rgb``).

    >>> reflectance((255, 255, 255)), reflectance((0, 0, 0))
    (1.0, 0.0)
    """
    linear = linear_of_srgb(np.array(colour) / 255.0)
    return reflectance_of_rgb(linear.tolist(), "#{:02x}{:02x}{:02x}".format(*colour))
