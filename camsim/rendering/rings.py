"""Edges around a place by their distance: ringing that adds up in phase at the centre of concentric outlines.

The light of a region at a place is ∮ E(r)·dφ/2π along its outline. Only the part of an edge that is perpendicular to
the line of sight contributes; elsewhere the phase varies and ringing cancels. Edges that stay perpendicular, as circles
do about their centre, contribute more than straight ones, and several add up where their distances differ by whole
waves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy

from camsim.core.arrays import F64
from camsim.core.kernels import kernel
from camsim.rendering.edges import Edges
from camsim.rendering.fast_length import fast_length
from camsim.rendering.grid import Grid

PLACES = 4  # centres of curvature that are examined, in addition to the frame's centre
A_WAVE, MOST_BINS = 8, 1 << 16  # bins of distance per period of the highest frequency, and the largest number of bins
MOST_PAIRS = 20_000  # pairs of edges whose centre of curvature is computed
MOST_WAVES = 16  # wavelengths whose ringing is summed


@dataclass(frozen=True, kw_only=True, eq=False)
class Rings:
    """Edges perpendicular to the line of sight from a few places, binned by distance.

    shares : (places, bins) jump × fraction of the circle, by distance
    step   : width of a bin, pitches
    most   : largest jump
    """

    shares: F64
    step: float
    most: float

    @classmethod
    def of(cls, edges: Edges, grid: Grid, farthest: float, jump: F64, longest: float, highest: float) -> Rings:
        """Bin edges about the frame's centre and the outlines' centres of curvature.

        farthest : largest distance of an edge, pitches
        jump : (n,) light on edges' left minus that on their right;  longest: λN, pitches;  highest: cycles/pitch
        """
        step = 1.0 / (A_WAVE * highest)
        places = _places(edges, jump, grid)
        reach = min(farthest + 1.0, (MOST_BINS - 2) * step)
        bins = math.ceil(reach / step) + 2
        shares = np.zeros((len(places), bins))
        for one, place in zip(shares, places, strict=True):
            _see(edges.start, edges.end, jump, (place[0], place[1]), longest, step, one)
        return cls(shares=shares, step=step, most=float(np.abs(jump).max()))

    @property
    def distances(self) -> F64:
        """Distances of the bins."""
        distances: F64 = self.step * np.maximum(np.arange(self.shares.shape[1]), 0.5)
        return distances

    def beyond(self, passes: F64, highest: float) -> F64:
        """Return, for evenly spaced frequencies, the largest light at any place from all frequencies above each.

        passes : (steps,) transfer at the steps' midpoints, up to the highest frequency, × light of the largest jump

        The light at a frequency is Σ share·2πr·J1(2πrf); for a straight edge this is 1/πf.
        """
        steps = passes.size
        count = fast_length(2 * max(self.shares.shape[1], math.ceil(steps / (highest * self.step))))
        lines = scipy.fft.rfft(self.shares * (2.0 / self.most * np.sqrt(self.distances)), count, axis=1)
        frequency = (np.arange(lines.shape[1]) + 0.5) / (count * self.step)
        within = frequency < highest
        cell = np.minimum(np.floor(frequency[within] * (steps / highest)).astype(np.int64), steps - 1)
        seen = lines[:, within] * (passes[cell] / np.sqrt(frequency[within]) / (count * self.step))
        last = np.append(np.searchsorted(cell, np.arange(steps)), cell.size - 1)[:steps]
        beyond = np.abs(np.cumsum(seen[:, ::-1], axis=1)[:, ::-1]).max(axis=0)
        most: F64 = np.maximum.accumulate(beyond[::-1])[::-1][last]
        return most

    def reach(self, blur: F64, light: F64, strength: float, allowed: float) -> float:
        """Return the distance beyond which the ringing of all edges together stays within ``allowed``.

        blur, light : (n,) λN, pitches, and its share of the light;  a circle rings by strength × (λN/r)²/π³
        """
        every = -(-blur.size // MOST_WAVES)
        starts = np.arange(0, blur.size, every)
        light, blur = np.add.reduceat(light, starts), blur[starts + (np.diff(starts, append=blur.size) // 2)]
        distances = self.distances
        each = self.shares * (strength / math.pi**3 / distances**2)
        each = each[np.sum(np.abs(each), axis=1) * np.max(blur) ** 2 > allowed]
        if not each.size:
            return 0.0
        # No product of matrices: threads of BLAS would wait for more of them, busily.
        waves = np.einsum("w,wb->b", light * blur**2, np.exp(2j * math.pi / blur[:, None] * distances))
        beyond = np.abs(np.cumsum((each * waves)[:, ::-1], axis=1)[:, ::-1]).max(axis=0)
        over = np.flatnonzero(beyond > allowed)
        return float(distances[over[-1]]) if over.size else 0.0


@kernel()
def _see(start: F64, end: F64, jump: F64, place: tuple[float, float], longest: float, step: float, shares: F64) -> None:
    """Add the fraction of the circle about a place over which each edge's distance varies by less than half a wave."""
    for e in range(len(start)):
        x, y, ex, ey = start[e, 0] - place[0], start[e, 1] - place[1], end[e, 0] - start[e, 0], end[e, 1] - start[e, 1]
        length = math.sqrt(ex * ex + ey * ey)
        if length == 0.0:
            continue
        begin, aside = (x * ex + y * ey) / length, (x * ey - y * ex) / length
        apart = max(abs(aside), step)
        half = min(0.5 * math.sqrt(longest / apart), 1.5)
        slack = 1.2 * half * apart if half < 0.8 else math.inf
        if begin > slack or begin + length < -slack:
            continue
        low, between = begin / apart, apart * apart + begin * (begin + length)
        ratio = length * apart / between if between > 0.0 else math.inf
        low = low - low**3 / 3.0 if abs(low) < 0.02 else math.atan(low)
        short = 0.0 < ratio < 0.02  # the angle between the ends
        high = low + ratio - ratio**3 / 3.0 if short else math.atan((begin + length) / apart)
        low, high = min(max(low, -half), half), min(max(high, -half), half)
        light = math.copysign((high - low) / (2.0 * math.pi), aside) * jump[e]
        at = apart / math.cos(0.5 * (low + high)) / step
        if at < len(shares) - 1:
            first = int(at)
            shares[first] += light * (1.0 - at + first)
            shares[first + 1] += light * (at - first)


