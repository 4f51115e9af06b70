"""Stiff and extreme cases of the sensor: right, clipped where it should be, or refused; never negative, wrapped or NaN.

The truth is what must come out by arithmetic on paper: a code, a count, the moments of a Poisson distribution. Where
noise decides, ``asked`` is five standard errors of the estimate.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from bench.extremes.judging import ExtremeCase, Outcome, refused
from camsim.camera.camera import Camera
from camsim.core.arrays import F64
from camsim.optics import Airy
from camsim.sensor.adc import Adc
from camsim.sensor.chain import record
from camsim.sensor.electronics import Electronics
from camsim.sensor.exposure import Exposure
from camsim.sensor.stage import Context
from camsim.sensor.stages.dark_current import DarkCurrent
from camsim.sensor.stages.full_well import FullWell
from camsim.sensor.stages.read_noise import ReadNoise
from camsim.spectra.light import Light

SIDE = 500
SIGMAS = 5.0
ADC = Adc(bit_depth=12, black_level_dn=64, electrons_per_dn=2.0, base_iso=100.0)


def flat(mean_e: float, time_s: float = 1.0, temperature_c: float | None = None, **stages: Any) -> F64:
    """Return what a flat field of 500 × 500 photosites records."""
    here = Context(
        time_s=time_s,
        temperature_c=temperature_c,
        seed=1,
        serial=1,
        origin=(0, 0),
        frame_cols=SIDE,
        rows_in_all=SIDE,
    )
    return record(np.full((SIDE, SIDE), mean_e), Electronics(**stages).stages, here)


def _case(name: str, words: str, off_by: Callable[[], float], allowed: float, truth: str) -> ExtremeCase:
    """Return a case that measures by how much the result is off."""

    def run() -> Outcome:
        begin = time.perf_counter()
        reached = off_by()
        seconds = time.perf_counter() - begin
        verdict = "right" if reached <= allowed else "wrong"  # NaN is wrong
        return Outcome(reached=reached, asked=allowed, seconds=seconds, verdict=verdict, truth=truth)

    return ExtremeCase(name=f"sensor: {name}", input=words, run=run)


def _farthest(values: F64 | np.ndarray, wanted: float) -> float:
    """Return how far the farthest value is off; infinity where one is not finite."""
    off = np.abs(np.asarray(values, float) - wanted)
    return float(off.max()) if np.isfinite(off).all() else math.inf


def _codes(electrons: F64 | list[float], adc: Adc = ADC, iso: float = 100.0) -> np.ndarray:
    return adc.quantise(np.asarray(electrons, float), iso=iso)


def _no_light() -> float:
    return _farthest(_codes(flat(0.0)), ADC.black_level_dn)


def _hardly_light() -> float:
    return abs(float(np.mean(flat(1e-3) > 0.0)) - (1.0 - math.exp(-1e-3)))


def _blinding() -> float:
    return abs(float(flat(1e9).mean()) / 1e9 - 1.0)


def _full() -> float:
    return _farthest(_codes(flat(1e9, full_well=FullWell(2000.0))), ADC.black_level_dn + 1000)


def _poisson() -> float:
    recorded = flat(100.0, read_noise=ReadNoise(0.0))
    return abs(float(recorded.var() / recorded.mean()) - 1.0)


def _one_electron() -> float:
    recorded = flat(100.0, full_well=FullWell(1.0))
    return _farthest(recorded, 1.0)


def _one_bit() -> float:
    adc = Adc(bit_depth=1, black_level_dn=0, electrons_per_dn=10.0, base_iso=100.0)
    return _farthest(_codes([-1e9, 0.0, 4.9, 5.1, 1e9], adc) - np.array([0, 0, 0, 1, 1]), 0.0)


def _sixteen_bits() -> float:
    adc = Adc(bit_depth=16, black_level_dn=65534, electrons_per_dn=1.0, base_iso=100.0)
    return _farthest(_codes([-1e12, 0.0, 1.0, 2.0, 1e300], adc) - np.array([0.0, 65534, 65535, 65535, 65535]), 0.0)


def _gain() -> float:
    adc = Adc(bit_depth=14, black_level_dn=100, electrons_per_dn=1e-9, base_iso=100.0)
    return _farthest(_codes([-1.0, 0.0, 1.0, 1e9], adc, 1e6) - np.array([0, 100, 16383, 16383]), 0.0)


def _short() -> float:
    camera = Camera.from_yaml("d40-like", lens=Airy(f_number=8.0))
    light = Light("D55", illuminance_lux=5000.0)
    second, micro = (camera.diffuser_electrons(light, t) for t in (1.0, 1e-6))
    return _farthest(micro / second * 1e6, 1.0)


def _long() -> float:
    recorded = flat(0.0, dark_current=DarkCurrent(0.5), time_s=3600.0)
    return abs(float(recorded.mean()) - 1800.0)


def _temperature(temperature_c: float) -> Callable[[], float]:
    def run() -> float:
        # Doubling every 6 °C: so many halvings and doublings from 20 °C, counted by hand.
        doublings = {-40.0: -10, 80.0: 10}[temperature_c]
        recorded = flat(
            0.0,
            dark_current=DarkCurrent(64.0, at_c=20.0, doubling_c=6.0),
            temperature_c=temperature_c,
            time_s=10.0,
        )
        return abs(float(recorded.mean()) - 640.0 * 2.0**doublings)

    return run


def _seventeen_bits() -> Adc:
    return Adc(bit_depth=17, black_level_dn=0, electrons_per_dn=1.0, base_iso=100.0)


def _poisson_sigmas(mean_e: float) -> float:
    """Return five standard errors of the mean of a Poisson field."""
    return SIGMAS * math.sqrt(mean_e) / SIDE


def cases() -> tuple[ExtremeCase, ...]:
    """Return every case."""
    code, moments = "codes on paper", "Poisson's moments"
    return (
        _case("no light", "0 photons", _no_light, 0.0, code),
        _case("hardly light", "0.001 electrons a photosite", _hardly_light, _poisson_sigmas(1e-3), "exp(−0.001)"),
        _case("blinding light", "1e9 electrons, no full well", _blinding, _poisson_sigmas(1e9) / 1e9, moments),
        _case("full wells", "1e9 electrons into wells of 2000", _full, 0.0, code),
        _case("no read noise", "100 electrons: variance over mean", _poisson, SIGMAS * math.sqrt(2.0) / SIDE, moments),
        _case("full well of 1 e⁻", "100 electrons into it", _one_electron, 0.0, "one electron"),
        _case("1 bit", "below, at and above its only step", _one_bit, 0.0, code),
        _case("16 bits", "black one code below white", _sixteen_bits, 0.0, code),
        _case("gain beyond the converter", "1e13 codes per electron at ISO 1e6", _gain, 0.0, code),
        _case("1 µs", "against a second of the same light", _short, 1e-12, "proportion"),
        _case("1 h", "half an electron of dark current a second", _long, _poisson_sigmas(1800.0), "1800 electrons"),
        _case(
            "−40 °C",
            "dark current that doubles every 6 °C",
            _temperature(-40.0),
            _poisson_sigmas(0.625),
            "640/1024 electrons",
        ),
        _case(
            "+80 °C",
            "dark current that doubles every 6 °C",
            _temperature(80.0),
            _poisson_sigmas(655360.0),
            "640 · 1024 electrons",
        ),
        refused(
            "sensor: −300 °C", "below absolute zero", lambda: Exposure(time_s=1.0, iso=100.0, temperature_c=-300.0)
        ),
        refused("sensor: 17 bits", "more than a code holds", _seventeen_bits),
        refused("sensor: a negative full well", "−1 electron", lambda: FullWell(-1.0)),
        refused("sensor: endless exposure", "infinite seconds", lambda: Exposure(time_s=math.inf, iso=100.0)),
    )
