"""Edges as a source: the Fourier transform of the regions that they bound."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import C128, F64, I64, Complex, Floats
from camsim.core.cached import cached_property
from camsim.core.kernels import kernel, shared
from camsim.numerics.nonuniform import SINGLE, complex_type, modes
from camsim.numerics.quadrature import gauss_pieces, gauss_rules
from camsim.rendering.edges import Edges
from camsim.rendering.waves.clamped import clamped, netted
from camsim.rendering.waves.kernels import slope, transform_edges
from camsim.rendering.waves.levels import Lattice

MOST_NODES = 200  # of one Gauss rule on an edge; longer edges are divided
STEPS = 128  # of frequency, over which a rule's error is averaged
EDGES_AT_ONCE, ROWS_AT_ONCE, PLACES_AT_ONCE = 1000, 16, 10_000
FEW_EDGES = 64  # for which closed forms at all frequencies take less than quadrature and transforms of its nodes
NODES_AT_ONCE = 4_000_000  # of all kinds that are transformed together


@dataclass(frozen=True, kw_only=True, eq=False)
class EdgeSource:
    """Regions of several kinds of light, bounded by edges.

    edges  : pitches from the optical axis
    shares : (spectra, kinds) share of each kind in the spectra on the sides of edges, the background first
    precision : error of the transforms, relative where the lens passes all light
    passes : frequencies (n,), cycles/pitch, and the share of the light that passes at them
    """

    edges: Edges
    shares: F64
    precision: float
    passes: tuple[F64, F64]

    @cached_property
    def box(self) -> tuple[F64, F64]:
        """Low and high corner (2,) of the bounding box, pitches."""
        return self.edges.box

    @property
    def whole(self) -> int:
        """1: edges put no condition on a lattice's period."""
        return 1

    @property
    def in_parts(self) -> bool:
        """True: it can transform parts of a lattice."""
        return True

    @property
    def kinds(self) -> int:
        """Number of kinds."""
        kinds: int = self.shares.shape[1]
        return kinds

    def _passed(self, cut: float) -> F64:
        """Return the part of the error of 1, 2 … nodes a piece that passes below ``cut``: it grows as f²ⁿ."""
        share = (np.arange(STEPS) + 0.5) / STEPS
        growth = np.cumprod(np.broadcast_to(share**2, (MOST_NODES, STEPS)), axis=0)
        light = np.interp(cut * share, *self.passes) * (4.0 / math.pi / STEPS) / share
        passed: F64 = np.clip(np.einsum("nf,f->n", growth, light), np.finfo(float).tiny, 1.0)
        return passed

    def transform(self, lattice: Lattice, origin: tuple[float, float]) -> Complex | None:
        """Return the transform (kinds, 2n − 1, m) of each kind's regions about an origin; None: no edges."""
        edges = clamped(self.edges, lattice.low, lattice.high, origin)
        if not len(edges):
            return None
        jump = self.shares[edges.left] - self.shares[edges.right]
        start, end, jump = netted(edges.start, edges.end, jump, lattice.low, lattice.high)
        if not len(start):
            return None
        twice = start[:, 0] * end[:, 1] - end[:, 0] * start[:, 1]
        areas = np.array([0.5 * float(np.sum(twice * one)) for one in jump.T])
        if len(start) <= FEW_EDGES:
            return _in_closed_form(start, end, jump, areas, lattice, complex_type(self.precision))
        kind = complex_type(self.precision, SINGLE)
        places, which, along = _nodes(start, end, lattice, 0.5 * self.precision, self._passed(lattice.cut), kind)
        rows, shape = lattice.rows, (len(lattice.rows), lattice.counts[0])
        if middle := rows.start + len(rows) // 2:
            along *= np.exp(-1j * middle * places[0].astype(np.float64))
        step_x, step_y = (1.0 / period for period in lattice.periods)
        at_once, jump, parts = max(1, NODES_AT_ONCE // along.size), np.ascontiguousarray(jump.T), []
        for first in range(0, self.kinds, at_once):
            some = jump[first : first + at_once]
            strengths = np.empty((len(some), along.size), kind)
            shared(along.size, functools.partial(_strong, along, some, which, strengths), least=EDGES_AT_ONCE)
            if first + at_once >= self.kinds:
                del along, which  # the transform needs the memory
            found = modes(places, strengths, shape, precision=self.precision, sign=-1)
            parts.append(found.astype(complex_type(self.precision), copy=False))
        out = parts[0] if len(parts) == 1 else np.concatenate(parts)
        for whole, area in zip(out, areas.tolist(), strict=True):
            shared(
                len(whole),
                functools.partial(slope, whole, -rows.start, step_x, step_y, area),
                least=ROWS_AT_ONCE,
            )
        return out


def _in_closed_form(
    start: F64, end: F64, jump: F64, areas: F64, lattice: Lattice, kind: type[np.complexfloating]
) -> Complex:
    """Return the transforms (kinds, n, m) of regions, edge by edge at every frequency."""
    rows, (columns, _) = np.array(lattice.rows), lattice.counts
    step_x, step_y = (1.0 / period for period in lattice.periods)
    middle, sides = 0.5 * (start + end), end - start
    along = []
    for axis, frequency in enumerate((step_x * np.arange(columns), step_y * rows)):
        phase, half = (np.pi * np.multiply.outer(one[:, axis], frequency) for one in (-2.0 * middle, sides))
        along.append(np.stack([np.cos(phase), np.sin(phase), np.cos(half), np.sin(half)]))
    out = np.empty((jump.shape[1], rows.size, columns), kind)
    scale, jump = (step_x, step_y, lattice.cut), np.ascontiguousarray(jump)
    work = functools.partial(transform_edges, out, jump, sides, along[0], along[1], scale, lattice.rows.start, areas)
    shared(rows.size, work, least=ROWS_AT_ONCE)
    return out


def half_plane(places: F64, lattice: Lattice) -> tuple[tuple[F64, F64], C128]:
    """Return radians along y and x of places (n, 2) in a lattice's period, −π … π, and factors of their strengths.

    The factors shift modes centred on 0 along x to modes from 0 on.
    """
    (down, across), turn = np.empty((2, len(places))), np.empty(len(places), complex)
    work = functools.partial(_turn, places, lattice.periods, lattice.counts[0] // 2, down, across, turn)
    shared(len(places), work, least=PLACES_AT_ONCE)
    return (down, across), turn


@kernel()
def _turn(
    places: F64, periods: tuple[int, int], middle: int, down: F64, across: F64, turn: C128, begin: int, stop: int
) -> None:
    """Write the phases and factors of places begin … stop."""
    for n in range(begin, stop):
        u, v = places[n, 0] / periods[0], places[n, 1] / periods[1]
        across[n] = 2.0 * math.pi * (u - math.floor(u + 0.5))
        down[n] = 2.0 * math.pi * (v - math.floor(v + 0.5))
        turn[n] = complex(math.cos(middle * across[n]), -math.sin(middle * across[n]))


def _nodes(
    start: F64, end: F64, lattice: Lattice, allowed: float, passed: F64, kind: type[np.complexfloating]
) -> tuple[tuple[Floats, Floats], I64, C128]:
    """Return the phases of nodes, their edges, and weights times ey + i·ex, shifted to the half plane."""
    length = np.hypot(*(end - start).T)
    pieces, orders = gauss_pieces(np.pi * lattice.cut * length, allowed, MOST_NODES, passed)
    first = np.concatenate([[0], np.cumsum(pieces * orders)])
    counts = tuple(np.flatnonzero(np.bincount(orders)).tolist())
    rules = gauss_rules(counts)
    rule = np.searchsorted(rules[2], orders)
    down, across = np.empty((2, first[-1]), kind(0).real.dtype)
    owner, strengths = np.empty(first[-1], np.int64), np.empty(first[-1], complex)
    middle, nodes = lattice.counts[0] // 2, (down, across, owner, strengths)

    def work(begin: int, stop: int) -> None:
        _lay((start, end, pieces, first), (*rules, rule), lattice.periods, middle, nodes, begin, stop)

    shared(len(start), work, least=EDGES_AT_ONCE)
    return (down, across), owner, strengths


@kernel()
def _strong(along: C128, jump: F64, which: I64, out: Complex, begin: int, stop: int) -> None:
    """Write the strengths (kinds, n) of nodes begin … stop: their own times their edges' jump (kinds, edges)."""
    for n in range(begin, stop):
        for k in range(len(jump)):
            out[k, n] = along[n] * jump[k, which[n]]


@kernel()
def _lay(
    edges: tuple[F64, F64, I64, I64],
    rules: tuple[F64, F64, I64, I64],
    periods: tuple[int, int],
    middle: int,
    nodes: tuple[Floats, Floats, I64, C128],
    begin: int,
    stop: int,
) -> None:
    """Write the quadrature nodes of edges begin … stop, each by its rule."""
    (start, end, pieces, first), (x, w, count, which) = edges, rules
    (px, py), (down, across, owner, strengths) = periods, nodes
    for e in range(begin, stop):
        n, rule, ex, ey = first[e], which[e], end[e, 0] - start[e, 0], end[e, 1] - start[e, 1]
        for piece in range(pieces[e]):
            for q in range(count[rule]):
                t = (piece + 0.5 * (1.0 + x[rule, q])) / pieces[e]
                u, v = (start[e, 0] + t * ex) / px, (start[e, 1] + t * ey) / py
                across[n] = 2.0 * math.pi * (u - math.floor(u + 0.5))
                down[n] = 2.0 * math.pi * (v - math.floor(v + 0.5))
                weight = 0.5 * w[rule, q] / pieces[e]
                turn = middle * across[n]
                cos, sin = math.cos(turn), math.sin(turn)
                strengths[n] = complex(weight * (ey * cos + ex * sin), weight * (ex * cos - ey * sin))
                owner[n] = e
                n += 1
