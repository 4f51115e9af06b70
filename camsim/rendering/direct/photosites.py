"""Light at photosites: Σ (left − right)·∮ G dφ along pieces of outlines, and sums of the PSF over places."""

from __future__ import annotations

import math

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.core.kernels import kernel
from camsim.rendering.direct.cuts import place_at
from camsim.rendering.direct.records import POWERS, Nodes, Outlines, Table

FAR_LENGTH, FAR_NODES = 0.5, 4  # the longest far panel, over its distance, and its nodes
FEW_LENGTH, FEW_NODES = 0.06, 2  # the longest for which fewer are as exact
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
def _far(t: Table, r: float, x: float, y: float, out: F64) -> None:
    """Set the difference of G (kinds,) from its limit at infinite r."""
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
                    # Term p of the PSF is of r^{−p−3}; its integral is r^{−p−1} over −(p + 1).
                    total = total * one - t.powers[h, q, p] / (p + 1.0)
                out[q] += turn * total * one
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
                    order = FEW_NODES if long <= FEW_LENGTH * nearest else FAR_NODES
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
                        _far(t, r, x / r, y / r, seen)
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
def _add_light(t: Table, x: float, y: float, values: F64, k: int, light: F64, total: F64, tails: F64) -> None:
    """Add the PSF at a place relative to the photosite, times values (planes, n) of number k.

    A near place adds to ``total`` (planes, kinds); a far one, to ``tails`` (harmonics, POWERS, planes), sums of the
    tail's powers of 1/r, which do not depend on the kind of light.
    """
    r = math.sqrt(x * x + y * y)
    if r < t.until:
        _near(t.light, t, r, x / r if r > 0.0 else 1.0, y / r if r > 0.0 else 0.0, light)
        for plane in range(len(total)):
            for q in range(t.kinds):
                total[plane, q] += values[plane, k] * light[q]
        return
    one = 1.0 / r
    step_c, step_s, c, s = 1.0, 0.0, 1.0, 0.0
    if t.far > 1:
        step_c, step_s = _turned(x * one, y * one, t.step)
    for n in range(t.far):
        for side in range(2 if t.sines and n else 1):
            power = (s if side else c) * one * one * one
            for p in range(POWERS):
                if r > t.reach[p]:
                    break
                for plane in range(len(total)):
                    tails[n + side * t.cosines, p, plane] += values[plane, k] * power
                power *= one
        c, s = c * step_c - s * step_s, c * step_s + s * step_c


@kernel(forceinline=True)
def _weighed(t: Table, weights: F64, total: F64, tails: F64, out: F64) -> None:
    """Add light of planes, see ``_add_light``, weighted, to channels (channels,)."""
    for plane in range(len(weights)):
        for q in range(t.kinds):
            light = total[plane, q]
            for h in range(len(tails)):
                for p in range(POWERS):
                    light += tails[h, p, plane] * t.powers[h, q, p]
            for c in range(weights.shape[1]):
                out[c] += weights[plane, c, q] * light


@kernel(allocates=True, error_model="numpy")
def over_samples(
    points: F64, values: F64, some: np.ndarray, lattice: F64, t: Table, weights: F64, out: F64, begin: int, end: int
) -> None:
    """Add the light of a picture's samples (planes, rows, cols), of those in the mask ``some``, to photosites.

    lattice : (3, 2) place of the first sample, and steps along rows and down columns
    """
    rows, cols = some.shape
    light, total = np.empty(t.kinds), np.empty((len(weights), t.kinds))
    tails, far = np.empty((len(t.powers), POWERS, len(weights))), np.empty(cols)
    plain = max(t.until, t.reach[1]) if t.far == 1 else math.inf  # from there on the tail is its first power
    dx, dy = lattice[1]
    for p in range(begin, end):
        total[:], tails[:] = 0.0, 0.0
        for r in range(rows):
            x0, y0 = lattice[0, 0] + r * lattice[2, 0] - points[p, 0], lattice[0, 1] + r * lattice[2, 1] - points[p, 1]
            first, last = _within(x0, y0, dx, dy, plain, cols)
            for c in range(cols):
                x, y = x0 + c * dx, y0 + c * dy
                square = x * x + y * y
                far[c] = 1.0 / (square * math.sqrt(square)) if some[r, c] and not first <= c < last else 0.0
            for plane in range(len(weights)):
                tails[0, 0, plane] += np.dot(far, values[plane, r])
            for c in range(first, last):
                if some[r, c]:
                    _add_light(t, x0 + c * dx, y0 + c * dy, values[:, r], c, light, total, tails)
        _weighed(t, weights, total, tails, out[p])


@kernel()
def _within(x: float, y: float, dx: float, dy: float, radius: float, count: int) -> tuple[int, int]:
    """Return the first of ``count`` places along a row within a radius, or one nearby, and the one past the last."""
    square = dx * dx + dy * dy
    middle, away = -(x * dx + y * dy) / square, x * dy - y * dx
    half = math.sqrt(max(radius * radius - away * away / square, 0.0) / square) + 1.0
    return int(min(max(middle - half, 0.0), count)), int(min(max(middle + half + 1.0, 0.0), count))


@kernel(allocates=True)
def over_nodes(
    points: F64, cells: F64, reach: float, nodes: Nodes, t: Table, weights: F64, out: F64, begin: int, end: int
) -> None:
    """Add the light of cells to photosites, with fine nodes for centres (n, 2) within ``reach``, coarse ones beyond."""
    light, total = np.empty(t.kinds), np.empty((len(weights), t.kinds))
    tails = np.empty((len(t.powers), POWERS, len(weights)))
    for p in range(begin, end):
        total[:], tails[:] = 0.0, 0.0
        for cell in range(len(cells)):
            which = 0 if math.hypot(cells[cell, 0] - points[p, 0], cells[cell, 1] - points[p, 1]) < reach else 1
            for k in range(nodes.begins[cell, which, 0], nodes.begins[cell, which, 1]):
                x, y = nodes.at[k, 0] - points[p, 0], nodes.at[k, 1] - points[p, 1]
                _add_light(t, x, y, nodes.light, k, light, total, tails)
        _weighed(t, weights, total, tails, out[p])
