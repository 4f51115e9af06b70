"""A ColorChecker in any photograph: positions of its 24 patches, and their mean in each channel."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
import scipy

from camsim.core.arrays import F32, F64
from camsim.core.typed import known_name
from camsim.errors import InvalidValueError, UnsupportedError
from camsim.measure.colour.areas import PatchArea, photosites_in
from camsim.measure.colour.matrix import PatchColours, quick_difference
from camsim.measure.demosaic.subject import CHANNELS
from camsim.measure.lattice import Places, homography, lattices, moved
from camsim.measure.picture import Picture
from camsim.spectra import named

ROWS, COLS = 4, 6
CHARTS = {"ISO 17321-1": "", "BabelColor Average": "BabelColor Average/"}
"""Measured reflectances of the 24 patches, and the prefix of their names."""

CORNERS = "dark skin, bluish green, black and white"
"""The patches at the corners, clockwise from the one above at the left of an upright chart."""

_INSIDE = 0.25
"""Half side of the area used, in distances between patches: half of a patch's, to exclude its rim."""

_OVERVIEW = 800
_EVEN = (0.015, 0.03, 0.06, 0.12)
_LEAST_FOUND, _MOST_FOUND = 10, 48
_ALIKE = 12.0
"""Largest mean ΔE*ab after the best 3 × 3 matrix; patches in any other order have more than 20."""

Corner: TypeAlias = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Chart:
    """The patches of a chart in a picture.

    areas   : areas of the 24 patches, in the chart's order
    window  : first row, first column, rows and columns of the area that contains them
    light   : (rows, cols, 3) of the window, as fractions of black..white; NaN where a channel has no photosite
    mean, error : (24, 3) over each channel's photosites, and its standard error
    clipped : for each patch, whether it has clipped photosites
    """

    areas: tuple[PatchArea, ...]
    window: tuple[int, int, int, int]
    light: F32
    mean: F64
    error: F64
    clipped: tuple[bool, ...]

    def displayed(self, area: PatchArea) -> tuple[slice, slice]:
        """Return the slices of a patch's rectangle in ``light``."""
        row, col = area.roi.row - self.window[0], area.roi.col - self.window[1]
        return slice(row, row + area.roi.rows), slice(col, col + area.roi.cols)


def read_chart(
    picture: Picture, colours: PatchColours, *, corners: Sequence[Corner] | None = None, chart: str = "ISO 17321-1"
) -> Chart:
    """Find the patches of a ColorChecker and read them.

    colours : colours of the patches in the light
    corners : (row, col) of the centres of the patches dark skin, bluish green, black and white; None: detected
    chart   : name of the measured reflectances

    Raises UnsupportedError if there is no chart, or for channels other than red, green and blue.
    """
    missing = [letter for letter in CHANNELS if not any(plane.name[0] == letter for plane in picture.planes)]
    if missing:
        names = ", ".join(dict.fromkeys(plane.name for plane in picture.planes))
        message = f"has the channels {names}; colours need R, G and B (of a bare mosaic say its filters: --cfa RGGB)"
        raise UnsupportedError(message, stage=picture.name)
    if corners is None:
        to_pixel = _found(picture, colours)
    else:
        to_pixel = _of_corners(picture, corners)
        difference = quick_difference(_means_at(_overview(picture), to_pixel), colours)
        if not difference < _ALIKE:
            message = (
                f"what lies between them is no ColorChecker in the order {CORNERS} (its colours are off by "
                f"{difference:.0f} ΔE*ab after the best matrix); give row,col of the middles of these four patches"
            )
            raise InvalidValueError(message, key="--corners", stage=picture.name)
    return _read(picture, to_pixel, reflectance_names(chart))


def reflectance_names(chart: str) -> tuple[str, ...]:
    """Return the names of a chart's 24 reflectances, by rows."""
    prefix = CHARTS[known_name("chart", chart, tuple(CHARTS), "--chart")]
    bare = named.reflectance_names()[: ROWS * COLS]
    return bare if not prefix else tuple(n for n in named.reflectance_names() if n.startswith(prefix))


