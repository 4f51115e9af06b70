"""Whether the last shapes of a scene cover a place, by the angles under which their outlines are seen from there.

A piece is seen under the angle between its ends where no line through the place parts its control points; where one
does, the piece is halved. So whatever bends is asked itself, however near it comes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from camsim.arrays import C128, F64, I64
from camsim.rendering.check.beziers import between
from camsim.scene import Primitive
from camsim.scene.curves import ARC, CUBIC, Curves

HALVINGS = 60
AT_ONCE = 1 << 18  # pieces times places
QUARTERS = 4  # of a curve, as far as one of a whole turn has tangents that meet


def covers(primitive: Primitive, places: C128) -> np.ndarray:
    """Return which places (n,), x + iy, a primitive covers: some fill of every layer does."""
    covered = np.ones(len(places), bool)
    for layer in primitive.layers:
        filled = np.zeros(len(places), bool)
        for fill in layer:
            turns = winds(fill.curves, places)
            filled |= turns % 2 == 1 if fill.rule == "evenodd" else turns != 0
        covered &= filled
    return covered


def hidden(places: C128, after: I64, primitives: Sequence[Primitive]) -> np.ndarray:
    """Return which places primitives cover that are numbered ``after`` (n,), or later."""
    found = np.zeros(len(places), bool)
    order = np.argsort(places.real, kind="stable")
    boxes = np.array([_box(one) for one in primitives]).reshape(-1, 4)
    x = places.real[order]
    begin, end = np.searchsorted(x, boxes[:, 0], "left"), np.searchsorted(x, boxes[:, 2], "right")
    for number in np.flatnonzero(end > begin).tolist():
        some = order[begin[number] : end[number]]
        y = places[some].imag
        some = some[(boxes[number, 1] <= y) & (y <= boxes[number, 3]) & (after[some] <= number) & ~found[some]]
        if some.size:
            found[some] = covers(primitives[number], places[some])
    return found


def winds(curves: Curves, places: C128) -> I64:
    """Return how often closed curves wind about places (n,)."""
    pieces = _Pieces.of(curves)
    low, high = (pick(pieces.hulls.real, 1) + 1j * pick(pieces.hulls.imag, 1) for pick in (np.amin, np.amax))
    begins, ends = pieces.hulls[:, 0], pieces.hulls[:, 3]
    step = max(1, AT_ONCE // max(1, len(begins)))
    angles = np.zeros(len(places))
    for first in range(0, len(places), step):
        own = places[first : first + step]
        x, y = own.real[:, None], own.imag[:, None]
        about = (low.real <= x) & (x <= high.real) & (low.imag <= y) & (y <= high.imag)
        far = np.where(about, 0.0, np.angle((ends - own[:, None]) * (begins - own[:, None]).conj()))
        angles[first : first + step] = far.sum(axis=1)
        place, piece = np.nonzero(about)
        np.add.at(angles, first + place, _angles(pieces.some(piece), own[place]))
    return np.rint(angles / math.tau).astype(np.int64)


def _angles(pieces: _Pieces, places: C128) -> F64:
    """Return the angles under which pieces are seen from places, each from its own."""
    angles, number = np.zeros(len(places)), np.arange(len(places))
    for turn in range(HALVINGS):
        seen = pieces.hulls - places[number, None]
        direction = _unit(seen[:, 0]) + _unit(seen[:, 3])
        ahead: F64 = (seen * direction.conj()[:, None]).real.min(axis=1)
        clear = ahead > (0.0 if turn < HALVINGS - 1 else -math.inf)
        np.add.at(angles, number[clear], np.angle(seen[clear, 3] * seen[clear, 0].conj()))
        pieces, number = pieces.some(~clear).halved(), np.repeat(number[~clear], 2)
        if not number.size:
            break
    return angles


class _Pieces(NamedTuple):
    """Parts of curves.

    hulls : (n, 4) control points;  axes: (n, 3) of an arc its centre and half axes, x + iy
    from_rad, to_rad : of an arc, along it; both 0 of others
    """

    hulls: C128
    axes: C128
    from_rad: F64
    to_rad: F64

    @classmethod
    def of(cls, curves: Curves) -> _Pieces:
        """Take curves, arcs in quarters."""
        p = curves.points[..., 0] + 1j * curves.points[..., 1]
        arc = np.repeat(np.flatnonzero(curves.kind == ARC), QUARTERS)
        quarter = np.arange(len(arc)) % QUARTERS
        turn = curves.turn_rad[arc] / QUARTERS
        hulls = np.where((curves.kind == CUBIC)[:, None], p, p[:, [0, 0, 3, 3]])[curves.kind != ARC]
        axes = np.stack([p[arc, 0] - p[arc, 1], p[arc, 1], p[arc, 2]], axis=1)
        begin, end = turn * quarter, turn * (quarter + 1)
        round_ones = _about_arcs(axes, begin, end)
        first, last = quarter == 0, quarter == QUARTERS - 1
        round_ones[first, 0], round_ones[last, 3] = p[arc[first], 0], p[arc[last], 3]
        nothing = np.zeros(len(hulls))
        return cls(
            np.concatenate([hulls, round_ones]),
            np.concatenate([np.zeros((len(hulls), 3)), axes]),
            np.concatenate([nothing, begin]),
            np.concatenate([nothing, end]),
        )

    def some(self, which: I64 | np.ndarray) -> _Pieces:
        """Return picked ones."""
        return _Pieces(self.hulls[which], self.axes[which], self.from_rad[which], self.to_rad[which])

    def halved(self) -> _Pieces:
        """Return the halves of each, one after the other."""
        half, middle = np.full(len(self.hulls), 0.5), 0.5 * (self.from_rad + self.to_rad)
        first, second = between(self.hulls, 0.0 * half, half), between(self.hulls, half, 2.0 * half)
        arc = self.from_rad != self.to_rad
        ends = self.hulls[:, [0, 3]]
        first[arc] = _about_arcs(self.axes[arc], self.from_rad[arc], middle[arc])
        second[arc] = _about_arcs(self.axes[arc], middle[arc], self.to_rad[arc])
        first[:, 0], second[:, 0], second[:, 3] = ends[:, 0], first[:, 3], ends[:, 1]
        hulls = np.stack([first, second], axis=1).reshape(-1, 4)
        from_rad = np.stack([self.from_rad, middle], axis=1).ravel()
        to_rad = np.stack([middle, self.to_rad], axis=1).ravel()
        return _Pieces(hulls, np.repeat(self.axes, 2, axis=0), from_rad, to_rad)


def _about_arcs(axes: C128, begin: F64, end: F64) -> C128:
    """Return points (n, 4) about arcs of up to a quarter: their ends, and between them twice where tangents meet."""
    middle, half = 0.5 * (begin + end), 0.5 * (end - begin)
    centre, u, v = axes.T
    meet = centre + (u * np.cos(middle) + v * np.sin(middle)) / np.cos(half)
    ends = [centre + u * np.cos(angle) + v * np.sin(angle) for angle in (begin, end)]
    return np.stack([ends[0], meet, meet, ends[1]], axis=1)


def _unit(vectors: C128) -> C128:
    size = np.abs(vectors)
    unit: C128 = vectors / np.where(size > 0.0, size, 1.0)
    return unit


def _box(primitive: Primitive) -> tuple[float, float, float, float]:
    """Return a box about what a primitive covers at the most: about one of its layers."""
    boxes = np.concatenate([np.empty((0, 4)), *(fill.curves.boxes for fill in primitive.layers[0])])
    if not len(boxes):
        return math.inf, math.inf, -math.inf, -math.inf
    (left, top), (right, bottom) = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
    return float(left), float(top), float(right), float(bottom)
