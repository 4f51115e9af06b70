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
from camsim.optics.rays import ROUNDING, OverPupil
from camsim.quadrature import gauss_legendre

NARROW = 1e-13  # a strip that is none: two corners at one level, but for rounding
ALONG = 65  # places on a strip's sides, between which they are taken to be straight
PER_TURN = 0.265  # nodes for a radian that a wave turns along a strip's side: a quarter, and a little
SPARE, GROWTH, MOST_SPARE = 26, 1.3, 8000
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

    def chords(self, u: F64) -> tuple[F64, F64, F64, F64]:
        """Return x, dx/du, and both ends of the chords at ``u``, 0 … 1.

        x goes as a cosine where an end is a circle's, which takes its square roots.
        """
        width = self.high - self.low
        if self.lower.radius or self.upper.radius:
            x, slope = self.low + width * np.sin(0.5 * np.pi * u) ** 2, 0.5 * np.pi * width * np.sin(np.pi * u)
        else:
            x, slope = self.low + width * u, np.full_like(u, width)
        return x, slope, self.lower.at(x), self.upper.at(x)

    def nodes(self, levels: int, along: int, some: slice) -> F64:
        """Return x, y and weights (3, n) of some of so many chords with so many nodes on each."""
        u, share = (values[some] for values in _from_0(levels))
        t, weights = _from_0(along)
        x, slope, below, above = self.chords(u)
        length = above - below
        y = below[:, None] + length[:, None] * t
        own = np.multiply.outer(share * slope * length, weights)
        return np.stack([np.broadcast_to(x[:, None], y.shape), y, own]).reshape(3, -1)

    def counts(self, turns_rad: float, spares: tuple[int, int]) -> tuple[int, int]:
        """Return how many chords, and nodes on each, a wave takes, ``turns_rad`` on a length of 1, and spares.

        A Gauss rule of n nodes is exact to degree 2n − 1, and a wave that turns by κ on all of it is a polynomial of
        degree κ/2 and some more.
        """
        x, _, below, above = self.chords(np.linspace(0.0, 1.0, ALONG))
        ways = [np.hypot(np.diff(x), np.diff(y)).max() * (ALONG - 1) for y in (below, above)]
        longest = float((above - below).max())
        levels, along = (math.ceil(PER_TURN * turns_rad * way) for way in (max(ways), longest))
        return levels + spares[0], along + spares[1]


class Chords(NamedTuple):
    """A product rule over an opening's strips.

    strips : turned by ``turn_rad``
    spares : how many chords and nodes on them the wavefront takes in each, besides a wave
    """

    strips: tuple[_Strip, ...]
    turn_rad: float
    spares: tuple[tuple[int, int], ...]

    @classmethod
    def of(cls, lens: OverPupil, wavelength_nm: float) -> Chords:
        """Return the rule for a lens."""
        return cls(*strips_of(lens.pupil), _spares(lens, wavelength_nm))

    def total(self, turns_rad: float) -> float:
        """Return how many nodes a wave takes that turns by ``turns_rad`` on a length of 1."""
        return float(sum(math.prod(sizes) for sizes in self._sizes(turns_rad)))

    def parts(self, turns_rad: float, at_once: int) -> Iterator[tuple[F64, F64, F64]]:
        """Yield x, y and weights for it, at most about ``at_once`` nodes at a time."""
        held: list[F64] = []
        count = 0
        for strip, (levels, along) in zip(self.strips, self._sizes(turns_rad), strict=True):
            chords = max(at_once // along, 1)
            for first in range(0, levels, chords):
                if held and count + min(chords, levels - first) * along > at_once:
                    yield self._joined(held)
                    held, count = [], 0
                held.append(strip.nodes(levels, along, slice(first, first + chords)))
                count += held[-1].shape[1]
        yield self._joined(held)

    def _sizes(self, turns_rad: float) -> list[tuple[int, int]]:
        return [strip.counts(turns_rad, spares) for strip, spares in zip(self.strips, self.spares, strict=True)]

    def _joined(self, parts: list[F64]) -> tuple[F64, F64, F64]:
        x, y, weights = np.concatenate(parts, axis=1)
        return *_turned(x, y, self.turn_rad), weights


@functools.lru_cache(maxsize=64)
def strips_of(pupil: Pupil) -> tuple[tuple[_Strip, ...], float]:
    """Return an opening as strips, and the angle by which these are turned: chords run along a polygon's first side."""
    corners, hole = pupil.corners, pupil.obstruction
    turn_rad, levels = 0.0, [-1.0, 1.0]
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


def _from_0(order: int) -> tuple[F64, F64]:
    """Return nodes on 0 … 1 and weights of a Gauss rule."""
    nodes, weights = gauss_legendre(order)
    return 0.5 * (1.0 + nodes), 0.5 * weights


@functools.lru_cache(maxsize=256)
def _spares(lens: OverPupil, wavelength_nm: float) -> tuple[tuple[int, int], ...]:
    """Return how many chords and nodes on them the wavefront takes besides a wave, in each strip.

    As many as change no integral along lines of a strip: of its chords, and of what goes from chord to chord.
    """
    place = np.linspace(0.0, 1.0, LINES)[:, None]
    strips, turn_rad = strips_of(lens.pupil)

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
