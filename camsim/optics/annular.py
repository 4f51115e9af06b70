"""An aberration-free lens with a central obstruction, such as a mirror lens or a telescope."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
import scipy

from camsim.core.arrays import C128, F64
from camsim.core.typed import Number, Positive, validate
from camsim.numerics.bessel import jinc
from camsim.numerics.quadrature import gauss_legendre
from camsim.optics.airy import AIRY, DiffractionLimit, airy_otf
from camsim.optics.pattern import POWERS, RING, SEVENTH, Pattern, of_unit
from camsim.optics.pupil import Obstruction
from camsim.spectra.curve import NumberOrCurve, Transmission

PANEL = 0.5  # of the tabulated integral, in x: 12 Gauss nodes on it are exact
TERMS = 10  # of the asymptotic series beyond the table
SERIES_FROM = 5.0  # λN: x = 16, where an Airy pattern's asymptotic series has a relative error of 1e-8


@dataclass(frozen=True, slots=True, kw_only=True)
class AnnularAiry(DiffractionLimit):
    """A diffraction-limited lens with a central obstruction.

    f_number     : focal length over aperture diameter, dimensionless; the obstruction does not change it
    obstruction  : diameter of the obstruction over that of the aperture, 0 … 0.95
    transmission : fraction of the light that passes, a number or a curve over wavelength

    The obstruction takes obstruction² of the light.

    >>> lens = AnnularAiry(f_number=8.0, obstruction=0.3)
    >>> lens.otf(np.array([0.0, 0.1, 0.3]), np.zeros(3), 550.0).round(4)
    array([1.    , 0.3612, 0.    ])
    """

    place: ClassVar[str] = "lens"

    f_number: Positive
    obstruction: Obstruction
    transmission: Transmission = 1.0

    if TYPE_CHECKING:

        def __init__(self, *, f_number: Number, obstruction: Number, transmission: NumberOrCurve = 1.0) -> None: ...

    def __post_init__(self) -> None:
        validate(self)

    @property
    def opening(self) -> float:
        """Area of the pupil as a fraction of the aperture without obstruction."""
        return 1.0 - self.obstruction**2

    def pattern(self) -> Pattern:
        """Return the pattern for the boundary engine."""
        return _pattern(self.obstruction) if self.obstruction > 0.0 else AIRY

    def reach_um(self, lost_fraction: float, wavelength_nm: float) -> float:
        """Return a radius beyond which at most ``lost_fraction`` of the light falls, µm.

        The tail is proportional to the pupil's perimeter over its area: 1/(1 − obstruction) times an Airy pattern's.
        """
        airy = 4.0 / (math.pi**2 * lost_fraction * (1.0 - self.obstruction))
        return self.blur_um(wavelength_nm) * (airy + 1.0 / (1.0 - self.obstruction))

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer function at (fx, fy) cycles/µm (O'Neill, JOSA 46, 285, 1956): a sum of overlaps of circles."""
        frequency = np.hypot(fx_per_um, fy_per_um)
        e = self.obstruction
        large = airy_otf(frequency, f_number=self.f_number, wavelength_nm=wavelength_nm)
        if e == 0.0:
            return large
        small = airy_otf(frequency, f_number=self.f_number / e, wavelength_nm=wavelength_nm)
        # Overlap of circles of radii 1 and e, 2u apart, relative to the large one's area.
        apart = 2.0 * np.minimum(frequency * self.blur_um(wavelength_nm), 1.0)
        safe = np.clip(apart, 1.0 - e, 1.0 + e)
        a = np.arccos(np.clip((safe * safe + 1.0 - e * e) / (2.0 * safe), -1.0, 1.0))
        b = np.arccos(np.clip((safe * safe + e * e - 1.0) / (2.0 * safe * e), -1.0, 1.0))
        kite = np.sqrt(np.maximum((1.0 + e - safe) * (safe + 1.0 - e) * (safe - 1.0 + e) * (safe + 1.0 + e), 0.0))
        overlap = (a + e * e * b - 0.5 * kite) / math.pi
        both = np.where(apart <= 1.0 - e, e * e, np.where(apart >= 1.0 + e, 0.0, overlap))
        otf: F64 = (large + e * e * small - 2.0 * both) / (1.0 - e * e)
        return otf

    def point_spread(self, r_um: F64, wavelength_nm: float) -> F64:
        """Irradiance at ``r_um`` (µm) from a point of unit power, 1/µm²: the amplitudes of two discs subtracted."""
        blur_um, e = self.blur_um(wavelength_nm), self.obstruction
        x = (math.pi / blur_um) * np.asarray(r_um, float)
        amplitude = jinc(x) - e * e * jinc(e * x)
        irradiance: F64 = math.pi / (blur_um**2 * (1.0 - e * e)) * amplitude * amplitude
        return irradiance

    def encircled_energy(self, r_um: F64, wavelength_nm: float) -> F64:
        """Fraction of the light within ``r_um`` (µm) of the centre.

        With x = πr/(λN) and A(x) = J0² + J1²: (1 − e²)·(1 − E) = A(x) + e²·A(ex) − 4e·∫_x^∞ J1(t)J1(et)/t dt.
        """
        e = self.obstruction
        x = (math.pi / self.blur_um(wavelength_nm)) * np.asarray(r_um, float)
        outside = _airy_outside(x)
        if e > 0.0:
            outside = outside + e * e * _airy_outside(e * x) - 4.0 * e * _cross(x, e)
        energy: F64 = np.where(x == 0.0, 0.0, 1.0 - outside / (1.0 - e * e))
        return energy


