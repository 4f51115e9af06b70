"""Bézier curves that nothing comes near: the check integrates them as they are, and the painter takes their chords.

A curve is cut into parts that go forward all along, short enough for one Gauss rule. Where no other outline comes into
the convex hull of a part's control points, the part may be drawn out into its chord without meeting anything: what
covers what, on which side, stays as it is. So cuts and the painter's rule are asked about the chord. Other parts are
followed by arcs.
"""

from __future__ import annotations

import itertools

import numpy as np

from camsim.arrays import C128, F64, I64
from camsim.kernels import kernel
from camsim.rendering.check.near import Squares, touching
from camsim.scene.arcs import Fineness
from camsim.scene.curves import ARC, CUBIC, Curves

HALF_WAVES = 4.0  # half of a part's length: as much as one rule follows (``points.PANEL_BLURS``)
FORWARD = 0.5  # cosine between a part's chord and where it heads, at the least
HALVINGS, MORE_HALVINGS = 40, 6  # of a curve, and of what is short enough but turns back, as at a cusp
BETWEEN = 1e-6  # sine of the angle that parts which meet in an end leave between them and a line
ROUNDING = 1e-9  # of the largest coordinate: nearer than that nothing is told apart


def polynomials(p: C128) -> C128:
    """Return the coefficients (n, 4) of curves with control points (n, 4) as polynomials of t from −1 to 1."""
    a, b, c, d = p.T
    terms = [a + 3.0 * b + 3.0 * c + d, 3.0 * (d + c - b - a), 3.0 * (a - b - c + d), d - 3.0 * c + 3.0 * b - a]
    return np.stack(terms, axis=1) / np.complex128(8.0)


def between(p: C128, low: F64, high: F64) -> C128:
    """Return the control points (n, 4) of curves from one share of their parameter to another (de Casteljau)."""

    if not len(p):
        return p

    def blossom(*shares: F64) -> C128:
        left = list(p.T)
        for t in shares:
            left = [(1.0 - t) * one + t * two for one, two in itertools.pairwise(left)]
        place: C128 = left[0]
        return place

    of_each = [blossom(low, low, low), blossom(low, low, high), blossom(low, high, high), blossom(high, high, high)]
    return np.where(((low > 0.0) | (high < 1.0))[:, None], np.stack(of_each, axis=1), p)


def in_parts(curves: Curves, longest: float) -> tuple[Curves, I64, np.ndarray]:
    """Return curves with those of Bézier in parts, how many parts each has, and which go forward and are short.

    longest : the shortest wave that passes, pitches

    On −1 … 1 the wave's phase along P = Σ cₖtᵏ grows no faster than it does along a straight line of half the length
    |c₁| + 4|c₂| + 16|c₃|, as far out as |t| = 2: a rule that follows this one follows P.
    """
    cubic = np.flatnonzero(curves.kind == CUBIC)
    if not cubic.size:
        return curves, np.ones(len(curves.kind), np.int64), np.zeros(len(curves.kind), bool)
    points = curves.points[cubic, :, 0] + 1j * curves.points[cubic, :, 1]
    owner, begin = cubic, np.zeros(cubic.size)
    size, more = np.ones(cubic.size), np.zeros(cubic.size, np.int64)
    done: list[tuple[I64, F64, C128, np.ndarray]] = []
    for _ in range(HALVINGS):
        c = np.abs(polynomials(points))
        short = c[:, 1] + 4.0 * c[:, 2] + 16.0 * c[:, 3] <= HALF_WAVES * longest
        way, chord = np.diff(points, axis=1), (points[:, 3] - points[:, 0])[:, None]
        cosines = (way * chord.conj()).real >= FORWARD * np.abs(way) * np.abs(chord)
        forward = cosines.all(axis=1) & (chord[:, 0] != 0.0)
        more += short & ~forward
        good = short & (forward | (more > MORE_HALVINGS))
        done.append((owner[good], begin[good], points[good], forward[good]))
        rest = np.flatnonzero(~good)
        if not rest.size:
            break
        p, half = points[rest], np.full(rest.size, 0.5)
        first, second = between(p, 0.0 * half, half), between(p, half, 2.0 * half)
        second[:, 0] = first[:, 3]
        points = np.stack([first, second], axis=1).reshape(-1, 4)
        owner, more = np.repeat(owner[rest], 2), np.repeat(more[rest], 2)
        begin, size = np.repeat(begin[rest], 2), np.repeat(0.5 * size[rest], 2)
        begin[1::2] += size[1::2]
    else:
        done.append((owner, begin, points, np.zeros(owner.size, bool)))
    others = np.flatnonzero(curves.kind != CUBIC)
    owners = np.concatenate([others, *(part[0] for part in done)])
    order = np.lexsort((np.concatenate([np.zeros(others.size), *(part[1] for part in done)]), owners))
    drawn = np.concatenate([part[2] for part in done])
    places = np.concatenate([curves.points[others], np.stack([drawn.real, drawn.imag], axis=2)])[order]
    usable = np.concatenate([np.zeros(others.size, bool), *(part[3] for part in done)])[order]
    owners = owners[order]
    counts = np.bincount(owners, minlength=len(curves.kind))
    first_part = np.concatenate([[0], np.cumsum(counts)])
    return Curves(places, curves.turn_rad[owners], curves.kind[owners], first_part[curves.first]), counts, usable


