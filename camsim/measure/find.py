"""Automatic edge detection: straight pieces of strong gradient, each with its region."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from camsim.core.arrays import F64
from camsim.errors import UnsupportedError
from camsim.measure.geometry import Roi
from camsim.measure.grow import grow
from camsim.measure.picture import LARGEST_SIGNAL, Picture, Plane
from camsim.numerics.filtering import bell, filtered

_LARGEST = 2500
"""Most cells along the side of a square picture: up to 6 megapixels a cell is a photosite."""

_BAND = 512
_LEAST_LENGTH = 20.0
"""Least length of an edge, pixels: noise and blur reduce the 25 px that a side needs."""

_LEAST_REACH, _FULL_REACH = 6.0, 32.0
_REACHES = (_FULL_REACH, 16.0, 10.0)
_LEAST_SPAN, _MOST_SPAN = 12.0, 400.0
_SPANS, _ASIDES = 24, 24
_SHIFTS, _ASKEW = (-0.5, -0.25, 0.0, 0.25, 0.5), 0.5
"""Trial shifts of a region along the edge, relative to the length that it leaves over, and the penalty on them."""

_LEAST_ASIDE = 4.0
_ANGLE_TOLERANCE = math.radians(20.0)
_LEAST_STEP = 0.03
_LEAST_NOISES = 3.0
_OTHER, _ALIKE = 0.25, 0.7
"""Gradient relative to the edge's, and cosine between directions, beyond which it is another edge or a corner."""

_THICKS = 8.0  # of its scatter: distance within which it reaches its two levels
_THICKEST = 0.25  # of its length: broader pieces are not edges
_MOST_FOUND = 2000
_SAMPLES_FOR_NOISE = 1_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """Edges, the longest first: for each the candidate regions, the best first.

    without : reasons for edges without room for a region
    """

    edges: tuple[tuple[Roi, ...], ...]
    without: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class _Segment:
    """A straight piece of edge, in pixels: centre, unit direction, half length, scatter across it.

    strength : of its gradient;  label : of its cells
    """

    x: float
    y: float
    tx: float
    ty: float
    half: float
    thick: float
    strength: float
    label: int


class _Cells(NamedTuple):
    """The picture as one grey plane: cell (i, j) is centred at (i·every + middle, j·every + middle) pixels."""

    grey: F64
    every: int
    middle: float


class _Gradients(NamedTuple):
    """Gradients of every cell; label: its group, 0 without an edge."""

    gx: F64
    gy: F64
    label: npt.NDArray[np.int32]
    every: int
    middle: float


