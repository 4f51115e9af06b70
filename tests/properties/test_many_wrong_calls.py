"""Hundreds of wrong calls: each is refused where it is made, by its argument's name, with what is allowed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from PIL import Image

import camsim
from camsim.errors import CamsimError
from camsim.measure import colour, demosaic, distortion, noise, target, truth
from camsim.spectra import named  # noqa: F401 (calls are told by their text)
from camsim.study import read_study  # noqa: F401

A = np.array([400.0, 700.0])
FLAT = camsim.Curve(A, (1.0, 1.0), outside="hold")
LENS = camsim.Airy(f_number=8)
DISC = camsim.Disc(radius_um=9, reflectance=0.1)
SCENE = camsim.Scene(background=0.5, shapes=[DISC])
LIGHT = camsim.Light("D55", illuminance_lux=500)
EXPOSURE = camsim.Exposure(time_s=0.01, iso=100)
GRID = camsim.Grid(rows=4, cols=4, pitch_um=4.88)
ADC = camsim.Adc(bit_depth=12, black_level_dn=100, electrons_per_dn=2, base_iso=100)
CAMERA = camsim.Camera(
    rows=60,
    cols=80,
    pitch_um=4.88,
    lens=LENS,
    photosite=camsim.SquarePhotosite(side_um=4.88),
    cfa=camsim.Cfa.mono(),
    quantum_efficiency=camsim.QuantumEfficiency([("Y", camsim.Curve((300, 1100), (1, 1)))], per="photon", peak=0.5),
    adc=ADC,
)
MEASURING = {"colour": colour, "demosaic": demosaic, "distortion": distortion, "target": target} | {
    "noise": noise,
    "truth": truth,
}
BAYER = camsim.Sensor.from_yaml("d40-like")
CAPTURE = camsim.Capture(
    camera=CAMERA, scene=SCENE, light=LIGHT, exposure=EXPOSURE, region=camsim.Region(rows=4, cols=4), tolerance=1e-2
)
FRAME = CAPTURE.frame()
PICTURE = camsim.measure.picture_of_frame(FRAME)
CODES = np.random.default_rng(1).integers(0, 256, (8, 9, 3)).astype(np.uint8)
IMAGE = Image.fromarray(CODES)
SHAPELY = shapely.box(0, 0, 1, 1)


class Tensor:
    """Numbers of which another program keeps gradients: it refuses as PyTorch's do."""

    requires_grad = True

    def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
        raise RuntimeError("Can't call numpy() on Tensor that requires grad. Use tensor.detach().numpy() instead.")

    def detach(self) -> Any:
        return self


TENSOR = Tensor()


def adc(**changes: Any) -> camsim.Adc:
    return camsim.Adc(**{"bit_depth": 12, "black_level_dn": 100, "electrons_per_dn": 2, "base_iso": 100} | changes)


def expose(**changes: Any) -> camsim.Frame:
    return CAMERA.expose(**{"scene": SCENE, "light": LIGHT, "exposure": EXPOSURE} | changes)


def efficiency(**changes: Any) -> camsim.QuantumEfficiency:
    return camsim.QuantumEfficiency(**{"curves": [("R", FLAT)], "per": "energy", "peak": 0.5} | changes)


def revolved(**changes: Any) -> camsim.FieldLens:
    """A lens that is told at four heights by three Zernikes."""
    usual = {"f_number": 5.6, "wavelength_nm": [550.0], "zernike": [4, 5, 8], "height_um": (0.0, 2500.0, 6000.0, 1e4)}
    waves = {"waves": [[[0.05, 0, 0], [0.07, 0.02, 0.03], [0.16, 0.09, 0.06], [0.35, 0.25, 0.1]]]}
    return camsim.FieldLens(**usual | waves | changes)


WRONG = (Path(__file__).parents[1] / "data" / "wrong-calls.txt").read_text(encoding="utf-8")
CALLS = [tuple(part.strip() for part in line.split("|", 1)) for line in WRONG.splitlines()]


def test_there_are_enough_different_ones() -> None:
    assert len({call for call, _ in CALLS}) == len(CALLS) >= 400


@pytest.mark.parametrize(("call", "message"), CALLS, ids=[call for call, _ in CALLS])
def test_it_is_refused_by_its_arguments_name(call: str, message: str) -> None:
    with pytest.raises(CamsimError) as refused:
        eval(call, globals() | MEASURING)
    assert str(refused.value).startswith(message)
