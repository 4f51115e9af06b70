"""Light at photosites: Σ (left − right)·∮ G dφ along pieces of outlines, and sums of the PSF over places."""

from __future__ import annotations

import math

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.core.kernels import kernel
from camsim.rendering.direct.cuts import place_at
from camsim.rendering.direct.records import POWERS, Outlines, Table

FAR_LENGTH, FAR_NODES = 0.5, 4  # the longest far panel, over its distance, and its nodes
MOST_TURN = 1.0  # largest angle of a panel of an arc, radians
DEEP = 96  # size of the stack of halved panels


@kernel(forceinline=True)
def _turned(x: float, y: float, times: int) -> tuple[float, float]:
    """Return a power of a unit vector, taken as a complex number."""
    a, b = x, y
    for _ in range(times - 1):
        a, b = a * x - b * y, a * y + b * x
    return a, b


@kernel(forceinline=True)
def _between(values: F64, cell: int, k: int, w: tuple[float, float, float, float, float, float]) -> float:
    """Return a quintic between two rows, from values and two derivatives at either."""
    here, there = values[cell], values[cell + 1]
    value: float = (
        w[0] * here[0, k] + w[1] * here[1, k] + w[2] * here[2, k]
        + w[3] * there[0, k] + w[4] * there[1, k] + w[5] * there[2, k]
    )  # fmt: skip
    return value


@kernel()
def _near(values: F64, t: Table, r: float, x: float, y: float, out: F64) -> None:
    """Set a table's values (kinds,) at a distance in the direction of a unit vector, by quintic interpolation."""
    zone = len(t.starts) - 1
    while r < t.starts[zone]:
        zone -= 1
    place = (r - t.starts[zone]) * t.per_pitch[zone]
    cell = int(place)
    u = place - cell
    cell += t.first[zone]
    v = 1.0 - u
    w0, w1, w2 = v * v * v * (1.0 + 3.0 * u + 6.0 * u * u), v * v * v * u * (1.0 + 3.0 * u), 0.5 * v * v * v * u * u
    w3, w4 = u * u * u * (1.0 + 3.0 * v + 6.0 * v * v), -u * u * u * v * (1.0 + 3.0 * v)
    w5 = 0.5 * u * u * u * v * v
    weights = w0, w1, w2, w3, w4, w5
    kinds = t.kinds
    for q in range(kinds):
        out[q] = _between(values, cell, q, weights)
    if t.cosines == 0:
        return
    step_c, step_s = _turned(x, y, t.step)
    c, s = step_c, step_s
    for n in range(1, t.cosines + 1):
        for q in range(kinds):
            out[q] += c * _between(values, cell, n * kinds + q, weights)
            if t.sines:
                out[q] += s * _between(values, cell, (t.cosines + n) * kinds + q, weights)
        c, s = c * step_c - s * step_s, c * step_s + s * step_c


@kernel()
def _far(t: Table, inside: bool, r: float, x: float, y: float, out: F64) -> None:
    """Set the PSF's tail (kinds,), or with ``inside`` the difference of G from its limit at infinite r."""
    one = 1.0 / r
    step_c, step_s = 1.0, 0.0
    if t.far > 1:
        step_c, step_s = _turned(x, y, t.step)
    c, s = 1.0, 0.0
    out[:] = 0.0
    for n in range(t.far):
        for side in range(2 if t.sines and n else 1):
            h = n + side * t.cosines
            turn = s if side else c
            for q in range(t.kinds):
                total = 0.0
                for p in range(POWERS - 1, -1, -1):
                    # Term p is of r^{−p−3}; its integral is r^{−p−1} over −(p + 1).
                    total = total * one + (-t.powers[h, q, p] / (p + 1.0) if inside else t.powers[h, q, p])
                out[q] += turn * total * (one if inside else one * one * one)
        c, s = c * step_c - s * step_s, c * step_s + s * step_c


