"""Validation of custom optical stages when a camera is constructed."""

from __future__ import annotations

import dataclasses
import types
from typing import Any

import numpy as np

from camsim.core.arrays import F64, distinct
from camsim.core.custom import check_described, is_custom, refused
from camsim.core.typed import NonNegative, Positive, check
from camsim.core.words import both, displayed
from camsim.errors import CamsimError, InvalidValueError
from camsim.numerics.quadrature import GOLDEN
from camsim.optics.protocols import Illuminates, KnowsOpening, OpticalStage, PhotositeShape, Varies
from camsim.spectra.curve import Transmission

_WAVELENGTH_NM, _HIGHEST_PER_UM, _ROUNDING = 550.0, 0.4, 1e-9
_PLACES, _COLOURS = 32, 32  # frequencies in a half plane, and wavelengths, that are tested
_BESIDES = {"opening", "illumination"}  # capabilities that are independent of all others
_NAMED = 4  # names in a message
_NEAR, _FALLS = 1e-6, 0.01  # fraction of the highest frequency at which a transfer has fallen by less than this


def check_custom(stage: OpticalStage, key: str) -> None:
    """Refuse a custom stage that files cannot describe, or with an impossible transfer.

    key : parameter of the camera
    """
    if not is_custom(stage):
        return
    name = type(stage).__name__
    check_described(stage, key)
    fields: Any = stage
    if key == "lens" and "f_number" not in {field.name for field in dataclasses.fields(fields)}:
        raise refused(key, f"{name}.f_number must be a field; a magnification changes it")
    check_transfer(stage, key, np.array([_WAVELENGTH_NM]))


def check_blur(stage: OpticalStage) -> None:
    """Refuse as an additional blur a stage that varies over the frame or has a transmission."""
    name = type(stage).__name__
    if isinstance(stage, Varies):
        raise refused("extra_optics", f"{name} changes over the frame, which only a lens can; give it as lens")
    if getattr(stage, "transmission", 1.0) != 1.0:
        message = f"{name}.transmission takes no light from a blur besides the lens; leave it 1, and give a filter"
        raise refused("extra_optics", message)


def check_extent(photosite: PhotositeShape) -> None:
    """Refuse a custom photosite with an invalid area or extent."""
    name = type(photosite).__name__
    area_um2 = check(photosite.area_um2, NonNegative, "area_um2", name)
    half_um = check(photosite.half_extent_um, tuple[NonNegative, NonNegative], "half_extent_um", name)
    if area_um2 > 4.0 * half_um[0] * half_um[1] * (1.0 + _ROUNDING):
        message = f"{area_um2:g} µm², and what reaches {half_um[0]:g} × {half_um[1]:g} µm from its centre has less"
        raise InvalidValueError(message, key="area_um2", stage=name)


def settled(lens: Any, farthest_um: float) -> Any:
    """Return a custom lens, validated, with its transmission in standard form.

    farthest_um : largest distance of the frame from the axis
    """
    name = type(lens).__name__
    if isinstance(lens, KnowsOpening):
        check(lens.opening, Positive, "opening", name)
    if isinstance(lens, Illuminates):
        _check_illumination(lens, farthest_um)
    transmission = check(lens.transmission, Transmission, "transmission", name)
    if transmission is lens.transmission:
        return lens
    if "transmission" in {field.name for field in dataclasses.fields(lens) if field.init}:
        return dataclasses.replace(lens, transmission=transmission)
    if isinstance(lens.transmission, int):
        return lens
    form = "a float" if isinstance(transmission, float) else "a held curve"
    message = f"is no field, so that it cannot be kept as {form}; give it so"
    raise InvalidValueError(message, key="transmission", stage=name)


def _check_illumination(lens: Illuminates, farthest_um: float) -> None:
    radius_um = farthest_um * np.linspace(0.0, 1.0, 6).reshape(2, 3)
    light: Any = lens.illumination(radius_um)
    if not isinstance(light, np.ndarray) or light.shape != radius_um.shape or light.dtype.kind not in "fiu":
        message = f"gives {displayed(light)} for distances of shape {radius_um.shape}; give an array of as many numbers"
    elif not (np.isfinite(light).all() and light.min() >= 0.0):
        message = f"is not finite, or below 0, somewhere between the axis and {farthest_um:g} µm from it"
    elif abs(light[0, 0] - 1.0) > _ROUNDING:
        message = f"is {light[0, 0]:g} on the axis; it is relative to that, 1 there; light that is lost is transmission"
    else:
        return
    raise InvalidValueError(message, key="illumination", stage=type(lens).__name__)


