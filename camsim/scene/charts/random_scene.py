"""A scene drawn by chance: shapes, colours, letters and gradients, as content for training data."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Annotated

import numpy as np
from annotated_types import Ge, Le, MinLen

from camsim.core.typed import Point, Positive, Seed, Several
from camsim.scene.charts.chart import chart
from camsim.scene.primitives import Shape
from camsim.scene.shapes import Ellipse, Path, Polygon, Rectangle, RegularPolygon, Ring, Sector, Star, Text
from camsim.spectra import named
from camsim.spectra.curve import Reflectance, Spectrum

_BANDS = 24
_LETTERS = "ABCDEFGHKMRSWXabdegkqrs2345689&%?"
_Make = Callable[[np.random.Generator, float, tuple[float, float], Spectrum], Iterator[Shape]]


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
        make = _KINDS[int(source.integers(len(_KINDS)))]
        colour = colours[int(source.integers(len(colours)))]
        yield from make(source, 0.5 * size, (centre_um[0] + x, centre_um[1] + y), colour)


def _measured() -> Sequence[Spectrum]:
    names = [name for name in named.reflectance_names() if "/" not in name or name.startswith("PMC/")]
    return [named.reflectance(name) for name in names]


def _angle_deg(source: np.random.Generator) -> float:
    return float(360.0 * source.random())


def _polygon(source: np.random.Generator, radius: float, at: tuple[float, float], colour: Spectrum) -> Iterator[Shape]:
    count = int(source.integers(3, 9))
    angles = np.sort(math.tau * (np.arange(count) + 0.8 * source.random(count)) / count)
    radii = radius * (0.4 + 0.6 * source.random(count))
    corners = np.array(at) + radii[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    yield Polygon(points_um=corners, reflectance=colour)


def _regular(source: np.random.Generator, radius: float, at: tuple[float, float], colour: Spectrum) -> Iterator[Shape]:
    sides = int(source.integers(3, 9))
    yield RegularPolygon(sides=sides, radius_um=radius, centre_um=at, rotate_deg=_angle_deg(source), reflectance=colour)


def _star(source: np.random.Generator, radius: float, at: tuple[float, float], colour: Spectrum) -> Iterator[Shape]:
    tips, inner = int(source.integers(4, 12)), radius * float(0.3 + 0.4 * source.random())
    yield Star(
        tips=tips,
        radius_um=radius,
        inner_radius_um=inner,
        centre_um=at,
        rotate_deg=_angle_deg(source),
        reflectance=colour,
    )


def _rectangle(
    source: np.random.Generator, radius: float, at: tuple[float, float], colour: Spectrum
) -> Iterator[Shape]:
    wide, high = (2.0 * radius * (0.15 + 0.85 * source.random(2))).tolist()
    yield Rectangle(width_um=wide, height_um=high, centre_um=at, rotate_deg=_angle_deg(source), reflectance=colour)


def _ellipse(source: np.random.Generator, radius: float, at: tuple[float, float], colour: Spectrum) -> Iterator[Shape]:
    rx, ry = (radius * (0.3 + 0.7 * source.random(2))).tolist()
    yield Ellipse(radius_x_um=rx, radius_y_um=ry, centre_um=at, rotate_deg=_angle_deg(source), reflectance=colour)


def _ring(source: np.random.Generator, radius: float, at: tuple[float, float], colour: Spectrum) -> Iterator[Shape]:
    inner = radius * float(0.3 + 0.6 * source.random())
    yield Ring(radius_um=radius, inner_radius_um=inner, centre_um=at, reflectance=colour)


def _sector(source: np.random.Generator, radius: float, at: tuple[float, float], colour: Spectrum) -> Iterator[Shape]:
    turn = float(30.0 + 300.0 * source.random())
    yield Sector(radius_um=radius, from_deg=_angle_deg(source), turn_deg=turn, centre_um=at, reflectance=colour)


def _blob(source: np.random.Generator, radius: float, at: tuple[float, float], colour: Spectrum) -> Iterator[Shape]:
    """Draw a smooth closed curve: each corner's handles run along its neighbours' chord."""
    count = int(source.integers(4, 9))
    angles = math.tau * np.arange(count) / count
    corners = np.array(at) + (radius * (0.5 + 0.5 * source.random(count)))[:, None] * np.stack(
        [np.cos(angles), np.sin(angles)], axis=1
    )
    handles = (np.roll(corners, -1, axis=0) - np.roll(corners, 1, axis=0)) / 6.0
    segments: list[tuple[str | float, ...]] = [("move", *corners[0].tolist())]
    for index in range(count):
        after = (index + 1) % count
        points = (corners[index] + handles[index], corners[after] - handles[after], corners[after])
        segments.append(("cubic", *np.concatenate(points).tolist()))
    yield Path(segments_um=segments, reflectance=colour)


def _letter(source: np.random.Generator, radius: float, at: tuple[float, float], colour: Spectrum) -> Iterator[Shape]:
    yield Text(
        text=_LETTERS[int(source.integers(len(_LETTERS)))],
        size_um=2.0 * radius,
        at_um=at,
        align="centre",
        vertical="middle",
        rotate_deg=_angle_deg(source),
        reflectance=colour,
    )


def _gradient(source: np.random.Generator, radius: float, at: tuple[float, float], colour: Spectrum) -> Iterator[Shape]:
    """Draw greys side by side, from one level to another."""
    first_level, last_level = (0.02 + 0.9 * source.random(2)).tolist()
    levels = np.linspace(first_level, last_level, _BANDS)
    angle = math.radians(_angle_deg(source))
    along, across = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
    ends = [np.array(at) + radius * (2.0 * index / _BANDS - 1.0) * along for index in range(_BANDS + 1)]
    side = 0.6 * radius * across
    for index, level in enumerate(levels.tolist()):
        first, last = ends[index], ends[index + 1]
        yield Polygon(points_um=[first - side, last - side, last + side, first + side], reflectance=level)


_KINDS: tuple[_Make, ...] = (_polygon, _regular, _star, _rectangle, _ellipse, _ring, _sector, _blob, _letter, _gradient)
