"""A stage of one's own joins a camera: it acts where it says, is told, counted and refused in words."""

import json
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest
from electronics import Spy, Telegraph
from tolerances import STATISTICAL

import camsim
from camsim.errors import InputError, InvalidValueError
from camsim.revive import revive_capture

TELEGRAPH = Telegraph(probability=0.1, step_e=50.0)
HOW = {
    "light": camsim.Light(line_nm=488.0, irradiance_w_per_m2=1e-4),
    "exposure": camsim.Exposure(time_s=0.01, iso=100.0),
    "region": camsim.Region(rows=130, cols=90),
    "seed": 7,
}
GREY = camsim.Scene(background=0.5)


@dataclass(frozen=True)
class Glow(camsim.ElectronicStage):
    """An amplifier that shines into the frame's left edge, e⁻/s."""

    name: ClassVar = "glow"
    phases: ClassVar = (camsim.Phase.CHARGE,)

    e_per_s: float

    def apply(self, electrons, context):
        col = context.first[1] + np.arange(electrons.shape[1])
        return electrons + self.e_per_s * context.time_s * np.exp(-col / 20.0)


def camera_with(*own, **stages):
    camera = camsim.Camera.from_yaml("paper-488", lens=camsim.Airy(f_number=8.0)).replace(rows=400, cols=300)
    return camera.replace(extra_stages=own, **({"shot_noise": None} | stages))


def test_it_acts_in_its_phase():
    """Light of one's own has photon noise: each photosite's variance is its mean, which falls from left to right."""
    camera = camera_with(Glow(2e5), shot_noise=camsim.ShotNoise(), full_well=None)
    how = HOW | {"region": camsim.Region(rows=400, cols=60, origin=(0, 0))}
    frame = camera.expose(camsim.Scene(background=0.0), **how)
    wanted = 2e3 * np.exp(-np.arange(60) / 20.0)
    mean, variance = frame.electrons.mean(axis=0), frame.electrons.var(axis=0, ddof=1)
    assert (np.abs(mean - wanted) < STATISTICAL * np.sqrt(wanted / 400)).all()
    assert (np.abs(variance - wanted) < STATISTICAL * wanted * np.sqrt((2 + 1 / wanted) / 399)).all()
    # The order of the report is that of the phases.
    assert [name.partition("(")[0] for name in frame.report.electronics] == ["Glow", "ShotNoise"]


def test_a_window_has_its_part_of_it():
    whole = camera_with(Glow(2e5)).expose(GREY, **(HOW | {"region": None}))
    part = camera_with(Glow(2e5)).expose(GREY, **(HOW | {"region": camsim.Region(rows=9, cols=9, origin=(70, 11))}))
    np.testing.assert_allclose(part.electrons, whole.electrons[70:79, 11:20], rtol=1e-6)


def test_it_is_counted_and_changes_no_others_draws(monkeypatch):
    stages = {"read_noise": camsim.ReadNoise(3.0), "dsnu": camsim.Dsnu(1.0)}
    spy = Spy(monkeypatch)
    plain = camera_with(**stages).expose(GREY, **HOW)
    before = spy.numbers
    frame = camera_with(TELEGRAPH, **stages).expose(GREY, **HOW)
    assert frame.report.work["random_numbers"] == spy.numbers - before == plain.report.work["random_numbers"] + 130 * 90
    off_e = frame.electrons - plain.electrons
    up = off_e > 25.0
    np.testing.assert_allclose(off_e, 50.0 * up, atol=1e-9)
    assert abs(up.mean() - 0.1) < STATISTICAL * np.sqrt(0.09 / up.size)


def test_dark_noise_has_its_share():
    camera = camera_with(TELEGRAPH, read_noise=camsim.ReadNoise(8.0))
    assert camera.dark_noise_e(100.0) == pytest.approx(17.0)  # 15² + 8²
    assert camera_with(TELEGRAPH).expose(GREY, **HOW, noise=False).report.electronics == ()


def test_rows_are_those_of_the_frame():
    camera, rows = camera_with(TELEGRAPH, Glow(1e4)), []
    camsim.Capture(camera=camera, scene=GREY, **HOW).rows(rows.append)
    np.testing.assert_array_equal(np.concatenate(rows), camera.expose(GREY, **HOW).mosaic)


def test_files_say_that_it_was_there_and_others_keep_their_bytes():
    plain, with_it = (camera.expose(GREY, **HOW).description for camera in (camera_with(), camera_with(TELEGRAPH)))
    assert "extra_stages" not in plain["camera"]
    assert json.dumps(with_it["camera"].pop("extra_stages")) == (
        '[{"kind": "Telegraph", "probability": 0.1, "step_e": 50}]'
    )
    assert with_it == plain


def test_a_capture_with_it_is_not_taken_again_without_it():
    described = json.loads(json.dumps(camera_with(TELEGRAPH).expose(GREY, **HOW).description))
    with pytest.raises(InputError, match="extra_stages: 'Telegraph' is not a stage of this version of camsim"):
        revive_capture(described)


@dataclass(frozen=True)
class Neighbourly(camsim.ElectronicStage):
    name: ClassVar = "neighbourly"
    margin: ClassVar = 1

    def apply(self, electrons, context):
        return electrons[1:-1, 1:-1]


@dataclass(frozen=True)
class Flash(Telegraph):
    phases: ClassVar = (camsim.Phase.LIGHT,)


@dataclass(frozen=True)
class Taken(Telegraph):
    stream: ClassVar = camsim.ReadNoise.stream


@pytest.mark.parametrize(
    ("own", "message"),
    [
        ([object()], "extra_stages: item 0 must be a dataclass that inherits from camsim.ElectronicStage"),
        ([Neighbourly()], "Neighbourly: margin 1; only crosstalk sees beyond the window"),
        ([Flash(probability=0.1, step_e=1.0)], "Flash: in phase LIGHT only patterns of the sensor act; take CHARGE"),
        ([Taken(probability=0.1, step_e=1.0)], "Taken: stream 3; those below 1000 are camsim's"),
        ([TELEGRAPH, replace(TELEGRAPH, step_e=1.0)], "each stage needs one of its own"),
    ],
)
def test_what_cannot_join_is_refused(own, message):
    with pytest.raises(InvalidValueError, match=message):
        camera_with(*own)
