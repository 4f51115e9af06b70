"""What the boundary engine knows of a lens: a round pattern that depends on ρ = r/blur alone, as pure functions of ρ.

``blur`` is the pattern's own length, one number per wavelength: λN of a diffraction pattern, σ of a Gaussian.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64
from camsim.errors import UnsupportedError
from camsim.optics import Airy, AnnularAiry, Gaussian, RadialOtf
from camsim.rendering.quadrature import gauss_legendre

MOMENT_NODES = 60  # of a bound: a per cent of it does not matter


@dataclass(frozen=True, slots=True, kw_only=True)
class Pattern:
    """One pattern; lengths in blurs, frequencies in cycles per blur.

    energy  : E(ρ), the light within ρ
    core    : lim E/ρ² at ρ = 0
    otf     : transfer at u
    breaks  : where the transfer is not smooth, in rising order; it is 0 (or below 1e-16) past the last
    powers  : c1, c3, c5 of 1 − E = Σ c_k/ρ^k + what oscillates
    rings   : (u, a, n): an edge's end at distance R leaves oscillation of frequency u, at most a·R⁻ⁿ, in the far form
    airy    : rings.py knows what oscillates; else it is kept out by distance
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
    airy: bool
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

    def moment(self, power: int) -> float:
        """Return ∫|OTF|·u^power du: how much there is to follow."""
        x, w = gauss_legendre(MOMENT_NODES)
        top = self.breaks[-1]
        u = 0.5 * top * (1.0 + x)
        return float(np.abs(self.otf(u)) @ (u**power * w)) * 0.5 * top

    def spread(self, rho: F64) -> F64:
        """Return the most light per square blur at ρ and beyond, where the far form holds: its slope over 2πρ.

        c/ρᵏ of it has the slope kc/ρ^{k+1}. An end's oscillation is 4π√(uρ) times less than its light's, and that has
        2πu times its slope.
        """
        smooth = sum(k * abs(c) * rho ** -(k + 2.0) for k, c in zip((1, 3, 5), self.powers, strict=True))
        swing = sum(8.0 * math.pi**2 * u**1.5 * a * rho ** -(n + 0.5) for u, a, n in self.rings)
        light: F64 = (smooth + swing + np.zeros_like(rho)) / (2.0 * math.pi)
        return light


def pattern_of(lens: object) -> Pattern:
    """Return the pattern of a lens."""
    if isinstance(lens, AnnularAiry):
        return _annular(lens.obstruction) if lens.obstruction > 0.0 else AIRY
    if isinstance(lens, Airy):
        return AIRY
    if isinstance(lens, Gaussian):
        return _GAUSSIAN
    if isinstance(lens, RadialOtf):
        return _curve(lens)
    raise UnsupportedError(
        f"the boundary engine knows Airy, AnnularAiry, Gaussian or RadialOtf, not {type(lens).__name__}; use fourier",
        key="lens",
    )


_UNIT_NM = 1e3  # at 1000 nm and f/1 a diffraction pattern's λN is 1 µm: lengths are blurs
_FAR = 2.0 / math.pi**2
_POWERS = (_FAR, _FAR / (8.0 * math.pi**2), -_FAR * 9.0 / (128.0 * math.pi**4))
# The next power, c7 = 2·0.2197/π⁸, as an edge's end met square on leaves it: times ∫cos⁷θ dθ/2π over a right angle.
SEVENTH = 2.0 * 0.2197 / math.pi**8 * (16.0 / 35.0) / (2.0 * math.pi)
# What oscillates in 1 − E is cos(2πuρ)·b/ρ² to leading order; the end of an edge met square on makes b/(4π√u) of it.
RING = 1.0 / (4.0 * math.pi**4)


def _round(lens: Airy | AnnularAiry | Gaussian) -> tuple[Callable[[F64], F64], Callable[[F64], F64]]:
    """Return energy and transfer of a lens whose blur is 1 µm."""
    return (
        lambda rho: lens.encircled_energy(rho, _UNIT_NM),
        lambda u: lens.otf(u, np.zeros(1), _UNIT_NM),
    )


_AIRY_ENERGY, _AIRY_OTF = _round(Airy(f_number=1.0))
AIRY = Pattern(
    energy=_AIRY_ENERGY,
    core=math.pi**2 / 4.0,
    otf=_AIRY_OTF,
    breaks=(1.0,),
    powers=_POWERS,  # (2/πx)(1 + 1/8x² − 9/128x⁴ + …), x = πρ (DLMF 10.18.17)
    rings=((1.0, RING, 2.5),),
    airy=True,
    signed=False,
    quiet=lambda allowed: max(5.0, (SEVENTH / allowed) ** (1.0 / 7.0)),
    finest=1e-9,
)

