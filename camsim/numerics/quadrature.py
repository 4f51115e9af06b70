"""Quadrature rules, kept: one takes longer to make than to use."""

from __future__ import annotations

import functools
import math

import numpy as np

from camsim.core.arrays import F64, I64

GOLDEN = 0.6180339887498949  # multiples of it, less their whole part, lie about evenly on 0 … 1 and in no pattern
MANY = 256  # nodes of a rule: each step to the next degree is no longer what NumPy takes to begin it
# What a look-up through n values leaves of a wave, over its (2πδf)ⁿ: half-way between two of them, Π(k − ½)²/n!.
EIGHT_POINTS, SIX_POINTS = (0.5 * 1.5 * 2.5 * 3.5) ** 2 / math.factorial(8), (0.5 * 1.5 * 2.5) ** 2 / math.factorial(6)


@functools.cache
def gauss_legendre(order: int) -> tuple[F64, F64]:
    """Return nodes on −1 … 1 and weights of the Gauss–Legendre rule, both (order,), read-only.

    Zeros of P_n by Newton's steps, of which the fifth changes nothing more; weights 2/((1 − x²)·P_n′²). Half of them
    are computed, the others are their mirror images. (SciPy's rules take as long to import as half a capture.)

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
    """Return nodes on −1 … 1 and weights of a rule for waves, both (order,), read-only: two thirds of Gauss's nodes.

    A Gauss rule's nodes lie π/2 times as far apart in the middle as if they were even, and a wave is followed there
    last. Mapped by x = arcsin(α·s)/arcsin α they are nearly even; how nearly leaves the integrand's own ellipse as wide
    as rounding asks for, whatever their number. (Hale and Trefethen, "New quadrature formulas from conformal maps",
    SIAM J. Numer. Anal. 46, 2008.)

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
    """Return α."""
    alpha: F64 = 1.0 / np.cosh(14.0 * np.float64(order) ** -0.8)
    return alpha


def _legendre(order: int, x: F64) -> tuple[F64, F64]:
    """Return P_n and P_n′ within −1 … 1 by Bonnet's recurrence."""
    if order >= MANY:
        # Nothing that is done by rules of few nodes waits for a compiler.
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
    """Return the order of a Gauss rule that integrates cos(phase·x) over −1 … 1 to ``allowed``; ``most`` at the most.

    >>> gauss_order(math.pi, 1e-6), gauss_order(math.pi, 1e-6, most=4)
    (7, 4)
    """
    order = least
    while order != most and gauss_error(order, phase) > math.log(allowed):
        order += 1
    return order


@functools.cache
def gauss_phases(allowed: float, most: int) -> F64:
    """Return (most,) phases for which cos(phase·x) over −1 … 1 is integrated to ``allowed`` by 1, 2 … nodes."""
    orders = np.arange(1, most + 1)
    phases: F64 = np.exp([0.5 * (math.log(allowed) - gauss_error(n, 1.0)) / n for n in orders.tolist()])
    return phases


def gauss_pieces(phase: F64, allowed: float, most: int) -> tuple[I64, I64]:
    """Return into how many pieces to cut lines, and how many nodes (up to ``most``) each piece takes.

    phase   : half of what each line spans, radians
    allowed : error of a piece, relative to it

    >>> gauss_pieces(np.array([0.01, 3.0, 1000.0]), 1e-12, most=200)
    (array([1, 1, 4]), array([  3,   9, 182]))
    """
    phases = gauss_phases(allowed, most)
    pieces = np.maximum(np.ceil(phase / phases[-1]), 1.0).astype(np.int64)
    orders = np.minimum(np.searchsorted(phases, phase / pieces) + 1, most)
    return pieces, orders


@functools.cache
def gauss_rules(counts: tuple[int, ...]) -> tuple[F64, F64, I64]:
    """Return rules of so many nodes each: nodes and weights (rules, most), of which the first counts are used.

    returns : and the counts as an array; all read-only
    """
    nodes, weights = np.zeros((len(counts), max(counts))), np.zeros((len(counts), max(counts)))
    for k, n in enumerate(counts):
        nodes[k, :n], weights[k, :n] = gauss_legendre(n)
    of_each = np.array(counts, np.int64)
    for array in (nodes, weights, of_each):
        array.flags.writeable = False
    return nodes, weights, of_each


def chebyshev(order: int) -> F64:
    """Chebyshev nodes of the first kind on −1 … 1."""
    nodes: F64 = np.cos(np.pi * (np.arange(order)[::-1] + 0.5) / order)
    return nodes


def barycentric(nodes: F64, weights: np.ndarray, points: F64, *, same: float = 0.0) -> F64:
    """Return (points, nodes): Lagrange's polynomials of the nodes at points, by the barycentric formula.

    weights : of the nodes, up to a factor;  same: points no farther than this from a node are it
    """
    gap = points[:, None] - nodes[None, :]
    hit = np.abs(gap) <= same
    terms = weights / np.where(hit, 1.0, gap)
    matrix: F64 = terms / terms.sum(axis=1, keepdims=True)
    exact = hit.any(axis=1)
    matrix[exact] = hit[exact]
    return matrix


def interpolation(nodes: F64, points: F64) -> F64:
    """Return the matrix (points, nodes) of interpolation from Chebyshev nodes of the first kind."""
    k = np.arange(nodes.size)
    weights = (-1.0) ** k * np.sin(np.pi * (k + 0.5) / nodes.size)
    return barycentric(nodes, weights, points, same=1e-14)
