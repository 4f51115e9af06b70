"""What a round lens tells the boundary engine: its pattern, which depends on ρ = r/blur alone, as functions of ρ.

``blur`` is the pattern's own length, one number per wavelength: λN of a diffraction pattern, σ of a Gaussian.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np

from camsim.core.arrays import F64
from camsim.numerics.quadrature import gauss_legendre

MOMENT_NODES = 60  # of a bound: a per cent of it does not matter
Tone: TypeAlias = tuple[float, tuple[complex, ...]]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pattern:
    """One pattern; lengths in blurs, frequencies in cycles per blur.

    energy  : E(ρ), the light within ρ
    core    : lim E/ρ² at ρ = 0
    otf     : transfer at u
    breaks  : where the transfer is not smooth, in rising order; it is 0 (or below 1e-16) past the last
    powers  : c1, c3, c5 of 1 − E = Σ c_k/ρ^k + what oscillates
    rings   : (u, a, n): an edge's end at distance R leaves oscillation of frequency u, at most a·R⁻ⁿ, in the far form
    tones   : (u, (a₀, a₁ …)): what oscillates in 1 − E is Re Σ aₖ·ρ^(−2−k)·e^{2πiuρ}, all of it added up; none where
              that is not known, and it is kept out by distance
    oscillations_from_blurs : ρ past which they hold, to 3e-8 of the strongest
    signed  : the pattern has negative rings, as no light has: a transfer that was measured or made up
    quiet   : an error → ρ past which the smooth powers leave no more
    finest  : the smallest tolerance
    """

    energy: Callable[[F64], F64]
    core: float
    otf: Callable[[F64], F64]
    breaks: tuple[float, ...]
    powers: tuple[float, float, float]
    rings: tuple[tuple[float, float, float], ...]
    oscillations: tuple[Tone, ...]
    oscillations_from_blurs: float
    signed: bool
    quiet: Callable[[float], float]
    finest: float

    def beyond(self, rho: F64) -> F64:
        """Return how much light may lie beyond ρ: with negative rings it comes and goes, and is looked for farther.

        Of a signed pattern it is what a ray that enters and leaves an outline once may see.
        """
        if not self.signed:
            return 1.0 - self.energy(rho)
        farther = rho[:, None] * np.linspace(1.0, 1.5, 33)
        light: F64 = 2.0 * np.abs(1.0 - self.energy(farther)).max(axis=1, initial=0.0)
        return light

    def absolute(self, rho: float) -> float:
        """Return ∫|light| beyond ρ: more than 1 in all of a pattern with negative rings, 6 was met."""
        radius, beyond = _absolute(self)
        if rho < radius[-1]:
            return float(np.interp(rho, radius, beyond))
        return float(beyond[-1]) * math.sqrt(radius[-1] / rho)

    @property
    def peak(self) -> float:
        """The most light per square blur, of either sign: in the middle, but with negative rings anywhere."""
        return 2.0 * math.pi * self.moment(1) if self.signed else self.core / math.pi

    def moment(self, power: int) -> float:
        """Return ∫|OTF|·u^power du: how much there is to follow."""
        u, passing = _passing(self)
        return float(passing @ u**power)

    def spread(self, rho: F64) -> F64:
        """Return the most light per square blur at ρ and beyond, where the far form holds: its slope over 2πρ.

        c/ρᵏ of it has the slope kc/ρ^{k+1}. An end's oscillation is 4π√(uρ) times less than its light's, and that has
        2πu times its slope.
        """
        smooth = sum(k * abs(c) * rho ** -(k + 2.0) for k, c in zip((1, 3, 5), self.powers, strict=True))
        amplitude = sum(8.0 * math.pi**2 * u**1.5 * a * rho ** -(n + 0.5) for u, a, n in self.rings)
        light: F64 = (smooth + amplitude + np.zeros_like(rho)) / (2.0 * math.pi)
        return light


@functools.lru_cache(maxsize=16)
def _passing(pattern: Pattern) -> tuple[F64, F64]:
    """Return the frequencies of a Gauss rule over all that passes, and |OTF| there times its weights."""
    x, w = gauss_legendre(MOMENT_NODES)
    top = pattern.breaks[-1]
    u = 0.5 * top * (1.0 + x)
    return u, 0.5 * top * w * np.abs(pattern.otf(u))


FOLLOWED, EACH = 200.0, 0.125  # blurs over which rings are added up, eight steps to the shortest


@functools.cache
def _absolute(pattern: Pattern) -> tuple[F64, F64]:
    """Return radii and ∫|light| beyond them: how far E goes up and down.

    A transfer with a corner leaves the slowest rings that there are: in all ρ^−½ of light. So what is beyond the last
    radius is no more than 1/(√2 − 1) of what the outer half held.
    """
    radius = np.arange(0.0, FOLLOWED + EACH, EACH)
    steps = np.abs(np.diff(pattern.energy(radius)))
    beyond = np.append(np.cumsum(steps[::-1])[::-1], 0.0)
    return radius, beyond + (1.0 + math.sqrt(2.0)) * beyond[radius.size // 2]


UNIT_NM = 1e3  # at 1000 nm and f/1 a diffraction pattern's λN is 1 µm: lengths are blurs
FAR = 2.0 / math.pi**2
POWERS = (FAR, FAR / (8.0 * math.pi**2), -FAR * 9.0 / (128.0 * math.pi**4))  # (2/πx)(1 + 1/8x² − 9/128x⁴ + …), x = πρ
# The next power, c7 = 2·0.2197/π⁸, as an edge's end met square on leaves it: times ∫cos⁷θ dθ/2π over a right angle.
SEVENTH = 2.0 * 0.2197 / math.pi**8 * (16.0 / 35.0) / (2.0 * math.pi)
# What oscillates in 1 − E is cos(2πuρ)·b/ρ² to leading order; the end of an edge met square on makes b/(4π√u) of it.
RING = 1.0 / (4.0 * math.pi**4)


class _Round(Protocol):
    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64: ...

    def encircled_energy(self, r_um: F64, wavelength_nm: float) -> F64: ...


def of_unit(lens: _Round) -> tuple[Callable[[F64], F64], Callable[[F64], F64]]:
    """Return energy and transfer of a lens whose blur is 1 µm."""
    return (
        lambda rho: lens.encircled_energy(rho, UNIT_NM),
        lambda u: lens.otf(u, np.zeros(1), UNIT_NM),
    )
