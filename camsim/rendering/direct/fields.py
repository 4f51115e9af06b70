"""Light of pictures, gradients and points at photosites: direct sums of the PSF over their visible parts.

The visible part of a picture or a gradient comes from the check's separate painter's rule. Samples of a picture with
fully visible splines use a PSF that is convolved with the spline. All others are integrated cell by cell with Gauss
rules, where a cell lies between a picture's knots; a cell that an outline cuts is integrated line by line.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np

from camsim.core.arrays import F64, I64, distinct, picked
from camsim.core.cached import cached_property
from camsim.core.kernels import shared
from camsim.numerics.cut_cells import cell_states, cut_nodes
from camsim.numerics.picture_splines import coefficients_of, values_of
from camsim.numerics.quadrature import GOLDEN, gauss_legendre, gauss_order, gauss_pieces
from camsim.rendering.direct.painter import covered
from camsim.rendering.direct.photosites import over_nodes, over_samples
from camsim.rendering.direct.records import Nodes, Table
from camsim.rendering.direct.scenery import pieces_of, shapes_of
from camsim.rendering.direct.spread import Spline
from camsim.rendering.grid import Grid
from camsim.scene import Picture, PointSource, Scene, flattened
from camsim.scene.arcs import Fineness
from camsim.scene.gradients import Gradient
from camsim.scene.primitives import turned
from camsim.scene.raster import DEGREES, Field
from camsim.spectra.component import Component
from camsim.spectra.curve import Curve, Spectrum

MOST_PHASE = 250.0  # of a spline with which the PSF is convolved: about the number of harmonics
CELL, TURNS = 8.0, 2.0  # largest side of a gradient's cell: periods of the lens's highest frequency, and its own cycles
FAR_NODES, MOST_NODES = 4, 120  # along a side of a cell: of far ones, and at most
# Relative error of a rule over the tail: at most this, times (half a cell over twice r) to its degree less that of the
# spline; of cells that an outline cuts, and by the degree of the spline in all others.
OF_CUT_TAIL, OF_TAIL = 25.0, {0: 25.0, 1: 4.0, 3: 0.06}
MOST_TURN = 0.1  # radians of a chord: the bound on its error is of small angles
NODES_A_WAVE = 2.5  # along a side of a cell
OF_HIDING = 0.1  # of the allowed error, for outlines that may hide a point near them


Tabled: TypeAlias = Callable[[Spline | None], tuple[Table, F64, F64]]


class Light(NamedTuple):
    """The PSF, and the weights (planes, channels, kinds) of its kinds of light in each plane."""

    table: Table
    weights: F64


@dataclass(frozen=True, kw_only=True, eq=False)
class Seen:
    """The visible part of one picture or gradient, on a lattice of cells, pitches.

    shape    : rows and columns of cells;  corner: corner of the first cell;  sides: (2, 2) vectors of its sides
    cut      : outlines (start, end) of the visible part, in cells; None: all is visible
    values   : function of places (n, 2) in cells, and of a picture's coefficients that count, that returns (planes, n)
    coefficients : (planes, rows, cols) of a picture's splines: cell (r, c) uses those from (r, c) on
    degree   : degree of these splines
    cycles   : largest number of a gradient's cycles per cell, for each cell (rows, cols)
    """

    shape: tuple[int, int]
    corner: F64
    sides: F64
    cut: tuple[F64, F64] | None
    values: Callable[[F64, np.ndarray | None], F64]
    coefficients: F64 | None = None
    degree: int = 0
    cycles: F64 | float = 0.0

    @property
    def step(self) -> float:
        """Side of a cell, pitches."""
        return float(np.hypot(*self.sides[0]))

    @cached_property
    def states(self) -> tuple[np.ndarray, np.ndarray]:
        """Masks (rows, cols) of the cells that are fully visible, and of those that an outline cuts."""
        rows, cols = self.shape
        if self.cut is None:
            return np.ones((rows, cols), bool), np.zeros((rows, cols), bool)
        flips, is_cut = np.zeros((rows, cols + 1), np.uint8), np.zeros((rows, cols), bool)
        cell_states(*self.cut, flips, is_cut)
        whole: np.ndarray = (np.cumsum(flips[:, :-1], axis=1, dtype=np.uint8) % 2 == 1) & ~is_cut
        return whole, is_cut

    def whole_samples(self) -> np.ndarray:
        """Return a mask (rows, cols) of the coefficients whose splines are fully visible."""
        return ~_any(~np.pad(self.states[0], self.degree), self.degree + 1)

    def cells(self, others: np.ndarray | None) -> I64:
        """Return rows and columns (n, 2) of cells to integrate; others: mask of coefficients to integrate."""
        whole, is_cut = self.states
        wanted = np.array(whole | is_cut, bool)
        if others is not None:
            wanted &= _any(others, self.degree + 1)
        return np.argwhere(wanted)

    def nodes(self, cells: I64, others: np.ndarray | None, order: int) -> tuple[I64, F64, F64]:
        """Return where each cell's nodes begin (n + 1,), their places (m, 2) and their light (planes, m)."""
        x, w = gauss_legendre(order)
        grid = 0.5 * (1.0 + np.stack(np.meshgrid(x, x), axis=-1).reshape(-1, 2))
        weight = 0.25 * np.outer(w, w).ravel()
        is_cut = self.states[1][cells[:, 0], cells[:, 1]]
        counts, of_cut = np.full(len(cells), order * order), np.empty((0, 3))
        if self.cut is not None:
            first, of_cut = cut_nodes(*self.cut, cells[is_cut], order)
            counts[is_cut] = np.diff(first)
        begin = np.concatenate([[0], np.cumsum(counts)])
        item = np.repeat(cells, counts, axis=0)
        t, weights = np.empty((len(item), 2)), np.empty(len(item))
        here = np.repeat(~is_cut, counts)
        t[here] = np.tile(grid, (int(np.count_nonzero(~is_cut)), 1))
        weights[here] = np.tile(weight, int(np.count_nonzero(~is_cut)))
        t[~here], weights[~here] = of_cut[:, :2], of_cut[:, 2]
        places = t + item[:, ::-1]
        light = self.values(places, others) * (weights * self.step**2)
        return begin, self.corner + np.einsum("na,ax->nx", places, self.sides), light


