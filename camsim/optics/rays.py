"""Nodes of a pupil along rays from its middle: Gauss rules by radius and along sides, even steps round a circle."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Iterator
from itertools import pairwise
from typing import NamedTuple, Protocol

import numpy as np
import scipy

from camsim.arrays import F64
from camsim.errors import UnsupportedError
from camsim.optics.pupil import Pupil

NOTHING = 1e-14  # a coefficient of the phase factor that rounding hides
ROUNDING = 2.0**-52  # of a phase, relative: a tenth of that was seen in the coefficients
RAYS = 24  # on every side of the outline, along which the wavefront's degree is looked for
RINGS = 16  # groups, each of as many nodes round as its outermost takes: 1.9 times fewer than if all did
MOST_POINTS = 1 << 13  # along a ray


class OverPupil(Protocol):
    """A lens of one opening, and the path difference over it."""

    @property
    def pupil(self) -> Pupil: ...  # noqa: D102

    def __hash__(self) -> int: ...

    def waves(self, x: F64, y: F64, wavelength_nm: float) -> F64: ...  # noqa: D102


class Turns(NamedTuple):
    """By how much waves turn on half of the diameter along x and along y, radians: all of a rectangle's.

    x, y : of its corners, from its middle;  middle: what the wave in its middle turns, along x and along y
    """

    x: float
    y: float
    middle: tuple[float, float] = (0.0, 0.0)

    def along(self, x: F64, y: F64) -> F64:
        """Return how much any of them turns at most on the way (x, y)."""
        most: F64 = np.abs(self.middle[0] * x + self.middle[1] * y) + self.x * np.abs(x) + self.y * np.abs(y)
        return most

    @property
    def most(self) -> tuple[float, float]:
        """What any of them turns at most along x, and along y."""
        return abs(self.middle[0]) + self.x, abs(self.middle[1]) + self.y

    @property
    def largest(self) -> float:
        """What any of them turns on half of the diameter in any direction."""
        return math.hypot(*self.most)


class Rays(NamedTuple):
    """A polar rule over an opening: rings of an even number of nodes, or of a number for each side.

    along, round_about : degrees of the wavefront's phase factor along a radius, and along a side or round a circle
    turns : of the waves besides
    """

    pupil: Pupil
    along: int
    round_about: int
    turns: Turns

    @classmethod
    def of(cls, lens: OverPupil, wavelength_nm: float, turns: Turns) -> Rays:
        """Return the rule for a lens, and for waves."""
        return cls(lens.pupil, *_degrees(lens, wavelength_nm), turns)

    @property
    def total(self) -> float:
        """How many nodes there are."""
        return float(sum((rings.stop - rings.start) * sum(sides) for rings, sides in self._groups))

    def parts(self, at_once: int, half: bool = False) -> Iterator[tuple[F64, F64, F64]]:
        """Yield x, y and weights, about ``at_once`` nodes at a time; ``half``: of two that are opposite only one."""

        def each() -> Iterator[tuple[F64, F64, F64]]:
            for rings, sides in self._groups:
                most = max(at_once // sum(sides), 1)
                for first in range(rings.start, rings.stop, most):
                    yield self.pupil.rule(self._radial, sides, slice(first, min(first + most, rings.stop)), half=half)

        yield from joined(each(), at_once)

    @property
    def _radial(self) -> int:
        """Nodes along a radius.

        A Gauss rule of n nodes is exact to degree 2n − 1. A wave of phase κt on −1 … 1 is a polynomial of degree κ and
        some twenty more; of the wavefront's own phase factor the degrees are looked up (``_degrees``).
        """
        pupil, turns = self.pupil, self.turns
        farthest = float(turns.along(*pupil.corners.T).max()) if pupil.sides > 1 else turns.largest
        open_part = 1.0 - pupil.obstruction / pupil.outer_radius
        return in_steps(0.27 * farthest * open_part + 0.5 * self.along + 24.0)

    @property
    def _groups(self) -> list[tuple[slice, list[int]]]:
        """Rings from the inside out, and how many nodes each has on each side: as its group's outermost takes."""
        pupil, turns, radial = self.pupil, self.turns, self._radial
        inner, groups = pupil.obstruction, []
        ends = sorted({round(radial * part / RINGS) for part in range(RINGS + 1)})
        ways = np.roll(pupil.corners, -1, axis=0) - pupil.corners
        of_sides = [float(turns.along(dx, dy) / math.hypot(dx, dy)) for dx, dy in ways]
        for first, stop in pairwise(ends):
            share = 0.5 - 0.5 * math.cos(math.pi * stop / radial)  # of the way from the obstruction, or a little less
            hole = (1.0 - share) * inner * turns.largest
            if pupil.sides == 1:
                sides = [2 * math.ceil(0.53 * (share * turns.largest + hole) + 32.0 + 0.5 * self.round_about)]
            else:
                # A ring is so much of its outline, and the rest a circle.
                per_turn = share * pupil.side_share * pupil.outer_radius
                speeds = [per_turn * turn + hole * math.pi / pupil.sides for turn in of_sides]
                sides = [in_steps(0.55 * speed + 0.5 * self.round_about + 30.0) for speed in speeds]
            groups.append((slice(first, stop), sides))
        return groups


