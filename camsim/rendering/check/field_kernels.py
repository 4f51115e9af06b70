"""Sums of light over a picture's patches at one photosite; arrays only."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import C128, F64
from camsim.kernels import kernel


class Patches(NamedTuple):
    """A picture's field: patch (r, c) takes the coefficients from (r, c) on."""

    values: F64  # (planes, rows, cols) coefficients
    whole: np.ndarray  # (rows, cols) of patches
    degree: int
    corner: F64  # where the first patch begins
    axes: F64  # and its sides, (2, 2)


class Rule(NamedTuple):
    """Nodes and weights, over a footprint (m, 2) or over a patch's side, −1/2 … 1/2."""

    nodes: F64
    weights: F64


class Near(NamedTuple):
    """The pattern of every plane and channel by the radius: (cells, planes, channels, 6), so many cells a pitch."""

    table: F64
    per_pitch: float


class Far(NamedTuple):
    """r³ times its mean over a ring, (cells, planes, channels), on steps of log r."""

    table: F64
    first_log: float
    per_log: float


class Waves(NamedTuple):
    """r³ times the rings' light in the middles of cells, (cells, planes, channels), so many cells a pitch."""

    table: C128
    per_pitch: float


@kernel()
def _near(pattern: Near, r: float, p: int, c: int) -> float:
    place = r * pattern.per_pitch
    cell = min(int(place), len(pattern.table) - 1)
    t = place - cell
    a = pattern.table[cell, p, c]
    value: float = a[0] + t * (a[1] + t * (a[2] + t * (a[3] + t * (a[4] + t * a[5]))))
    return value


@kernel()
def _far(pattern: Far, r: float, p: int, c: int) -> float:
    table = pattern.table
    place = (math.log(r) - pattern.first_log) * pattern.per_log
    cell = min(max(int(place), 0), len(table) - 2)
    t = place - cell
    value: float = ((1.0 - t) * table[cell, p, c] + t * table[cell + 1, p, c]) / (r * r * r)
    return value


@kernel()
def _spline(degree: int, t: float, out: F64) -> None:
    """Set the splines of degree + 1 samples at t, 0 … 1 from the knot before."""
    if degree == 0:
        out[0] = 1.0
    elif degree == 1:
        out[0], out[1] = 1.0 - t, t
    else:
        s = 1.0 - t
        out[0], out[3] = s * s * s / 6.0, t * t * t / 6.0
        out[1], out[2] = 2.0 / 3.0 - t * t * (1.0 - 0.5 * t), 2.0 / 3.0 - s * s * (1.0 - 0.5 * s)


@kernel(allocates=True)
def lattice_light(
    patches: Patches, point: F64, footprint: Rule, inner: Rule, near: Near, bounds: tuple[float, float]
) -> F64:
    """Return (channels,): the light at a photosite of whole patches at some distance, for patches of area 1."""
    values, whole, degree, corner, axes = patches
    nodes, weights = footprint
    rows, cols = whole.shape
    planes, channels = near.table.shape[1], near.table.shape[2]
    count, order = len(weights), len(inner.nodes)
    sums = np.zeros((rows, channels))
    for r in range(rows):
        down, across = np.empty(4), np.empty(4)
        own = np.empty(planes)
        for c in range(cols):
            if not whole[r, c]:
                continue
            mx = corner[0] + (c + 0.5) * axes[0, 0] + (r + 0.5) * axes[1, 0] - point[0]
            my = corner[1] + (c + 0.5) * axes[0, 1] + (r + 0.5) * axes[1, 1] - point[1]
            distance = math.sqrt(mx * mx + my * my)
            if distance > bounds[1] or distance < bounds[0]:
                continue
            for i in range(order):
                _spline(degree, 0.5 + inner.nodes[i], down)
                for j in range(order):
                    _spline(degree, 0.5 + inner.nodes[j], across)
                    for p in range(planes):
                        own[p] = 0.0
                        for a in range(degree + 1):
                            for b in range(degree + 1):
                                own[p] += down[a] * across[b] * values[p, r + a, c + b]
                        own[p] *= inner.weights[i] * inner.weights[j]
                    x = mx + inner.nodes[j] * axes[0, 0] + inner.nodes[i] * axes[1, 0]
                    y = my + inner.nodes[j] * axes[0, 1] + inner.nodes[i] * axes[1, 1]
                    for m in range(count):
                        dx, dy = x - nodes[m, 0], y - nodes[m, 1]
                        distance = math.sqrt(dx * dx + dy * dy)
                        for p in range(planes):
                            light = own[p] * weights[m]
                            for k in range(channels):
                                sums[r, k] += light * _near(near, distance, p, k)
    total = np.zeros(channels)
    for r in range(rows):
        total += sums[r]
    return total


