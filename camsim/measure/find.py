"""Edges found without being told where: straight pieces of strong gradient, each with a region of its own."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy

from camsim.arrays import F64
from camsim.errors import UnsupportedError
from camsim.measure.geometry import Roi
from camsim.measure.grow import grow
from camsim.measure.picture import LARGEST_SIGNAL, Picture, Plane

_LARGEST = 2000
_HALF_WIDTH = 32
_LEAST_HALF_WIDTH = 16
_LEAST_LENGTH = 40
_MOST_LENGTH = 400
_ANGLE_TOLERANCE = math.radians(20.0)
_LEAST_STEP = 0.03
_MOST_TRIED = 500


@dataclass(frozen=True, slots=True, kw_only=True)
class _Segment:
    """A straight piece of edge, in pixels: centre, unit direction, half length, scatter across it; its label."""

    x: float
    y: float
    tx: float
    ty: float
    half: float
    thick: float
    label: int


def find_edges(picture: Picture, most: int = 100) -> tuple[Roi, ...]:
    """Return regions that each hold one straight slanted edge, the longest first; empty when there are none.

    The picture is brought to one grey plane of cells (a Bayer cell, or larger in large pictures). Cells of strong and
    equally directed gradient grow together; each group that is straight and long enough gets a region as wide as its
    neighbours allow, 32 px on either side at the most.
    """
    if not all(abs(end) <= LARGEST_SIGNAL for plane in picture.planes for end in _range(plane)):
        raise UnsupportedError(
            f"holds values that are no numbers (NaN or infinite) or above {LARGEST_SIGNAL:g}; "
            "point at an edge beside them with a roi",
            stage=picture.name,
        )
    if min(picture.shape) < 2 * _LEAST_HALF_WIDTH:
        return ()
    grey, cell = _grey(picture)
    smooth = scipy.ndimage.gaussian_filter(grey, 1.0)
    gx, gy = scipy.ndimage.sobel(smooth, axis=1) / 8.0, scipy.ndimage.sobel(smooth, axis=0) / 8.0
    strength = np.hypot(gx, gy)
    noise = 1.4826 * float(np.median(np.abs(strength - np.median(strength)))) + float(np.median(strength))
    low, high = np.percentile(grey[:: max(1, grey.shape[0] // 500), :: max(1, grey.shape[1] // 500)], (1, 99))
    threshold = max(5.0 * noise, 0.25 * _LEAST_STEP * float(high - low), 1e-12)
    strong = strength > threshold
    if not strong.any():
        return ()
    segments, label = _segments(gx, gy, strength, strong, cell)
    rows, cols = np.nonzero(strong)
    # Where there is edge, in pixels, and whose: regions must not hold any that is not their own.
    marks = np.stack([(cols + 0.5) * cell, (rows + 0.5) * cell, label[rows, cols]], axis=1)
    marks = marks[np.argsort(marks[:, 1], kind="stable")]
    found: list[Roi] = []
    for segment in sorted(segments, key=lambda s: -s.half)[:_MOST_TRIED]:
        roi = _region(segment, marks, picture.shape, cell)
        if roi is not None and not any(_overlap(roi, other) for other in found):
            found.append(roi)
        if len(found) >= most:
            break
    return tuple(found)


def _range(plane: Plane) -> tuple[float, float]:
    """Return the smallest and the largest sample; NaN where there is one."""
    return float(np.min(plane.samples)), float(np.max(plane.samples))


def _grey(picture: Picture) -> tuple[F64, int]:
    """Return the picture as one plane, averaged over square cells, and the cell's side in pixels.

    Every cell holds the same number of each channel's photosites, and each channel counts alike.
    """
    smallest = _smallest_cell(picture)
    # By the area: a strip of a million columns is as much work as a square of it.
    cell = smallest * max(1, math.ceil(math.sqrt(math.prod(picture.shape)) / smallest / _LARGEST))
    rows, cols = (size // cell for size in picture.shape)
    grey = np.zeros((rows, cols))
    for channel in picture.select("all"):
        density = sum(1.0 / math.prod(plane.step) for plane in channel.planes)
        for plane in channel.planes:
            for samples, row, col in _parts(plane, cell):
                # Where a cell is smaller than the period, a part has a sample in every so many cells only.
                every = max(1, plane.step[0] // cell), max(1, plane.step[1] // cell)
                here = grey[row :: every[0], col :: every[1]]
                here += (samples[: here.shape[0], : here.shape[1]] - plane.black) / (density * cell**2)
    return grey, cell


def _parts(plane: Plane, cell: int) -> Iterator[tuple[npt.NDArray[Any], int, int]]:
    """Yield views of a plane's samples, each with no more than one in a cell, and the cell of their first."""
    step, first = plane.step, plane.first
    down, across = max(1, cell // step[0]), max(1, cell // step[1])
    for i in range(down):
        for j in range(across):
            yield (
                plane.samples[i::down, j::across],
                (first[0] + i * step[0]) // cell,
                (first[1] + j * step[1]) // cell,
            )


def _smallest_cell(picture: Picture) -> int:
    """Return the side of the smallest cells that all hold the same photosites: 2 of Bayer, 3 of X-Trans.

    >>> from camsim.measure.picture import mosaic_planes
    >>> x_trans = ("GBGGRG", "RGRBGB", "GBGGRG", "GRGGBG", "BGBRGR", "GRGGBG")
    >>> _smallest_cell(Picture(name="", shape=(6, 6), planes=mosaic_planes(np.zeros((6, 6)), x_trans)))
    3
    """
    period = math.lcm(*(step for plane in picture.planes for step in plane.step))
    for cell in (size for size in range(1, period) if period % size == 0):
        held: dict[tuple[int, int], list[str]] = {}
        for plane in picture.planes:
            for row in range(plane.first[0], period, plane.step[0]):
                for col in range(plane.first[1], period, plane.step[1]):
                    held.setdefault((row // cell, col // cell), []).append(plane.name)
        if len(held) == (period // cell) ** 2 and len({tuple(sorted(names)) for names in held.values()}) == 1:
            return cell
    return period


def _segments(
    gx: F64, gy: F64, strength: F64, strong: np.ndarray, cell: int
) -> tuple[list[_Segment], npt.NDArray[np.int32]]:
    """Return the straight pieces, and of every cell the label of its group."""
    angle = np.arctan2(gy, gx)
    rows, cols = np.nonzero(strong)
    order = np.argsort(-strength[rows, cols], kind="stable")
    label = grow(angle, strong, rows[order], cols[order], _ANGLE_TOLERANCE)
    count = int(label.max())
    if not count:
        return [], label
    rows, cols = np.nonzero(label)
    which = label[rows, cols] - 1
    weight = strength[rows, cols]
    total = np.bincount(which, weight, count)
    x = np.bincount(which, weight * cols, count) / total
    y = np.bincount(which, weight * rows, count) / total
    dx, dy = cols - x[which], rows - y[which]
    xx = np.bincount(which, weight * dx * dx, count) / total
    yy = np.bincount(which, weight * dy * dy, count) / total
    xy = np.bincount(which, weight * dx * dy, count) / total
    turn = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    tx, ty = np.cos(turn), np.sin(turn)
    along = dx * tx[which] + dy * ty[which]
    across = -dx * ty[which] + dy * tx[which]
    first, last = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(first, which, along)
    np.maximum.at(last, which, along)
    thick = np.sqrt(np.bincount(which, weight * across**2, count) / total)
    segments = []
    for k in range(count):
        length = (last[k] - first[k]) * cell
        if length < _LEAST_LENGTH or thick[k] > 0.15 * (last[k] - first[k]):
            continue
        middle = 0.5 * (first[k] + last[k])
        segments.append(
            _Segment(
                x=float((x[k] + middle * tx[k] + 0.5) * cell),
                y=float((y[k] + middle * ty[k] + 0.5) * cell),
                tx=float(tx[k]),
                ty=float(ty[k]),
                half=0.5 * float(length),
                thick=float(thick[k]) * cell,
                label=k + 1,
            )
        )
    return segments, label


def _region(segment: _Segment, marks: F64, shape: tuple[int, int], cell: int) -> Roi | None:
    """Return the largest region about a segment's middle that holds no other edge; None when there is no room."""
    upright = abs(segment.ty) >= abs(segment.tx)
    lead = abs(segment.ty) if upright else abs(segment.tx)
    slant = (segment.tx / segment.ty) if upright else (segment.ty / segment.tx)
    margin = 3.0 * cell + 4.0
    longest = min(2.0 * (segment.half - margin) * lead, _MOST_LENGTH)
    tried = {
        half_width: [
            roi
            for length in np.unique(np.linspace(_LEAST_LENGTH, max(longest, _LEAST_LENGTH), 8).astype(int))[::-1]
            if length <= longest + 1e-9
            and (roi := _about(segment, length, 2.0 * half_width / lead + abs(slant) * length, upright, shape))
            is not None
        ]
        for half_width in (_HALF_WIDTH, 24, _LEAST_HALF_WIDTH)
    }
    near = _inside(marks, [roi for rois in tried.values() for roi in rois], cell)
    own = 2.5 * cell + 3.0
    dx, dy = near[:, 0] - segment.x, near[:, 1] - segment.y
    across = np.abs(-dx * segment.ty + dy * segment.tx)
    along = np.abs(dx * segment.tx + dy * segment.ty)
    # A blurred edge is wide, and all of it is its own.
    wide = np.where(near[:, 2] == segment.label, own + 4.0 * segment.thick, own)
    foreign = near[(across > wide) | (along > segment.half + wide)]
    for rois in tried.values():
        free = [roi for roi in rois if not len(_inside(foreign, [roi], cell))]
        if free:
            return max(free, key=lambda roi: roi.rows * roi.cols)
    return None


def _inside(marks: F64, rois: Sequence[Roi], cell: int) -> F64:
    """Return the marks, ascending in y, in the smallest rectangle about regions."""
    if not rois:
        return marks[:0]
    top, bottom = min(roi.row for roi in rois) - cell, max(roi.row + roi.rows for roi in rois) + cell
    left, right = min(roi.col for roi in rois) - cell, max(roi.col + roi.cols for roi in rois) + cell
    first, last = np.searchsorted(marks[:, 1], top, "right"), np.searchsorted(marks[:, 1], bottom, "left")
    rows = marks[first:last]
    return rows[(rows[:, 0] > left) & (rows[:, 0] < right)]


def _about(segment: _Segment, length: float, wide: float, upright: bool, shape: tuple[int, int]) -> Roi | None:
    """Return a region about a segment's middle, None when it reaches beyond the image."""
    height, width = (length, wide) if upright else (wide, length)
    return _even(segment.x - 0.5 * width, segment.y - 0.5 * height, width, height, shape)


def _even(left: float, top: float, width: float, height: float, shape: tuple[int, int]) -> Roi | None:
    """Return the region on even rows and columns, None when it reaches beyond the image."""
    col, row = 2 * round(left / 2.0), 2 * round(top / 2.0)
    cols, rows = 2 * round(width / 2.0), 2 * round(height / 2.0)
    if row < 0 or col < 0 or row + rows > shape[0] or col + cols > shape[1]:
        return None
    return Roi(row, col, rows, cols)


def _overlap(a: Roi, b: Roi) -> bool:
    """Whether two regions are mostly the same."""
    rows = min(a.row + a.rows, b.row + b.rows) - max(a.row, b.row)
    cols = min(a.col + a.cols, b.col + b.cols) - max(a.col, b.col)
    return min(rows, cols) > 0 and 2 * rows * cols > min(a.rows * a.cols, b.rows * b.cols)
