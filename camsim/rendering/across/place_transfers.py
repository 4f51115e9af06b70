"""The check's transfers at one place of the frame, by rules, shifts, angles and wavelengths of its own.

T(ν, θ) = (1/π)·∫ exp(2πi·[W(p − d) − W(p + d)]) dp over what two copies of the pupil have in common. In axes along the
shift that region is the same in all directions, and the wavefront turns: polynomials are asked once for each shift.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy

from camsim.arrays import C128, F64, I64
from camsim.kept import cached_property
from camsim.optics.airy import NM_PER_UM
from camsim.optics.placed import PlacedLens
from camsim.products import complex_product, product
from camsim.quadrature import barycentric, chebyshev, gauss_legendre, interpolation
from camsim.rendering.across.place_samples import EACH, FINEST, PlaceSamples, first_nodes

AT_ONCE = 256  # frequencies


@dataclass(frozen=True, kw_only=True, eq=False)
class PlaceTransfers:
    """Transfers of one place, less the perfect one's, for sets of weights (sets, wavelengths).

    angle_rad : of the place about the axis
    shifts    : Gauss nodes of the shifts' angles;  order: (m,) of the harmonics
    harmonics : (wavelengths · shifts, 2·m), real and imaginary parts in turn
    """

    f_number: float
    angle_rad: float
    wavelength_nm: F64
    weights: F64
    shifts: F64
    order: I64
    harmonics: F64

    @classmethod
    def of(
        cls, lens: PlacedLens, angle_rad: float, wavelength_nm: F64, weights: F64, tolerance: float
    ) -> PlaceTransfers:
        """Return those of a lens that looks alike on both sides of the radius, as one of revolution does."""
        loud = float(np.abs(weights).sum(axis=1).max())
        samples = PlaceSamples(
            lens,
            angle_rad,
            wavelength_nm,
            allowed=max(EACH * tolerance / max(loud, 1e-300), FINEST),
            first=first_nodes(lens, wavelength_nm, tolerance),
        )
        nm, shifts, around = samples.taken()
        count = around.shape[-1]
        order = np.arange(-(count // 2) + 1, count // 2)
        harmonics = np.ascontiguousarray((scipy.fft.fft(around, axis=-1) / count)[..., order]).view(np.float64)
        own = np.eye(nm.size)
        if nm.size < wavelength_nm.size:
            low, high = wavelength_nm[0], wavelength_nm[-1]
            own = interpolation(chebyshev(nm.size), (2.0 * wavelength_nm - low - high) / (high - low))
        return cls(
            f_number=lens.f_number,
            angle_rad=angle_rad,
            wavelength_nm=wavelength_nm,
            weights=weights,
            shifts=shifts,
            order=order,
            harmonics=product(own, harmonics.reshape(nm.size, -1)).reshape(-1, 2 * order.size),
        )

    def on(self, frequency_per_um: F64, theta: F64) -> C128:
        """Return transfers (sets, directions, frequencies)."""
        fused = self.harmonics_at(frequency_per_um)
        around = np.exp(1j * np.multiply.outer(theta - self.angle_rad, self.order))
        return np.stack([complex_product(around, own) for own in fused])

    def harmonics_at(self, frequency_per_um: F64) -> C128:
        """Return harmonics (sets, m, frequencies), wavelengths added up; kept for the next directions."""
        key = frequency_per_um.size, float(frequency_per_um[0]), float(frequency_per_um[-1])
        if key not in self._kept:
            scale_um = self.f_number * self.wavelength_nm / NM_PER_UM
            x, w = gauss_legendre(self.shifts.size)
            signs = (-1.0) ** np.arange(x.size) * np.sqrt((1.0 - x * x) * w)
            fused = np.empty((len(self.weights), frequency_per_um.size, self.order.size), complex)
            for first in range(0, frequency_per_um.size, AT_ONCE):
                part = slice(first, first + AT_ONCE)
                nu = np.multiply.outer(frequency_per_um[part], scale_um)
                at = np.zeros((*nu.shape, x.size))
                at[nu < 1.0] = barycentric(x, signs, np.arccos(nu[nu < 1.0]) / (0.25 * math.pi) - 1.0, same=1e-14)
                for own, weights in zip(fused, self.weights, strict=True):
                    # Two real numbers for a complex one, all wavelengths at once: one product of matrices.
                    own[part] = product((at * weights[:, None]).reshape(len(nu), -1), self.harmonics).view(complex)
            self._kept[key] = np.moveaxis(fused, 2, 1)
        return self._kept[key]

    @cached_property
    def _kept(self) -> dict[tuple[int, float, float], C128]:
        return {}
