"""Every rendering is checked: hard photosites are computed again by a path of its own.

The check averages point samples over the footprint by a Gauss product rule (the rendering uses filtered tables and
moments), integrates E(r)·h/(h² + s²) along each edge from a table of E/r² made directly from its formula (the
rendering interpolates the field of the potential), and changes to the far form of a *point* about three times
further out. It shares no radius, table, far form or wavelength node with the rendering; its settings come from a
fortieth of the tolerance.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numba as nb
import numpy as np

from camsim.arrays import F64, I64
from camsim.rendering.far import far_moments
from camsim.rendering.footprint import Footprint, footprint_rule, rule_order
from camsim.rendering.kernels import ONE_AT_A_TIME
from camsim.rendering.patterns import Pattern
from camsim.rendering.plan import quiet_distance
from camsim.rendering.quadrature import gauss_legendre, quintic_cells

CELLS_PER_BLUR = 32
PANEL_NODES = 20
PANEL_BLUR = 4.0
SHARE = 1.0 / 40.0  # of the tolerance: what the check may be wrong by


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Check:
    """Settings of the check, lengths in pitches: radius of exact integration and the footprint's rule."""

    radius: float
    nodes: F64
    weights: F64

    @classmethod
    def planned(cls, pattern: Pattern, blur: F64, shares: F64, footprint: Footprint, tolerance: float) -> Check:
        """Choose settings for a fortieth of ``tolerance``; arguments as in ``plan_boundary``."""
        longest, shortest = float(blur.max()), float(blur.min())
        allowed = SHARE * tolerance
        radius = max(
            12.0 * longest,
            pattern.quiet(allowed) * longest,
            quiet_distance(pattern, blur, shares, footprint, 0.25 * allowed, front="end"),
        )
        nodes, weights = footprint_rule(
            footprint.width,
            footprint.height,
            footprint.spots,
            rule_order(math.pi * footprint.side / shortest, 20.0 * allowed),
        )
        return cls(radius=radius + float(np.abs(nodes).max()), nodes=nodes, weights=weights)


def reference_values(
    points: F64,
    sets: I64,
    *,
    start: F64,
    end: F64,
    pair: I64,
    weights: F64,
    base: F64,
    pattern: Pattern,
    blur: F64,
    check: Check,
) -> F64:
    """Return the light at ``points`` (m, 2), each in its channel ``sets`` (m,); the rest as in ``boundary_image``."""
    step = float(blur.min()) / CELLS_PER_BLUR
    cells = math.ceil(check.radius / step) + 1
    profile = _profile(pattern, 1 << (cells + 3).bit_length())  # its last cells are read three further on
    pairs, channels = weights.shape[:2]
    table_of = np.full((pairs, channels), -1)
    for point, channel in zip(points, sets, strict=True):
        table_of[pair[_distance(point, start, end) <= check.radius], channel] = 0
    used = table_of == 0
    table_of[used] = np.arange(np.count_nonzero(used))
    tables = quintic_cells(_contract_profile(profile, blur, weights[used], step, cells))
    far = far_moments(pattern, blur, weights.reshape(pairs * channels, -1)).reshape(pairs, channels, 4)
    gauss_x, gauss_w = gauss_legendre(PANEL_NODES)
    with ONE_AT_A_TIME:
        samples = _point_samples(
            points,
            sets,
            start,
            end,
            pair,
            table_of,
            tables,
            step,
            far,
            check.radius,
            check.nodes,
            PANEL_BLUR * float(blur.min()),
            gauss_x,
            gauss_w,
        )
    values: F64 = base[sets] + samples @ check.weights
    return values


def _distance(point: F64, start: F64, end: F64) -> F64:
    """Distance of a point from every edge."""
    along = end - start
    t = np.clip(np.sum((point - start) * along, axis=1) / np.sum(along * along, axis=1), 0.0, 1.0)
    distance: F64 = np.hypot(*(start + t[:, None] * along - point).T)
    return distance


@functools.cache
def _profile(pattern: Pattern, cells: int) -> F64:
    """E/ρ² as a quintic per cell (cells, 6), even in ρ."""
    rho = np.arange(-2, cells + 3) / CELLS_PER_BLUR
    safe = np.where(rho == 0.0, 1.0, np.abs(rho))
    values = np.where(rho == 0.0, pattern.core, pattern.energy(safe) / safe**2)
    profile = quintic_cells(values)
    profile.flags.writeable = False
    return profile