def _airy_outside(x: F64) -> F64:
    energy: F64 = scipy.special.j0(x) ** 2 + scipy.special.j1(x) ** 2
    return energy


def _cross(x: F64, e: float) -> F64:
    """Return ∫_x^∞ J1(t)·J1(et)/t dt, from a table of panels, or by its asymptotic series where that is accurate."""
    edges, sums = _panels(e)
    near = x < edges[-1]
    out = np.empty_like(x)
    inside = x[near]
    cell = (inside / PANEL).astype(np.int64)
    out[near] = sums[cell] - _gauss_integral(edges[cell], inside, e)
    out[~near] = _asymptotic(x[~near], e)
    return out


@functools.cache
def _panels(e: float) -> tuple[F64, F64]:
    """Return the panels' boundaries and the integral from each of them to infinity."""
    last = max(200.0, 60.0 / (1.0 - e), 60.0 / e)
    edges = PANEL * np.arange(math.ceil(last / PANEL) + 1.0)
    pieces = _gauss_integral(edges[:-1], edges[1:], e)
    beyond = _asymptotic(edges[-1:], e)[0]
    sums = np.concatenate([np.cumsum(pieces[::-1])[::-1], [0.0]]) + beyond
    return edges, sums


def _gauss_integral(low: F64, high: F64, e: float) -> F64:
    nodes, weights = gauss_legendre(12)
    half = 0.5 * (high - low)
    t = (low + half)[:, None] + half[:, None] * nodes
    values: F64 = half * ((scipy.special.j1(t) * e * jinc(e * t)) @ weights)
    return values


def _asymptotic(x: F64, e: float) -> F64:
    total = np.zeros(x.shape, complex)
    for omega, series in _cross_series(e):
        total += np.exp(1j * omega * x) * np.polynomial.polynomial.polyval(1.0 / x, series) / (x * x)
    values: F64 = total.real
    return values


def _cross_series(e: float) -> list[tuple[float, C128]]:
    """Return (ω, c): ∫_x^∞ J1(t)·J1(et)/t dt = Re Σ c_k·x^(−2−k)·exp(iωx), summed over both ω.

    Hankel's expansion of both Bessel functions (DLMF 10.17.3), multiplied and integrated by parts:
    J1(t) = Re √(2/πt)·exp(i(t − 3π/4))·Σ (i/t)^k·a_k; the product of two real parts has the sum and the difference
    of their phases, and ∫_x^∞ t^{−n}·exp(iωt) dt = −exp(iωx)·x^{−n}/(iω)·Σ_m n(n+1)…(n+m−1)/(iωx)^m.
    """
    a = [1.0]
    for k in range(1, TERMS):
        a.append(a[-1] * (4.0 - (2 * k - 1) ** 2) / (8.0 * k))
    first = np.array([1j**k * a[k] for k in range(TERMS)])
    second = np.array([1j**k * a[k] / e**k for k in range(TERMS)])
    found = []
    for other, turn, omega in ((second.conj(), 1.0, 1.0 - e), (second, 1j, 1.0 + e)):
        series = np.zeros(TERMS, complex)
        for k, factor in enumerate(np.convolve(first, other)[:TERMS]):
            term = -factor * turn / (1j * omega * math.pi * math.sqrt(e))
            for m in range(k, TERMS):
                series[m] += term
                term *= (m + 2) / (1j * omega)
        found.append((omega, series))
    return found


@functools.cache
def _pattern(e: float) -> Pattern:
    """Return the pattern of a pupil with a central obstruction of a fraction e of its diameter.

    (1 − e²)(1 − E) = A(ρ) + e²·A(eρ) − 4e·∫_x^∞ J1(t)·J1(et)/t dt with A = 1 − E of an Airy pattern: two Airy patterns,
    whose powers and ringing add up, and a cross term with phases (1 ± e)t, which oscillates at frequencies
    (1 ± e)/2. The series of the small disc is valid for eρ as that of the large one for ρ: its next term is
    e²·c7/(eρ)⁷. Closer than that, the amplitude of its ringing, slow enough for photosites to pass it, is the bound.
    """
    energy, otf = of_unit(AnnularAiry(f_number=1.0, obstruction=e))
    share = 1.0 / (1.0 - e * e)

    def cross(sign: float) -> tuple[float, float, float]:
        u = 0.5 * (1.0 + sign * e)
        return u, share * 4.0 * math.sqrt(e) / (1.0 + sign * e) * RING / math.sqrt(u), 2.5

    rings = (cross(-1.0), (e, share / math.sqrt(e) * RING, 2.5), cross(1.0), (1.0, share * RING, 2.5))
    return Pattern(
        energy=energy,
        otf=otf,
        breaks=tuple(sorted(u for u, _, _ in rings)),
        powers=(
            POWERS[0] * share * (1.0 + e),
            POWERS[1] * share * (1.0 + 1.0 / e),
            POWERS[2] * share * (1.0 + e**-3.0),
        ),
        rings=rings,
        signed=False,
        quiet=lambda allowed: max(
            SERIES_FROM,
            SERIES_FROM / (1.0 - e),
            min(SERIES_FROM / e, (share / math.sqrt(e) * RING / allowed) ** (1.0 / 2.5)),
            (share * (1.0 + e**-5.0) * SEVENTH / allowed) ** (1.0 / 7.0),
        ),
        finest=1e-11,
    )
