"""How a camera's channels see light: what its colour matrices are made from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camsim.sensor.colour_matrix import ColourResponse, MatrixOf
from camsim.sensor.quantum_efficiency import QuantumEfficiency
from camsim.spectra.curve import Spectrum, spectrum_at
from camsim.spectra.light import LightSamples


def colour_response(
    quantum_efficiency: QuantumEfficiency, samples: LightSamples, *, passes: Sequence[Spectrum], matrix: MatrixOf
) -> ColourResponse:
    """Return the channels' response over the visible; not per photon but per energy, hence × λ.

    passes : what the light goes through on its way, fractions (lens, filters); all of them multiply
    """
    wavelength_nm = np.arange(360.0, 831.0)
    sensitivity = quantum_efficiency.at(wavelength_nm) * wavelength_nm
    for spectrum in passes:
        sensitivity = sensitivity * spectrum_at(spectrum, wavelength_nm)
    if samples.wavelength_nm.size == 1:
        light = (np.abs(wavelength_nm - samples.wavelength_nm[0]) <= 0.5).astype(float)
    else:
        light = np.interp(wavelength_nm, samples.wavelength_nm, samples.irradiance_w_per_m2_nm, left=0.0, right=0.0)
    return ColourResponse(
        channels=quantum_efficiency.channels,
        wavelength_nm=wavelength_nm,
        sensitivity=sensitivity,
        light=light,
        matrix=matrix,
    )