class Fields:
    """Pictures, gradients and points of a scene; allowed: error of a sum; highest: largest frequency, cycles/pitch."""

    def __init__(self, scene: Scene, pitch_um: float, highest: float, allowed: float) -> None:
        self.scene, self.pitch_um, self.highest, self.allowed = scene, pitch_um, highest, allowed
        self.shapes = [(k, one) for k, one in enumerate(scene.shapes) if isinstance(one, Picture | Gradient)]

    @cached_property
    def seen(self) -> list[Seen]:
        """Visible parts of pictures and gradients."""
        return [self._seen(number, shape) for number, shape in self.shapes]

    @property
    def visible(self) -> bool:
        """Whether any picture, gradient or point is visible."""
        return bool(self.points) or any(seen.cut is None or len(seen.cut[0]) for seen in self.seen)

    @cached_property
    def points(self) -> list[PointSource]:
        """Points that no later shape covers."""
        points = [(k, one) for k, one in enumerate(self.scene.shapes) if isinstance(one, PointSource)]
        if not points:
            return []
        fine = Fineness(1.0 / self.highest, OF_HIDING * self.allowed)
        shapes, _ = shapes_of(self.scene.framed(0.5), self.pitch_um, fine)
        begins = np.cumsum([0, *(len(flattened([shape])) for shape in self.scene.framed(0.5).shapes)])
        at = np.array([one.centre_um for _, one in points]) / self.pitch_um
        hidden = np.zeros(len(points), bool)
        covered(shapes, at, begins[np.array([k for k, _ in points])], hidden)
        return [one for (_, one), never in zip(points, hidden.tolist(), strict=True) if not never]

    @property
    def spectra(self) -> list[Spectrum | Component]:
        """Spectra of all planes, followed by those of all points."""
        return [*(item for _, shape in self.shapes for item in shape.spectra), *self._colours]

    @cached_property
    def _colours(self) -> list[Spectrum]:
        return list(dict.fromkeys(point.reflectance for point in self.points))

    @cached_property
    def strongest(self) -> tuple[float, float]:
        """The largest step of a picture, pitches, and the brightest point, photosites."""
        steps = [shape.step_um / self.pitch_um for _, shape in self.shapes if isinstance(shape, Picture)]
        return max(steps, default=0.0), max((point.photosites or 0.0 for point in self.points), default=0.0)

    def _outline(self, number: int) -> tuple[F64, F64] | None:
        """Return segments (start, end), each (n, 2), that bound a field's visible part, by the painter's rule.

        None: a picture of squares that is visible entirely.
        """
        field, later = self.scene.shapes[number], self.scene.shapes[number + 1 :]
        squares = isinstance(field, Picture) and field.interpolation == "squares"
        if squares and all(isinstance(one, PointSource) for one in later):
            return None
        assert isinstance(field, Field)
        # Two spectra that differ from all others.
        item, beyond = (
            Curve((400.0, 700.0), ends, name="the picture", outside="hold") for ends in ((0.25, 0.75), (0.75, 0.25))
        )
        covered_by = Scene(background=beyond, shapes=[field.frame(item), *later]).framed(0.5)
        pieces, spectra = pieces_of(covered_by, self.pitch_um, Fineness(1.0 / self.highest, self.allowed))
        which = spectra.index(item) if item in spectra else -1
        mine = (pieces.left == which) | (pieces.right == which)
        o = picked(pieces.outlines, mine)
        straight = o.turn_rad == 0.0
        begin = np.stack([o.x, o.y], axis=1)[straight]
        starts, ends = [begin], [begin + np.stack([o.dx, o.dy], axis=1)[straight]]
        # A chord that cells cut is wrong by the area between it and its arc, about s³/(72·√3·R), times the PSF's peak.
        for x, y, radius, first, turn in np.stack([o.x, o.y, o.dx, o.from_rad, o.turn_rad], axis=1)[~straight].tolist():
            side = min(math.cbrt(72.0 * radius * self.allowed), 0.5 / self.highest)
            count = math.ceil(max(radius * abs(turn) / side, abs(turn) / MOST_TURN))
            count += count in (1, 3)
            angle = first + turn * np.arange(count + 1) / count
            # A polygon with the area of the curve has its corners outside it, but for ends, whose neighbours make up.
            part = abs(turn) / count
            out = np.full(count + 1, radius * math.sqrt(part / math.sin(part)))
            if abs(turn) < 2.0 * math.pi * (1.0 - 1e-12):
                beside = radius if count == 2 else out[1]
                out[[1, -2]] = 2.0 * radius**2 * part / (math.sin(part) * (radius + beside))
                out[[0, -1]] = radius
            corners = np.stack([x + out * np.cos(angle), y + out * np.sin(angle)], axis=1)
            starts.append(corners[:-1])
            ends.append(corners[1:])
        return np.concatenate(starts), np.concatenate(ends)

    def _seen(self, number: int, shape: Picture | Gradient) -> Seen:
        outline = self._outline(number)
        axes, middle = turned(np.eye(2), shape.rotate_deg), np.array(shape.centre_um) / self.pitch_um
        if isinstance(shape, Gradient):
            side = 1.0 / max(self.highest / CELL, float(shape.cycles_per_um()) * self.pitch_um / TURNS)
            cols, rows = (2 * math.ceil(half / self.pitch_um / side) for half in shape.half_um)
        else:
            side, (rows, cols) = shape.step_um / self.pitch_um, shape.shape
            if shape.interpolation != "squares":
                rows, cols = rows + 1, cols + 1
        corner = middle - 0.5 * side * (np.array([cols, rows], float) @ axes)
        cut = None
        if outline is not None:
            start, end = ((ends - corner) @ axes.T / side for ends in outline)
            cut = start, end
        place = functools.partial(Seen, shape=(rows, cols), corner=corner, sides=side * axes, cut=cut)
        if isinstance(shape, Gradient):

            def of_gradient(places: F64, _: np.ndarray | None) -> F64:
                x, y = (places - 0.5 * np.array([cols, rows])).T * (side * self.pitch_um)
                return shape.planes_at(x, y)

            across, down = (np.abs(np.arange(count) + 0.5 - 0.5 * count) for count in (cols, rows))
            nearest_um = np.maximum(np.hypot(across, down[:, None]) - 0.75, 0.0) * (side * self.pitch_um)
            return place(values=of_gradient, cycles=shape.cycles_per_um(nearest_um) * (side * self.pitch_um))
        degree = DEGREES[shape.interpolation]
        coefficients = _coefficients(np.array(shape.planes, np.float64), degree)
        values = functools.partial(values_of, coefficients, degree)
        return place(values=values, coefficients=coefficients, degree=degree)

    def light(self, points: F64, channels: int, tabled: Tabled) -> F64:
        """Return the light (n, channels) at points (n, 2); tabled: see ``DirectCheck._tabled``."""
        out = np.zeros((len(points), channels))
        first = 0
        for (_, shape), seen in zip(self.shapes, self.seen, strict=True):
            self._add(seen, slice(first, first + len(shape.spectra)), points, tabled, out)
            first += len(shape.spectra)
        if self.points:
            behind = _light(tabled(None), slice(first, None))
            at = np.array([point.centre_um for point in self.points]) / self.pitch_um
            light = np.zeros((len(self._colours), len(at)))
            for k, point in enumerate(self.points):
                light[self._colours.index(point.reflectance), k] = point.photosites or 0.0
            begins = np.arange(len(at))[:, None, None] + np.array([[0, 1], [0, 1]])
            shared(len(points), functools.partial(over_nodes, points, at, 0.0, Nodes(begins, at, light), *behind, out))
        return out

    def nodes(self, until: float) -> float:
        """Return about how many terms the sum for a photosite has; until: cutoff radius of ringing, pitches."""
        total = float(len(self.points))
        for seen in self.seen:
            cells = float(seen.states[0].size)
            near = min(cells, math.pi * (until / seen.step + 1.0) ** 2)
            each = (NODES_A_WAVE * self.highest * seen.step + FAR_NODES) ** 2
            far, part = (FAR_NODES**2, 1.0) if seen.coefficients is None else (1.0, 4.0 / math.sqrt(cells))
            total += far * cells + part * near * each
        return total

    def places(self, grid: Grid, count: int) -> F64:
        """Return difficult places (n, 2): outlines over fields, centres and corners of fields, and points."""
        low = np.array(grid.first_centre)
        found = [np.empty((0, 2))]
        for (_, shape), seen in zip(self.shapes, self.seen, strict=True):
            middle, half = np.array(shape.centre_um) / self.pitch_um, np.array(shape.half_um) / self.pitch_um
            axes = turned(np.eye(2), shape.rotate_deg)
            sides = np.array([(0, 0), (-1, -1), (1, 1), (1, -1), (-1, 1)])
            item = [middle + (sides * half) @ axes]
            if seen.cut is not None and len(seen.cut[0]):
                along = seen.corner + 0.5 * (seen.cut[0] + seen.cut[1]) @ seen.sides
                inside = along[np.all((along >= low - 0.5) & (along <= low + np.array([grid.cols, grid.rows])), axis=1)]
                item.insert(0, inside[(np.arange(min(count, len(inside))) * GOLDEN % 1.0 * len(inside)).astype(int)])
            found.append(np.concatenate(item))
        # Hidden points are included: an image in which one is visible is wrong.
        points = [one for one in self.scene.shapes if isinstance(one, PointSource)]
        points.sort(key=lambda point: -(point.photosites or 0.0))
        found.append(np.array([point.centre_um for point in points[:count]]).reshape(-1, 2) / self.pitch_um)
        # Take turns between the lists.
        rank = np.concatenate([np.arange(len(item)) for item in found])
        return np.concatenate(found)[np.argsort(rank, kind="stable")]

    def _add(self, seen: Seen, planes: slice, points: F64, tabled: Tabled, out: F64) -> None:
        others = None
        if seen.coefficients is not None:
            along = seen.sides[0] / seen.step
            spline = Spline(seen.degree, seen.step, (float(along[0]), float(along[1])))
            whole = np.zeros(seen.coefficients.shape[1:], bool)
            if 2.0 * math.pi * self.highest * spline.extent <= MOST_PHASE:
                whole = seen.whole_samples()
                behind = _light(tabled(spline), planes, seen.step**2)
                centre = seen.corner + (0.5 - 0.5 * seen.degree) * seen.sides.sum(axis=0)  # of the first spline
                of_whole = points, seen.coefficients, whole, np.stack([centre, *seen.sides])
                shared(len(points), functools.partial(over_samples, *of_whole, *behind, out))
            others = ~whole
            if whole.all():
                return
        cells = seen.cells(others)
        if not len(cells):
            return
        behind = _light(tabled(None), planes)
        centres = seen.corner + (cells[:, ::-1] + 0.5) @ seen.sides
        reach = behind.table.until + 0.75 * seen.step
        near = np.zeros(len(cells), bool)
        for point in points:
            near |= np.hypot(*(centres - point).T) < reach
        turns = np.broadcast_to(seen.cycles, seen.shape)[cells[:, 0], cells[:, 1]]
        phase = math.pi * (self.highest * seen.step + float(turns[near].max(initial=0.0)))
        fine = gauss_order(phase, max(self.allowed, 1e-12), most=MOST_NODES) + seen.degree // 2
        # The coarse cells send at most the light beyond the table's end.
        far = np.einsum("pcq,q->pc", np.abs(behind.weights), np.abs(behind.table.powers[0, :, 0]))
        beyond = max(2.0 * math.pi * float(far.max()) / behind.table.until, self.allowed)
        share = max(self.allowed / beyond, 1e-12)
        error = (0.25 * seen.step / reach) ** (2.0 * np.arange(2, FAR_NODES) - seen.degree)
        fewest, of_cut = (2 + int(np.sum(times * error > share)) for times in (OF_TAIL[seen.degree], OF_CUT_TAIL))
        least = np.where(seen.states[1][cells[:, 0], cells[:, 1]], of_cut, fewest)
        coarse = np.maximum(gauss_pieces(math.pi * turns, share, MOST_NODES)[1], least)
        orders = [(1, order, coarse == order) for order in distinct(coarse).tolist()]
        begins, first, places, found = np.zeros((len(cells), 2, 2), np.int64), 0, [], []
        for which, order, some in [(0, fine, near), *orders]:
            begin, at, light = seen.nodes(cells[some], others, order)
            begins[some, which] = first + np.stack([begin[:-1], begin[1:]], axis=1)
            first += len(at)
            places.append(at)
            found.append(light)
        nodes = Nodes(begins, np.concatenate(places), np.concatenate(found, axis=1))
        shared(len(points), functools.partial(over_nodes, points, centres, reach, nodes, *behind, out))


def _light(tabled: tuple[Table, F64, F64], planes: slice, times: float = 1.0) -> Light:
    """Return a table and the weights of its kinds of light in some planes."""
    return Light(tabled[0], np.ascontiguousarray(times * tabled[2][planes]))


def _any(mask: np.ndarray, n: int) -> np.ndarray:
    """Return whether any of the n × n places from each one on is in a mask."""
    rows = np.logical_or.reduce([mask[k : len(mask) - n + 1 + k] for k in range(n)])
    return np.array(np.logical_or.reduce([rows[:, k : rows.shape[1] - n + 1 + k] for k in range(n)]))


def _coefficients(planes: F64, degree: int) -> F64:
    """Return the B-spline coefficients through samples (planes, rows, cols), mirrored and padded at the ends."""
    if degree == 3:
        planes = coefficients_of(planes)
    more = (degree + 1) // 2
    return np.pad(planes, ((0, 0), (more, more), (more, more)), mode="symmetric")
