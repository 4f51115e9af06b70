"""Columns of the manifest that are measured on the frame itself."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

from camsim.api import Exposed
from camsim.camera.frame import Frame
from camsim.camera.shot import Shot
from camsim.errors import UnsupportedError
from camsim.measure import CameraOtf, measure_mtf, picture_of_frame
from camsim.measure.target.moire import measure_moire
from camsim.sensor.adc import full_codes

_OF_A_MEDIAN = math.sqrt(math.pi / 2.0)
_CLEAR = 5.0  # standard deviations from either end of the codes


Columns: TypeAlias = tuple[dict[str, Any], list[str]]
"""Measured columns, and reasons for missing ones."""


def measured(frame: Frame, capture: Exposed, what: Sequence[str]) -> Columns:
    """Return the columns that ``what`` asks for: ``mtf`` of edges, ``moire`` of a zone plate, ``noise``, ``signal``."""
    columns: dict[str, Any] = {}
    said: list[str] = []
    if "signal" in what:
        columns |= _signal(frame)
    for name, measure in (("noise", _noise), ("mtf", _mtf), ("moire", _moire)):
        if name in what:
            try:
                more, why = measure(frame, capture)
            except UnsupportedError as error:
                more, why = {}, [f"{name}: {error}"]
            columns |= more
            said += why
    return columns, said


def _signal(frame: Frame) -> dict[str, Any]:
    """Mean light, mean data number and its scatter, and the share that is clipped, of each channel."""
    columns: dict[str, Any] = {}
    codes = frame.linear_dn.astype(float)
    for number, signal in enumerate(frame.report.signal):
        one = codes[frame.channel_index == number]
        columns |= {
            f"mean_{signal.name}_e": signal.mean_e,
            f"mean_{signal.name}_dn": signal.mean_dn,
            f"std_{signal.name}_dn": float(np.std(one)) if one.size else None,
            f"clipped_{signal.name}": signal.clipped_photosites / max(signal.photosites, 1),
        }
    return columns


def _noise(frame: Frame, capture: Exposed) -> Columns:
    """Scatter of each channel's codes about the noise-free signal, in electrons, and the mean over it.

    Over photosites with means far enough from both ends of the codes to be unclipped: a noise-independent selection.
    Fixed patterns count as noise, as one frame cannot separate them.
    """
    gain, bends, adc = frame.electrons_per_dn, capture.camera.nonlinearity, capture.camera.converter
    offsets_dn = adc.offsets_dn(frame.shape, capture.grid.origin)
    black = frame.black_level_dn + offsets_dn
    # Black offsets reduce the range of some photosites.
    room_dn = full_codes(frame.white_level_dn, offsets_dn, adc.largest_dn) - black
    rooms, which = np.unique(room_dn / (frame.white_level_dn - frame.black_level_dn), return_inverse=True)
    full_e = np.array([capture.camera.charge_at_e(float(share), frame.iso) for share in rooms])[which]
    charge = frame.mean_electrons + capture.dark_e
    signal = charge if bends is None else bends.response(charge)
    off = frame.signal_e - signal
    even_e = math.hypot(frame.read_noise_e, *(getattr(stage, "sigma_e", 0.0) for stage in capture.electronics))
    uneven = capture.camera.prnu.fraction if capture.camera.prnu else 0.0
    clear = _CLEAR * np.sqrt(charge + even_e**2 + np.square(uneven * charge)) + gain
    whole = (charge + clear < full_e.reshape(frame.shape)) & (black * gain + signal > clear)
    columns: dict[str, Any] = {}
    said: list[str] = []
    for number, name in enumerate(frame.channels):
        there = frame.channel_index == number
        one = whole & there
        noise = float(np.std(off[one])) if np.any(one) else math.nan
        columns[f"noise_{name}_e"] = noise if math.isfinite(noise) else None
        columns[f"snr_{name}"] = float(np.mean(frame.mean_electrons[one])) / noise if noise > 0.0 else None
        if np.any(there) and not np.any(one):
            said.append(f"noise: codes of {name} are cut at white or at 0")
    return columns, said


def _mtf(frame: Frame, capture: Exposed) -> Columns:
    """MTF50 and MTF at Nyquist of each channel, the median of its edges, with standard errors and theory.

    A median's standard error is that of a mean times √(π/2); for one or two edges, that of their mean.
    """
    if isinstance(capture, Shot):
        raise UnsupportedError("passed no lens with a known transfer", stage="light on a sensor")
    edges = measure_mtf(picture_of_frame(frame), channel="all", theory=CameraOtf.of(capture)).edges
    columns: dict[str, Any] = {}
    said: list[str] = []
    per_mm = 1e3 / capture.camera.pitch_um
    for channel in dict.fromkeys(edge.channel for edge in edges):
        one = [edge for edge in edges if edge.channel == channel]
        for name in ("mtf50_cycles_per_pixel", "mtf_at_nyquist"):
            pairs = [(getattr(edge.figures, name), getattr(edge.standard_error, name)) for edge in one]
            pairs = [(value, error) for value, error in pairs if math.isfinite(value)]
            columns[f"{name}_{channel}"] = float(np.median([value for value, _ in pairs])) if pairs else None
            error = math.hypot(*(error for _, error in pairs)) / max(len(pairs), 1)
            error *= 1.0 if len(pairs) < 3 else _OF_A_MEDIAN
            columns[f"{name}_{channel}_error"] = error if pairs and math.isfinite(error) else None
        mtf50 = columns[f"mtf50_cycles_per_pixel_{channel}"]
        columns[f"mtf50_lp_per_mm_{channel}"] = None if mtf50 is None else mtf50 * per_mm
        theory = [edge.theory.mtf50_cycles_per_pixel for edge in one if edge.theory is not None]
        theory = [value for value in theory if math.isfinite(value)]
        columns[f"mtf50_cycles_per_pixel_{channel}_theory"] = float(np.median(theory)) if theory else None
        columns[f"edges_{channel}"] = len(one)
        if mtf50 is None:
            said.append(f"mtf: {channel} does not fall to 50 % where it is measured")
    return columns, said


def _moire(frame: Frame, capture: Exposed) -> Columns:
    """Moiré of each channel that lies on one lattice: the contrast of a zone plate's ghosts, and theory."""
    if isinstance(capture, Shot):
        raise UnsupportedError("has no zone plate", stage="light on a sensor")
    report = measure_moire(picture_of_frame(frame), capture)
    columns: dict[str, Any] = {}
    for channel in dict.fromkeys(ghost.channel for ghost in report.ghosts):
        one = [ghost.theory for ghost in report.ghosts if ghost.channel == channel]
        columns[f"moire_{channel}"] = report.moire(channel)
        columns[f"moire_{channel}_theory"] = float(np.sqrt(np.mean(np.square(one))))
    return columns, []
