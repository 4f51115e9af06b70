"""What the check sees of a picture: patches of its field that are whole, and points of light for parts of patches.

The outline of what is seen comes from the check's own painter's rule. A patch that it cuts is integrated line by line:
between the crossings of a horizontal with the outline there is picture, and then there is none.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from camsim.arrays import F64, I64
from camsim.kept import cached_property
from camsim.rendering.check.patch_nodes import NEXT_TO, count_gathered, crossing, gathered, in_patch
from camsim.scene.raster import DEGREES, Raster

Segments = tuple[F64, F64]
Zone = tuple[float, tuple[float, float]]
LARGEST = 3.0  # pitches, of a patch
COUNTED = 32  # patches whose points are counted for a price
ASKED_AT = 0.3137  # of a patch, where it is asked whether it is seen: no picture's own side is there, as in its middle


@dataclass(frozen=True, kw_only=True, eq=False)
class Seen:
    """One picture, pitches.

    picture : whose samples;  less: (planes,) taken off every plane;  ones: whether a plane of ones follows
    outline : segments (start, end) (n, 2) about what is seen, in any order, pitches; None for all of it
    pitch_um : of the photosites;  order: of the rule on a patch that is cut
    """

    picture: Raster
    less: F64
    ones: bool
    outline: Segments | None
    pitch_um: float
    order: int

    @property
    def degree(self) -> int:
        """Of the splines."""
        return DEGREES[self.picture.interpolation]

    @property
    def parts(self) -> int:
        """Into how many a sample is parted along either side: rules are for patches of a few photosites.

        An odd number, so that knots stay knots.
        """
        return 2 * max(0, math.ceil(0.5 * (self.picture.step_um / self.pitch_um / LARGEST - 1.0))) + 1

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of samples, parted."""
        rows, cols = self.picture.shape
        return rows * self.parts, cols * self.parts

    @property
    def planes(self) -> int:
        """Number of planes."""
        return len(self.picture.planes) + self.ones

    @property
    def step(self) -> float:
        """Distance of samples, pitches."""
        return float(self.picture.width_um / self.pitch_um / self.shape[1])

    @cached_property
    def axes(self) -> F64:
        """Unit vectors along rows and columns."""
        angle = math.radians(self.picture.rotate_deg)
        return np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])

    @cached_property
    def corner(self) -> F64:
        """Where the first patch begins: the picture's own corner, or half a sample outside it."""
        rows, cols = self.shape
        outside = 0.0 if self.degree == 0 else 0.5
        middle = np.array(self.picture.centre_um) / self.pitch_um
        first: F64 = middle - self.step * np.einsum("a,ax->x", [0.5 * cols + outside, 0.5 * rows + outside], self.axes)
        return first

    @cached_property
    def values(self) -> F64:
        """Coefficients (planes, rows, cols): a patch takes those from its own place on."""
        # One copy, changed in place: of a large picture there is no room for more.
        planes = np.array(self.picture.planes, np.float64)
        if self.parts > 1:
            # The same splines on finer knots go through what they are there.
            for axis in (1, 2):
                planes = _between(_coefficients(planes, self.degree, axis), self.degree, self.parts, axis)
        for axis in (1, 2):
            planes = _coefficients(planes, self.degree, axis)
        planes -= self.less[:, None, None]
        if self.ones:
            planes = np.concatenate([planes, np.ones((1, *self.shape))])
        # The patch before the first sample lies between it and its own image.
        more = (self.degree + 1) // 2
        if not more:
            return np.ascontiguousarray(planes)
        return np.ascontiguousarray(np.pad(planes, ((0, 0), (more, more), (more, more)), mode="symmetric"))

    @cached_property
    def _sides(self) -> Segments:
        """Segments about what is seen, in patches from the first one."""
        if self.outline is None:
            rows, cols = self.shape
            outside = 0.0 if self.degree == 0 else 0.5
            corners = np.array([[0.0, 0.0], [cols, 0.0], [cols, rows], [0.0, rows]]) + outside
            return corners, np.roll(corners, -1, axis=0)
        start, end = (np.einsum("nx,ax->na", part - self.corner, self.axes) / self.step for part in self.outline)
        return start, end

    @cached_property
    def _states(self) -> tuple[np.ndarray, np.ndarray]:
        """(rows, cols) of patches: which are whole, and which an outline may cut."""
        rows, cols = (n + (self.degree > 0) for n in self.shape)
        if self.outline is None and self.degree == 0:
            return np.ones((rows, cols), bool), np.zeros((rows, cols), bool)
        whole, cut = np.zeros((rows, cols), bool), np.zeros((rows, cols), bool)
        start, end = self._sides
        low, high = np.minimum(start[:, 1], end[:, 1]), np.maximum(start[:, 1], end[:, 1])
        for row in range(rows):
            here = np.flatnonzero((high >= row - NEXT_TO) & (low <= row + 1 + NEXT_TO))
            a, b = start[here], end[here]
            y = row + ASKED_AT
            crosses = (np.minimum(a[:, 1], b[:, 1]) <= y) & (np.maximum(a[:, 1], b[:, 1]) > y)
            turns = np.searchsorted(np.sort(crossing(a[crosses], b[crosses], y)), np.arange(cols) + ASKED_AT)
            whole[row] = turns % 2 == 1
            flat = np.abs(a[:, 1] - b[:, 1]) < NEXT_TO
            at_top, at_bottom = (
                np.where(flat, place, crossing(a, np.where(flat[:, None], b + np.array([0.0, 1.0]), b), y))
                for place, y in ((a[:, 0], row - NEXT_TO), (b[:, 0], row + 1 + NEXT_TO))
            )
            ends_low, ends_high = np.minimum(a[:, 0], b[:, 0]), np.maximum(a[:, 0], b[:, 0])
            first = np.clip(np.minimum(at_top, at_bottom), ends_low, ends_high) - NEXT_TO
            last = np.clip(np.maximum(at_top, at_bottom), ends_low, ends_high) + NEXT_TO
            # A side of squares that an outline follows is no cut.
            along = flat & (np.abs(a[:, 1] - np.round(a[:, 1])) < NEXT_TO)
            upright = np.abs(a[:, 0] - b[:, 0]) < NEXT_TO
            along |= upright & (np.abs(a[:, 0] - np.round(a[:, 0])) < NEXT_TO)
            for f, g in zip(np.floor(first[~along]).tolist(), np.floor(last[~along]).tolist(), strict=True):
                cut[row, max(0, int(f)) : max(0, int(g) + 1)] = True
        return whole & ~cut, cut

    @property
    def loud(self) -> float:
        """Light of points that are no part of anything larger, square pitches."""
        return 0.0

    @property
    def whole(self) -> np.ndarray:
        """Which patches (rows, cols) are seen whole."""
        return self._states[0]

    def _nodes_in(self, patches: I64) -> Iterator[tuple[int, int, F64, F64]]:
        """Yield rows and columns of patches (n, 2) that outlines cut, row by row, with nodes and weights there."""
        start, end = self._sides
        low, high = np.minimum(start[:, 1], end[:, 1]), np.maximum(start[:, 1], end[:, 1])
        for row in np.unique(patches[:, 0]).tolist():
            here = np.flatnonzero((high >= row) & (low <= row + 1))
            a, b = start[here], end[here]
            for col in patches[patches[:, 0] == row, 1].tolist():
                yield row, col, *in_patch(a - [col, row], b - [col, row], self.order)

    @cached_property
    def _parts(self) -> tuple[F64, F64]:
        """Places (m, 2) and light (planes, m) of the parts of patches, of a patch's area 1."""
        places, lights = [np.empty((0, 2))], [np.empty((self.planes, 0))]
        for row, col, nodes, weights in self._nodes_in(np.argwhere(self._states[1])):
            if weights.size:
                nodes, light = gathered(nodes, self._field(row, col, nodes) * weights, self.order)
                places.append(nodes + np.array([col, row]))
                lights.append(light)
        placed = self.corner + self.step * np.einsum("na,ax->nx", np.concatenate(places), self.axes)
        return placed, np.concatenate(lights, axis=1)

    def lit_near(self, point: F64, zones: Sequence[Zone], *, beyond: bool = True) -> Iterator[tuple[F64, F64]]:
        """Yield where the light of parts of patches lies (m, 2), and how much it is (planes, m), of a patch's area 1.

        point, zones : about which it is to be summed, and how exactly at which distance; here it is the same for all
        beyond       : whether what lies beyond the last zone is wanted
        """
        if self._parts[0].size:
            yield self._parts

    def in_step_until(self, points: F64, longest: float, most: float, farthest: float) -> float:
        """Return how far off its rings may be heard in places (n, 2); samples may be in step anywhere.

        longest : of the rings' waves;  most: times what a ring's light, all of it in step, is of what is allowed, times
                  r³;  farthest: where all are heard no more
        """
        return farthest

    def _field(self, row: int, col: int, places: F64) -> F64:
        """Return (planes, n) the field on a patch at places 0 … 1."""
        n = self.degree + 1
        own = self.values[:, row : row + n, col : col + n]
        across, down = (_weights(self.degree, places[:, axis]) for axis in (0, 1))
        field: F64 = np.einsum("pij,ni,nj->pn", own, down, across)
        return field

    def points_near(self, zones: Sequence[Zone]) -> F64:
        """Return (zones + 1,) about how many points lie in each zone about a photosite, and beyond."""
        cut = float(np.count_nonzero(self._states[1]))
        passed = np.minimum(4.0 * np.array([low for _, (low, _) in zones] + [zones[-1][1][1]]) / self.step, cut)
        counts: F64 = self._each_part * np.diff(passed, append=cut)
        return counts

    @cached_property
    def _each_part(self) -> float:
        """How many points a patch has that is cut, of some: outlines of many sides cut it into many bands."""
        patches = np.argwhere(self._states[1])
        some = patches[:: max(1, len(patches) // COUNTED)]
        counts = [count_gathered(weights.size, self.order) for *_, weights in self._nodes_in(some)]
        return sum(counts) / max(1, len(some))

    def farthest(self, points: F64) -> float:
        """Return the largest distance of a photosite from the picture's first patch and its last."""
        rows, cols = self.whole.shape
        ends = self.corner + self.step * np.einsum(
            "na,ax->nx", np.array([[0, 0], [cols, 0], [cols, rows], [0, rows]], float), self.axes
        )
        return float(np.hypot(*(points[:, None] - ends[None]).transpose(2, 0, 1)).max())


def _coefficients(samples: F64, degree: int, axis: int) -> F64:
    """Return those of splines through samples along an axis, mirrored at either end.

    Such a spline is a cosine series, of which each is divided by what the splines pass.
    """
    if degree < 2:
        return samples
    count = samples.shape[axis]
    form = [1, 1, 1]
    form[axis] = count
    passed = (2.0 + np.cos(np.pi * np.arange(count) / count)) / 3.0
    through: F64 = scipy.fft.idct(scipy.fft.dct(samples, axis=axis) / passed.reshape(form), axis=axis)
    return through


def _between(coefficients: F64, degree: int, parts: int, axis: int) -> F64:
    """Return what splines are in the middles of a sample's parts, along an axis."""
    if degree == 0:
        return np.repeat(coefficients, parts, axis=axis)
    count, more = coefficients.shape[axis], (degree + 1) // 2
    padding = [(0, 0)] * 3
    padding[axis] = (more, more)
    mirrored = np.moveaxis(np.pad(coefficients, padding, mode="symmetric"), axis, -1)
    place = (np.arange(count * parts) + 0.5) / parts + 0.5
    first = np.floor(place).astype(int)
    weights = _weights(degree, place - first)
    total = sum(mirrored[..., first + k] * weights[:, k] for k in range(degree + 1))
    return np.ascontiguousarray(np.moveaxis(np.asarray(total), -1, axis))


def _weights(degree: int, t: F64) -> F64:
    """Return (n, degree + 1) splines by Cox and de Boor's recursion, on whole knots."""
    weights = np.ones((t.size, 1))
    for d in range(1, degree + 1):
        wider = np.zeros((t.size, d + 1))
        for k in range(d):
            # Of spline k of degree d − 1, whose support begins d − 1 − k knots before this patch.
            since = t + (d - 1 - k)
            wider[:, k + 1] += weights[:, k] * since / d
            wider[:, k] += weights[:, k] * (d - since) / d
        weights = wider
    return weights
