"""A lens of one pupil as the check knows it: its amplitude summed along chords of the opening.

The engines sum over rays from the middle, with as many nodes as a formula and the wavefront's own harmonics ask for.
Here the opening is cut into strips at its corners and at its obstruction's ends, each strip into chords; every chord
has a Gauss rule, and so has what goes from chord to chord. How many nodes the wavefront takes is not worked out: more
are taken until integrals along lines of a strip stay the same.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import ClassVar, NamedTuple

import numpy as np

from camsim.arrays import C128, F64
from camsim.nonuniform import modes
from camsim.optics.difference import Difference, Split
from camsim.optics.of_pupil import OfPupil
from camsim.optics.protocols import OpticalStage, Splits
from camsim.optics.pupil import Pupil
from camsim.quadrature import gauss_legendre

NARROW = 1e-13  # a strip that is none: two corners at one level, but for rounding
ALONG = 65  # places on a strip's sides, between which they are taken to be straight
PER_TURN = 0.265  # nodes for a radian that a wave turns along a strip's side: a quarter, and a little
SPARE, GROWTH, MOST_SPARE = 26, 1.3, 4000
LINES, HEARD, SETTLED = 9, 6.0, 1e-12  # of a strip, along which integrals times a wave of so many radians settle
AT_ONCE = 2_800_000  # nodes: 200 MB


class End(NamedTuple):
    """Where chords end: y = offset + slope·x ± √(radius² − x²), the sign the radius's; no root where that is 0."""

    offset: float
    slope: float
    radius: float

    def at(self, x: F64) -> F64:
        """Return y."""
        root = np.sqrt(np.maximum((self.radius - x) * (self.radius + x), 0.0))
        return self.offset + self.slope * x + np.copysign(root, self.radius)


class Strip(NamedTuple):
    """A part of an opening between two levels: chords along y, from one smooth line to another.

    low, high    : the levels, x
    lower, upper : where chords begin and end
    """

    low: float
    high: float
    lower: End
    upper: End

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

    def counts(self, turns: float, spares: tuple[int, int]) -> tuple[int, int]:
        """Return how many chords, and nodes on each, waves take that turn by ``turns`` on a length of 1, and spares.

        A Gauss rule of n nodes is exact to degree 2n − 1, and a wave that turns by κ on all of it is a polynomial of
        degree κ/2 and some more.
        """
        x, _, below, above = self.chords(np.linspace(0.0, 1.0, ALONG))
        ways = [np.hypot(np.diff(x), np.diff(y)).max() * (ALONG - 1) for y in (below, above)]
        longest = float((above - below).max())
        return math.ceil(PER_TURN * turns * max(ways)) + spares[0], math.ceil(PER_TURN * turns * longest) + spares[1]


