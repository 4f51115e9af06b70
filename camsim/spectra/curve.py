"""Curve: a tabulated spectrum, and Spectrum: a curve or one number for every wavelength."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np

from camsim.arrays import F64
from camsim.errors import InvalidValueError


@dataclass(frozen=True, slots=True)
class Curve:
    """A curve through tabulated points, straight in between.

    wavelength_nm : (n,) strictly increasing, at least two
    values        : (n,) finite, not negative; the unit is the user's affair (a reflectance, W/m²/nm, …)
    name          : what to call it in reports; two curves that differ in name only are not equal
    outside       : "zero", or "hold" to keep the first and the last value beyond the table

    >>> red = Curve((600.0, 700.0), (0.1, 0.8), outside="hold")
    >>> red.at(np.array([500.0, 650.0, 900.0]))
    array([0.1 , 0.45, 0.8 ])
    """

    wavelength_nm: tuple[float, ...]
    values: tuple[float, ...]
    name: str = ""
    outside: Literal["zero", "hold"] = "zero"

    def __post_init__(self) -> None:
        object.__setattr__(self, "wavelength_nm", tuple(float(w) for w in self.wavelength_nm))
        object.__setattr__(self, "values", tuple(float(v) for v in self.values))
        what = f"Curve {self.name!r}" if self.name else "Curve"
        if len(self.wavelength_nm) != len(self.values):
            raise InvalidValueError(
                f"{len(self.values)} for {len(self.wavelength_nm)} wavelengths; every point has one of each",
                key="values",
                stage=what,
            )
        if len(self.values) < 2:
            raise InvalidValueError(
                "a curve needs at least 2 points; write a number for a flat one", key="values", stage=what
            )
        for wavelength, value in zip(self.wavelength_nm, self.values, strict=True):
            if not (math.isfinite(wavelength) and wavelength > 0.0):
                raise InvalidValueError(f"{wavelength} nm; must be above 0 and finite", key="wavelength_nm", stage=what)
            if not (math.isfinite(value) and value >= 0.0):
                raise InvalidValueError(
                    f"{value} at {wavelength:g} nm; must be finite and not negative", key="values", stage=what
                )
        for before, after in pairwise(self.wavelength_nm):
            if after <= before:
                raise InvalidValueError(
                    f"{after:g} nm follows {before:g} nm; wavelengths must increase, each given once",
                    key="wavelength_nm",
                    stage=what,
                )
        if self.outside not in ("zero", "hold"):
            raise InvalidValueError(f"{self.outside!r}; must be 'zero' or 'hold'", key="outside", stage=what)

    def at(self, wavelength_nm: F64) -> F64:
        """Return the values at ``wavelength_nm`` (any shape)."""
        beyond = 0.0 if self.outside == "zero" else None
        values: F64 = np.interp(wavelength_nm, self.wavelength_nm, self.values, left=beyond, right=beyond)
        return values


Spectrum: TypeAlias = float | Curve


def spectrum_at(spectrum: Spectrum, wavelength_nm: F64) -> F64:
    """Return a spectrum's values at ``wavelength_nm``; a number is the same everywhere.

    >>> spectrum_at(0.18, np.array([450.0, 550.0]))
    array([0.18, 0.18])
    """
    if isinstance(spectrum, Curve):
        return spectrum.at(wavelength_nm)
    return np.full(np.shape(wavelength_nm), float(spectrum))
