"""Linear sRGB colours as reflectances, by three spectra that add up to white (Mallett and Yuksel 2019)."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np
from annotated_types import Ge, Le
from numpy.typing import NDArray

from camsim.core.arrays import F64, distinct
from camsim.core.typed import Number, check
from camsim.errors import InvalidValueError
from camsim.spectra.cached import cached
from camsim.spectra.colour_science import colour_science
from camsim.spectra.curve import Curve, Spectrum


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


@cached
def _primaries() -> tuple[list[float], list[list[float]]]:
    basis = colour_science().recovery.MSDS_BASIS_FUNCTIONS_sRGB_MALLETT2019
    return basis.wavelengths.tolist(), basis.values.T.tolist()


def reflectance_of_rgb(rgb: Sequence[float], name: str = "") -> Spectrum:
    """Return the reflectance of a linear sRGB colour, components from 0 to 1; a grey is flat: one number.

    It is smooth, never outside 0 to 1, and linear in the components: a picture is three planes of light times the
    basis. Constant outside 380 to 780 nm.

    >>> reflectance_of_rgb([0.5, 0.5, 0.5])
    0.5
    >>> reflectance_of_rgb([1.0, 0.0, 0.0]).at(np.array([450.0, 650.0])).round(3)
    array([0.012, 0.905])
    """
    red, green, blue = (float(part) for part in rgb)
    if not all(0.0 <= part <= 1.0 for part in (red, green, blue)):
        displayed = ", ".join(f"{part:g}" for part in (red, green, blue))
        raise InvalidValueError(
            f"components must be from 0 to 1, not ({displayed}); linear, white is (1, 1, 1)", key="rgb"
        )
    if red == green == blue:
        return red
    basis = rgb_basis()
    values = red * basis.values[0] + green * basis.values[1] + blue * basis.values[2]
    return Curve(tuple(basis.wavelength_nm.tolist()), tuple(np.clip(values, 0.0, 1.0).tolist()), name, "hold")


Encoding: TypeAlias = Literal["srgb", "linear"]
"""Encoding of colours: sRGB's curve, or linear."""

_ANY_ENCODING = Encoding | Annotated[float, Ge(0.1), Le(10)] | None
_DEPTHS = (255, 65_535)
_MANY_CODES, _LOOKED_AT = 32, 1 << 16


def linear_light(encoded: F64, encoding: Encoding | float) -> F64:
    """Return linear values; ``encoding`` may be an exponent such as 2.2.

    >>> linear_light(np.array([0.5]), "srgb").round(4), linear_light(np.array([0.5]), 2.0)
    (array([0.214]), array([0.25]))
    """
    if encoding == "srgb":
        return linear_of_srgb(encoded)
    linear: F64 = encoded if encoding == "linear" else np.sign(encoded) * np.abs(encoded) ** float(encoding)
    return linear


def linear_colours(
    samples: NDArray[Any],
    encoding: Encoding | Number | None,
    key: str = "",
    stage: str = "",
    *,
    of_codes: Encoding | float | None = None,
    largest: int | None = None,
) -> NDArray[np.floating]:
    """Return linear colours from 0 to 1; the largest code is 1.

    samples  : (rows, cols) or (rows, cols, 3)
    encoding : encoding of the numbers; None if not declared: then raises for values that are evidently not linear
    of_codes : encoding of integers if ``encoding`` is None;  largest: largest code, if less than that of their type

    Raises InvalidValueError, by ``key`` or "encoding", with what to give.
    """
    given = check(encoding, _ANY_ENCODING, "encoding", stage)
    if samples.dtype.kind not in "fui":
        raise InvalidValueError(f"must be numbers, not {samples.dtype}", key=key, stage=stage)
    if samples.dtype.kind in "ui":
        if samples.dtype.kind != "u" or samples.dtype.itemsize > 2:
            message = (
                f"its samples are {samples.dtype.name}, and nobody knows which of them is white; give uint8 or uint16 "
                "(in numpy .astype(np.uint8): white is 255), or floats from 0 to 1"
            )
            raise InvalidValueError(message, key=key, stage=stage)
        if given is None and of_codes is None:
            raise _asked(f"the samples are codes, {samples.dtype}", stage)
        # Lookup table of all values: a large picture needs no further memory.
        each = np.arange(np.iinfo(samples.dtype).max + 1) / (largest or np.iinfo(samples.dtype).max)
        linear: F64 = linear_light(each, given or of_codes or "srgb")[samples]
        return linear
    if given is None and (depth := depth_of_codes(samples)):
        raise _asked(f"the samples are all whole {depth}ths, as codes of {depth.bit_length()} bits are", stage)
    return samples if given in (None, "linear") else linear_light(np.asarray(samples, np.float64), given)


def _asked(what: str, stage: str) -> InvalidValueError:
    write = f"{stage}(…, encoding='srgb', width_um=…)" if stage else "encoding: srgb"
    message = (
        f"must be said: {what}, and those of pictures are not in proportion to light; write {write} for a PNG, a JPEG, "
        "what screens show, or 'linear' for what is light all the same"
    )
    return InvalidValueError(message, key="encoding", stage=stage)


def whole_codes(samples: NDArray[Any]) -> bool:
    """Whether floats are codes of a picture that were not divided by the largest code.

    >>> whole_codes(np.array([0.0, 255.0])), whole_codes(np.array([0.0, 1.0])), whole_codes(np.array([0, 255]))
    (True, False, False)
    """
    return samples.dtype.kind == "f" and bool(samples.max() > 2.0 and (samples == np.rint(samples)).all())


def depth_of_codes(samples: NDArray[np.floating]) -> int:
    """Return the largest code of which all numbers from 0 to 1 are fractions: 255, 65535, or 0 for neither.

    Computed or measured light has no such steps; divided codes of a picture have, and these are rarely linear. For few
    distinct numbers (masks, steps of a tenth) it is undecidable: 0.

    >>> depth_of_codes(np.arange(64) / 255), depth_of_codes(np.linspace(0, 1, 64)), depth_of_codes(np.eye(9))
    (255, 0, 0)
    """
    some = samples.reshape(-1)[:: max(1, samples.size // _LOOKED_AT)].astype(np.float64)
    for largest in _DEPTHS:
        codes = np.rint(some * largest)
        # In single precision the error of a number from 0 to 1 is 6e-8.
        if np.abs(some * largest - codes).max() <= 1.2e-7 * largest and distinct(codes).size > _MANY_CODES:
            return largest
    return 0


def linear_of_srgb(encoded: F64) -> F64:
    """Undo the sRGB curve of IEC 61966-2-1, from 0 to 1 to 0 to 1.

    >>> linear_of_srgb(np.array([0.0, 0.04045, 0.5, 1.0])).round(4)
    array([0.    , 0.0031, 0.214 , 1.    ])
    """
    encoded = np.asarray(encoded, np.float64)
    linear: F64 = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    return linear.round(12)  # last bits of powers differ between processors