def alone(curves: Curves, usable: np.ndarray, fine: Fineness) -> np.ndarray:
    """Return which of the usable curves (n,) have nothing else in their hulls, but what meets them in their ends."""
    found = usable.copy()
    if not usable.any():
        return found
    hulls, boxes = curves.points.copy(), curves.boxes
    straight, arc = (curves.kind != CUBIC) & (curves.kind != ARC), curves.kind == ARC
    hulls[straight, 1], hulls[straight, 2] = hulls[straight, 0], hulls[straight, 3]
    hulls[arc] = boxes[arc][:, [[0, 1], [2, 1], [2, 3], [0, 3]]]
    # Arcs that follow others lie somewhat outside of their hulls.
    apart = 2.0 * fine.most_off + ROUNDING * float(np.abs(boxes).max())
    squares = Squares.of(boxes + apart * np.array([-1.0, -1.0, 1.0, 1.0]))
    _leave_alone(hulls, squares, apart, np.empty(len(usable), np.int64), found)
    return found


@kernel(allocates=True)
def _leave_alone(hulls: F64, squares: Squares, apart: float, near: I64, found: np.ndarray) -> None:
    """Strike out what is not alone; near: (n,) memory."""
    for a in range(len(hulls)):
        for b in near[: touching(squares, a, near)]:
            if (found[a] or found[b]) and not _separate(hulls[a], hulls[b], apart):
                found[a] = found[b] = False


@kernel(allocates=True)
def _separate(a: F64, b: F64, apart: float) -> bool:
    """Return whether a line lies between two hulls (4, 2), through the end that they share if they do."""
    for i in (0, 3):
        for j in (0, 3):
            if a[i, 0] == b[j, 0] and a[i, 1] == b[j, 1]:
                return _part_from(a, b, a[i, 0], a[i, 1])
    # A side of one of them, or its direction, is what lies between if anything does.
    for hull in (a, b):
        for i in range(3):
            for j in range(i + 1, 4):
                dx, dy = hull[j, 0] - hull[i, 0], hull[j, 1] - hull[i, 1]
                gap = apart * (dx * dx + dy * dy) ** 0.5
                if gap > 0.0 and (_gap(a, b, dy, -dx) > gap or _gap(a, b, dx, dy) > gap):
                    return True
    return False


@kernel()
def _gap(a: F64, b: F64, x: float, y: float) -> float:
    """Return how far two hulls lie apart along a direction, times its length; below 0 where they overlap."""
    low_a, low_b, high_a, high_b = np.inf, np.inf, -np.inf, -np.inf
    for k in range(4):
        of_a, of_b = a[k, 0] * x + a[k, 1] * y, b[k, 0] * x + b[k, 1] * y
        low_a, high_a = min(low_a, of_a), max(high_a, of_a)
        low_b, high_b = min(low_b, of_b), max(high_b, of_b)
    return max(low_b - high_a, low_a - high_b)


@kernel(allocates=True)
def _part_from(a: F64, b: F64, x: float, y: float) -> bool:
    """Return whether hulls that share a corner have a line through it between them, and nothing else on it."""
    ways = np.zeros((2, 2))
    for side in range(2):
        hull = a if side == 0 else b
        for k in range(4):
            dx, dy = hull[k, 0] - x, hull[k, 1] - y
            size = (dx * dx + dy * dy) ** 0.5
            if size > 0.0:
                ways[side, 0] += dx / size
                ways[side, 1] += dy / size
    across, up = ways[1, 0] - ways[0, 0], ways[1, 1] - ways[0, 1]
    long = (across * across + up * up) ** 0.5
    for side in range(2):
        hull = a if side == 0 else b
        for k in range(4):
            dx, dy = hull[k, 0] - x, hull[k, 1] - y
            beyond = (dx * across + dy * up) * (1.0 if side == 1 else -1.0)
            size = (dx * dx + dy * dy) ** 0.5
            if size > 0.0 and beyond <= BETWEEN * size * long:
                return False
    return True
