"""What the boundary engine knows of a lens: a round pattern that depends on ρ = r/blur alone, as pure functions of ρ.

``blur`` is the pattern's own length, one number per wavelength: λN of an Airy pattern, σ of a Gaussian.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64
from camsim.errors import UnsupportedError
from camsim.optics import Airy, Gaussian


@dataclass(frozen=True, slots=True, kw_only=True)
class Pattern:
    """One family of patterns.

    energy  : E(ρ), the light within ρ
    core    : lim E/ρ² at ρ = 0
    otf     : transfer at u cycles per blur;  cutoff: it is 0 (or below 1e-16) past this u
    powers  : c1, c3, c5 of 1 − E = Σ c_k/ρ^k + what oscillates
    ring    : an edge's end at distance R leaves at most ring·(blur/R)^{5/2} of oscillation in the far form
    grain   : how much coarser than for an Airy pattern a table may be
    quiet   : tolerance → ρ past which the far form's smooth part holds
    finest  : the smallest tolerance; what oscillates sets the radii, and they grow as its power −0.4
    """

    energy: Callable[[F64], F64]
    core: float
    otf: Callable[[F64], F64]
    cutoff: float
    powers: tuple[float, float, float]
    ring: float
    grain: float
    quiet: Callable[[float], float]
    finest: float


def pattern_of(lens: object) -> Pattern:
    """Return the pattern of a lens."""
    for kind, pattern in PATTERNS.items():
        if type(lens) is kind:
            return pattern
    known = " or ".join(kind.__name__ for kind in PATTERNS)
    raise UnsupportedError(f"lens: the boundary engine knows {known}, not {type(lens).__name__}")


_UNIT_NM = 1e3  # at 1000 nm and f/1 an Airy pattern's λN is 1 µm: lengths are blurs
_AIRY, _GAUSSIAN = Airy(f_number=1.0), Gaussian(sigma_um=1.0)
_C1 = 2.0 / math.pi**2

PATTERNS: dict[type, Pattern] = {
    # 1 − E = (2/πx)(1 + 1/8x² − 9/128x⁴ + …), x = πρ, and what oscillates (DLMF 10.18.17).
    Airy: Pattern(
        energy=lambda rho: _AIRY.encircled_energy(rho, _UNIT_NM),
        core=math.pi**2 / 4.0,
        otf=lambda u: _AIRY.otf(u, np.zeros(1), _UNIT_NM),
        cutoff=1.0,
        powers=(_C1, _C1 / (8.0 * math.pi**2), -_C1 * 9.0 / (128.0 * math.pi**4)),
        ring=1.0 / (4.0 * math.pi**4),
        grain=1.0,
        quiet=lambda tolerance: 5.0,
        finest=1e-9,
    ),
    Gaussian: Pattern(
        energy=lambda rho: _GAUSSIAN.encircled_energy(rho, _UNIT_NM),
        core=0.5,
        otf=lambda u: _GAUSSIAN.otf(u, np.zeros(1), _UNIT_NM),
        cutoff=1.37,
        powers=(0.0, 0.0, 0.0),
        ring=0.0,
        grain=2.0,
        quiet=lambda tolerance: math.sqrt(2.0 * math.log(20.0 / tolerance)),
        finest=1e-9,
    ),
}
