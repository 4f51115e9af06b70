"""Nodes of a pupil along rays from its middle: Gauss rules by radius and along sides, even steps round a circle."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from typing import NamedTuple, Protocol

import numpy as np
import scipy

from camsim.arrays import F64
from camsim.errors import UnsupportedError
from camsim.optics.pupil import Pupil

NOTHING = 1e-14  # a coefficient of the phase factor that rounding hides
ROUNDING = 2.0**-52  # of a phase, relative: a tenth of that was seen in the coefficients
RAYS = 24  # on every side of the outline, along which the wavefront's degree is looked for
MOST_POINTS = 1 << 13  # along a ray


class OverPupil(Protocol):
    """A lens of one opening, and the path difference over it."""

    @property
    def pupil(self) -> Pupil: ...  # noqa: D102

    def __hash__(self) -> int: ...

    def waves(self, x: F64, y: F64, wavelength_nm: float) -> F64: ...  # noqa: D102


class Rays(NamedTuple):
    """A polar product rule over an opening.

    along, round_about : degrees of the wavefront's phase factor along a radius, and along a side or round a circle
    """

    pupil: Pupil
    along: int
    round_about: int

    @classmethod
    def of(cls, lens: OverPupil, wavelength_nm: float) -> Rays:
        """Return the rule for a lens."""
        return cls(lens.pupil, *_degrees(lens, wavelength_nm))

    def total(self, turns_rad: float) -> float:
        """Return how many nodes a wave takes that turns by ``turns_rad`` on a length of 1."""
        radial, angular = self._orders(turns_rad)
        return float(radial * angular * self.pupil.sides)

    def parts(self, turns_rad: float, at_once: int) -> Iterator[tuple[F64, F64, F64]]:
        """Yield x, y and weights for it, about ``at_once`` nodes at a time."""
        radial, angular = self._orders(turns_rad)
        rings = math.ceil(radial / math.ceil(self.total(turns_rad) / at_once))
        for first in range(0, radial, rings):
            yield self.pupil.rule(radial, angular, slice(first, first + rings))

    def _orders(self, turns_rad: float) -> tuple[int, int]:
        """Return nodes along a radius, and along a side or round a circle.

        A Gauss rule of n nodes is exact to degree 2n − 1. A wave of phase κt on −1 … 1 is a polynomial of degree κ and
        some twenty more; of the wavefront's own phase factor the degrees are looked up (``_degrees``).
        """
        turns_rad *= self.pupil.outer_radius
        radial = math.ceil(0.27 * turns_rad + 0.5 * self.along) + 24
        if self.pupil.sides > 1:
            return radial, math.ceil(0.54 * self.pupil.side_share * turns_rad + 0.5 * self.round_about) + 24
        return radial, math.ceil(1.06 * turns_rad + 64.0) + self.round_about


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
