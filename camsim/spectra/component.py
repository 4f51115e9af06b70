"""A spectral component: the contribution of one plane of a picture, which may be negative."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import F64
from camsim.spectra.curve import Curve, Spectrum


@dataclass(frozen=True, slots=True, eq=False)
class Component:
    """A curve of any sign through tabulated points, piecewise linear; constant outside.

    wavelength_nm, values : (n,)
    """

    wavelength_nm: F64
    values: F64

    @classmethod
    def less(cls, spectrum: Spectrum) -> Component:
        """Return the negative of a reflectance."""
        if isinstance(spectrum, Curve):
            return cls(np.array(spectrum.wavelength_nm, float), -np.array(spectrum.values, float))
        return cls(np.array([1.0]), np.array([-float(spectrum)]))

    def at(self, wavelength_nm: F64) -> F64:
        """Return the values at ``wavelength_nm`` (any shape)."""
        values: F64 = np.interp(wavelength_nm, self.wavelength_nm, self.values)
        return values

    @property
    def size(self) -> Spectrum:
        """The absolute value of the curve, with the same kinks."""
        if self.values.size == 1:
            return abs(float(self.values[0]))
        return Curve(tuple(self.wavelength_nm.tolist()), tuple(np.abs(self.values).tolist()), outside="hold")
