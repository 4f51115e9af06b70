"""Colours of drawings: as sRGB, and as reflectances."""

from __future__ import annotations

import colorsys
import re
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from camsim.errors import InvalidValueError
from camsim.scene.svg.outline import share
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

    >>> rgb_and_alpha("rgba(0, 64, 255, 0.25)"), rgb_and_alpha("#0000"), rgb_and_alpha("hsl(0 0% 12.5% / 100%)")
    (((0, 64, 255), 0.25), ((0, 0, 0), 0.0), ((32, 32, 32), 1.0))
    """
    from PIL import ImageColor

    plain = text.strip().lower()
    try:
        if match := re.fullmatch(r"(rgb|hsl)a?\(([^()]*)\)", plain):
            return _of_function(match[1], match[2])
        if not re.fullmatch(r"#[0-9a-f]+|[a-z]+", plain):  # what else has a name there CSS does not know
            raise ValueError
        red, green, blue, *more = ImageColor.getrgb(plain)
    except (ValueError, InvalidValueError):
        raise InvalidValueError(f"{text[:40]!r} is no colour; write #rrggbb or a name of CSS") from None
    return (red, green, blue), more[0] / 255 if more else 1.0


def _of_function(name: str, inside: str) -> tuple[Rgb, float]:
    """Return the colour of rgb() or hsl(), with commas or with spaces and a slash; what lies beyond is clipped."""
    commas, (first, slash, last) = "," in inside, inside.partition("/")
    parts = inside.split(",") if commas else [*first.split(), *([last] if slash else [])]
    if len(parts) - bool(slash) != 3 and not (commas and len(parts) == 4 and not slash):
        raise ValueError
    percent = [part.strip().endswith("%") for part in parts[:3]]
    if name == "hsl":
        if percent != [False, True, True]:
            raise ValueError
        hue = share(parts[0].strip().removesuffix("deg")) / 360.0 % 1.0
        shares: Sequence[float] = colorsys.hls_to_rgb(hue, *(min(max(share(parts[k]), 0.0), 1.0) for k in (2, 1)))
    else:
        if len(set(percent)) > 1:
            raise ValueError
        shares = tuple(share(part) / (1.0 if percent[0] else 255.0) for part in parts[:3])
    red, green, blue = (int(255.0 * min(max(one, 0.0), 1.0) + 0.5) for one in shares)
    return (red, green, blue), min(max(share(parts[3]), 0.0), 1.0) if len(parts) == 4 else 1.0


def reflectance(colour: Rgb) -> Spectrum:
    """Return the reflectance of a colour (``camsim.spectra.rgb``).

    >>> reflectance((255, 255, 255)), reflectance((0, 0, 0))
    (1.0, 0.0)
    """
    linear = linear_of_srgb(np.array(colour) / 255.0)
    return reflectance_of_rgb(linear.tolist(), "#{:02x}{:02x}{:02x}".format(*colour))
