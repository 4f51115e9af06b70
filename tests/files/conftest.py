"""Frames made by hand, without the renderer: what is tested here is the files."""

import dataclasses
import functools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from planes_by_rows import rows_of_plane

from camsim.camera.frame import Frame
from camsim.rendering.cube import SpectralCube
from camsim.sensor.colour_matrix import ColourResponse
from camsim.sensor.quantum_efficiency import QuantumEfficiency
from camsim.spectra.curve import Curve
from camsim.spectra.light import Light
from tests.colorchecker import chart

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
    plain = chart(rows, cols, tuple(pattern.split()))
    channels, index = plain.channels, plain.channel_index
    of_letter = {"Y": bell(550, 60), "R": 0.6 * bell(600, 30), "G": bell(535, 35), "B": 0.8 * bell(460, 25)}
    sensitivity = np.array([of_letter[letter] for letter in channels])
    light = np.linspace(1.2, 0.8, WAVELENGTH_NM.size)
    neutral = sensitivity @ light / (sensitivity @ light).max()
    truth = rng.uniform(2000, 6000, (rows, cols, 1)) * neutral
    truth[6:18, 6:18] = 20000 * neutral
    truth[6:18, 18:30] = 90000 * neutral
    truth[18:30, 6:18, 1:] = 1000
    truth[18:30, 6:18, 0] = 10000
    mean = np.take_along_axis(truth, index[:, :, None].astype(np.int64), axis=2)[:, :, 0]
    electrons = np.minimum(rng.poisson(mean).astype(np.float64), 38950.0)
    frame = dataclasses.replace(
        plain,
        mosaic=np.clip(np.rint(128 + electrons / 10), 0, 4095).astype(np.uint16),
        mean_electrons=mean,
        electrons=electrons,
        truth=truth.astype(np.float32),
        spectral=cube_of([truth[:, :, 0].astype(np.float32), truth[:, :, -1].astype(np.float32)]),
        colour=ColourResponse(
            quantum_efficiency=QuantumEfficiency(
                tuple((name, Curve(WAVELENGTH_NM, curve)) for name, curve in zip(channels, sensitivity, strict=True)),
                per="energy",
                peak=0.5,
            ),
            light=Light(Curve(WAVELENGTH_NM, light), illuminance_lux=1.0),
        ),
    )
    return dataclasses.replace(frame, **changes)


@pytest.fixture
def make_frame() -> Callable[..., Frame]:
    return build_frame


@pytest.fixture
def frame() -> Frame:
    return build_frame()


@pytest.fixture
def mono_frame() -> Frame:
    return build_frame(pattern="Y")


@pytest.fixture
def x_trans() -> str:
    return X_TRANS