@dataclass(frozen=True, kw_only=True)
class Chorded(OfPupil):
    """A lens whose pattern is summed along chords."""

    place: ClassVar[str] = "lens"

    lens: OfPupil
    f_number: float
    pupil: Pupil

    @classmethod
    def of(cls, lens: OfPupil) -> Chorded:
        """Return a lens's."""
        return cls(lens=lens, f_number=lens.f_number, pupil=lens.pupil)

    def waves(self, x: F64, y: F64, wavelength_nm: float) -> F64:
        """As the lens's."""
        return self.lens.waves(x, y, wavelength_nm)

    @property
    def _symmetric(self) -> bool:
        return self.lens._symmetric

    def split(self) -> Split | None:
        """Return the lens's parts, of which the difference is summed along chords."""
        parts: Split | None = self.lens.split() if isinstance(self.lens, Splits) else None
        return parts if parts is None or parts.rest is None else parts._replace(rest=_of_difference(parts.rest))

    def point_spread_on(self, x_um: F64, y_um: F64, wavelength_nm: float, precision: float) -> F64:
        """Irradiance (y, x) per µm² from a point of unit power, on a lattice of even steps."""
        per_um = math.pi / self.blur_um(wavelength_nm)  # radians of phase from the pupil's middle to 1
        lattice = [(axis[axis.size // 2], axis[-1] - axis[-2] if axis.size > 1 else 0.0) for axis in (x_um, y_um)]
        turns = per_um * math.hypot(max(abs(x_um[0]), abs(x_um[-1])), max(abs(y_um[0]), abs(y_um[-1])))
        middle = -0.5 * per_um / math.pi * lattice[0][0], -0.5 * per_um / math.pi * lattice[1][0]  # waves to it
        amplitude = np.zeros((y_um.size, x_um.size), complex)
        for x, y, weights in self._nodes(turns, wavelength_nm):
            strengths = self._phase_factor(x, y, wavelength_nm, middle)
            strengths *= weights
            steps = per_um * lattice[1][1] * y, per_um * lattice[0][1] * x
            amplitude += modes(steps, strengths, amplitude.shape, precision=max(precision, 1e-14), sign=-1)
        light: F64 = amplitude.real**2 + amplitude.imag**2
        light *= (0.5 / self.blur_um(wavelength_nm)) ** 2 / self.pupil.area
        return light

    def pupil_nodes(self, wavelength_nm: float) -> Callable[[float], float]:
        """Return what tells how many nodes the pattern takes out to a distance in µm."""
        per_um = math.pi / self.blur_um(wavelength_nm)
        each = tuple(zip(strips_of(self.pupil)[0], _spares(self, wavelength_nm), strict=True))
        return lambda reach_um: float(sum(math.prod(strip.counts(per_um * reach_um, spares)) for strip, spares in each))

    def _nodes(self, turns: float, wavelength_nm: float) -> Iterator[F64]:
        """Yield x, y and weights (3, n), many at a time, for waves that turn by ``turns`` from the middle to 1."""
        held: list[F64] = []
        for part in self._parts(turns, wavelength_nm):
            if held and sum(one.shape[1] for one in held) + part.shape[1] > AT_ONCE:
                yield np.concatenate(held, axis=1)
                held = []
            held.append(part)
        yield np.concatenate(held, axis=1)

    def _parts(self, turns: float, wavelength_nm: float) -> Iterator[F64]:
        strips, turn_rad = strips_of(self.pupil)
        for strip, spares in zip(strips, _spares(self, wavelength_nm), strict=True):
            levels, along = strip.counts(turns, spares)
            u, share = _from_0(levels)
            t, weights = _from_0(along)
            x, slope, below, above = strip.chords(u)
            for first in range(0, levels, max(AT_ONCE // along, 1)):
                some = slice(first, first + max(AT_ONCE // along, 1))
                length = above[some] - below[some]
                y = below[some, None] + length[:, None] * t
                own = np.multiply.outer(share[some] * slope[some] * length, weights)
                yield np.stack([*_turned(x[some, None], y, turn_rad), own]).reshape(3, -1)


def by_chords(lens: OpticalStage) -> OpticalStage:
    """Return a lens with its pattern summed along chords, where it is summed over a pupil; any other as it is."""
    if isinstance(lens, OfPupil):
        return Chorded.of(lens)
    return _of_difference(lens) if isinstance(lens, Difference) else lens


def _of_difference(rest: Difference) -> Difference:
    return replace(rest, lens=Chorded.of(rest.lens)) if isinstance(rest.lens, OfPupil) else rest


@functools.lru_cache(maxsize=64)
def strips_of(pupil: Pupil) -> tuple[tuple[Strip, ...], float]:
    """Return an opening as strips, and the angle by which these are turned: chords run along a polygon's first side."""
    corners, hole = pupil.corners, pupil.obstruction
    turn_rad, levels = 0.0, [-1.0, 1.0]
    if len(corners):
        along_x, along_y = corners[1] - corners[0]
        turn_rad = math.atan2(-along_x, along_y)
        corners = np.stack(_turned(corners[:, 0], corners[:, 1], -turn_rad), axis=1)
        levels = corners[:, 0].tolist()
    strips: list[Strip] = []
    for low, high in pairwise(sorted([*levels, *((-hole, hole) if hole else ())])):
        middle = 0.5 * (low + high)
        if high - low <= NARROW:
            continue
        lower, upper = _sides(corners, middle) if len(corners) else (End(0.0, 0.0, -1.0), End(0.0, 0.0, 1.0))
        if abs(middle) < hole:
            strips.append(Strip(low, high, lower, End(0.0, 0.0, -hole)))
            strips.append(Strip(low, high, End(0.0, 0.0, hole), upper))
        else:
            strips.append(Strip(low, high, lower, upper))
    return tuple(strips), turn_rad


def _turned(x: F64, y: F64, angle_rad: float) -> tuple[F64, F64]:
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return x * cos - y * sin, x * sin + y * cos


def _sides(corners: F64, x: float) -> tuple[End, End]:
    """Return the two sides of a convex outline that are met at a level."""
    met: list[tuple[float, End]] = []
    for (px, py), (qx, qy) in zip(corners.tolist(), np.roll(corners, -1, axis=0).tolist(), strict=True):
        if min(px, qx) < x < max(px, qx):
            slope = (qy - py) / (qx - px)
            met.append((py + slope * (x - px), End(py - slope * px, slope, 0.0)))
    lower, upper = sorted(met)
    return lower[1], upper[1]


def _from_0(order: int) -> tuple[F64, F64]:
    """Return nodes on 0 … 1 and weights of a Gauss rule."""
    nodes, weights = gauss_legendre(order)
    return 0.5 * (1.0 + nodes), 0.5 * weights


@functools.lru_cache(maxsize=256)
def _spares(lens: Chorded, wavelength_nm: float) -> tuple[tuple[int, int], ...]:
    """Return how many chords and nodes on them the wavefront takes besides a wave, in each strip.

    As many as change no integral along lines of a strip: of its chords, and of what goes from chord to chord.
    """
    place = np.linspace(0.0, 1.0, LINES)[:, None]

    def settled(factor: Callable[[F64], C128]) -> int:
        spare, before = SPARE, np.full(LINES, math.inf, complex)
        while True:
            t, weights = _from_0(spare)
            found = np.sum(factor(t) * (weights * np.exp(HEARD * t * 1j)), axis=1)
            if np.abs(found - before).max() <= SETTLED or spare > MOST_SPARE:
                return spare
            spare, before = math.ceil(GROWTH * spare), found

    def factor(strip: Strip, u: F64, t: F64) -> C128:
        x, _, below, above = strip.chords(u)
        x, y = _turned(x, below + (above - below) * t, turn_rad)
        factors: C128 = np.exp(2j * np.pi * lens.waves(x, y, wavelength_nm))
        return factors

    each: list[tuple[int, int]] = []
    strips, turn_rad = strips_of(lens.pupil)
    for strip in strips:
        across, along = functools.partial(factor, strip, t=place), functools.partial(factor, strip, place)
        each.append((settled(across), settled(along)))
    return tuple(each)
