"""Lattices of points in a picture, such as a chart in perspective: grown from point to neighbour, and projected."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from camsim.core.arrays import F64

Places: TypeAlias = dict[tuple[int, int], F64]
"""Points (x, y) by column and row in a lattice."""

_SEEDS = 40
_LOOKED_AT = 600
"""Most seeds, by decreasing size, from which lattices are grown."""


def homography(given: F64, wanted: F64) -> F64:
    """Return the (3, 3) least-squares projection of points (n, 2) to others (n, 2) (Hartley)."""
    (shift, scale), (shift_w, scale_w) = _normal(given), _normal(wanted)
    x, y = ((given - shift) * scale).T
    u, v = ((wanted - shift_w) * scale_w).T
    zero, one = np.zeros_like(x), np.ones_like(x)
    rows = np.concatenate(
        [
            np.stack([x, y, one, zero, zero, zero, -u * x, -u * y, -u], axis=1),
            np.stack([zero, zero, zero, x, y, one, -v * x, -v * y, -v], axis=1),
        ]
    )
    inner = np.linalg.svd(rows)[2][-1].reshape(3, 3)
    to = np.array([[scale, 0, -scale * shift[0]], [0, scale, -scale * shift[1]], [0, 0, 1]])
    back = np.array([[1 / scale_w, 0, shift_w[0]], [0, 1 / scale_w, shift_w[1]], [0, 0, 1]])
    whole: F64 = back @ inner @ to
    return whole


def _normal(places: F64) -> tuple[F64, float]:
    middle = places.mean(axis=0)
    return middle, math.sqrt(2.0) / max(float(np.hypot(*(places - middle).T).mean()), 1e-12)


def moved(projection: F64, places: F64) -> F64:
    """Return where a projection takes points (n, 2)."""
    x, y, w = projection @ np.concatenate([places, np.ones((len(places), 1))], axis=1).T
    moved: F64 = np.stack([x / w, y / w], axis=1)
    return moved


def lattices(middles: F64, sizes: F64, *, least: int, most: int) -> Iterator[Places]:
    """Yield lattices of points, each grown from a point and two of its neighbours; the largest points are tried first.

    sizes : areas (n,) of the regions at the points, similar within a lattice;  least, most : points in a lattice
    """
    grown: list[Places] = []
    taken: set[int] = set()
    for seed in np.argsort(-sizes)[:_LOOKED_AT].tolist():
        if seed in taken or len(grown) >= _SEEDS:
            continue
        alike = np.flatnonzero((sizes > 0.4 * sizes[seed]) & (sizes < 2.5 * sizes[seed]))
        ways = middles[alike] - middles[seed]
        lengths = np.hypot(*ways.T)
        near = [k for k in np.argsort(lengths).tolist() if lengths[k] > 0.9 * math.sqrt(sizes[seed])][:5]
        best: dict[tuple[int, int], int] = {}
        for a, b in itertools.permutations(near, 2):
            across, down = ways[a], ways[b]
            turned = across[0] * down[1] - across[1] * down[0]
            # Down is clockwise of across, as displayed: charts are not mirrored.
            if turned < 0.85 * lengths[a] * lengths[b] or not 0.6 < lengths[a] / lengths[b] < 1.7:
                continue
            lattice = _grown(middles, alike, seed, across, down, most)
            if len(lattice) > len(best):
                best = lattice
        if len(best) >= least:
            taken |= set(best.values())
            grown.append({place: middles[k] for place, k in best.items()})
    yield from sorted(grown, key=len, reverse=True)


def _grown(
    middles: F64, alike: npt.NDArray[np.intp], seed: int, across: F64, down: F64, most: int
) -> dict[tuple[int, int], int]:
    """Return regions by lattice index; steps are updated from found ones, as perspective changes them."""
    found, steps, left = {(0, 0): seed}, {(0, 0): (across, down)}, [(0, 0)]
    others, used = middles[alike], {seed}
    while left and len(found) < most:
        place = left.pop(0)
        each = steps[place]
        for axis, sign in ((0, 1), (0, -1), (1, 1), (1, -1)):
            to = (place[0] + sign, place[1]) if axis == 0 else (place[0], place[1] + sign)
            if to in found:
                continue
            guess = middles[found[place]] + sign * each[axis]
            distance = np.hypot(*(others - guess).T)
            nearest = int(np.argmin(distance))
            if distance[nearest] > 0.25 * np.hypot(*each[axis]) or int(alike[nearest]) in used:
                continue
            step = sign * (others[nearest] - middles[found[place]])
            found[to] = int(alike[nearest])
            used.add(found[to])
            steps[to] = (step, each[1]) if axis == 0 else (each[0], step)
            left.append(to)
    return found
