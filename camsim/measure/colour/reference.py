"""Reference colours of reflectances in a light, and expected responses of the camera's channels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camsim.camera.capture import Capture
from camsim.core.arrays import F64
from camsim.errors import UnsupportedError
from camsim.sensor.colour_matrix import XYZ_D50, adaptation, observer
from camsim.spectra.curve import Spectrum, spectrum_at
from camsim.spectra.light import Light, LightSamples


def reference_xyz(light: Light, reflectances: Sequence[Spectrum]) -> F64:
    """Return (n, 3) XYZ in a light, adapted from its white to D50 (Bradford); white has Y = 1."""
    samples = light.samples(reflectances, observer())
    power = _power(light, samples)
    white = power.sum(axis=1)
    surfaces = np.array([spectrum_at(surface, samples.wavelength_nm) for surface in reflectances])
    xyz = np.einsum("kn,rn->rk", power, surfaces) / white[1]
    adapted: F64 = np.einsum("sk,rk->rs", adaptation(white / white[1], XYZ_D50), xyz)
    return adapted


def white_of(light: Light) -> F64:
    """Return (3,) XYZ of a perfect diffuser in a light, Y = 1."""
    white = _power(light, light.samples(observer())).sum(axis=1)
    xyz: F64 = white / white[1]
    return xyz


def _power(light: Light, samples: LightSamples) -> F64:
    seen = np.array([curve.at(samples.wavelength_nm) for curve in observer()])
    power: F64 = seen * samples.irradiance_w_per_m2_nm * samples.weight_nm
    if not power[1].sum() > 0.0:
        raise UnsupportedError(
            f"the eye sees nothing of the light, {light.name}; there is no colour to compare with", key="light"
        )
    return power


def expected_channels(capture: Capture, reflectances: Sequence[Spectrum]) -> F64:
    """Return (n, channels) balanced responses of the camera to reflectances; 1 for a perfect diffuser."""
    response = capture.camera.colour_response(capture.light, capture.colour_matrix)
    samples, electrons = response.to(capture.light, reflectances)
    surfaces = np.array([spectrum_at(surface, samples.wavelength_nm) for surface in reflectances])
    balanced: F64 = np.einsum("kn,rn->rk", electrons, surfaces) / electrons.sum(axis=1)
    return balanced
