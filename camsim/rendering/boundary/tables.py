"""Tables that are computed before the first photosite: the system's field near an edge, and its edge response.

Lengths are in pitches. One *weight set* is one (pair of spectra, channel): its tables are summed over the wavelengths,
so the cost of a photosite does not depend on their number.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64, distinct
from camsim.core.kernels import kernel, shared
from camsim.numerics.matrix_products import product
from camsim.numerics.quadrature import gauss_legendre
from camsim.numerics.quintics import quintic_cells
from camsim.optics.pattern import Pattern
from camsim.rendering.boundary.potential import ORDER, SCALE, at_cell, contract, lagrange_weights, potential
from camsim.rendering.footprint import Footprint

AT_ONCE = 16  # weight sets that share the computation of cells and weights
WORTH_A_THREAD = 10_000  # numbers of a table: a few tenths of a millisecond
FIELD_ORDER = 8  # points per axis of the look-up in the field table (potential.eight_points)
NARROW = 1e-2  # steps: below this, differences over a side cancel; two slopes at Gauss nodes are right to 1e-13
_GAUSS_X, _GAUSS_W = gauss_legendre(8)  # exact for the interpolant's degree, ORDER − 1
_NODES = np.arange(ORDER) + 1.0 - ORDER // 2
_OTHERS = ~np.eye(ORDER, dtype=bool)  # for each node, all others
_LEFT_OUT = ~(_OTHERS[:, None] & _OTHERS[None])  # by node and by factor: the node and that factor


def field_tables(pattern: Pattern, blur: F64, weights: F64, footprint: Footprint, *, radius: float, step: float) -> F64:
    """Field V = ∇Φ averaged over the footprint, on a square grid over one quadrant.

    pattern, blur : pattern of the lens, and its scale (j,) at every wavelength
    weights  : (k, j) weight sets
    footprint : if its spots form no grid, the table is of the rectangle alone, to be looked up at every spot
    radius   : the table covers 0 … radius in x and y (plus the spots' offsets), with a margin for the stencil
    returns  : (k, 2, n, n): V_x and V_y at ((i − margin)·step, (j − margin)·step), margin = FIELD_ORDER/2

    Derivation: the average of ∂Φ/∂x over a box is a difference of Φ at its two sides, averaged along y. Both
    are short filters along one axis each, so a table needs no two-dimensional rule. The
    filters are made from the interpolant itself; a small photosite therefore loses no digits.
    """
    margin = FIELD_ORDER // 2
    x, y, apart = footprint.grid
    rows = math.ceil((radius + np.abs(apart).max()) / step) + 2 * margin
    width, height = footprint.width / step, footprint.height / step
    along_x = _average_taps(width, x / step), _slope_taps(width, x / step) / step
    along_y = along_x if footprint.square else (_average_taps(height, y / step), _slope_taps(height, y / step) / step)
    count = rows - margin + max(along_x[0].size, along_y[0].size) // 2
    radial_step = 0.5 * step
    samples = math.ceil(math.sqrt(2.0) * count * step / radial_step) + ORDER
    phi = potential(pattern, samples * radial_step / float(blur.min()))
    radial = contract(phi, blur, weights, radial_step, samples)
    tables = np.empty((weights.shape[0], 2, rows, rows))
    tables[:, 0] = _filtered(radial, step / radial_step, along_y[0], along_x[1], rows, margin, count)
    across = tables[:, 0]
    if not footprint.square:
        across = _filtered(radial, step / radial_step, along_x[0], along_y[1], rows, margin, count)
    tables[:, 1] = across.transpose(0, 2, 1)
    return tables


class Filters(NamedTuple):
    """A short filter along each axis."""

    average: F64
    slope: F64
    slopes: I64  # indices of taps that are not 0


class Line(NamedTuple):
    """Scratch memory of one thread for one row."""

    cells: I64
    weights: F64  # (columns, ORDER)
    values: F64  # from −margin − reach on, mirrored at 0


def _filtered(
    radial: F64, samples_per_step: float, average: F64, slope: F64, rows: int, margin: int, count: int
) -> F64:
    """Apply ``slope`` along the first axis and ``average`` along the second to radial functions: (k, rows, rows)."""
    filters = Filters(average, slope, np.flatnonzero(slope))
    tables = np.empty((radial.shape[0], rows, rows))
    for first in range(0, len(tables), AT_ONCE):
        some, one = tables[first : first + AT_ONCE], radial[first : first + AT_ONCE]
        averaged = np.zeros((len(some), count, rows))
        least = math.ceil(WORTH_A_THREAD / (len(some) * rows))
        shared(count, functools.partial(_average_rows, one, samples_per_step, filters, margin, averaged), least=least)
        shared(rows, functools.partial(_slope, averaged, filters, margin, some), least=least)
    return tables


def _average_rows(
    radial: F64, samples_per_step: float, filters: Filters, margin: int, averaged: F64, begin: int, end: int
) -> None:
    rows, reach = averaged.shape[2], filters.average.size // 2
    columns = rows - margin + reach
    line = Line(np.empty(columns, np.int64), np.empty((columns, ORDER)), np.empty(rows + 2 * reach))
    _average(radial, samples_per_step, filters, margin, line, averaged, begin, end)


@kernel()
def _average(
    radial: F64,
    samples_per_step: float,
    filters: Filters,
    margin: int,
    line: Line,
    averaged: F64,
    begin: int,
    end: int,
) -> None:
    """Fill in some rows of the averages along the second axis."""
    average = filters.average
    cells, weights, values = line
    reach, rows = average.size // 2, averaged.shape[2]
    for i in range(begin, end):
        for j in range(cells.size):
            u = math.hypot(i, j) * samples_per_step
            cells[j] = int(u)
            lagrange_weights(u - cells[j], ORDER, SCALE, weights[j])
        for k in range(len(averaged)):
            for j in range(cells.size):
                values[j + margin + reach] = at_cell(radial[k], cells[j], weights[j])
            for j in range(margin + reach):
                values[j] = values[2 * (margin + reach) - j]
            one = averaged[k, i]
            for b in range(average.size):
                for c in range(rows):
                    one[c] += average[b] * values[c + b]


@kernel()
def _slope(averaged: F64, filters: Filters, margin: int, tables: F64, begin: int, end: int) -> None:
    """Fill in some rows of the slopes along the first axis."""
    lean, rows = filters.slope.size // 2, tables.shape[1]
    for r in range(begin, end):
        for k in range(len(tables)):
            row = tables[k, r]
            for c in range(rows):
                row[c] = 0.0
            for a in filters.slopes:
                for c in range(rows):
                    row[c] += filters.slope[a] * averaged[k, abs(r - margin + a - lean), c]


def _average_taps(side: float, shifts: F64) -> F64:
    """Filter that averages over [−side/2, side/2] shifted by ``shifts``; lengths in steps."""
    reach = math.ceil(0.5 * side + float(np.abs(shifts).max())) + ORDER // 2 + 1
    taps = np.zeros(2 * reach + 1)
    for shift in shifts:
        if side == 0.0:
            _add_points(taps, reach, np.array([shift]), np.ones(1))
            continue
        cuts = np.arange(math.floor(shift - 0.5 * side), math.ceil(shift + 0.5 * side) + 1)
        cuts = distinct(np.clip(cuts, shift - 0.5 * side, shift + 0.5 * side))
        low, high = cuts[:-1, None], cuts[1:, None]
        places = 0.5 * (low + high + (high - low) * _GAUSS_X)
        _add_points(taps, reach, places.ravel(), (0.5 * (high - low) * _GAUSS_W / side).ravel())
    taps /= shifts.size
    return 0.5 * (taps + taps[::-1])


def _slope_taps(side: float, shifts: F64) -> F64:
    """Filter for the derivative (per step) of that average: a difference of the box's sides, or two slopes in it."""
    reach = math.ceil(0.5 * side + float(np.abs(shifts).max())) + ORDER // 2 + 1
    taps = np.zeros(2 * reach + 1)
    for shift in shifts:
        if side <= NARROW:
            for at in (-0.5, 0.5):
                _add_slope(taps, reach, shift + at * side / math.sqrt(3.0), 0.5)
            continue
        _add_points(taps, reach, shift + 0.5 * side * np.array([1.0, -1.0]), np.array([1.0, -1.0]) / side)
    taps /= shifts.size
    return 0.5 * (taps - taps[::-1])


@kernel(allocates=True)
def _add_points(taps: F64, reach: int, positions: F64, amounts: F64) -> None:
    weights = np.empty(ORDER)
    for position, amount in zip(positions, amounts):  # noqa: B905 (Numba has no strict)
        cell = math.floor(position)
        lagrange_weights(position - cell, ORDER, SCALE, weights)
        first = reach + cell + 1 - ORDER // 2
        for k in range(ORDER):
            taps[first + k] += amount * weights[k]


def _add_slope(taps: F64, reach: int, position: float, amount: float) -> None:
    """Add ``amount`` times the interpolant's derivative, by the product rule for Lagrange polynomials."""
    cell = math.floor(position)
    first = reach + cell + 1 - ORDER // 2
    products = np.where(_LEFT_OUT, 1.0, position - cell - _NODES).prod(axis=2)
    taps[first : first + ORDER] += (
        amount * SCALE * np.array([math.fsum(row) for row in products[_OTHERS].reshape(ORDER, -1)])
    )


def edge_responses(
    pattern: Pattern,
    blur: F64,
    weights: F64,
    normals: F64,
    footprint: Footprint,
    *,
    distance: float,
    step: float,
) -> F64:
    """Response across an infinite edge, minus the value half-way, as a quintic for each cell of width ``step``.

    normals  : (o, 2) unit normals of the edges
    returns  : (o, k, cells, 6): coefficients of (h/step − cell)^0 … ^5 for 0 ≤ h ≤ distance

    ESF(h) − ½ = ∫_0^{cut-off} OTF(f·normal)·sin(2πfh)/(πf) df. Between two breaks the summed OTF is smooth except for
    3/2 powers at the ends (none at 0, and only the upper one for an Airy pattern). The substitution
    f = top − (top − bottom)·t², with t²(3 − 2t) for t² if the lower end has one too, turns them into polynomials. A
    Gauss rule of n nodes then resolves a phase of 2n radians, where the phase is 2πf times the sum of the distance and
    the footprint's extent.
    """
    cells = math.ceil(distance / step)
    inner = len(pattern.breaks) > 1
    bottom, nodes, node_weights = 0.0, [], []
    for top in distinct(np.divide.outer(pattern.breaks, blur)):
        count = 14 + math.ceil((1.6 if inner else 1.1) * math.pi * (distance + footprint.extent) * (top - bottom))
        x, w = gauss_legendre(count)
        t = 0.5 * (1.0 + x)
        nodes.append(top - (top - bottom) * t * t * ((3.0 - 2.0 * t) if inner else 1.0))
        node_weights.append((top - bottom) * t * w * ((3.0 - 3.0 * t) if inner else 1.0))
        bottom = top
    f, df = np.concatenate(nodes), np.concatenate(node_weights)
    lens = pattern.otf(f[None, :] * blur[:, None])
    spectrum = product(weights, lens) * (df / (np.pi * f))
    passes = np.stack([footprint.otf(f * n[0], f * n[1]) for n in normals])
    h = step * np.arange(-2, cells + 4)
    wave = np.sin((2.0 * np.pi) * np.outer(h, f))
    values = product((passes[:, None, :] * spectrum[None]).reshape(-1, f.size), wave.T)
    return quintic_cells(values.reshape(len(normals), len(weights), h.size))
