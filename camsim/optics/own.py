"""What a camera asks of optical stages of one's own before it takes one in."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from camsim.errors import CamsimError
from camsim.optics.protocols import OpticalStage
from camsim.own import check_described, is_own, refused

_FREQUENCIES = np.array([[0.0, 0.0], [0.11, 0.03], [-0.11, -0.03], [0.02, -0.4], [-0.02, 0.4]]).T
"""Cycles/µm: at none, and two with their opposites."""

_WAVELENGTH_NM, _ROUNDING = 550.0, 1e-9


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
    fx, fy = _FREQUENCIES
    try:
        otf: Any = np.asarray(stage.otf(fx.copy(), fy.copy(), _WAVELENGTH_NM))
    except CamsimError:
        raise
    except Exception as error:
        raise refused(key, f"{name}.otf(fx_per_um, fy_per_um, wavelength_nm) failed: {error!r}") from error
    if otf.shape != fx.shape:
        raise refused(key, f"{name}.otf gives shape {otf.shape} for frequencies of shape {fx.shape}; give as many")
    if not np.isfinite(otf).all():
        raise refused(key, f"{name}.otf is not finite everywhere; at frequency 0 too it must be a number")
    if abs(otf[0] - 1.0) > _ROUNDING:
        raise refused(
            key, f"{name}.otf is {otf[0]:.6g} at frequency 0; it must be 1; light that is lost is transmission"
        )
    if np.abs(otf).max() > 1.0 + _ROUNDING:
        raise refused(key, f"{name}.otf is {np.abs(otf).max():.6g} at some frequency; no blur amplifies, at most 1")
    if np.abs(otf[1::2] - otf[2::2].conj()).max() > _ROUNDING:
        raise refused(key, f"{name}.otf(−f) must be the conjugate of otf(f); else the picture would not be real")
