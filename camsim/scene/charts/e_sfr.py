"""A chart of slanted edges after ISO 12233: squares, slanted stars and grey steps."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from camsim.core.typed import Fraction, Point, Positive
from camsim.scene.charts.chart import Card, Place, chart, refused, with_densities
from camsim.scene.primitives import Shape
from camsim.scene.shapes import Sector
from camsim.spectra.curve import Reflectance, Spectrum

_SLANT_DEG = 5.0
_STEPS = 20


@chart
def e_sfr(
    *,
    height_um: Positive,
    aspect: Positive = 1.5,
    stars: bool = True,
    dark: Reflectance = 0.14,
    light: Reflectance = 0.56,
    darkest: Fraction = 0.03,
    lightest: Fraction = 0.9,
    centre_um: Point = (0.0, 0.0),
) -> Iterator[Shape]:
    """Draw slanted squares over the frame, a slanted star in the middle and in the corners, and a circle of greys.

    After ISO 12233: edges 5° off the axes, contrast 4 : 1; the slanted star of the edition of 2023, whose edges lie 5°
    off the axes and off the diagonals, so that radial and tangential edges are among them. The standard's sizes and
    places are not public: those here are camsim's own. There are no hyperbolic wedges.

    height_um : height of the chart
    aspect    : width of the chart over its height
    stars     : whether the middle and the corners have stars (2023), or squares like the rest (2014)
    dark, light : reflectances of the squares and stars, and of the card
    darkest, lightest : reflectances of the first and the last of 20 grey steps, even in density between

    >>> len(e_sfr(height_um=1000.0).shapes)
    49
    """
    with_densities(e_sfr, darkest=darkest, lightest=lightest)
    if aspect < 1.0:
        raise refused(e_sfr, "aspect", f"is {aspect:g}, too narrow: its squares would lie over one another; at least 1")
    card = Card(centre_um)
    width_um = aspect * height_um
    yield card.rectangle(width_um, height_um, (0.0, 0.0), light)
    side, radius = 0.13 * height_um, 0.085 * height_um
    x, y = 0.5 * width_um - 0.13 * height_um, 0.37 * height_um
    corners = [(-x, -y), (x, -y), (-x, y), (x, y)]
    rest = [(0.0, -y), (0.0, y), (-x, 0.0), (x, 0.0)]
    rest += [(sx * 0.52 * x, sy * y) for sx in (-1.0, 1.0) for sy in (-1.0, 1.0)]
    for at_um in rest if stars else (*rest, *corners, (0.0, 0.0)):
        yield card.rectangle(side, side, at_um, dark, _SLANT_DEG)
    for at_um in ((0.0, 0.0), *corners) if stars else ():
        yield from _star(card, radius, at_um, dark)
    for index, density in enumerate(np.linspace(-np.log10(darkest), -np.log10(lightest), _STEPS)):
        angle = 2.0 * np.pi * (index + 0.5) / _STEPS
        at_um = (0.24 * height_um * float(np.sin(angle)), -0.24 * height_um * float(np.cos(angle)))
        yield card.rectangle(0.055 * height_um, 0.055 * height_um, at_um, float(10.0**-density))


def _star(card: Card, radius_um: float, at_um: Place, dark: Spectrum) -> Iterator[Shape]:
    """Draw four dark sectors of 45°: their edges are four straight lines through the centre."""
    (centre_um,) = card.placed_um([at_um])
    for quarter in range(4):
        from_deg = _SLANT_DEG + 90.0 * quarter
        yield Sector(radius_um=radius_um, from_deg=from_deg, turn_deg=45.0, centre_um=centre_um, reflectance=dark)