def joined(parts: Iterable[tuple[F64, F64, F64]], at_once: int) -> Iterator[tuple[F64, F64, F64]]:
    """Yield x, y and weights of parts in a row together, about ``at_once`` nodes at a time.

    Each that is yielded takes a transform of its own where the lattice is small.
    """
    held: list[tuple[F64, F64, F64]] = []
    count = 0
    for part in parts:
        if held and count + part[0].size > at_once:
            joint, held, count = [_together(held)], [], 0
            yield joint.pop()  # and nothing is kept of it
        held.append(part)
        count += part[0].size
    if held:
        yield _together(held)


def _together(parts: list[tuple[F64, F64, F64]]) -> tuple[F64, F64, F64]:
    x, y, weights = (np.concatenate(each) for each in zip(*parts, strict=True))
    return x, y, weights


def in_steps(least: float) -> int:
    """Return a number of nodes, a hundredth larger at most: rules for the next wavelength are often the same ones."""
    step = max(1, int(least) >> 7)
    return step * math.ceil(least / step)


@functools.lru_cache(maxsize=256)
def _degrees(lens: OverPupil, wavelength_nm: float) -> tuple[int, int]:
    """Return the degrees of exp(2πiW) along a radius and along a side of the outline (round it: its harmonics).

    They are read off its Chebyshev (Fourier) coefficients, on as many points as it takes for these to end. A bound
    by the steepest slope would be blind or absurd: beyond the circle of the coefficients, in the corners of a
    square, a polynomial of order n is up to 2^(n/2) times as steep as on its rim, but there only.
    """
    inner = lens.pupil.obstruction
    shares = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
    round_rim = lens.pupil.sides == 1
    points = 64
    while points <= MOST_POINTS:
        cheb = 0.5 * (1.0 + np.cos(np.pi * (np.arange(points) + 0.5) / points))
        angle, edge = (a[..., None] for a in lens.pupil.rays(np.arange(RAYS) / RAYS))
        radius = inner + cheb * (edge - inner)
        waves = lens.waves(radius * np.cos(angle), radius * np.sin(angle), wavelength_nm)
        # The corners of a square are 2^(n/2) times as far off as its rim: what 1000 radians are rounded to shows.
        hidden = max(NOTHING, 2.0 * math.pi * ROUNDING * float(np.abs(waves).max()))
        along = _degree(np.abs(scipy.fft.dct(np.exp(2j * np.pi * waves), axis=-1)) / points, hidden)
        angle, edge = lens.pupil.rays(np.arange(points) / points if round_rim else cheb)
        rim = inner + shares[:, None, None] * (edge - inner)
        factor = np.exp(2j * np.pi * lens.waves(rim * np.cos(angle), rim * np.sin(angle), wavelength_nm))
        if round_rim:
            spectrum = np.abs(scipy.fft.fft(factor, axis=-1)) / points
            half = points // 2
            round_about = _degree(np.maximum(spectrum[..., :half], spectrum[..., ::-1][..., :half]), hidden)
        else:
            round_about = _degree(np.abs(scipy.fft.dct(factor, axis=-1)) / points, hidden)
        if along is not None and round_about is not None:
            return along, round_about
        points *= 2
    raise UnsupportedError(
        f"the wavefront has too many waves at {wavelength_nm:g} nm to be sampled along a radius "
        f"({MOST_POINTS} points do not follow it); give smaller coefficients",
        key="zernike_waves",
    )


def _degree(coefficients: F64, hidden: float) -> int | None:
    """Return the largest degree above ``hidden`` of (..., n) coefficients, None where the last quarter still is."""
    largest = coefficients.reshape(-1, coefficients.shape[-1]).max(axis=0)
    matter = np.flatnonzero(largest > hidden)
    degree = int(matter[-1]) if matter.size else 0
    return degree if degree < 0.75 * largest.size else None
