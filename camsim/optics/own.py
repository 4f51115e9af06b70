"""What a camera asks of optical stages of one's own before it takes one in."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from camsim.arrays import F64
from camsim.errors import CamsimError
from camsim.optics.protocols import OpticalStage
from camsim.own import check_described, is_own, refused
from camsim.quadrature import GOLDEN

_WAVELENGTH_NM, _HIGHEST_PER_UM, _ROUNDING = 550.0, 0.4, 1e-9
_PLACES, _COLOURS = 32, 32  # frequencies in half of the plane, and wavelengths, that are looked at
_NEAR, _FALLS = 1e-6, 0.01  # of the highest frequency, at which a transfer has not fallen by so much


def check_own(stage: OpticalStage, key: str) -> None:
    """Refuse a stage of one's own that files could not describe, or whose transfer no stage can have.

    key : the camera's
    """
    if not is_own(stage):
        return
    name = type(stage).__name__
    check_described(stage, key)
    fields: Any = stage
    if key == "lens" and "f_number" not in {field.name for field in dataclasses.fields(fields)}:
        raise refused(key, f"{name}.f_number must be a field; a magnification changes it")
    check_transfer(stage, key, np.array([_WAVELENGTH_NM]))


def check_transfer(stage: OpticalStage, key: str, wavelength_nm: F64, highest_per_um: float = _HIGHEST_PER_UM) -> None:
    """Refuse a stage of one's own whose transfer no stage can have, at some of these wavelengths.

    highest_per_um : frequencies are looked at up to there
    """
    if not is_own(stage):
        return
    some = np.unique(np.linspace(0, wavelength_nm.size - 1, _COLOURS).round().astype(int))
    for nm in wavelength_nm[some].tolist():
        _check_at(stage, key, nm, highest_per_um)


def _check_at(stage: OpticalStage, key: str, wavelength_nm: float, highest_per_um: float) -> None:
    name = type(stage).__name__
    # None, next to none, and evenly over half of a disc, each with its opposite.
    size = np.append(_NEAR, np.sqrt((np.arange(_PLACES) + 0.5) / _PLACES)) * highest_per_um
    angle = np.pi * (GOLDEN * np.arange(_PLACES + 1) % 1.0)
    half = np.stack([size * np.cos(angle), size * np.sin(angle)])
    fx, fy = np.concatenate([np.zeros((2, 1)), np.stack([half, -half], axis=2).reshape(2, -1)], axis=1)
    try:
        otf: Any = np.asarray(stage.otf(fx.copy(), fy.copy(), wavelength_nm))
    except CamsimError:
        raise
    except Exception as error:
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