_GAUSS_ENERGY, _GAUSS_OTF = _round(Gaussian(sigma_um=1.0))
_GAUSSIAN = Pattern(
    energy=_GAUSS_ENERGY,
    core=0.5,
    otf=_GAUSS_OTF,
    breaks=(1.37,),
    powers=(0.0, 0.0, 0.0),
    rings=(),
    airy=False,
    signed=False,
    quiet=lambda allowed: math.sqrt(2.0 * math.log(1.0 / allowed)),
    finest=1e-9,
)


@functools.cache
def _annular(e: float) -> Pattern:
    """Return the pattern of a pupil whose middle is covered to a fraction e of its diameter.

    (1 − e²)(1 − E) = A(ρ) + e²·A(eρ) − 4e·∫_x^∞ J1(t)·J1(et)/t dt with A = 1 − E of an Airy pattern: two Airy patterns,
    whose powers and rings add up, and a cross term whose phases (1 ± e)t make rings of the frequencies (1 ± e)/2.
    The small disc's powers hold from e·ρ on as the large one's do from ρ on: next comes e²·c7/(eρ)⁷.
    """
    energy, otf = _round(AnnularAiry(f_number=1.0, obstruction=e))
    share = 1.0 / (1.0 - e * e)

    def cross(sign: float) -> tuple[float, float, float]:
        u = 0.5 * (1.0 + sign * e)
        return u, share * 4.0 * math.sqrt(e) / (1.0 + sign * e) * RING / math.sqrt(u), 2.5

    rings = (cross(-1.0), (e, share / math.sqrt(e) * RING, 2.5), cross(1.0), (1.0, share * RING, 2.5))
    return Pattern(
        energy=energy,
        core=math.pi**2 / 4.0 * (1.0 - e * e),
        otf=otf,
        breaks=tuple(sorted(u for u, _, _ in rings)),
        powers=(
            _POWERS[0] * share * (1.0 + e),
            _POWERS[1] * share * (1.0 + 1.0 / e),
            _POWERS[2] * share * (1.0 + e**-3.0),
        ),
        rings=rings,
        airy=False,
        signed=False,
        quiet=lambda allowed: max(5.0, 5.0 / (1.0 - e), (share * (1.0 + e**-5.0) * SEVENTH / allowed) ** (1.0 / 7.0)),
        finest=1e-7,
    )


@functools.cache
def _curve(lens: RadialOtf) -> Pattern:
    """Return the pattern of a transfer that is a cubic between its knots; the blur is the inverse of the last one.

    A power uⁿ of the transfer at 0 makes 2πρ·∫uⁿ·J1(2πuρ) du = 1/(2πρ) of E for n = 1, −3/(2πρ)³ for n = 3, and nothing
    for n even. A jump J of the m-th derivative at u makes J/(π√(uρ)·(2πρ)^m) of oscillation there, and an edge's end
    met square on 1/(4π√(uρ)) of that.
    """
    last = lens.freq_per_um[-1]
    cubic = lens.curve()
    knots = cubic.x / last
    at_zero = cubic.c[::-1, 0] * last ** np.arange(4)
    rings = []
    for order in (1, 2, 3):
        slope = cubic.derivative(order)
        jumps = np.append(slope.c[-1, 1:], 0.0) - slope(cubic.x[1:] * (1.0 - 1e-12))
        for u, jump in zip(knots[1:], np.abs(jumps) * last**order, strict=True):
            if jump > 1e-9:
                rings.append((float(u), float(jump / (4.0 * math.pi**2 * u * (2.0 * math.pi) ** order)), order + 1.0))
    return Pattern(
        energy=lambda rho: lens.encircled_energy(rho / last, _UNIT_NM),
        core=math.pi * float(lens.point_spread(np.zeros(1), _UNIT_NM)[0]) / last**2,
        otf=lambda u: lens.otf(u * last, np.zeros(1), _UNIT_NM),
        breaks=tuple(float(u) for u in knots[1:]),
        powers=(float(-at_zero[1] / (2.0 * math.pi)), float(3.0 * at_zero[3] / (2.0 * math.pi) ** 3), 0.0),
        rings=tuple(rings),
        airy=False,
        signed=True,
        quiet=lambda allowed: max(5.0, 2.0 / float(knots[1])),
        finest=1e-7,
    )
