"""Curves followed piece by piece by polynomials: as few nodes as what is made of the curve allows."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from camsim.arrays import C128, F64
from camsim.quadrature import chebyshev, interpolation
from camsim.rendering.across.unfollowed import unfollowed

COUNTS = (3, 4, 5, 6, 8, 10, 12, 16)  # nodes tried in a panel
MOST_NODES = 400
THINNEST = 1e-6  # of the whole: panels are cut no further


@dataclass(frozen=True, kw_only=True, eq=False)
class Panels:
    """Chebyshev nodes in panels that touch.

    ends   : (n + 1,) of the panels;  counts: (n,) nodes in each
    """

    ends: tuple[float, ...]
    counts: tuple[int, ...]

    @property
    def nodes(self) -> F64:
        """All nodes (k,)."""
        parts = [
            0.5 * (low + high) + 0.5 * (high - low) * chebyshev(count)
            for low, high, count in zip(self.ends[:-1], self.ends[1:], self.counts, strict=True)
        ]
        return np.concatenate(parts)

    def weights(self, places: F64) -> F64:
        """Return (places, k): what each node weighs at places."""
        out = np.zeros((places.size, sum(self.counts)))
        which = np.clip(np.searchsorted(self.ends, places, side="right") - 1, 0, len(self.counts) - 1)
        first = 0
        for k, count in enumerate(self.counts):
            low, high = self.ends[k], self.ends[k + 1]
            here = which == k
            own = (places[here] - 0.5 * (low + high)) / max(0.5 * (high - low), 1e-300)
            out[here, first : first + count] = interpolation(chebyshev(count), own)
            first += count
        return out


def panels(sampled: Callable[[F64], C128], low: float, high: float, knots: Sequence[float], allowed: float) -> Panels:
    """Return panels from whose nodes ``sampled`` is interpolated to what is allowed.

    sampled : places (n,) → (n, …) numbers, real or complex
    knots   : where a panel may rather end than anywhere else
    """
    if high <= low:
        return Panels(ends=(low, low), counts=(1,))
    found: list[tuple[float, float, int]] = []
    open_ends = [(low, high)]
    while open_ends:
        a, b = open_ends.pop()
        count = _enough(sampled, a, b, allowed)
        if count is not None:
            found.append((a, b, count))
            continue
        if b - a < THINNEST * (high - low) or sum(n for *_, n in found) > MOST_NODES:
            raise unfollowed(f"{MOST_NODES} places along the radius")
        inside = [knot for knot in knots if a < knot < b]
        middle = 0.5 * (a + b)
        cut = min(inside, key=lambda knot: abs(knot - middle)) if inside else middle
        open_ends += [(cut, b), (a, cut)]
    return Panels(ends=(low, *(b for _, b, _ in found)), counts=tuple(n for *_, n in found))


def _enough(sampled: Callable[[F64], C128], low: float, high: float, allowed: float) -> int | None:
    """Return how many nodes are enough in one panel, None where the most are not."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    between = np.cos(math.pi * np.arange(COUNTS[-1] + 1) / COUNTS[-1])
    right = sampled(middle + half * between)
    # Of terms from the n-th on n nodes have nothing: these are missing, at the root of the mean of their squares.
    pairs = np.ascontiguousarray(right.reshape(len(right), -1)).view(np.float64)
    missing = np.abs(scipy.fft.dct(pairs, type=1, axis=0)).max(axis=1) / (math.sqrt(2.0) * COUNTS[-1])
    for count in COUNTS:
        if float(missing[count:].max()) > allowed:
            continue
        x = chebyshev(count)
        found = np.einsum("pn,n...->p...", interpolation(x, between), sampled(middle + half * x))
        if float(np.abs(found - right).max()) <= allowed:
            return count
    return None
