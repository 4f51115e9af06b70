"""A scene drawn by chance: shapes, colours, letters and gradients, as content for training data."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Annotated, Any

import numpy as np
from annotated_types import Ge, Le, MinLen

from camsim.core.arrays import F64
from camsim.core.typed import Point, Positive, Seed, Several
from camsim.scene.charts.chart import Place, chart
from camsim.scene.primitives import Shape, turned
from camsim.scene.shapes import Ellipse, Path, Polygon, Rectangle, RegularPolygon, Ring, Sector, Star, Text
from camsim.spectra import named
from camsim.spectra.curve import Reflectance, Spectrum

_BANDS = 24
_LETTERS = "ABCDEFGHKMRSWXabdegkqrs2345689&%?"
_KINDS = ["polygon", "regular polygon", "star", "rectangle", "ellipse", "ring", "sector", "blob", "letter", "gradient"]


@chart
def random(
    *,
    width_um: Positive,
    height_um: Positive,
    shapes: Annotated[int, Ge(1), Le(100_000)] = 60,
    seed: Seed = 0,
    palette: Annotated[Several[Reflectance], MinLen(1)] | None = None,
    centre_um: Point = (0.0, 0.0),
) -> Iterator[Shape]:
    """Draw shapes of all kinds and sizes over an area, the large ones first, so that none hides all others.

    width_um, height_um : size of the area in which the shapes' centres lie
    shapes  : number of shapes; each is a polygon, a star, a rectangle, an ellipse, a ring, a sector, a curved blob, a
              letter or a gradient in bands
    palette : reflectances to draw from; the 54 measured surfaces of two charts when left out

    >>> random(width_um=90.0, height_um=60.0, seed=3) == random(width_um=90.0, height_um=60.0, seed=3)
    True
    """
    source = np.random.Generator(np.random.Philox(seed))
    colours: Several[Reflectance] = palette or _measured()
    whole = min(width_um, height_um)
    # Sizes are log-uniform.
    sizes = np.sort(whole * np.geomspace(0.02, 0.5, 1000)[source.integers(1000, size=shapes)])[::-1]
    for size in sizes.tolist():
        x, y = ((source.random(2) - 0.5) * (width_um, height_um)).tolist()
        kind = _KINDS[int(source.integers(len(_KINDS)))]
        colour = colours[int(source.integers(len(colours)))]
        yield from _shape(source, kind, 0.5 * size, (centre_um[0] + x, centre_um[1] + y), colour)


def _measured() -> Sequence[Spectrum]:
    names = [name for name in named.reflectance_names() if "/" not in name or name.startswith("PMC/")]
    return [named.reflectance(name) for name in names]


def _shape(source: np.random.Generator, kind: str, radius: float, at: Place, colour: Spectrum) -> Iterator[Shape]:
    """Draw a shape of a kind about a place."""

    def angle_deg() -> float:
        return float(360.0 * source.random())

    def corners(angles: F64, least: float) -> F64:
        """Return points (n, 2) in these directions, at random distances from ``least`` radii on."""
        radii = radius * (least + (1.0 - least) * source.random(len(angles)))
        places: F64 = np.array(at) + radii[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        return places

    about: dict[str, Any] = {"centre_um": at, "reflectance": colour}
    match kind:
        case "polygon":
            count = int(source.integers(3, 9))
            angles = np.sort(math.tau * (np.arange(count) + 0.8 * source.random(count)) / count)
            yield Polygon(points_um=corners(angles, 0.4), reflectance=colour)
        case "regular polygon":
            sides = int(source.integers(3, 9))
            yield RegularPolygon(sides=sides, radius_um=radius, rotate_deg=angle_deg(), **about)
        case "star":
            tips, inner = int(source.integers(4, 12)), radius * float(0.3 + 0.4 * source.random())
            yield Star(tips=tips, radius_um=radius, inner_radius_um=inner, rotate_deg=angle_deg(), **about)
        case "rectangle":
            wide, high = (2.0 * radius * (0.15 + 0.85 * source.random(2))).tolist()
            yield Rectangle(width_um=wide, height_um=high, rotate_deg=angle_deg(), **about)
        case "ellipse":
            rx, ry = (radius * (0.3 + 0.7 * source.random(2))).tolist()
            yield Ellipse(radius_x_um=rx, radius_y_um=ry, rotate_deg=angle_deg(), **about)
        case "ring":
            yield Ring(radius_um=radius, inner_radius_um=radius * float(0.3 + 0.6 * source.random()), **about)
        case "sector":
            turn = float(30.0 + 300.0 * source.random())
            yield Sector(radius_um=radius, from_deg=angle_deg(), turn_deg=turn, **about)
        case "blob":  # a smooth closed curve: each corner's handles run along its neighbours' chord
            count = int(source.integers(4, 9))
            points = corners(math.tau * np.arange(count) / count, 0.5)
            handles = (np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)) / 6.0
            after = np.roll(points - handles, -1, axis=0), np.roll(points, -1, axis=0)
            curves = np.hstack([points + handles, *after]).tolist()
            yield Path(segments_um=[("move", *points[0]), *(("cubic", *each) for each in curves)], reflectance=colour)
        case "letter":
            yield Text(
                text=_LETTERS[int(source.integers(len(_LETTERS)))],
                size_um=2.0 * radius,
                at_um=at,
                align="centre",
                vertical="middle",
                rotate_deg=angle_deg(),
                reflectance=colour,
            )
        case "gradient":  # greys side by side, from one level to another
            darkest, lightest = (0.02 + 0.9 * source.random(2)).tolist()
            levels = np.linspace(darkest, lightest, _BANDS).tolist()
            along, across = turned(np.eye(2), angle_deg())
            ends = [np.array(at) + radius * (2.0 * index / _BANDS - 1.0) * along for index in range(_BANDS + 1)]
            side = 0.6 * radius * across
            for (first, last), level in zip(pairwise(ends), levels, strict=True):
                yield Polygon(points_um=[first - side, last - side, last + side, first + side], reflectance=level)
