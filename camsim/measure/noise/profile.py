"""What a camera's own numbers say that its flats and darks must show."""

from __future__ import annotations

import math

import numpy as np

from camsim.arrays import F64
from camsim.camera import Camera
from camsim.measure.noise.taking import DARK_TIMES_S, LEVELS, TIME_S
from camsim.spectra.light import Light


def expected_of(
    camera: Camera, channel: str, *, iso: float | None = None, temperature_c: float | None = None
) -> dict[str, float]:
    """Return the figures of ``PhotonTransfer`` by sums of a profile's numbers; NaN where it has none.

    channel : G1 and G2 are G
    iso, temperature_c : as the frames were taken
    """
    letter = channel if channel in camera.cfa.channels else channel.rstrip("0123456789")
    iso = camera.adc.base_iso if iso is None else iso
    dark = camera.dark_current
    dark_e_per_s = dark.e_per_s * dark.warming(temperature_c) if dark else 0.0
    dcnu_e = dark_e_per_s * dark.nonuniformity * TIME_S if dark else 0.0
    gain = camera.adc.electrons_per_dn_at(iso)
    offsets = (camera.dsnu.sigma_e if camera.dsnu else 0.0, camera.column_noise.sigma_e if camera.column_noise else 0.0)
    return {
        "gain_dn_per_e": 1.0 / gain,
        "read_noise_e": math.sqrt(camera.dark_noise_e(iso) ** 2 + dark_e_per_s * DARK_TIMES_S[0]),
        "full_well_e": camera.well_as_read_e(iso) or math.nan,
        "dark_current_e_per_s": dark_e_per_s,
        "dsnu_e": math.hypot(*offsets, dcnu_e, float(np.std(np.array(camera.adc.black_offsets_dn))) * gain),
        "prnu": _pattern(camera, letter),
        "linearity_error": _bend(camera),
    }


def _pattern(camera: Camera, letter: str) -> float:
    """PRNU as a flat shows it: crosstalk mixes gains that know nothing of one another, and light of other colours."""
    fraction = camera.prnu.fraction if camera.prnu else 0.0
    if camera.crosstalk is None:
        return fraction
    light = Light("E", irradiance_w_per_m2=1.0, at="sensor")
    signal_e = dict(zip(camera.cfa.channels, camera.diffuser_electrons(light, TIME_S).tolist(), strict=True))
    pattern = np.tile(np.array([[signal_e[c] for c in row] for row in camera.cfa.pattern]), (3, 3))
    mixed, squares = np.zeros_like(pattern), np.zeros_like(pattern)
    for i, row in enumerate(camera.crosstalk.kernel):
        for j, share in enumerate(row):
            part = share * np.roll(pattern, (i - 1, j - 1), axis=(0, 1))
            mixed += part
            squares += part**2
    here = np.tile(np.array([list(row) for row in camera.cfa.pattern]) == letter, (3, 3))
    return float(math.sqrt(fraction**2 * squares[here].mean() + mixed[here].var()) / mixed[here].mean())


def _bend(camera: Camera) -> float:
    """Return the linearity error of the profile's response itself."""
    if camera.nonlinearity is None:
        return 0.0
    well = camera.full_well.capacity_e if camera.full_well else 0.0
    exposure: F64 = np.array([level for level in LEVELS if 0.05 <= level <= 0.95]) * well
    signal = camera.nonlinearity.response(exposure)
    line = np.polynomial.Polynomial.fit(exposure, signal, 1, w=1.0 / signal)
    return float(np.mean(np.abs(signal / line(exposure) - 1.0)))