def _read(picture: Picture, to_pixel: F64, names: Sequence[str]) -> Chart:
    areas = []
    for number, name in enumerate(names):
        row, col = divmod(number, COLS)
        rim = [(col + _INSIDE * dx, row + _INSIDE * dy) for dx, dy in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        found = photosites_in(moved(to_pixel, np.array(rim)), picture.shape)
        if found is None:
            message = f"the patch {name} shows fewer than 64 photosites; take the chart larger, or all of it"
            raise UnsupportedError(message, stage=picture.name)
        roi, inside = found
        areas.append(PatchArea(name=name.split("/")[-1], reflectance=named.reflectance(name), roi=roi, inside=inside))
    top, left = (min(getattr(area.roi, key) for area in areas) for key in ("row", "col"))
    bottom = max(area.roi.row + area.roi.rows for area in areas)
    right = max(area.roi.col + area.roi.cols for area in areas)
    # Starts at a multiple of the period, so that the window has the filter phase of the picture.
    period = [max(plane.step[axis] for plane in picture.planes) for axis in (0, 1)]
    window = (top - top % period[0], left - left % period[1], 0, 0)
    window = (*window[:2], bottom - window[0], right - window[1])
    light, clipped = _light_in(picture, window), []
    chart = Chart(areas=tuple(areas), window=window, light=light, mean=np.empty(0), error=np.empty(0), clipped=())
    mean, error = np.empty((len(areas), 3)), np.empty((len(areas), 3))
    for k, area in enumerate(areas):
        one = light[chart.displayed(area)][area.inside].astype(np.float64)
        there = np.isfinite(one)
        count = there.sum(axis=0)
        if count.min() < 2:
            raise UnsupportedError(f"the patch {area.name} shows a channel too little", stage=picture.name)
        mean[k] = np.nanmean(one, axis=0)
        error[k] = np.nanstd(one, axis=0, ddof=1) / np.sqrt(count)
        clipped.append(float(np.mean(one[there] >= 1.0 - 1e-6)) > 0.002)
    return Chart(areas=tuple(areas), window=window, light=light, mean=mean, error=error, clipped=tuple(clipped))


def _light_in(picture: Picture, window: tuple[int, int, int, int]) -> F32:
    """Return (rows, cols, 3) of a window, black is 0 and white 1."""
    row, col, rows, cols = window
    light = np.full((rows, cols, 3), np.nan, np.float32)
    for plane in picture.planes:
        if plane.name[0] not in CHANNELS:
            continue
        starts = [
            (first - start) % step for first, start, step in zip(plane.first, (row, col), plane.step, strict=True)
        ]
        of = [
            slice((start + begin - first) // step, None)
            for start, begin, first, step in zip((row, col), starts, plane.first, plane.step, strict=True)
        ]
        target = light[starts[0] :: plane.step[0], starts[1] :: plane.step[1], CHANNELS.index(plane.name[0])]
        samples = plane.samples[of[0], of[1]][: target.shape[0], : target.shape[1]]
        target[...] = (samples.astype(np.float64) - plane.black) / _span(plane.samples, plane.black, plane.white)
    return light


def _span(samples: npt.NDArray[Any], black: float, white: float | None) -> float:
    """Return the span from black to white; without a white level to the brightest sample, which then never clips."""
    return white - black if white is not None else 1.01 * max(float(samples.max()) - black, 1e-30)


@dataclass(frozen=True, slots=True, eq=False)
class _Overview:
    """A small picture: (rows, cols, 3) means of ``side`` × ``side`` photosites, as fractions of black..white."""

    image: F64
    side: int


def _overview(picture: Picture) -> _Overview:
    period = math.lcm(*(step for plane in picture.planes for step in plane.step))
    side = period * max(1, math.ceil(max(picture.shape) / (_OVERVIEW * period)))
    rows, cols = (size // side for size in picture.shape)
    if min(rows, cols) < 24:
        raise UnsupportedError(
            f"has {picture.shape[0]} × {picture.shape[1]} photosites; a chart of 24 patches needs more",
            stage=picture.name,
        )
    total, planes = np.zeros((rows, cols, 3)), np.zeros(3)
    for plane in picture.planes:
        if plane.name[0] in CHANNELS:
            down, across = (side // step for step in plane.step)
            part = plane.samples[: rows * down, : cols * across].reshape(rows, down, cols, across)
            channel = CHANNELS.index(plane.name[0])
            light = (part.mean(axis=(1, 3), dtype=np.float64) - plane.black) / _span(
                plane.samples, plane.black, plane.white
            )
            total[..., channel] += light
            planes[channel] += 1.0
    return _Overview(total / planes, side)


def _of_corners(picture: Picture, corners: Sequence[Corner]) -> F64:
    """Return the projection from chart coordinates to pixels, from the centres of the patches at its corners."""
    if len(corners) != 4:
        raise InvalidValueError(f"{len(corners)} places; give four: {CORNERS}", key="--corners")
    for row, col in corners:
        if not (0.0 <= row <= picture.shape[0] and 0.0 <= col <= picture.shape[1]):
            message = (
                f"{row:g},{col:g} lies outside the picture of {picture.shape[0]} rows × {picture.shape[1]} columns"
            )
            raise InvalidValueError(message, key="--corners")
    grid = np.array([(0, 0), (COLS - 1, 0), (COLS - 1, ROWS - 1), (0, ROWS - 1)], np.float64)
    pixels = np.array([(col, row) for row, col in corners], np.float64)
    sides = np.roll(pixels, -1, axis=0) - pixels
    crosses = np.cross(np.pad(sides, ((0, 0), (0, 1))), np.pad(np.roll(sides, -1, axis=0), ((0, 0), (0, 1))))[:, 2]
    if not (crosses.min() > 0.0 or crosses.max() < 0.0):
        raise InvalidValueError(f"they are no four corners in turn; give {CORNERS}", key="--corners")
    return homography(grid, pixels)


def _grid() -> F64:
    return np.array([(number % COLS, number // COLS) for number in range(ROWS * COLS)], np.float64)


def _means_at(overview: _Overview, to_pixel: F64) -> F64 | None:
    """Return (24, 3) means around the centres of the patches; None if one lies outside."""
    middles = moved(to_pixel, _grid()) / overview.side
    # Distance to the nearest neighbour, which varies with perspective.
    reach = _INSIDE * min(float(np.hypot(*(middles[k + 1] - middles[k]))) for k in range(COLS - 1))
    half = max(0, math.floor(reach * 0.7))
    rows, cols = overview.image.shape[:2]
    means = []
    for x, y in middles:
        row, col = math.floor(y), math.floor(x)
        if not (half <= row < rows - half and half <= col < cols - half):
            return None
        means.append(overview.image[row - half : row + half + 1, col - half : col + half + 1].mean(axis=(0, 1)))
    return np.array(means)


def _found(picture: Picture, colours: PatchColours) -> F64:
    """Return the projection from chart coordinates to pixels of the chart detected in a picture."""
    overview = _overview(picture)
    best, difference = None, math.inf
    for threshold in _EVEN:
        middles, sizes = _even_regions(overview.image, threshold)
        for lattice in lattices(middles, sizes, least=_LEAST_FOUND, most=_MOST_FOUND):
            for to_cell in _laid(lattice):
                to_pixel = np.diag([overview.side, overview.side, 1.0]) @ to_cell
                off = quick_difference(_means_at(overview, to_pixel), colours)
                if off < difference:
                    best, difference = to_pixel, off
        if best is not None and difference < 0.5 * _ALIKE:
            break
    if best is None or not difference < _ALIKE:
        raise UnsupportedError(
            "shows no ColorChecker that is found (24 patches, 6 × 4, in one piece); say where it lies by --corners: "
            f"row,col of the middles of the patches {CORNERS}",
            stage=picture.name,
        )
    return best


def _even_regions(image: F64, threshold: float) -> tuple[F64, F64]:
    """Return centres (n, 2) and areas (n,) of uniform, nearly rectangular regions, in cells of an overview."""
    import shapely

    brightest = np.maximum(np.percentile(image, 99.5, axis=(0, 1)), 1e-9)
    # The square root makes shot noise uniform, and is closer to perceived steps.
    seen = np.sqrt(np.clip(image / brightest, 0.0, 2.0))
    high = scipy.ndimage.maximum_filter(seen, (3, 3, 1))
    low = scipy.ndimage.minimum_filter(seen, (3, 3, 1))
    even = (high - low).max(axis=2) < threshold
    labels, count = scipy.ndimage.label(even)
    middles, sizes = [], []
    for number, at in enumerate(scipy.ndimage.find_objects(labels), 1):
        rows, cols = (part.stop - part.start for part in at)
        if min(rows, cols) < 3 or max(rows, cols) > min(image.shape[:2]) // 2:
            continue
        inside = labels[at] == number
        area = float(np.count_nonzero(inside))
        y, x = np.nonzero(inside)
        hull = shapely.convex_hull(shapely.multipoints(np.stack([x, y], axis=1)))
        box = shapely.minimum_rotated_rectangle(hull)
        if box.geom_type != "Polygon":
            continue
        corners = shapely.get_coordinates(box)
        sides = np.hypot(*np.diff(corners[:3], axis=0).T) + 1.0
        if area >= 0.7 * sides.prod() and sides.max() <= 1.7 * sides.min():
            middles.append((at[1].start + x.mean() + 0.5, at[0].start + y.mean() + 0.5))
            sizes.append(area)
    assert count >= len(middles)
    return np.array(middles).reshape(-1, 2), np.array(sizes)


def _laid(lattice: Places) -> Iterator[F64]:
    """Yield projections of a 6 × 4 chart on a lattice, at every position and rotation that most patches fit."""
    for turn in range(4):
        turned = {_turned(place, turn): middle for place, middle in lattice.items()}
        cols, rows = ([place[axis] for place in turned] for axis in (0, 1))
        for col in range(min(cols) - 2, max(cols) - COLS + 4):
            for row in range(min(rows) - 2, max(rows) - ROWS + 4):
                here = {
                    (c - col, r - row): middle
                    for (c, r), middle in turned.items()
                    if 0 <= c - col < COLS and 0 <= r - row < ROWS
                }
                if len(here) >= _LEAST_FOUND and min(len(set(axis)) for axis in zip(*here, strict=True)) > 1:
                    yield homography(np.array(list(here), np.float64), np.array(list(here.values())))


def _turned(place: tuple[int, int], turn: int) -> tuple[int, int]:
    col, row = place
    return ((col, row), (row, -col), (-col, -row), (-row, col))[turn]
