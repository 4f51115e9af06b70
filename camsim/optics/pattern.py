"""The pattern of a rotationally symmetric lens for the boundary engine, as functions of ρ = r/blur alone.

``blur`` is the scale of the PSF, one number per wavelength: λN of a diffraction pattern, σ of a Gaussian.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from camsim.core.arrays import F64
from camsim.numerics.quadrature import gauss_legendre

MOMENT_NODES = 60  # for bounds, in which a per cent does not matter


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pattern:
    """One pattern; lengths in blurs, frequencies in cycles per blur.

    energy  : E(ρ), the encircled energy
    otf     : transfer at u
    breaks  : where the transfer is not smooth, in increasing order; it is 0 (or below 1e-16) past the last
    powers  : c1, c3, c5 of 1 − E = Σ c_k/ρ^k + oscillatory terms
    rings   : (u, a, n): the far form of an edge's end at distance R has ringing of frequency u, at most a·R⁻ⁿ
    signed  : the PSF has negative values, as for a measured or invented transfer
    quiet   : function of an error: ρ from which the smooth powers leave no more than it
    finest  : the smallest tolerance
    """

    energy: Callable[[F64], F64]
    otf: Callable[[F64], F64]
    breaks: tuple[float, ...]
    powers: tuple[float, float, float]
    rings: tuple[tuple[float, float, float], ...]
    signed: bool
    quiet: Callable[[float], float]
    finest: float

    def beyond(self, rho: F64) -> F64:
        """Return a bound of the light beyond ρ; for a signed pattern, its largest absolute value from ρ to some way on.

        For a signed pattern it bounds the light along a ray that enters and leaves an outline once.
        """
        if not self.signed:
            return 1.0 - self.energy(rho)
        farther = rho[:, None] * np.linspace(1.0, 1.5, 33)
        light: F64 = 2.0 * np.abs(1.0 - self.energy(farther)).max(axis=1, initial=0.0)
        return light

    def moment(self, power: int) -> float:
        """Return ∫|OTF|·u^power du, a moment of the MTF."""
        u, passing = _passing(self)
        return float(passing @ u**power)


@functools.lru_cache(maxsize=16)
def _passing(pattern: Pattern) -> tuple[F64, F64]:
    """Return the frequencies of a Gauss rule over the pass band, and the MTF there times its weights."""
    x, w = gauss_legendre(MOMENT_NODES)
    top = pattern.breaks[-1]
    u = 0.5 * top * (1.0 + x)
    return u, 0.5 * top * w * np.abs(pattern.otf(u))


UNIT_NM = 1e3  # at 1000 nm and f/1 a diffraction pattern's λN is 1 µm: lengths are blurs
FAR = 2.0 / math.pi**2
POWERS = (FAR, FAR / (8.0 * math.pi**2), -FAR * 9.0 / (128.0 * math.pi**4))  # (2/πx)(1 + 1/8x² − 9/128x⁴ + …), x = πρ
# The next power, c7 = 2·0.2197/π⁸, for an edge's end perpendicular to the line of sight: times ∫cos⁷θ dθ/2π over π/2.
SEVENTH = 2.0 * 0.2197 / math.pi**8 * (16.0 / 35.0) / (2.0 * math.pi)
# 1 − E oscillates as cos(2πuρ)·b/ρ² to leading order; the end of an edge perpendicular to the line of sight b/(4π√u).
RING = 1.0 / (4.0 * math.pi**4)


class _Round(Protocol):
    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64: ...

    def encircled_energy(self, r_um: F64, wavelength_nm: float) -> F64: ...


def of_unit(lens: _Round) -> tuple[Callable[[F64], F64], Callable[[F64], F64]]:
    """Return encircled energy and transfer, as functions, of a lens whose blur is 1 µm."""
    return (
        lambda rho: lens.encircled_energy(rho, UNIT_NM),
        lambda u: lens.otf(u, np.zeros(1), UNIT_NM),
    )
