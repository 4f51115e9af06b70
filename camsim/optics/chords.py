"""Nodes of a pupil along chords: strips between its corners and its obstruction's ends, a rule along and one across.

Chords run along a side of a polygon. What the wavefront takes besides waves is measured along lines of each strip.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64
from camsim.optics.follow import from_0, nodes_of, reached, spare_nodes
from camsim.optics.pupil import Pupil
from camsim.optics.rays import OverPupil, Turns, joined

NARROW = 1e-13  # a strip that is none: two corners at one level, but for rounding
ALONG = 65  # places on a strip's sides, between which they are taken to be straight
GROUPS = 8  # of a strip's chords, each with nodes for its longest
BENT_SPARE = 14  # of chords that end on a circle: with 6 1e-10 of the light was lost, with 10 2e-12
LINES = 17  # of a strip, along which the wavefront is looked at


class _End(NamedTuple):
    """Where chords end: y = offset + slope·x ± √(radius² − x²), the sign the radius's; no root where that is 0."""

    offset: float
    slope: float
    radius: float

    def at(self, x: F64) -> F64:
        """Return y."""
        root = np.sqrt(np.maximum((self.radius - x) * (self.radius + x), 0.0))
        return self.offset + self.slope * x + np.copysign(root, self.radius)


class _Strip(NamedTuple):
    """A part of an opening between two levels: chords along y, from one smooth line to another.

    low, high    : the levels, x
    lower, upper : where chords begin and end
    """

    low: float
    high: float
    lower: _End
    upper: _End

    @property
    def bent(self) -> bool:
        """Whether chords end on a circle."""
        return bool(self.lower.radius or self.upper.radius)

    def chords(self, u: F64) -> tuple[F64, F64, F64, F64]:
        """Return x, dx/du, and both ends of the chords at ``u``, 0 … 1.

        x goes as a cosine where an end is a circle's, which takes its square roots.
        """
        width = self.high - self.low
        if self.bent:
            x, slope = self.low + width * np.sin(0.5 * np.pi * u) ** 2, 0.5 * np.pi * width * np.sin(np.pi * u)
        else:
            x, slope = self.low + width * u, np.full_like(u, width)
        return x, slope, self.lower.at(x), self.upper.at(x)

    def nodes(self, levels: int, along: int, some: slice) -> F64:
        """Return x, y and weights (3, n) of some of so many chords with so many nodes on each of them."""
        u, share = (values[some] for values in from_0(levels))
        t, weights = from_0(along)
        x, slope, below, above = self.chords(u)
        length = above - below
        y = below[:, None] + length[:, None] * t
        own = np.multiply.outer(share * slope * length, weights)
        return np.stack([np.broadcast_to(x[:, None], y.shape), y, own]).reshape(3, -1)

    def halves(self, levels: int) -> tuple[int, int]:
        """Return how many of so many chords lie before 0, and how many do or go through it.

        Of two strips with a hole between them each is the other one's opposite, by a rule of its own: only one counts.
        """
        if self.low < -NARROW and self.high > NARROW:
            if self.upper.radius < 0.0:
                return levels, levels
            if self.lower.radius > 0.0:
                return 0, 0
        x = self.chords(from_0(levels)[0])[0]
        return int(np.searchsorted(x, -NARROW)), int(np.searchsorted(x, NARROW))

    def counts(self, turns: Turns, turn_rad: float, spares: tuple[int, int]) -> list[tuple[int, int]]:
        """Return for some chords after the others how many, and nodes on each, that waves take, and spares.

        Nodes are nearly even: they follow what a strip's side turns where it turns most.
        """
        u = np.linspace(0.0, 1.0, ALONG)
        x, _, below, above = self.chords(u)
        ways = [turns.along(*_turned(np.diff(x), np.diff(y), turn_rad)) for y in (below, above)]
        levels = nodes_of(float(np.max(ways)) * (ALONG - 1), spares[0] + (BENT_SPARE if self.bent else 0))
        each = turns.along(*_turned(np.zeros(1), np.ones(1), turn_rad)).item()
        ends = [round(levels * part / GROUPS) for part in range(GROUPS + 1)]
        found: list[tuple[int, int]] = []
        for first, stop in pairwise(ends):
            if first < stop:
                # Somewhere between these is the longest of them, or at an end.
                x, _, below, above = self.chords(np.linspace(reached(levels, first), reached(levels, stop), 9))
                along = nodes_of(each * float((above - below).max()), spares[1])
                if found and found[-1][1] == along:
                    found[-1] = found[-1][0] + stop - first, along
                else:
                    found.append((stop - first, along))
        return found