def check_transfer(stage: OpticalStage, key: str, wavelength_nm: F64, highest_per_um: float = _HIGHEST_PER_UM) -> None:
    """Refuse a custom stage with an impossible transfer, tested at some of these wavelengths.

    highest_per_um : highest frequency of the test
    """
    if not is_custom(stage):
        return
    _check_inherited(stage, key)
    some = distinct(np.linspace(0, wavelength_nm.size - 1, _COLOURS).round().astype(int))
    for nm in wavelength_nm[some].tolist():
        _check_at(stage, key, nm, highest_per_um)


def _check_inherited(stage: OpticalStage, key: str) -> None:
    """Refuse a subclass of camsim's stage that overrides some capabilities, such as ``otf``, but inherits others."""
    classes = [kind for kind in type(stage).__mro__ if kind is not object and not getattr(kind, "_is_protocol", False)]
    one = {name for kind in classes if not _of_camsim(kind) for name in vars(kind)}
    theirs = [kind for kind in classes if _of_camsim(kind)]
    verbs = {
        name
        for kind in theirs
        for name, member in vars(kind).items()
        if not name.startswith("_") and isinstance(member, types.FunctionType | property)
    }
    overridden, inherited = sorted(one & verbs - _BESIDES), sorted(verbs - one - _BESIDES)
    inherited = inherited if len(inherited) <= _NAMED else [*inherited[:_NAMED], "more"]
    if overridden and inherited:
        name, base = type(stage).__name__, theirs[0].__name__
        message = f"{name} has its own {both(overridden)}, and {both(inherited)} of the {base} that it inherits from"
        raise refused(key, f"{message}; write a dataclass that holds one instead, and says only what it knows")


def _of_camsim(kind: type) -> bool:
    return kind.__module__.partition(".")[0] == "camsim"


def disc_of_frequencies(highest_per_um: float) -> tuple[F64, F64]:
    """Return test frequencies, cycles/µm: zero, one near zero and some over a disc, each followed by its opposite."""
    size = np.append(_NEAR, np.sqrt((np.arange(_PLACES) + 0.5) / _PLACES)) * highest_per_um
    angle = np.pi * (GOLDEN * np.arange(_PLACES + 1) % 1.0)
    half = np.stack([size * np.cos(angle), size * np.sin(angle)])
    fx, fy = np.concatenate([np.zeros((2, 1)), np.stack([half, -half], axis=2).reshape(2, -1)], axis=1)
    return fx, fy


def _check_at(stage: OpticalStage, key: str, wavelength_nm: float, highest_per_um: float) -> None:
    name = type(stage).__name__
    fx, fy = disc_of_frequencies(highest_per_um)
    given = fx.view(), fy.view()
    for part in given:
        part.flags.writeable = False
    try:
        otf: Any = np.asarray(stage.otf(*given, wavelength_nm))
    except CamsimError:
        raise
    except Exception as error:
        if "read-only" in str(error):
            message = f"{name}.otf writes into the frequencies that it is given; work on others, such as fx_per_um * …"
            raise refused(key, message) from error
        raise refused(key, f"{name}.otf(fx_per_um, fy_per_um, wavelength_nm) failed: {error!r}") from error
    if otf.shape != fx.shape:
        raise refused(key, f"{name}.otf gives shape {otf.shape} for frequencies of shape {fx.shape}; give as many")
    if otf.dtype.kind not in "fciu":
        raise refused(key, f"{name}.otf gives {otf.dtype.name}; give numbers")
    if not np.isfinite(otf).all():
        at = f"at {wavelength_nm:g} nm; at frequency 0 too it must be a number"
        raise refused(key, f"{name}.otf is not finite everywhere {at}")
    if abs(otf[0] - 1.0) > _ROUNDING:
        raise refused(
            key, f"{name}.otf is {otf[0]:.6g} at frequency 0; it must be 1; light that is lost is transmission"
        )
    if abs(otf[1] - 1.0) > _FALLS:
        raise refused(
            key, f"{name}.otf is {otf[1]:.6g} next to frequency 0, and 1 there; a pattern of some size has no such step"
        )
    if np.abs(otf).max() > 1.0 + _ROUNDING:
        raise refused(key, f"{name}.otf is {np.abs(otf).max():.6g} at some frequency; no blur amplifies, at most 1")
    if np.abs(otf[1::2] - otf[2::2].conj()).max() > _ROUNDING:
        raise refused(key, f"{name}.otf(−f) must be the conjugate of otf(f); else the picture would not be real")