@kernel(allocates=True)
def middles_light(patches: Patches, point: F64, far: Far, radius: float) -> F64:
    """Return (channels,): that of those farther away, each in its middle."""
    values, whole, degree, corner, axes = patches
    rows, cols = whole.shape
    planes, channels = far.table.shape[1], far.table.shape[2]
    sums = np.zeros((rows, channels))
    for r in range(rows):
        half = np.empty(4)
        _spline(degree, 0.5, half)
        for c in range(cols):
            mx = corner[0] + (c + 0.5) * axes[0, 0] + (r + 0.5) * axes[1, 0] - point[0]
            my = corner[1] + (c + 0.5) * axes[0, 1] + (r + 0.5) * axes[1, 1] - point[1]
            distance = math.sqrt(mx * mx + my * my)
            if not whole[r, c] or distance <= radius:
                continue
            for p in range(planes):
                value = 0.0
                for i in range(degree + 1):
                    for j in range(degree + 1):
                        value += half[i] * half[j] * values[p, r + i, c + j]
                for k in range(channels):
                    sums[r, k] += value * _far(far, distance, p, k)
    total = np.zeros(channels)
    for r in range(rows):
        total += sums[r]
    return total


@kernel()
def _about(x: float, y: float, waves: Waves, shells: tuple[float, float], out: C128) -> tuple[int, int, int, float]:
    """Return cell, shell (negative: nearer than the first, or beyond the last) and sector of a place, and 1/r³."""
    _, count, sectors = out.shape
    r = math.hypot(x, y)
    place = (math.log(r) - shells[0]) * shells[1] if r > 0.0 else -1.0
    sector = int((math.atan2(y, x) / math.tau + 1.0) * sectors) % sectors
    shell = math.floor(place) if place < count else -1
    return min(int(r * waves.per_pitch), len(waves.table) - 1), shell, sector, r**-3.0


@kernel(allocates=True)
def rings_of_patches(
    patches: Patches, point: F64, waves: Waves, frequency: float, shells: tuple[float, float], out: C128
) -> None:
    """Add to (channels, shells, sectors): the rings of whole patches, by distance and direction.

    frequency : of the rings, which a patch averages over its sides, cycles/pitch
    shells    : log of where the first one begins, and how many there are to a step of log r
    """
    values, whole, degree, corner, axes = patches
    rows, cols = whole.shape
    half = np.empty(4)
    _spline(degree, 0.5, half)
    for r in range(rows):
        for c in range(cols):
            x = corner[0] + (c + 0.5) * axes[0, 0] + (r + 0.5) * axes[1, 0] - point[0]
            y = corner[1] + (c + 0.5) * axes[0, 1] + (r + 0.5) * axes[1, 1] - point[1]
            cell, shell, sector, light = _about(x, y, waves, shells, out)
            if shell < 0 or not whole[r, c]:
                continue
            per_side = math.pi * frequency / math.hypot(x, y)
            across = per_side * (x * axes[0, 0] + y * axes[0, 1])
            down = per_side * (x * axes[1, 0] + y * axes[1, 1])
            for turn in (across, down):
                light *= math.sin(turn) / turn if turn != 0.0 else 1.0
            for p in range(len(values)):
                value = 0.0
                for i in range(degree + 1):
                    for j in range(degree + 1):
                        value += half[i] * half[j] * values[p, r + i, c + j]
                for k in range(len(out)):
                    out[k, shell, sector] += light * value * waves.table[cell, p, k]


@kernel()
def rings_of_points(places: F64, lit: F64, point: F64, waves: Waves, shells: tuple[float, float], out: C128) -> None:
    """Add the rings of points (n, 2) of light (planes, n)."""
    for q in range(len(places)):
        cell, shell, sector, light = _about(places[q, 0] - point[0], places[q, 1] - point[1], waves, shells, out)
        if shell >= 0:
            for p in range(len(lit)):
                for k in range(len(out)):
                    out[k, shell, sector] += light * lit[p, q] * waves.table[cell, p, k]


@kernel(allocates=True)
def points_light(places: F64, light: F64, point: F64, footprint: Rule, near: Near, bounds: tuple[float, float]) -> F64:
    """Return (channels,): the light (planes, n) of points (n, 2) at a photosite, of those at some distance."""
    nodes, weights = footprint
    planes, channels = near.table.shape[1], near.table.shape[2]
    total = np.zeros(channels)
    for q in range(len(places)):
        mx, my = places[q, 0] - point[0], places[q, 1] - point[1]
        distance = math.sqrt(mx * mx + my * my)
        if distance > bounds[1] or distance <= bounds[0]:
            continue
        for m in range(len(weights)):
            dx, dy = mx - nodes[m, 0], my - nodes[m, 1]
            distance = math.sqrt(dx * dx + dy * dy)
            for p in range(planes):
                for k in range(channels):
                    total[k] += weights[m] * light[p, q] * _near(near, distance, p, k)
    return total


@kernel(allocates=True)
def far_points_light(places: F64, light: F64, point: F64, far: Far, radius: float) -> F64:
    """Return (channels,): that of those farther away."""
    planes, channels = far.table.shape[1], far.table.shape[2]
    total = np.zeros(channels)
    for q in range(len(places)):
        mx, my = places[q, 0] - point[0], places[q, 1] - point[1]
        distance = math.sqrt(mx * mx + my * my)
        if distance > radius:
            for p in range(planes):
                for k in range(channels):
                    total[k] += light[p, q] * _far(far, distance, p, k)
    return total
