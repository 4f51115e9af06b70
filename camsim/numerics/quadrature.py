"""Quadrature rules, cached, since a rule takes longer to compute than to use."""

from __future__ import annotations

import functools
import math

import numpy as np

from camsim.core.arrays import F64, I64

GOLDEN = 0.6180339887498949  # the fractional parts of its multiples are evenly distributed on 0 … 1
MANY = 256  # nodes of a rule from which on NumPy's overhead no longer dominates the recurrence
# Error of interpolation through n values for a wave, over (2πδf)ⁿ: half-way between two of them, Π(k − ½)²/n!.
EIGHT_POINTS, SIX_POINTS = (0.5 * 1.5 * 2.5 * 3.5) ** 2 / math.factorial(8), (0.5 * 1.5 * 2.5) ** 2 / math.factorial(6)


@functools.cache
def gauss_legendre(order: int) -> tuple[F64, F64]:
    """Return nodes on −1 … 1 and weights of the Gauss–Legendre rule, both (order,), read-only.

    Zeros of P_n by five steps of Newton's method, which suffice; weights 2/((1 − x²)·P_n′²). Half of them are computed,
    the others follow by symmetry. (The import of SciPy's rules takes as long as half a capture.)

    >>> [values.round(9).tolist() for values in gauss_legendre(3)]
    [[-0.774596669, 0.0, 0.774596669], [0.555555556, 0.888888889, 0.555555556]]
    """
    x = np.cos(np.pi * (np.arange((order + 1) // 2) + 0.75) / (order + 0.5))
    for _ in range(5):
        value, slope = _legendre(order, x)
        x = x - value / slope
    slope = _legendre(order, x)[1]
    half, half_weights = x, 2.0 / ((1.0 - x * x) * slope * slope)
    if order % 2:
        half[-1] = 0.0
    one = slice(order % 2, None)
    nodes = np.concatenate([0.0 - half, half[::-1][one]])
    weights = np.concatenate([half_weights, half_weights[::-1][one]])
    nodes.flags.writeable = weights.flags.writeable = False
    return nodes, weights


@functools.cache
def even_rule(order: int) -> tuple[F64, F64]:
    """Return nodes on −1 … 1 and weights of a rule for waves, both (order,), read-only; two thirds of Gauss's nodes do.

    The nodes of a Gauss rule are π/2 times as far apart in the middle as evenly spaced ones, which limits the waves
    that it resolves. The map x = arcsin(α·s)/arcsin α makes them nearly even; α is chosen so that the ellipse of
    analyticity suffices for rounding accuracy at any order. (Hale and Trefethen, "New quadrature formulas from
    conformal maps", SIAM J. Numer. Anal. 46, 2008.)

    >>> x, w = even_rule(125)  # a wave of 300 radians to either side; Gauss's rule takes 182 nodes
    >>> bool(abs(np.cos(300.0 * x) @ w - 2.0 * np.sin(300.0) / 300.0) < 1e-12)
    True
    """
    s, weights = gauss_legendre(order)
    alpha = _evenness(order)
    nodes = np.arcsin(alpha * s) / np.arcsin(alpha)
    weights = weights * alpha / (np.arcsin(alpha) * np.sqrt((1.0 - alpha * s) * (1.0 + alpha * s)))
    nodes.flags.writeable = weights.flags.writeable = False
    return nodes, weights


def _evenness(order: int) -> F64:
    """Return the parameter α of the map for a rule of this order."""
    alpha: F64 = 1.0 / np.cosh(14.0 * np.float64(order) ** -0.8)
    return alpha


def _legendre(order: int, x: F64) -> tuple[F64, F64]:
    """Return P_n and P_n′ within −1 … 1 by Bonnet's recurrence."""
    if order >= MANY:
        # A deferred import: rules of few nodes need no compiler.
        from camsim.core.kernels import shared
        from camsim.core.kernels.legendre import AT_ONCE, legendre

        at_many, slopes = np.empty_like(x), np.empty_like(x)
        shared(x.size, lambda begin, stop: legendre(begin, stop, order, x, at_many, slopes), least=AT_ONCE)
        return at_many, slopes
    before, value = np.ones_like(x), x
    for n in range(2, order + 1):
        before, value = value, ((2 * n - 1) * x * value - (n - 1) * before) / n
    return value, order * (before - x * value) / (1.0 - x * x)


def gauss_error(order: int, phase: float) -> float:
    """Return the natural logarithm of a Gauss rule's error for cos(phase·x) over −1 … 1."""
    return (
        (2 * order + 1) * math.log(2.0)
        + 4 * math.lgamma(order + 1)
        - math.log(2 * order + 1)
        - 3 * math.lgamma(2 * order + 1)
        + 2 * order * math.log(max(phase, 1e-3))
    )


def gauss_order(phase: float, allowed: float, *, least: int = 3, most: int | None = None) -> int:
    """Return the order, up to ``most``, of a Gauss rule that integrates cos(phase·x) over −1 … 1 to ``allowed``.

    >>> gauss_order(math.pi, 1e-6), gauss_order(math.pi, 1e-6, most=4)
    (7, 4)
    """
    order = least
    while order != most and gauss_error(order, phase) > math.log(allowed):
        order += 1
    return order


@functools.cache
def gauss_phases(allowed: float, most: int) -> F64:
    """Return phases (most,) for which 1, 2 … nodes integrate cos(phase·x) over −1 … 1 to ``allowed``."""
    orders = np.arange(1, most + 1)
    phases: F64 = np.exp([0.5 * (math.log(allowed) - gauss_error(n, 1.0)) / n for n in orders.tolist()])
    return phases


def gauss_pieces(phase: F64, allowed: float, most: int, passed: F64 | float = 1.0) -> tuple[I64, I64]:
    """Return the number of pieces into which to divide lines, and the nodes (up to ``most``) of each piece.

    phase   : half of the phase along each line, radians
    allowed : relative error of a piece
    passed  : (most,) the part of the error of 1, 2 … nodes that counts

    >>> gauss_pieces(np.array([0.01, 3.0, 1000.0]), 1e-12, most=200)
    (array([1, 1, 4]), array([  3,   9, 182]))
    """
    phases = gauss_phases(allowed, most) * passed ** (-0.5 / np.arange(1, most + 1))
    pieces = np.maximum(np.ceil(phase / phases[-1]), 1.0).astype(np.int64)
    orders = np.minimum(np.searchsorted(phases, phase / pieces) + 1, most)
    return pieces, orders


@functools.cache
def gauss_rules(counts: tuple[int, ...]) -> tuple[F64, F64, I64]:
    """Return Gauss rules with the numbers of nodes in ``counts``.

    returns : nodes and weights (rules, most), zero-padded, and the counts as an array; all read-only
    """
    nodes, weights = np.zeros((len(counts), max(counts))), np.zeros((len(counts), max(counts)))
    for k, n in enumerate(counts):
        nodes[k, :n], weights[k, :n] = gauss_legendre(n)
    of_each = np.array(counts, np.int64)
    for array in (nodes, weights, of_each):
        array.flags.writeable = False
    return nodes, weights, of_each


def chebyshev(order: int) -> F64:
    """Return the Chebyshev nodes of the first kind on −1 … 1, increasing."""
    nodes: F64 = np.cos(np.pi * (np.arange(order)[::-1] + 0.5) / order)
    return nodes


def power_series(values: F64, until: float, powers: int) -> F64:
    """Return coefficients (…, powers) of f⁰, f¹ … from values (…, n) at the n Chebyshev points on 0 … ``until``.

    >>> f = 0.5 * (1.0 + chebyshev(4))
    >>> power_series((3.0 + 2.0 * f)[None], 1.0, 3).round(12).tolist()
    [[3.0, 2.0, 0.0]]
    """
    count = values.shape[-1]
    angle = np.arccos(chebyshev(count))
    terms = np.einsum("...n,ns->...s", values, np.cos(np.outer(angle, np.arange(count)))) * (2.0 / count)
    terms[..., 0] *= 0.5
    series: F64 = np.einsum("...s,sp->...p", terms, _shifted(count, powers)) / until ** np.arange(powers)
    return series


@functools.cache
def _shifted(count: int, powers: int) -> F64:
    """Return the powers (count, powers) in Chebyshev polynomials on 0 … 1; that of order s is T_2s(√f)."""
    orders = np.zeros((count, powers))
    orders[0, 0], orders[1, :2] = 1.0, (-1.0, 2.0)
    for s in range(2, count):
        orders[s] = -2.0 * orders[s - 1] - orders[s - 2]
        orders[s, 1:] += 4.0 * orders[s - 1, :-1]
    return orders


def barycentric(nodes: F64, weights: np.ndarray, points: F64, *, same: float = 0.0) -> F64:
    """Return the Lagrange polynomials (points, nodes) of the nodes at points, by the barycentric formula.

    weights : of the nodes, up to a factor;  same: distance up to which a point coincides with a node
    """
    gap = points[:, None] - nodes[None, :]
    hit = np.abs(gap) <= same
    terms = weights / np.where(hit, 1.0, gap)
    exact = hit.any(axis=1)
    matrix: F64 = terms / np.where(exact, 1.0, terms.sum(axis=1))[:, None]
    matrix[exact] = hit[exact]
    return matrix


def interpolation(nodes: F64, points: F64) -> F64:
    """Return the interpolation matrix (points, nodes) from Chebyshev nodes of the first kind."""
    k = np.arange(nodes.size)
    weights = (-1.0) ** k * np.sin(np.pi * (k + 0.5) / nodes.size)
    return barycentric(nodes, weights, points, same=1e-14)