@kernel()
def _ends(t: Table, x: float, y: float, x1: float, y1: float, out: F64) -> None:
    """Set ∫ G dφ (kinds,) at infinite r, from the direction of one unit vector to that of another."""
    angle = math.atan2(x * y1 - y * x1, x * x1 + y * y1)
    for q in range(t.kinds):
        out[q] = t.ends[0, q] * angle
    if t.ending < 2:
        return
    step_c, step_s = _turned(x, y, t.step)
    step_c1, step_s1 = _turned(x1, y1, t.step)
    c, s, c1, s1 = step_c, step_s, step_c1, step_s1
    for n in range(1, t.ending):
        for q in range(t.kinds):
            out[q] += t.ends[n, q] * (s1 - s) / (n * t.step)
            if t.sines:
                out[q] -= t.ends[t.cosines + n, q] * (c1 - c) / (n * t.step)
        c, s = c * step_c - s * step_s, c * step_s + s * step_c
        c1, s1 = c1 * step_c1 - s1 * step_s1, c1 * step_s1 + s1 * step_c1


@kernel(allocates=True)
def along_outlines(
    points: F64,
    o: Outlines,
    length: F64,
    pair: I64,
    weights: F64,
    t: Table,
    panels: tuple[F64, F64, F64, float],
    out: F64,
    begin: int,
    end: int,
) -> None:
    """Add the light of outlines at photosites (n, 2) to ``out`` (n, channels).

    pair, weights : pair of spectra of each piece (pieces,), and left minus right of each pair (pairs, channels, kinds)
    panels        : nodes and weights of Gauss rules by order, the phases that they resolve, and the longest near panel
    """
    nodes, of_nodes, phases, longest = panels
    seen, total = np.empty(t.kinds), np.empty(t.kinds)
    stack = np.empty((DEEP, 2))
    per_length = phases[-1] / longest
    for p in range(begin, end):
        px, py = points[p, 0], points[p, 1]
        for e in range(len(length)):
            turn = abs(o.turn_rad[e])
            total[:] = 0.0
            stack[0, 0], stack[0, 1], depth = 0.0, 1.0, 1
            while depth > 0:
                depth -= 1
                t0, t1 = stack[depth, 0], stack[depth, 1]
                long = (t1 - t0) * length[e]
                x, y, _, _ = place_at(o, e, 0.5 * (t0 + t1))
                nearest = math.hypot(x - px, y - py) - 0.5 * long
                is_far = nearest >= t.until
                too_long = long > (FAR_LENGTH * nearest if is_far else longest) or turn * (t1 - t0) > MOST_TURN
                if too_long and depth + 2 <= DEEP:
                    middle = 0.5 * (t0 + t1)
                    stack[depth, 0], stack[depth, 1] = t0, middle
                    stack[depth + 1, 0], stack[depth + 1, 1] = middle, t1
                    depth += 2
                    continue
                if is_far:
                    order = FAR_NODES
                    x0, y0, _, _ = place_at(o, e, t0)
                    x1, y1, _, _ = place_at(o, e, t1)
                    r, r1 = math.hypot(x0 - px, y0 - py), math.hypot(x1 - px, y1 - py)
                    _ends(t, (x0 - px) / r, (y0 - py) / r, (x1 - px) / r1, (y1 - py) / r1, seen)
                    for q in range(t.kinds):
                        total[q] += seen[q]
                else:
                    order = 1
                    while phases[order - 1] < per_length * long and order < len(phases):
                        order += 1
                share = t1 - t0
                for k in range(order):
                    x, y, dx, dy = place_at(o, e, 0.5 * (t0 + t1) + 0.5 * share * nodes[order - 1, k])
                    x, y = x - px, y - py
                    r = math.hypot(x, y)
                    cross = x * dy - y * dx
                    if r == 0.0 or cross == 0.0:
                        continue
                    times = 0.5 * share * of_nodes[order - 1, k] * cross / (r * r)
                    if is_far or r >= t.until:
                        _far(t, True, r, x / r, y / r, seen)
                        if not is_far:
                            _whole(t, x / r, y / r, seen)
                    else:
                        _near(t.within, t, r, x / r, y / r, seen)
                    for q in range(t.kinds):
                        total[q] += times * seen[q]
            for c in range(weights.shape[1]):
                for q in range(t.kinds):
                    out[p, c] += weights[pair[e], c, q] * total[q]