class Chords(NamedTuple):
    """A product rule over an opening's strips.

    strips : turned by ``turn_rad``
    spares : how many chords and nodes on them the wavefront takes in each, besides waves
    turns  : of the waves
    """

    strips: tuple[_Strip, ...]
    turn_rad: float
    spares: tuple[tuple[int, int], ...]
    turns: Turns

    @classmethod
    def of(cls, lens: OverPupil, wavelength_nm: float, turns: Turns) -> Chords:
        """Return the rule for a lens, and for waves: across a circle chords run as these turn less."""
        across = turns.most[0] < turns.most[1] and not len(lens.pupil.corners)
        return cls(*strips_of(lens.pupil, across), _spares(lens, wavelength_nm, across), turns)

    @property
    def total(self) -> float:
        """How many nodes there are."""
        return float(sum(chords * along for some in self._counts for chords, along in some))

    def parts(self, at_once: int, half: bool = False) -> Iterator[tuple[F64, F64, F64]]:
        """Yield x, y and weights, at most about ``at_once`` at a time; ``half``: of two opposite nodes only one."""
        yield from joined(self._parts(at_once, half), at_once)

    def _parts(self, at_once: int, half: bool) -> Iterator[tuple[F64, F64, F64]]:
        for strip, some in zip(self.strips, self._counts, strict=True):
            levels, begin = sum(chords for chords, _ in some), 0
            first_half, second = strip.halves(levels) if half else (levels, levels)
            for chords, along in some:
                most = max(at_once // along, 1)
                end = min(begin + chords, second)
                for first in range(begin, end, most):
                    stop = min(first + most, end)
                    x, y, weights = strip.nodes(levels, along, slice(first, stop))
                    if stop > first_half:  # the chord through the middle is its own opposite
                        weights[-along:] *= 0.5
                    yield *_turned(x, y, self.turn_rad), weights
                begin += chords

    @property
    def _counts(self) -> list[list[tuple[int, int]]]:
        each = zip(self.strips, self.spares, strict=True)
        return [strip.counts(self.turns, self.turn_rad, spares) for strip, spares in each]


@functools.lru_cache(maxsize=64)
def strips_of(pupil: Pupil, across: bool = False) -> tuple[tuple[_Strip, ...], float]:
    """Return an opening as strips, and the angle by which these are turned.

    Chords run along a polygon's first side, and of a circle along y or, ``across``, along x.
    """
    corners, hole = pupil.corners, pupil.obstruction
    turn_rad, levels = 0.5 * math.pi if across else 0.0, [-1.0, 1.0]
    if len(corners):
        along_x, along_y = corners[1] - corners[0]
        turn_rad = math.atan2(-along_x, along_y)
        corners = np.stack(_turned(corners[:, 0], corners[:, 1], -turn_rad), axis=1)
        levels = corners[:, 0].tolist()
    strips: list[_Strip] = []
    for low, high in pairwise(sorted([*levels, *((-hole, hole) if hole else ())])):
        middle = 0.5 * (low + high)
        if high - low <= NARROW:
            continue
        lower, upper = _sides(corners, middle) if len(corners) else (_End(0.0, 0.0, -1.0), _End(0.0, 0.0, 1.0))
        if abs(middle) < hole:
            strips.append(_Strip(low, high, lower, _End(0.0, 0.0, -hole)))
            strips.append(_Strip(low, high, _End(0.0, 0.0, hole), upper))
        else:
            strips.append(_Strip(low, high, lower, upper))
    return tuple(strips), turn_rad


def _turned(x: F64, y: F64, angle_rad: float) -> tuple[F64, F64]:
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return x * cos - y * sin, x * sin + y * cos


def _sides(corners: F64, x: float) -> tuple[_End, _End]:
    """Return the two sides of a convex outline that are met at a level."""
    met: list[tuple[float, _End]] = []
    for (px, py), (qx, qy) in zip(corners.tolist(), np.roll(corners, -1, axis=0).tolist(), strict=True):
        if min(px, qx) < x < max(px, qx):
            slope = (qy - py) / (qx - px)
            met.append((py + slope * (x - px), _End(py - slope * px, slope, 0.0)))
    lower, upper = sorted(met)
    return lower[1], upper[1]


@functools.lru_cache(maxsize=256)
def _spares(lens: OverPupil, wavelength_nm: float, across: bool) -> tuple[tuple[int, int], ...]:
    """Return how many chords and nodes on them the wavefront takes besides a wave, in each strip.

    As many as change no integral along lines of a strip: of its chords, and of what goes from chord to chord.
    """
    strips, turn_rad = strips_of(lens.pupil, across)
    place = np.linspace(0.0, 1.0, LINES)[:, None]

    def waves(u: F64, t: F64) -> F64:
        every = [strip.chords(u) for strip in strips]
        each = [np.broadcast_arrays(x, below + (above - below) * t) for x, _, below, above in every]
        x, y = (np.stack(some) for some in zip(*each, strict=True))
        return lens.waves(*_turned(x, y, turn_rad), wavelength_nm)

    levels = spare_nodes(lambda u: waves(u, place), wavelength_nm, "a chord")
    along = spare_nodes(lambda t: waves(place, t), wavelength_nm, "a chord")
    return tuple(zip(levels, along, strict=True))
