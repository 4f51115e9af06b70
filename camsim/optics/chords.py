"""Nodes of a pupil along chords: strips between its corners and its obstruction's ends, Gauss rules along and across.

Chords run along a side of a polygon. How many nodes the wavefront takes is not worked out: more are taken until
integrals along lines of a strip stay the same.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64
from camsim.errors import UnsupportedError
from camsim.optics.pupil import Pupil
from camsim.optics.rays import ROUNDING, OverPupil, Turns, in_steps, joined
from camsim.quadrature import gauss_legendre

NARROW = 1e-13  # a strip that is none: two corners at one level, but for rounding
ALONG = 65  # places on a strip's sides, between which they are taken to be straight
PER_TURN = 0.265  # nodes for a radian that a wave turns along a strip's side: a quarter, and a little
CLOSER = 0.1  # of a rule's nodes in the middle, less of which are nowhere counted upon
GROUPS = 8  # of a strip's chords, each with nodes for its longest
SPARE, GROWTH, MOST_SPARE = 26, 1.3, 8000
BENT_SPARE = 6  # of chords that end on a circle: without them 4e-11 of the light were lost
LINES, HEARD, SETTLED = 9, 6.0, 1e-12  # of a strip, along which integrals times a wave of so many radians settle


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
        u, share = (values[some] for values in _from_0(levels))
        t, weights = _from_0(along)
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
        x = self.chords(_from_0(levels)[0])[0]
        return int(np.searchsorted(x, -NARROW)), int(np.searchsorted(x, NARROW))

    def counts(self, turns: Turns, turn_rad: float, spares: tuple[int, int]) -> list[tuple[int, int]]:
        """Return for some chords after the others how many, and nodes on each, that waves take, and spares.

        A Gauss rule of n nodes is exact to degree 2n − 1, and a wave that turns by κ on all of it is a polynomial of
        degree κ/2 and some more. Its nodes lie as 1/√(u − u²), two of them on each turn of what turns evenly: where
        the strip's sides turn a wave more towards their ends, they are closer there.
        """
        u = np.linspace(0.0, 1.0, ALONG)
        x, _, below, above = self.chords(u)
        middle = 0.5 * (u[1:] + u[:-1])
        closer = np.minimum(2.0 * np.sqrt(middle * (1.0 - middle)) + CLOSER, 1.0)
        ways = [turns.along(*_turned(np.diff(x), np.diff(y), turn_rad)) * closer for y in (below, above)]
        levels = in_steps(PER_TURN * float(np.max(ways)) * (ALONG - 1) + spares[0] + (BENT_SPARE if self.bent else 0))
        each = PER_TURN * turns.along(*_turned(np.zeros(1), np.ones(1), turn_rad)).item()
        ends = [round(levels * part / GROUPS) for part in range(GROUPS + 1)]
        found: list[tuple[int, int]] = []
        for first, stop in pairwise(ends):
            if first < stop:
                # Somewhere between these is the longest of them, or at an end.
                x, _, below, above = self.chords(np.linspace(*_reach(first, stop, levels), 9))
                along = in_steps(each * float((above - below).max()) + spares[1])
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


def _reach(first: int, stop: int, levels: int) -> tuple[float, float]:
    """Return where on 0 … 1 some of a Gauss rule's nodes begin and end, or a little farther."""
    begin, end = (0.5 - 0.5 * math.cos(math.pi * place / levels) for place in (first, stop))
    return begin, end


def _from_0(order: int) -> tuple[F64, F64]:
    """Return nodes on 0 … 1 and weights of a Gauss rule."""
    nodes, weights = gauss_legendre(order)
    return 0.5 * (1.0 + nodes), 0.5 * weights


@functools.lru_cache(maxsize=256)
def _spares(lens: OverPupil, wavelength_nm: float, across: bool) -> tuple[tuple[int, int], ...]:
    """Return how many chords and nodes on them the wavefront takes besides a wave, in each strip.

    As many as change no integral along lines of a strip: of its chords, and of what goes from chord to chord.
    """
    place = np.linspace(0.0, 1.0, LINES)[:, None]
    strips, turn_rad = strips_of(lens.pupil, across)

    def waves(strip: _Strip, u: F64, t: F64) -> F64:
        x, _, below, above = strip.chords(u)
        return lens.waves(*_turned(x, below + (above - below) * t, turn_rad), wavelength_nm)

    def settled(waves: Callable[[F64], F64]) -> int:
        spare, before = SPARE, np.full(LINES, math.inf, complex)
        while spare <= MOST_SPARE:
            t, weights = _from_0(spare)
            phase = 2.0 * np.pi * waves(t)
            found = np.sum(weights * np.exp(1j * (phase + HEARD * t)), axis=1)
            # The corners of a square are 2^(n/2) times as far off as its rim: what 1000 radians are rounded to shows.
            if np.abs(found - before).max() <= max(SETTLED, ROUNDING * float(np.abs(phase).max())):
                return spare
            spare, before = math.ceil(GROWTH * spare), found
        raise UnsupportedError(
            f"the wavefront has too many waves at {wavelength_nm:g} nm to be sampled along a chord of the pupil "
            f"({MOST_SPARE} points do not follow it); give smaller coefficients",
            key="zernike_waves",
        )

    return tuple(
        (settled(functools.partial(waves, strip, t=place)), settled(functools.partial(waves, strip, place)))
        for strip in strips
    )