@kernel()
def _whole(t: Table, x: float, y: float, out: F64) -> None:
    """Add the limit of G at infinite r (kinds,) in the direction of a unit vector."""
    step_c, step_s = _turned(x, y, t.step)
    c, s = 1.0, 0.0
    for n in range(t.ending):
        for q in range(t.kinds):
            out[q] += t.ends[n, q] * c
            if t.sines and n:
                out[q] += t.ends[t.cosines + n, q] * s
        c, s = c * step_c - s * step_s, c * step_s + s * step_c


@kernel(forceinline=True)
def _light_at(t: Table, x: float, y: float, out: F64) -> None:
    """Set the PSF (kinds,) at a place relative to the photosite."""
    r = math.hypot(x, y)
    if r >= t.until:
        _far(t, False, r, x / r, y / r, out)
    elif r > 0.0:
        _near(t.light, t, r, x / r, y / r, out)
    else:
        _near(t.light, t, 0.0, 1.0, 0.0, out)


@kernel(forceinline=True)
def _weighed(weights: F64, total: F64, out: F64) -> None:
    """Add light of planes (planes, kinds), weighted, to channels (channels,)."""
    for p in range(len(weights)):
        for c in range(weights.shape[1]):
            for q in range(weights.shape[2]):
                out[c] += weights[p, c, q] * total[p, q]


@kernel(allocates=True)
def over_samples(
    points: F64,
    values: F64,
    some: np.ndarray,
    at: F64,
    sides: F64,
    t: Table,
    weights: F64,
    out: F64,
    begin: int,
    end: int,
) -> None:
    """Add the light of a picture's samples (planes, rows, cols) in the mask ``some`` to photosites; at: the first."""
    planes, rows, cols = values.shape
    light, total = np.empty(t.kinds), np.empty((planes, t.kinds))
    for p in range(begin, end):
        total[:] = 0.0
        for r in range(rows):
            x0, y0 = at[0] + r * sides[1, 0] - points[p, 0], at[1] + r * sides[1, 1] - points[p, 1]
            for c in range(cols):
                if some[r, c]:
                    _light_at(t, x0 + c * sides[0, 0], y0 + c * sides[0, 1], light)
                    for plane in range(planes):
                        for q in range(t.kinds):
                            total[plane, q] += values[plane, r, c] * light[q]
        _weighed(weights, total, out[p])


@kernel(allocates=True)
def over_nodes(
    points: F64,
    centres: F64,
    reach: float,
    fine: tuple[I64, F64, F64],
    coarse: tuple[I64, F64, F64],
    t: Table,
    weights: F64,
    out: F64,
    begin: int,
    end: int,
) -> None:
    """Add the light of cells to photosites, with fine nodes for centres within ``reach`` and coarse ones beyond.

    fine   : (cells, 2) where each cell's nodes begin and end, places (n, 2), and light (n, planes)
    coarse : the same, but (cells + 1,) where they begin
    """
    (begins, fine_at, of_fine), (first, coarse_at, of_coarse) = fine, coarse
    planes = len(weights)
    light, total = np.empty(t.kinds), np.empty((planes, t.kinds))
    for p in range(begin, end):
        total[:] = 0.0
        for cell in range(len(centres)):
            near = math.hypot(centres[cell, 0] - points[p, 0], centres[cell, 1] - points[p, 1]) < reach
            low, high = (begins[cell, 0], begins[cell, 1]) if near else (first[cell], first[cell + 1])
            for k in range(low, high):
                x, y = (fine_at[k, 0], fine_at[k, 1]) if near else (coarse_at[k, 0], coarse_at[k, 1])
                _light_at(t, x - points[p, 0], y - points[p, 1], light)
                for plane in range(planes):
                    size = of_fine[k, plane] if near else of_coarse[k, plane]
                    for q in range(t.kinds):
                        total[plane, q] += size * light[q]
        _weighed(weights, total, out[p])