@nb.njit(cache=True)
def _contract_profile(profile: F64, blur: F64, weights: F64, step: float, cells: int) -> F64:
    """Σ_j w[k, j]·E/r² of λ_j at multiples −2 … cells + 2 of ``step``."""
    values = np.zeros((weights.shape[0], cells + 5))
    for j in range(blur.size):
        scale = step * CELLS_PER_BLUR / blur[j]
        inverse_square = 1.0 / (blur[j] * blur[j])
        for m in range(cells + 5):
            u = abs(m - 2) * scale
            c = profile[int(u)]
            t = u - int(u)
            value = (c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))))) * inverse_square
            for k in range(weights.shape[0]):
                values[k, m] += weights[k, j] * value
    return values


@nb.njit(cache=True, inline="always")
def _beyond(h: float, s: float, far: F64) -> float:
    """Σ c_k·∫ds/r^k over the half line from s ≥ 0, for k = 3, 5, 7."""
    r = math.hypot(h, s)
    u = s / r
    third = 1.0 / (r * (r + s))
    total: float = third * (
        far[1] + third * ((2.0 + u) / 3.0 * far[2] + third * (8.0 + 9.0 * u + 3.0 * u * u) / 15.0 * far[3])
    )
    return total


@nb.njit(cache=True)
def _point_far(h: float, s1: float, s2: float, far: F64) -> float:
    """Far form of a point sample over s1 … s2: the angle and the first three powers of 1/r."""
    if s1 < 0.0 < s2:
        powers = 2.0 * _beyond(h, 0.0, far) - _beyond(h, -s1, far) - _beyond(h, s2, far)
    else:
        powers = _beyond(h, min(abs(s1), abs(s2)), far) - _beyond(h, max(abs(s1), abs(s2)), far)
    total: float = far[0] * math.atan2(h * (s2 - s1), h * h + s1 * s2) - h * powers
    return total


@nb.njit(cache=True, parallel=True, error_model="numpy", fastmath={"contract"})
def _point_samples(
    points: F64,
    sets: I64,
    start: F64,
    end: F64,
    pair: I64,
    table_of: I64,
    tables: F64,
    step: float,
    far: F64,
    radius: float,
    nodes: F64,
    panel: float,
    gauss_x: F64,
    gauss_w: F64,
) -> F64:
    """Sum over the edges for every point and footprint node: (points, nodes), no background."""
    count, per_step = len(nodes), 1.0 / step
    samples = np.zeros((len(points), count))
    for job in nb.prange(len(points) * count):
        point, node = job // count, job % count
        x, y = points[point, 0] + nodes[node, 0], points[point, 1] + nodes[node, 1]
        channel = sets[point]
        total = 0.0
        for e in range(len(pair)):
            length = math.hypot(end[e, 0] - start[e, 0], end[e, 1] - start[e, 1])
            tx, ty = (end[e, 0] - start[e, 0]) / length, (end[e, 1] - start[e, 1]) / length
            dx, dy = start[e, 0] - x, start[e, 1] - y
            h = dx * ty - dy * tx
            s1 = dx * tx + dy * ty
            s2 = s1 + length
            f = far[pair[e], channel]
            table = table_of[pair[e], channel]
            cut = radius * radius - h * h
            cut = math.sqrt(cut) if cut > 0.0 else 0.0
            low, high = max(s1, -cut), min(s2, cut)
            if table < 0 or high <= low:
                total += _point_far(h, s1, s2, f)
                continue
            if s1 < low:
                total += _point_far(h, s1, low, f)
            if s2 > high:
                total += _point_far(h, high, s2, f)
            panels = math.ceil((high - low) / panel)
            half = 0.5 * (high - low) / panels
            inside = 0.0
            cells = tables[table]
            for p in range(panels):
                middle = low + half * (2 * p + 1)
                for q in range(gauss_x.size):
                    s = middle + half * gauss_x[q]
                    u = math.sqrt(h * h + s * s) * per_step
                    cell = np.uintp(u)
                    t = u - cell
                    c = cells[cell]
                    inside += gauss_w[q] * (c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5])))))
            total += h * half * inside / (2.0 * math.pi)
        samples[point, node] = total
    return samples
