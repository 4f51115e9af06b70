"""Frames made by hand, without the renderer: what is tested here is the files."""

import dataclasses
import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rawpy
from planes_by_rows import rows_of_plane

from camsim.camera.frame import ChannelSignal, Frame, Report
from camsim.rendering.cube import SpectralCube
from camsim.sensor.colour_matrix import ColourResponse
from camsim.sensor.quantum_efficiency import QuantumEfficiency
from camsim.spectra.curve import Curve
from camsim.spectra.light import Light

WAVELENGTH_NM = np.arange(360.0, 831.0)
X_TRANS = "GBGGRG RGRBGB GBGGRG GRGGBG BGBRGR GRGGBG"
MakeFrame = Callable[..., Frame]


def bell(centre_nm: float, width_nm: float) -> np.ndarray:
    return np.exp(-0.5 * ((WAVELENGTH_NM - centre_nm) / width_nm) ** 2)


def cube_of(planes: list[np.ndarray]) -> SpectralCube:
    """Return a cube of planes made before, with errors."""
    nodes = tuple(500.0 + 100 * k for k in range(len(planes)))
    return SpectralCube(nodes, "W.m^-2.sr^-1.nm^-1", functools.partial(rows_of_plane, planes))


def build_frame(rows: int = 48, cols: int = 66, pattern: str = "RG GB", seed: int = 5, **changes: Any) -> Frame:
    """Return a frame of an L of three squares, the lower one red, on noise; one square is clipped.

    None of the eight ways to turn or mirror it looks like another. ``pattern`` is "Y" for mono.
    """
    rng = np.random.default_rng(seed)
    cfa = tuple(pattern.split())
    if pattern == "Y":
        channels, sensitivity = ("Y",), bell(550, 60)[None]
    else:
        channels = ("R", "G", "B")
        sensitivity = np.array([0.6 * bell(600, 30), bell(535, 35), 0.8 * bell(460, 25)])
    index = np.array(
        [[channels.index(cfa[r % len(cfa)][c % len(cfa[0])]) for c in range(12)] for r in range(12)],
        dtype=np.uint8,
    )
    index = np.tile(index, (rows // 12 + 1, cols // 12 + 1))[:rows, :cols]
    light = np.linspace(1.2, 0.8, WAVELENGTH_NM.size)
    neutral = sensitivity @ light / (sensitivity @ light).max()
    truth = rng.uniform(2000, 6000, (rows, cols, 1)) * neutral
    truth[6:18, 6:18] = 20000 * neutral
    truth[6:18, 18:30] = 90000 * neutral
    truth[18:30, 6:18, 1:] = 1000
    truth[18:30, 6:18, 0] = 10000
    mean = np.take_along_axis(truth, index[:, :, None].astype(np.int64), axis=2)[:, :, 0]
    electrons = np.minimum(rng.poisson(mean).astype(np.float64), 38950.0)
    frame = Frame(
        mosaic=np.clip(np.rint(128 + electrons / 10), 0, 4095).astype(np.uint16),
        mean_electrons=mean,
        electrons=electrons,
        truth=truth.astype(np.float32),
        spectral=cube_of([truth[:, :, 0].astype(np.float32), truth[:, :, -1].astype(np.float32)]),
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
            quantum_efficiency=QuantumEfficiency(
                tuple((name, Curve(WAVELENGTH_NM, curve)) for name, curve in zip(channels, sensitivity, strict=True)),
                per="energy",
                peak=0.5,
            ),
            light=Light(Curve(WAVELENGTH_NM, light), illuminance_lux=1.0),
        ),
        description={"sensor": {"name": "Test camera, 4.88 µm", "cfa": list(cfa)}, "note": '<&"]]> \u0001 ü'},
        report=Report(
            scene="L",
            optics=("Airy f/5.6",),
            wavelengths="471",
            method="by hand",
            tolerance=1e-6,
            error_estimate=3.2e-7,
            truth_error_estimate=4.5e-7,
            checked_photosites=4,
            signal=tuple(
                ChannelSignal(name=name, mean_e=1, max_e=1, mean_dn=1, clipped_photosites=0, photosites=1)
                for name in channels
            ),
        ),
    )
    return dataclasses.replace(frame, **changes)


def rawpy_linear(path: Path) -> np.ndarray:
    """Return LibRaw's linear sRGB, (rows, cols, 3) in 0..1: camera white balance, not scaled by content."""
    with rawpy.imread(str(path)) as raw:
        developed = raw.postprocess(
            demosaic_algorithm=rawpy.DemosaicAlgorithm.LINEAR,
            use_camera_wb=True,
            output_color=rawpy.ColorSpace.sRGB,
            output_bps=16,
            gamma=(1, 1),
            no_auto_bright=True,
            adjust_maximum_thr=0,
        )
    return developed / 65535


@pytest.fixture
def make_frame() -> Callable[..., Frame]:
    return build_frame


@pytest.fixture
def develop_with_rawpy() -> Callable[[Path], np.ndarray]:
    return rawpy_linear


@pytest.fixture
def frame() -> Frame:
    return build_frame()


@pytest.fixture
def mono_frame() -> Frame:
    return build_frame(pattern="Y")


@pytest.fixture
def x_trans() -> str:
    return X_TRANS
