"""Long smooth outlines in pieces: where nothing else is near, a photosite sees a line that bends a little.

Sides that go on in one another with hardly a turn are a run, cut into pieces of about one length. About a piece's chord
the run is a polynomial: what sides' wobble about the curve leaves is 0 on average over each of them (bending.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from numpy.polynomial import polynomial as P

from camsim.arrays import F64, I64
from camsim.rendering.aberrated.kernels import Lines
from camsim.rendering.across.line_kernels import Pieces
from camsim.rendering.edges import Edges

Mask: TypeAlias = npt.NDArray[np.bool_]

TURN = 0.05  # radians from one side to the next: what turns more is a corner
DEGREE = 6
PARTS = 4  # of a piece, at the least, that long sides are cut into
STEEP, SHORTER = 0.3, 0.9  # of a run against its chord; of a run, a chord than which nothing has sides that steep
HEARD = 1.0 / 3.0  # of the reach: as far along a line as what it lacks is looked at


def pieces_of(edges: Edges, low: F64, high: F64, reach: float, long: float, allowed: F64) -> tuple[Pieces, Lines]:
    """Return the pieces within ``reach`` of a window, and what is none: sides (response −1), and runs' ends (0).

    low, high : x and y of the window's corners;  reach: of a line;  long: pieces
    allowed   : how far a run may be from what it is taken for, half of the square of how much it may bend, and how
        fast its bend may grow; pitches
    """
    apart = np.maximum(1, np.ceil(PARTS * edges.length / long)).astype(int)
    owner = np.repeat(np.arange(len(edges)), apart)
    part = (np.arange(owner.size) - np.repeat(np.cumsum(apart) - apart, apart)) / apart[owner]
    along = edges.end - edges.start
    start = edges.start[owner] + part[:, None] * along[owner]
    last = np.append(owner[1:] != owner[:-1], True)
    end = np.where(last[:, None], edges.end[owner], np.roll(start, -1, axis=0))
    here = np.all((np.maximum(start, end) >= low - reach) & (np.minimum(start, end) <= high + reach), axis=1)
    joined = _joined(edges)[owner] | ~last
    start, end, owner = start[here], end[here], owner[here]
    number = np.flatnonzero(here)
    joined = np.append(joined[here][:-1] & (np.diff(number) == 1), False)[: owner.size]
    length = np.hypot(*(end - start).T)
    fits: list[tuple[I64, _Fit]] = []
    loose: list[I64] = [np.empty(0, np.int64)]
    lines: list[F64] = []  # that pieces begin and end at
    marks: list[F64] = []
    for run in np.split(np.arange(owner.size), np.flatnonzero(~joined)[:-1] + 1) if owner.size else []:
        walked, whole = np.cumsum(length[run]) - 0.5 * length[run], float(length[run].sum())
        count = max(1, math.ceil(whole / long))
        before: _Fit | None = None
        for own in np.split(run, np.searchsorted(walked, whole * np.arange(1, count) / count)):
            if not own.size:
                continue
            fit, first, last_one = _fitted(start[own], end[own]), own[0], own[-1]
            if not fit.is_line(HEARD * reach, allowed):
                loose.append(own)
                before = None
                continue
            begin = np.concatenate([start[first], fit.frame[2:4]])
            if before is not None and before.goes_on(fit, HEARD * reach, allowed[0]):
                both = end[first] - start[first - 1]
                begin[2:] = lines[-1][2:] = both / np.hypot(*both)
                marks.pop()
            else:
                marks.append(start[first])
            fits.append((owner[first], fit))
            lines += [begin, np.concatenate([end[last_one], fit.frame[2:4]])]
            marks.append(end[last_one])
            before = fit
    which = np.array([number for number, _ in fits], int)
    pieces = Pieces(
        frame=np.array([fit.frame for _, fit in fits]).reshape(-1, 5),
        shape=np.array([fit.shape for _, fit in fits]).reshape(-1, DEGREE + 1),
        ends=np.array(lines).reshape(-1, 2, 4),
        spectra=np.stack([edges.left[which], edges.right[which]], axis=1),
    )
    return pieces, _marking(start, end, np.concatenate(loose), np.array(marks).reshape(-1, 2))


def _joined(edges: Edges) -> Mask:
    """Return which edges go on in the next one, alone, with the same on either side."""
    points, begin, finish = edges.corners
    met = np.bincount(begin, minlength=len(points)) + np.bincount(finish, minlength=len(points))
    along = edges.end - edges.start
    a, b = along[:-1], along[1:]
    turn = np.abs(np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], np.sum(a * b, axis=1)))
    same = (edges.left[1:] == edges.left[:-1]) & (edges.right[1:] == edges.right[:-1])
    return np.append((finish[:-1] == begin[1:]) & (met[finish[:-1]] == 2) & same & (turn <= TURN), False)


def runs_of(edges: Edges) -> list[I64]:
    """Return edges that go on in one another with hardly a turn, run by run, all of them."""
    if not len(edges):
        return []
    return np.split(np.arange(len(edges)), np.flatnonzero(~_joined(edges)[:-1]) + 1)


def _marking(start: F64, end: F64, loose: I64, ends: F64) -> Lines:
    """Return what is marked: sides that are of no piece, with all beside them, and ends of runs."""
    x, y = np.concatenate([start[loose], ends]).T
    along = end[loose] - start[loose]
    length = np.hypot(along[:, 0], along[:, 1])
    nothing = np.zeros(len(ends))
    tx, ty = (np.concatenate([part / np.maximum(length, 1e-300), nothing]) for part in along.T)
    response = np.concatenate([np.full(loose.size, -1), np.zeros(len(ends), int)])
    return Lines(x, y, tx, ty, np.concatenate([length, nothing]), response, np.zeros_like(response))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Fit:
    """A polynomial through a piece; off: how far sides are from it on average, at the most."""

    frame: F64
    shape: F64
    off: float

    def height(self, s: F64, order: int = 0) -> F64:
        """Return the height over the chord, or a derivative of it along the chord, at s = −1 … 1."""
        found: F64 = P.polyval(s, P.polyder(self.shape, order)) * (2.0 / self.frame[4]) ** order
        return found

    def is_line(self, heard: float, allowed: F64) -> bool:
        """Whether a photosite that hears so much of it cannot tell it from a parabola, nor how that adds up."""
        s = np.linspace(-1.0, 1.0, 9)
        slope, bend, twist = (np.abs(self.height(s, order)).max() for order in (1, 2, 3))
        square = (0.5 * bend * heard**2) ** 2
        return bool(slope <= STEEP and self.off <= allowed[0] and square <= allowed[1] and twist <= allowed[2])

    def goes_on(self, other: _Fit, heard: float, allowed: float) -> bool:
        """Whether the other piece goes on where this one ends, without a corner."""
        (x, y, tx, ty, length), (u, v, ux, uy, own) = self.frame, other.frame
        for t in (heard, 0.0, -heard):
            s = np.array(1.0 + 2.0 * t / length)
            along, height = length + t, float(self.height(s))
            px, py = x + along * tx - height * ty - u, y + along * ty + height * tx - v
            gap = ux * py - uy * px - float(other.height(np.array(2.0 * (ux * px + uy * py) / own - 1.0)))
            if abs(gap) > 2.0 * allowed:
                return False
        return True


def _fitted(start: F64, end: F64) -> _Fit:
    """Return the polynomial through sides that go on in one another."""
    first, chord = start[0], end[-1] - start[0]
    length, sides = float(np.hypot(*chord)), np.hypot(*(end - start).T)
    if length < SHORTER * float(sides.sum()):
        return _Fit(frame=np.ones(5), shape=np.zeros(DEGREE + 1), off=math.inf)
    tx, ty = chord / length if length > 0.0 else (1.0, 0.0)
    places = np.stack([start, 0.5 * (start + end), end])
    x, y = places[..., 0] - first[0], places[..., 1] - first[1]
    s = 2.0 * (x * tx + y * ty) / max(length, 1e-300) - 1.0
    height = y * tx - x * ty
    degree = min(DEGREE, len(start))
    powers = np.polynomial.polynomial.polyvander(s, degree)
    # Simpson's rule: on average over a side what it wobbles by is nothing.
    rule = np.array([1.0, 4.0, 1.0]) / 6.0
    powers, height = np.einsum("k,knd->nd", rule, powers), rule @ height
    weight = np.sqrt(sides)
    shape = np.zeros(DEGREE + 1)
    if len(start) > 1:
        shape[: degree + 1] = np.linalg.lstsq(powers * weight[:, None], height * weight, rcond=None)[0]
    off = float(np.abs(powers @ shape[: degree + 1] - height).max())
    return _Fit(frame=np.array([*first, tx, ty, length]), shape=shape, off=off)
