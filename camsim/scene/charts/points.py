"""Points of light: given ones, or a sky of stars drawn by chance."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

import numpy as np
from annotated_types import Ge, Le

from camsim.core.typed import Point, Positive, Seed, Several
from camsim.scene.charts.chart import Card, Many, chart, instead, refused
from camsim.scene.primitives import Shape
from camsim.spectra.curve import Reflectance

_PER_MAGNITUDE = 0.6  # stars uniform in space: 10^0.6 times as many per magnitude

Magnitude = Annotated[float, Ge(-30), Le(30)]


@chart
@instead(positions_um=("width_um", "height_um", "brightest", "faintest", "seed"), stars=("magnitudes",))
def points(
    *,
    radius_um: Positive,
    positions_um: Several[Point] | None = None,
    magnitudes: Several[Magnitude] | None = None,
    stars: Many | None = None,
    width_um: Positive | None = None,
    height_um: Positive | None = None,
    brightest: Magnitude = 0.0,
    faintest: Magnitude = 5.0,
    seed: Seed = 0,
    light: Reflectance = 1.0,
    centre_um: Point = (0.0, 0.0),
) -> Iterator[Shape]:
    """Draw points of light as discs much smaller than the blur, anywhere between photosites.

    A magnitude more means 10^0.4 times less light, and 10^0.4 times less area. Give the points, or the number of stars.

    radius_um    : radius of a point of magnitude 0; fainter ones are smaller
    positions_um : places of the points, from the chart's centre
    magnitudes   : magnitude of each point; all 0 when left out
    stars        : instead: number of stars drawn by chance, with more faint ones than bright, as in space
    width_um, height_um : size of the field in which stars are drawn
    brightest, faintest : limits of the stars' magnitudes
    light        : reflectance of the points

    >>> two = points(radius_um=1.0, positions_um=[(0, 0), (9, 0)], magnitudes=[0, 5])
    >>> [round(star.radius_um, 3) for star in two.shapes]
    [1.0, 0.1]
    """
    if (positions_um is None) == (stars is None):
        said = "missing" if stars is None else "given twice"
        raise refused(points, "positions_um", f"{said}; give one of positions_um and stars")
    if stars is not None:
        if width_um is None or height_um is None:
            raise refused(points, "width_um" if width_um is None else "height_um", "missing; stars need a field")
        if faintest < brightest:
            raise refused(points, "faintest", "is below 'brightest'")
        random = np.random.Generator(np.random.Philox(seed))
        positions_um = (random.random((stars, 2)) - 0.5) * (width_um, height_um)
        # The share of stars brighter than m goes as 10^(0.6·m).
        low, high = 10.0 ** (_PER_MAGNITUDE * brightest), 10.0 ** (_PER_MAGNITUDE * faintest)
        magnitudes = np.log10(low + (high - low) * random.random(stars)) / _PER_MAGNITUDE
    assert positions_um is not None
    levels = np.zeros(len(positions_um)) if magnitudes is None else np.asarray(magnitudes)
    if len(levels) != len(positions_um):
        raise refused(points, "magnitudes", f"{len(levels)} for {len(positions_um)} points; each has one")
    card = Card(centre_um)
    for (x, y), level in zip(np.asarray(positions_um).reshape(-1, 2).tolist(), levels.tolist(), strict=True):
        yield card.disc(radius_um * 10.0 ** (-0.2 * level), (x, y), light)
