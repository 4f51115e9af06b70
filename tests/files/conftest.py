"""Frames made by hand, without the renderer: what is tested here is the files."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from camsim.frame import ChannelSignal, Frame, Report
from camsim.sensor.colour_matrix import ColourResponse

WAVELENGTH_NM = np.arange(360.0, 831.0)


def bell(centre_nm: float, width_nm: float) -> np.ndarray:
    return np.exp(-0.5 * ((WAVELENGTH_NM - centre_nm) / width_nm) ** 2)


def make_frame(rows: int = 48, cols: int = 66, pattern: str = "RGGB", seed: int = 5, **changes: Any) -> Frame:
    """An asymmetric frame: noise, a bright L in the top left corner, saturated in its short arm.

    ``pattern`` is a Bayer phase, or "Y" for mono.
    """
    rng = np.random.default_rng(seed)
    if pattern == "Y":
        channels, cfa, sensitivity = ("Y",), ("Y",), bell(550, 60)[None]
        index = np.zeros((rows, cols), dtype=np.uint8)
    else:
        channels, cfa = ("R", "G", "B"), (pattern[:2], pattern[2:])
        sensitivity = np.array([0.6 * bell(600, 30), bell(535, 35), 0.8 * bell(460, 25)])
        tile = np.array([["RGB".index(letter) for letter in row] for row in cfa], dtype=np.uint8)
        index = np.tile(tile, (rows // 2 + 1, cols // 2 + 1))[:rows, :cols]
    truth = rng.uniform(2000, 6000, (rows, cols, len(channels)))
    truth[2 : rows // 2, 2 : cols // 8] = 20000
    truth[2 : rows // 6, 2 : cols // 2] = 45000
    mean = np.take_along_axis(truth, index[:, :, None].astype(np.int64), axis=2)[:, :, 0]
    electrons = np.minimum(rng.poisson(mean).astype(np.float64), 38950.0)
    frame = Frame(
        mosaic=np.clip(np.rint(128 + electrons / 10), 0, 4095).astype(np.uint16),
        mean_electrons=mean,
        electrons=electrons,
        truth=truth.astype(np.float32),
        channel_index=index,
        channels=channels,
        cfa_pattern=cfa,
        pitch_um=4.88,
        bit_depth=12,
        black_level_dn=128,
        white_level_dn=4023,
        electrons_per_dn=10.0,
        read_noise_e=9.0,
        camera_name="Test camera, 4.88 µm",
        serial=17,
        f_number=5.6,
        time_s=0.01,
        iso=200.0,
        datetime="2021-03-04 05:06:07",
        seed=2**40 + 1,
        colour=ColourResponse(
            channels=channels,
            wavelength_nm=WAVELENGTH_NM,
            sensitivity=sensitivity,
            light=np.linspace(1.2, 0.8, WAVELENGTH_NM.size),
        ),
        description={"sensor": {"name": "Test camera, 4.88 µm", "cfa": list(cfa)}, "note": '<&"] \u0001 ü'},
        report=Report(
            scene="L",
            optics=("Airy f/5.6",),
            wavelengths="471",
            method="by hand",
            tolerance=1e-6,
            error_estimate=3.21e-7,
            checked_photosites=4,
            signal=tuple(
                ChannelSignal(name=name, mean_e=1, max_e=1, mean_dn=1, clipped_photosites=0, photosites=1)
                for name in channels
            ),
        ),
    )
    return dataclasses.replace(frame, **changes)


@pytest.fixture
def frame() -> Frame:
    return make_frame()