def find_edges(picture: Picture) -> Found:
    """Return the straight slanted edges of a picture.

    The picture is reduced to one grey plane, in which each cell weights all channels equally. Neighbouring cells of
    strong gradient in similar directions are grouped; each straight and long enough group gets the best region: as long
    as it and up to 32 px wide on either side, without other edges. Narrower regions follow, for light that changes
    next to an edge.
    """
    if not all(abs(end) <= LARGEST_SIGNAL for plane in picture.planes for end in _range(plane)):
        raise UnsupportedError(
            f"holds values that are no numbers (NaN or infinite) or above {LARGEST_SIGNAL:g}; "
            "point at another edge with a roi",
            stage=picture.name,
        )
    cells = _cells(picture)
    if min(cells.grey.shape) < 3:
        return Found(edges=())
    smooth, slope = np.convolve(bell(1.0), [0.25, 0.5, 0.25]), np.convolve(bell(1.0), [-0.5, 0.0, 0.5])
    gx, gy = filtered(cells.grey, smooth, slope), filtered(cells.grey, slope, smooth)
    strength = np.hypot(gx, gy)
    some = (slice(None, None, max(1, math.isqrt(strength.size // _SAMPLES_FOR_NOISE))),) * 2
    middle = float(np.median(strength[some]))
    noise = 1.4826 * float(np.median(np.abs(strength[some] - middle))) + middle
    low, high = np.percentile(cells.grey[some], (1, 99))
    strong = strength > max(_LEAST_NOISES * noise, 0.25 * _LEAST_STEP * float(high - low), 1e-12)
    rows, cols = np.nonzero(strong)
    if not rows.size:
        return Found(edges=())
    order = np.argsort(-strength[rows, cols], kind="stable")
    label = grow(np.arctan2(gy, gx), strong, rows[order], cols[order], _ANGLE_TOLERANCE)
    gradients = _Gradients(gx, gy, label, cells.every, cells.middle)
    edges: list[tuple[Roi, ...]] = []
    without: list[str] = []
    segments = sorted(_segments(gradients), key=lambda s: -s.half)
    for segment in segments[:_MOST_FOUND]:
        rois, why_not = _regions(segment, gradients, picture)
        if not rois:
            where = f"at row {segment.y:.0f}, column {segment.x:.0f}"
            without.append(f"the edge of {2.0 * segment.half:.0f} px {where} has {why_not}")
        elif not any(_overlap(rois[0], other) for other, *_ in edges):
            edges.append(rois)
    if more := len(segments[_MOST_FOUND:]):
        without.append(f"{more} shorter edges: the {_MOST_FOUND} longest were tried; point at others with a roi")
    return Found(edges=tuple(edges), without=tuple(without))


def _range(plane: Plane) -> tuple[float, float]:
    """Return the smallest and the largest sample; NaN if any sample is."""
    return float(np.min(plane.samples)), float(np.max(plane.samples))


def _cells(picture: Picture) -> _Cells:
    """Return the picture averaged over (possibly overlapping) squares with equal sets of photosites.

    Every square has the same number of photosites of each channel, and channels are weighted equally.
    """
    # By area: a strip of a million columns costs as much as a square of the same area.
    every = max(1, math.ceil(math.sqrt(math.prod(picture.shape)) / _LARGEST))
    period = _period(picture)
    side = period * math.ceil(every / period)
    rows, cols = (max(0, (size - side) // every + 1) for size in picture.shape)
    grey = np.zeros((rows, cols))
    weights = [
        (plane, 1.0 / (sum(1.0 / math.prod(one.step) for one in channel.planes) * side**2))
        for channel in picture.select("all")
        for plane in channel.planes
    ]
    for first in range(0, rows, _BAND):
        last = min(first + _BAND, rows)
        start, height = first * every, (last - first - 1) * every + side
        whole = np.zeros((height, picture.shape[1]))
        for plane, weight in weights:
            top = (plane.first[0] - start) % plane.step[0]
            begin = (start + top - plane.first[0]) // plane.step[0]
            here = whole[top :: plane.step[0], plane.first[1] :: plane.step[1]]
            here += (plane.samples[begin : begin + len(here)] - plane.black) * weight
        tall = np.zeros((last - first, picture.shape[1]))
        for k in range(side):
            tall += whole[k : k + height - side + 1 : every]
        for k in range(side):
            grey[first:last] += tall[:, k : k + (cols - 1) * every + 1 : every]
    return _Cells(grey, every, 0.5 * side)


def _period(picture: Picture) -> int:
    """Return the side of the smallest squares with equal sets of photosites at every position: 2 for Bayer.

    >>> from camsim.measure.picture import mosaic_planes
    >>> x_trans = ("GBGGRG", "RGRBGB", "GBGGRG", "GRGGBG", "BGBRGR", "GRGGBG")
    >>> _period(Picture(name="", shape=(6, 6), planes=mosaic_planes(np.zeros((6, 6)), x_trans)))
    6
    """
    longest = math.lcm(*(step for plane in picture.planes for step in plane.step))
    names = np.full((longest, longest), "", dtype=object)
    for plane in picture.planes:
        names[plane.first[0] :: plane.step[0], plane.first[1] :: plane.step[1]] += f" {plane.name}"
    return next(
        period
        for period in range(1, longest + 1)
        if longest % period == 0
        and np.array_equal(names, np.tile(names[:period, :period], (longest // period, longest // period)))
    )


def _segments(cells: _Gradients) -> list[_Segment]:
    """Return the long enough straight pieces."""
    count = int(cells.label.max())
    rows, cols = np.nonzero(cells.label)
    which = cells.label[rows, cols] - 1
    gx, gy = cells.gx[rows, cols], cells.gy[rows, cols]
    weight = np.hypot(gx, gy)
    total = np.bincount(which, weight, count)
    x = np.bincount(which, weight * cols, count) / total
    y = np.bincount(which, weight * rows, count) / total
    dx, dy = cols - x[which], rows - y[which]
    xx = np.bincount(which, weight * dx * dx, count) / total
    yy = np.bincount(which, weight * dy * dy, count) / total
    xy = np.bincount(which, weight * dx * dy, count) / total
    turn = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    tx, ty = np.cos(turn), np.sin(turn)
    # Dark to bright is clockwise of the direction, so the two sides of a dark line have opposite directions.
    rising = np.bincount(which, gx * ty[which] - gy * tx[which], count) / total
    flip = np.where(rising < 0.0, -1.0, 1.0)
    tx, ty = flip * tx, flip * ty
    along = dx * tx[which] + dy * ty[which]
    across = -dx * ty[which] + dy * tx[which]
    first, last = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(first, which, along)
    np.maximum.at(last, which, along)
    thick = np.sqrt(np.bincount(which, weight * across**2, count) / total)
    strength = np.bincount(which, weight**2, count) / total
    middle = 0.5 * (first + last)
    long = ((last - first) * cells.every >= _LEAST_LENGTH) & (thick <= _THICKEST * (last - first))
    # A blurred corner extends along its gradient, an edge across it.
    straight = long & (np.abs(rising) >= _ALIKE)
    return [
        _Segment(
            x=float((x[k] + middle[k] * tx[k]) * cells.every + cells.middle),
            y=float((y[k] + middle[k] * ty[k]) * cells.every + cells.middle),
            tx=float(tx[k]),
            ty=float(ty[k]),
            half=0.5 * float(last[k] - first[k]) * cells.every,
            thick=float(thick[k]) * cells.every,
            strength=float(strength[k]),
            label=int(k + 1),
        )
        for k in np.flatnonzero(straight)
    ]


def _regions(segment: _Segment, cells: _Gradients, picture: Picture) -> tuple[tuple[Roi, ...], str]:
    """Return the regions for a segment, the best first; none, and the reason, if there is no room.

    Best is the largest length · √reach among regions without other edges that are long enough for all sampling phases
    (noise falls with the length, truncation of the line spread with the reach).
    """
    upright = abs(segment.ty) >= abs(segment.tx)
    lead, side = (abs(segment.ty), abs(segment.tx)) if upright else (abs(segment.tx), abs(segment.ty))
    channels = picture.select("all")
    pitch = min(channel.pitch_pixel for channel in channels)  # at least one channel must be measurable
    least_span, least_reach = max(_LEAST_SPAN, 8.0 * pitch / lead), max(_LEAST_REACH, 4.0 * pitch)
    longest = min(2.0 * (segment.half - 1.0 - segment.thick), _MOST_SPAN)
    if longest < least_span:
        return (), f"{max(longest, 0.0):.0f} px that are straight between its ends; {least_span:.0f} are needed"
    # Half sizes along and across: the edge leaves the region at its ends with a margin ``aside``.
    spans, asides = np.geomspace(least_span, longest, _SPANS), np.geomspace(_LEAST_ASIDE, _FULL_REACH / lead, _ASIDES)
    span, aside, shift = (grid.ravel() for grid in np.meshgrid(spans, asides, _SHIFTS))
    tall = 0.5 * span * lead
    wide = tall * side / lead + aside
    # Interleaved planes all have the same number of samples.
    unit = 2 if any(max(plane.step) > 1 for plane in picture.planes) else 1
    sizes = (tall, wide) if upright else (wide, tall)
    first, last = [], []
    for middle, along, half in zip((segment.y, segment.x), (segment.ty, segment.tx), sizes, strict=True):
        at = middle + along * shift * (longest - span)
        begin = unit * np.round((at - half) / unit).astype(np.intp)
        first.append(begin)
        last.append(begin + 2 * unit * np.maximum(1, np.round(half / unit)).astype(np.intp))
    middle_reach = np.minimum(wide / lead, tall / max(side, 1e-9))
    reach = np.minimum(_FULL_REACH, 0.5 * (middle_reach + np.minimum(middle_reach, aside * lead)))
    inside = (first[0] >= 0) & (first[1] >= 0) & (last[0] <= picture.shape[0]) & (last[1] <= picture.shape[1])
    fits = inside & (reach >= least_reach)
    if not fits.any():
        return (), f"less than {least_reach:.0f} px from it to the picture's border"
    free = fits & ~_holds_others(segment, cells, first, last)
    if not free.any():
        needed = f"{least_span:.0f} px of it must have {least_reach:.0f} px free on either side"
        return (), f"other edges too near: {needed}"
    enough = max(channel.gap_pixel * lead / max(side, 1e-3) + 3.0 * channel.period_pixel for channel in channels)
    levels = np.minimum(1.0, reach / (_THICKS * segment.thick))
    worth = span * np.sqrt(reach) * levels * (1.0 - _ASKEW * np.abs(shift))
    worth *= np.where(span >= min(enough, span[free].max()), 1.0, 1e-3)
    rois = []
    for most in _REACHES:
        allowed = free & (reach <= most)
        if allowed.any():
            best = int(np.argmax(np.where(allowed, worth, 0.0)))
            (top, left), (bottom, right) = (int(edges[best]) for edges in first), (int(edges[best]) for edges in last)
            rois.append(Roi(top, left, bottom - top, right - left))
    return tuple(dict.fromkeys(rois)), ""


def _holds_others(
    segment: _Segment, cells: _Gradients, first: list[npt.NDArray[np.intp]], last: list[npt.NDArray[np.intp]]
) -> npt.NDArray[np.bool_]:
    """Return which regions, given by first and last rows and columns, contain part of another edge."""
    # Cells with centres in each region; smoothing makes an edge wider in cells than it is.
    begin, end = [], []
    for starts, stops, count in zip(first, last, cells.label.shape, strict=True):
        begin.append(np.clip(np.ceil((starts - cells.middle) / cells.every), 0, count).astype(np.intp))
        end.append(np.clip(np.floor((stops - cells.middle) / cells.every) + 1, 0, count).astype(np.intp))
    top, left = int(begin[0].min()), int(begin[1].min())
    part = (slice(top, int(end[0].max())), slice(left, int(end[1].max())))
    gx, gy, label = (field[part] for field in cells[:3])
    y = (np.arange(label.shape[0]) + top)[:, None] * cells.every + cells.middle - segment.y
    x = (np.arange(label.shape[1]) + left)[None, :] * cells.every + cells.middle - segment.x
    across, along = np.abs(y * segment.tx - x * segment.ty), np.abs(x * segment.tx + y * segment.ty)
    one = 2.0 * cells.every + 3.0
    strength = np.hypot(gx, gy)
    turned = (gx * segment.ty - gy * segment.tx < _ALIKE * strength) & (strength > _OTHER * segment.strength)
    # A blurred edge is wide, and all of its width belongs to it.
    wide = np.where(label == segment.label, one + 4.0 * segment.thick, one)
    # Beyond its plateaus, a strong gradient belongs to another edge.
    again = (across > max(one, 3.0 * segment.thick)) & (strength > _OTHER * segment.strength)
    others = (across > wide) | (along > segment.half + wide) | (turned & (label != segment.label)) | again
    others &= label > 0
    total = np.zeros((label.shape[0] + 1, label.shape[1] + 1), np.int64)
    np.cumsum(np.cumsum(others, axis=0), axis=1, out=total[1:, 1:])
    rows, cols = ((begin[0] - top, end[0] - top), (begin[1] - left, end[1] - left))
    held: npt.NDArray[np.int64] = (
        total[rows[1], cols[1]] - total[rows[0], cols[1]] - total[rows[1], cols[0]] + total[rows[0], cols[0]]
    )
    return held > 0


def _overlap(a: Roi, b: Roi) -> bool:
    """Whether two regions are mostly the same."""
    rows = min(a.row + a.rows, b.row + b.rows) - max(a.row, b.row)
    cols = min(a.col + a.cols, b.col + b.cols) - max(a.col, b.col)
    return min(rows, cols) > 0 and 2 * rows * cols > min(a.rows * a.cols, b.rows * b.cols)
