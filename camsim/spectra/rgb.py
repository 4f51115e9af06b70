"""Linear sRGB colours as reflectances, by three spectra that add up to white (Mallett and Yuksel 2019)."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64
from camsim.errors import InvalidValueError
from camsim.spectra.colour_science import colour_science
from camsim.spectra.curve import Curve, Spectrum
from camsim.spectra.kept import kept


@dataclass(frozen=True, slots=True, eq=False)
class RgbBasis:
    """The reflectances of the three primaries.

    wavelength_nm : (81,) 380 to 780
    values        : (3, 81) of red, green and blue; they add up to 1 at every wavelength
    """

    wavelength_nm: F64
    values: F64


@functools.cache
def rgb_basis() -> RgbBasis:
    """Return the reflectances that have the colours of sRGB's primaries under D65, from colour-science.

    Of I. Mallett and C. Yuksel, "Spectral primary decomposition for rendering with sRGB reflectance" (EGSR 2019,
    doi:10.2312/sr.20191216). The published digits add up to 1 within 1e-5; here they are divided by their sum, so
    that greys are flat.

    >>> rgb_basis().values.shape, rgb_basis().wavelength_nm[[0, -1]].tolist()
    ((3, 81), [380.0, 780.0])
    """
    wavelength_nm, rows = _primaries()
    values = np.array(rows)
    return RgbBasis(wavelength_nm=np.array(wavelength_nm), values=values / values.sum(axis=0))


@kept
def _primaries() -> tuple[list[float], list[list[float]]]:
    basis = colour_science().recovery.MSDS_BASIS_FUNCTIONS_sRGB_MALLETT2019
    return basis.wavelengths.tolist(), basis.values.T.tolist()


def reflectance_of_rgb(rgb: Sequence[float], name: str = "") -> Spectrum:
    """Return the reflectance of a linear sRGB colour, components from 0 to 1; a grey is flat: one number.

    It is smooth, never outside 0 to 1, and linear in the components: a picture is three planes of light times the
    basis. Beyond 380 to 780 nm it goes on as it ends.

    >>> reflectance_of_rgb([0.5, 0.5, 0.5])
    0.5
    >>> reflectance_of_rgb([1.0, 0.0, 0.0]).at(np.array([450.0, 650.0])).round(3)
    array([0.012, 0.905])
    """
    red, green, blue = (float(part) for part in rgb)
    if not all(0.0 <= part <= 1.0 for part in (red, green, blue)):
        shown = ", ".join(f"{part:g}" for part in (red, green, blue))
        raise InvalidValueError(f"components must be from 0 to 1, not ({shown}); linear, white is (1, 1, 1)", key="rgb")
    if red == green == blue:
        return red
    basis = rgb_basis()
    values = red * basis.values[0] + green * basis.values[1] + blue * basis.values[2]
    return Curve(tuple(basis.wavelength_nm.tolist()), tuple(np.clip(values, 0.0, 1.0).tolist()), name, "hold")


def linear_of_srgb(encoded: F64) -> F64:
    """Undo the sRGB curve of IEC 61966-2-1, from 0 to 1 to 0 to 1.

    >>> linear_of_srgb(np.array([0.0, 0.04045, 0.5, 1.0])).round(4)
    array([0.    , 0.0031, 0.214 , 1.    ])
    """
    encoded = np.asarray(encoded, np.float64)
    linear: F64 = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    return linear.round(12)  # powers end on another bit on another processor