def _places(edges: Edges, jump: F64, grid: Grid) -> F64:
    """Return the frame's centre, and the centres of curvature in the frame of the strongest outlines: (n, 2)."""
    first = np.array(grid.first_centre)
    last = first + np.array([grid.cols - 1, grid.rows - 1])
    places = [0.5 * (first + last)]
    # A centre of curvature is where the perpendicular bisectors of two successive edges meet.
    following = np.arange(0, len(edges) - 1, 1 + len(edges) // MOST_PAIRS)
    following = following[(edges.end[following] == edges.start[following + 1]).all(axis=1)]
    a, b = edges.along[following], edges.along[following + 1]
    turn = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    onward = np.sum(a * b, axis=1)
    apart = 0.5 * (edges.length[following] + edges.length[following + 1] * onward)
    bent = np.flatnonzero((np.abs(turn) > 1e-6) & (np.abs(turn) < 0.5) & (onward > 0.0))
    a, apart, turn, following = a[bent], apart[bent], turn[bent], following[bent]
    radius = apart / turn
    middle = 0.5 * (edges.start[following] + edges.end[following])
    centre = middle + radius[:, None] * np.stack([-a[:, 1], a[:, 0]], axis=1)
    within = ((centre >= first - 1.0) & (centre <= last + 1.0)).all(axis=1)
    centre = centre[within]
    weight = np.abs(jump[following] * turn)[within] * np.sqrt(np.abs(radius[within]))
    column, row = np.round(centre - first + 0.2578125).astype(np.int64).T
    cells, which = np.unique(row * (1 << 32) + column, return_inverse=True)
    if len(cells):
        total = np.bincount(which, weight)
        means = np.stack([np.bincount(which, weight * one) for one in centre.T], axis=1) / total[:, None]
        places += list(means[np.argsort(-total, kind="stable")[:PLACES]])
    return np.array(places)
