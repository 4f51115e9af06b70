"""The truth at single photosites: the boundary integral by plain quadrature, without tables, far forms or transforms.

A point sample at x sees (1/2π) Σ_edges ∫ E(r)·h/(h² + s²) ds of a bright polygon (docs/mathematics.md). The integrand
varies over the pattern's own length only, so Gauss–Legendre panels of that length converge at once; a product rule
averages point samples over the square and the OLPF's spots. Slow, and independent of everything that is judged
by it. Imports nothing of camsim.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy import interpolate, special

from tests.truth.lattice import F64, Lens

PANEL_NODES = 20
POINTS_AT_ONCE = 64


def encircled_energy(lens: Lens) -> Callable[[F64], F64]:
    """Return the share of a point's light within r (pitches): the patterns of all wavelengths added."""
    if lens.gaussian:
        sigma = float(lens.blur[0])
        return lambda r: -np.expm1(-0.5 * np.square(r / sigma))

    def exactly(r: F64) -> F64:
        total = np.zeros(r.shape)
        for blur, weight in zip(lens.blur, lens.weights, strict=True):
            x = np.pi * r / blur
            total += weight * (1.0 - special.j0(x) ** 2 - special.j1(x) ** 2)
        return total

    return exactly


def tabulated_energy(lens: Lens, farthest: float) -> Callable[[F64], F64]:
    """Return the same as a spline to ``farthest`` pitches: for many wavelengths, to 1e-14."""
    r = np.linspace(0.0, farthest, math.ceil(farthest * 32.0 / float(lens.blur.min())))
    return interpolate.make_interp_spline(r, encircled_energy(lens)(r), k=9)


def photosite_value(
    polygon: F64, x: float, y: float, lens: Lens, *, side: float = 0.0, split: float = 0.0, order: int | None = None
) -> float:
    """Return the share of a photosite's light that comes from within a polygon.

    polygon : (n, 2) x, y, pitches, either direction round;  side: of the square photosite;  split: of the four spots
    order   : of the product rule; chosen from the pattern and the footprint when left out
    """
    shortest = float(lens.blur.min()) * (2.0 * math.pi if lens.gaussian else 1.0)
    count = 1 if side == 0.0 else order or math.ceil(12 + 5.0 * side / shortest)
    along, weight = np.polynomial.legendre.leggauss(count) if side else (np.zeros(1), np.full(1, 2.0))
    spots = np.array([-0.5, 0.5]) * split if split else np.zeros(1)
    offsets = (0.5 * side * along[:, None] + spots).ravel()
    share = np.repeat(0.5 * weight, spots.size) / spots.size
    px, py = (g.ravel() for g in np.meshgrid(x + offsets, y + offsets))
    weights = np.outer(share, share).ravel()
    farthest = float(np.hypot(polygon[:, 0] - x, polygon[:, 1] - y).max()) + side + split + 1.0
    energy = encircled_energy(lens) if lens.blur.size == 1 else tabulated_energy(lens, farthest)
    length = shortest if lens.gaussian else float(lens.blur.min())
    total = 0.0
    for first in range(0, px.size, POINTS_AT_ONCE):
        some = slice(first, first + POINTS_AT_ONCE)
        total += float(weights[some] @ _point_values(polygon, px[some], py[some], energy, length))
    return total


def _point_values(polygon: F64, px: F64, py: F64, energy: Callable[[F64], F64], length: float) -> F64:
    """(1/2π) Σ ∫ E(r)·h/(h² + s²) ds at each point."""
    nodes, weights = np.polynomial.legendre.leggauss(PANEL_NODES)
    following = np.roll(polygon, -1, axis=0)
    area = np.sum(polygon[:, 0] * following[:, 1] - following[:, 0] * polygon[:, 1])
    total = np.zeros(px.size)
    for (ax, ay), (bx, by) in zip(polygon, following, strict=True):
        edge = math.hypot(bx - ax, by - ay)
        if edge == 0.0:
            continue
        tx, ty = (bx - ax) / edge, (by - ay) / edge
        panels = math.ceil(edge / (1.5 * length))
        s = ((np.arange(panels)[:, None] + 0.5 + 0.5 * nodes) * (edge / panels)).ravel()
        w = np.tile(0.5 * edge / panels * weights, panels)
        h = tx * (py - ay) - ty * (px - ax)
        foot = tx * (px - ax) + ty * (py - ay)
        square = h[:, None] ** 2 + (s[None] - foot[:, None]) ** 2
        with np.errstate(invalid="ignore", divide="ignore"):
            # On the edge itself E(r)/r² stays finite and h is 0: nothing is added.
            field = np.where(square > 0.0, energy(np.sqrt(square)) / square, 0.0)
        total += h * (field @ w)
    return total / (2.0 * math.pi) * math.copysign(1.0, float(area))
