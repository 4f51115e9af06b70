"""A pupil's phase factor as a series of Zernike polynomials, whose transforms are Bessel functions of the radius.

exp(2πi·W) = Σ β_nm·R_nm(ρ)·exp(imθ), and the transform of R_nm(ρ)·exp(imθ) over a disc is
2π·(−i)ⁿ·J_{n+1}(z)/z·exp(imφ), z = πr/λN, exactly (Zernike, 1934; Janssen, "Extended Nijboer–Zernike approach", 2002).
So an amplitude is (2π/z)·Σ_n J_{n+1}(z)·γ_n(φ), with γ_n(φ) = (−i)ⁿ·Σ_m β_nm·exp(imφ), and an obstruction's is another
one that is taken away. A series ends soon: with so many waves that a term of degree n follows them, each further term
is nothing.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy

from camsim.arrays import C128, F64
from camsim.errors import UnsupportedError
from camsim.optics.difference import Difference
from camsim.quadrature import chebyshev, gauss_legendre
from camsim.rendering.aberrated.polar_kernels import add_series, add_terms
from camsim.rendering.fast_length import fast_length

DEGREES = (8, 12, 16, 20, 24, 32, 40, 48, 64, 80, 96, 128, 160, 192, 256, 320, 384, 512)
LAST = 0.75  # of a series: what lies beyond tells what is missing
# Nodes at which a series is looked at that none of its own may be near to: even over the disc, at the golden angle.
LOOKED_AT = 64
RHO: F64 = np.sqrt((np.arange(LOOKED_AT) + 0.5) / LOOKED_AT)
ANGLE: F64 = np.asarray(2.399963229728653 * np.arange(LOOKED_AT), np.float64)
SCATTER = 3.0  # times what a series may leave out: what it may there
CIRCLES = (0.3, 0.5, 0.7, 0.85, 1.0)  # of the pupil, on which harmonics are counted; as many diameters for degrees


class Series(NamedTuple):
    """Zernike coefficients β (discs, n, m) of a phase factor, m = −most … most: the pupil's and its obstruction's."""

    terms: C128

    @property
    def most(self) -> int:
        """The highest harmonic."""
        return int(self.terms.shape[2]) // 2

    @property
    def degree(self) -> int:
        """The highest degree."""
        return int(self.terms.shape[1]) - 1

    def around(self, angle_rad: F64) -> C128:
        """Return γ (discs, n, angles)."""
        m, n = np.arange(-self.most, self.most + 1), np.arange(self.degree + 1)
        turned = np.einsum("dnm,ma->dna", self.terms, np.exp(1j * np.multiply.outer(m, angle_rad)))
        around: C128 = turned * np.array([1.0, -1j, -1.0, 1j])[n % 4][:, None]
        return around


def series_of(rest: Difference, wavelength_nm: F64, allowed: float) -> list[Series]:
    """Return a difference's phase factors about its move at wavelengths.

    allowed : root mean square over the pupil of what is left out
    """
    found, first = [], 0
    for nm in wavelength_nm.tolist():
        while (own := _series(rest, nm, DEGREES[first], allowed)) is None:
            first += 1
            if first == len(DEGREES):
                raise UnsupportedError(
                    f"the wavefront has too many waves at {nm:g} nm for a series of Zernike polynomials "
                    f"(degree {DEGREES[-1]} does not follow it); give smaller coefficients",
                    key="zernike_waves",
                )
        found.append(own)
    return found


@functools.lru_cache(maxsize=1024)
def _series(rest: Difference, wavelength_nm: float, degree: int, allowed: float) -> Series | None:
    """Return a series of up to a degree, None where its end is not to be seen."""
    radii, phases = [1.0, rest.obstruction] if rest.obstruction else [1.0], _phases(rest, wavelength_nm)
    t, weights = gauss_legendre(degree // 2 + 2)  # of ρ²: what is integrated is a polynomial of that
    rho, angle = np.sqrt(0.5 * (1.0 + t)), np.pi * np.arange(2.0 * degree + 2.0) / (degree + 1.0)
    terms = np.zeros((len(radii), degree + 1, 2 * degree + 1), complex)
    for own, radius in zip(terms, radii, strict=True):
        around: C128 = scipy.fft.fft(phases(radius * rho[:, None], angle), axis=1, norm="forward")
        add_terms(rho, 0.5 * weights, around, own)
    light = np.sum(np.square(np.abs(terms)), axis=0) / np.arange(1.0, degree + 2.0)[:, None]
    last = _count(np.sqrt(light.sum(axis=1)), 0.5 * allowed)
    if last > LAST * degree:
        return None
    either = light.sum(axis=0)
    most = _count(np.sqrt(either[degree:] + either[degree::-1]), 0.5 * allowed) - 1
    kept = np.ascontiguousarray(terms[:, :last, degree - most : degree + most + 1])
    # Nodes may be where a polynomial is nothing: sin 9θ at all of 18 angles, R₁₂⁰ at all of six radii.
    for own, radius in zip(kept, radii, strict=True):
        wrong = -phases(radius * RHO, ANGLE)
        add_series(RHO, ANGLE, own, wrong)
        if math.sqrt(float(np.mean(np.square(np.abs(wrong))))) > SCATTER * allowed:
            return None
    kept.flags.writeable = False
    return Series(kept)


def length_of(rest: Difference, wavelength_nm: float, allowed: float) -> tuple[int, int]:
    """Return the highest degree and harmonic of a phase factor about its move, without its series.

    Harmonics on some circles; on a diameter a polynomial of degree n is one of the place on it.
    """
    points = fast_length(math.ceil(4.0 * math.pi * rest.steepest_waves(wavelength_nm)) + 2 * DEGREES[0])
    phases, angle = _phases(rest, wavelength_nm), 2.0 * np.pi * np.arange(float(points)) / points
    around = scipy.fft.fft(phases(np.array(CIRCLES)[:, None], angle), norm="forward")
    light = np.square(np.abs(around))
    either = (light + np.roll(light[:, ::-1], 1, axis=1))[:, : points // 2]
    across = phases(chebyshev(points), ANGLE[: len(CIRCLES), None])
    degrees = np.abs(scipy.fft.dct(across.real)) + np.abs(scipy.fft.dct(across.imag))
    return (
        max(_count(own / points, allowed) for own in degrees) - 1,
        max(_count(np.sqrt(own), allowed) for own in either) - 1,
    )


def _phases(rest: Difference, wavelength_nm: float) -> Callable[[F64, F64], C128]:
    """Return what gives the phase factor about the move at radii and angles of the pupil."""
    plane = np.array(rest.moved_um) / (2.0 * rest.blur_um(wavelength_nm))

    def phases(radius: F64, angle_rad: F64) -> C128:
        x, y = radius * np.cos(angle_rad), radius * np.sin(angle_rad)
        waves = rest.lens.waves(x, y, wavelength_nm) - (plane[0] * x + plane[1] * y)
        found: C128 = np.exp(2j * np.pi * waves)
        return found

    return phases


def _count(sizes: F64, allowed: float) -> int:
    """Return how many of the first there are to be, at least one, for the others not to add up to more.

    >>> _count(np.array([5.0, 1.0, 0.1, 0.01]), 0.2)
    2
    """
    beyond = np.cumsum(sizes[::-1])[::-1]
    return max(1, int(np.count_nonzero(beyond > allowed)))
