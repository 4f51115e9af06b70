"""A stage of one's own joins a camera: it acts where it says, is told, counted and refused in words."""

import json
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from electronics import Telegraph
from own_optics import Blurred, Diamond, Motion, SixSpotOlpf
from tolerances import STATISTICAL

import camsim
from camsim.cli.info import text_of_file
from camsim.config.from_record import capture_from_record
from camsim.errors import InputError, InvalidValueError
from tests.tables import rows

TELEGRAPH = Telegraph(probability=0.1, step_e=50.0)
HOW = {
    "light": camsim.Light(line_nm=488.0, irradiance_w_per_m2=1e-4),
    "exposure": camsim.Exposure(time_s=0.01, iso=100.0),
    "region": camsim.Region(rows=130, cols=90),
    "seed": 7,
}
GREY = camsim.Scene(background=0.5)
SMALL = HOW | {
    "light": camsim.Light(line_nm=550.0, irradiance_w_per_m2=1.0),
    "region": camsim.Region(rows=12, cols=10),
    "tolerance": 1e-4,
}


@dataclass(frozen=True)
class Glow(camsim.ElectronicStage):
    """An amplifier that shines into the frame's left edge, e⁻/s."""

    name: ClassVar = "glow"
    phases: ClassVar = (camsim.Phase.CHARGE,)

    e_per_s: float

    def apply(self, electrons, context):
        col = context.first[1] + np.arange(electrons.shape[1])
        return electrons + self.e_per_s * context.time_s * np.exp(-col / 20.0)


def camera_with(*each, **stages):
    camera = camsim.Camera.from_yaml("paper-488", lens=camsim.Airy(f_number=8.0)).replace(rows=400, cols=300)
    return camera.replace(extra_stages=each, **({"shot_noise": None} | stages))


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


def test_files_say_that_it_was_there_and_others_keep_their_bytes():
    plain, with_it = (camera.expose(GREY, **HOW).description for camera in (camera_with(), camera_with(TELEGRAPH)))
    assert "extra_stages" not in plain["camera"]
    assert json.dumps(with_it["camera"].pop("extra_stages")) == (
        '[{"kind": "Telegraph", "probability": 0.1, "step_e": 50}]'
    )
    assert with_it.pop("not_reproducible_by_camsim_alone") == ["Telegraph"]
    assert with_it == plain


def test_a_capture_with_it_is_not_taken_again_without_it():
    described = json.loads(json.dumps(camera_with(TELEGRAPH).expose(GREY, **HOW).description))
    with pytest.raises(InputError, match="not reproducible by camsim alone: it was taken with Telegraph, which camsim"):
        capture_from_record(described)


def each(*, frozen=True, fields=None, **facts):
    """Return a stage with these facts and verbs, right or wrong."""
    fields = fields or {}
    body = {"name": "own", "apply": lambda self, electrons, context: electrons} | facts
    body["__annotations__"] = {"name": ClassVar} | dict.fromkeys(fields, object)
    made = dataclass(frozen=frozen)(type("Own", () if "otf" in facts else (camsim.ElectronicStage,), body))
    return made(**fields)


@pytest.mark.parametrize(("value", "message"), rows("wrong-stages.txt", "fields of a stage"))
def test_fields_are_what_a_record_can_hold(value, message, tmp_path):
    message = eval(message)
    stated = {"level": eval(value)}
    joins = [
        lambda: camera_with(each(fields=stated)),
        lambda: camera_with().replace(
            extra_optics=[each(fields=stated, otf=lambda self, fx, fy, nm: np.ones_like(fx))]
        ),
    ]
    for join in joins:
        if message is None:
            join().expose(GREY, **SMALL).save(tmp_path / "own.npz", force=True)
            assert "custom stages: Own" in text_of_file(str(tmp_path / "own.npz"))
        else:
            with pytest.raises(InvalidValueError, match=message):
                join()


def test_no_record_is_written_that_is_no_json(tmp_path):
    frame = camera_with().expose(GREY, **SMALL)
    with pytest.raises(camsim.errors.OutputError, match="holds a number that is not finite"):
        replace(frame, description={"tau_s": np.inf}).save(tmp_path / "a.npz")
    assert not list(tmp_path.iterdir())


def changed(electrons, context):
    electrons += 5.0
    return electrons


@pytest.mark.parametrize("whole_window", [False, True])
@pytest.mark.parametrize(("apply", "message"), rows("wrong-stages.txt", "what an electronic stage gives"))
def test_what_it_gives_is_looked_at(apply, message, whole_window):
    stage = each(apply=lambda self, electrons, context: eval(apply)(electrons, context), whole_window=whole_window)
    with pytest.raises(InvalidValueError, match=f"Camera.extra_stages: {message}"):
        camera_with(stage).expose(GREY, **SMALL)


def test_what_it_keeps_stays_as_it_is():
    """What came in, or an array that it gives again, is not written over by the stages after it."""
    kept = np.full((12, 10), 7.0)
    for gives in (kept, None):
        stage = each(apply=lambda self, e, context, gives=gives: e if gives is None else gives, whole_window=True)
        frame = camera_with(stage, read_noise=camsim.ReadNoise(3.0)).expose(GREY, **SMALL)
        assert (kept == 7.0).all()
        assert np.ptp(frame.mean_electrons) < 1e-3 * frame.mean_electrons.max()


def test_several_streams_and_the_exposure():
    def apply(self, electrons, context):
        fixed, fresh = context.normals(1001, electrons.shape), context.generator(1002).normal(size=electrons.shape)
        return context.iso + fixed + fresh

    stage = each(apply=apply, stream=(1001, 1002), temporal=True)
    one, two = (camera_with(stage).expose(GREY, **SMALL, frame_number=n).electrons - 100.0 for n in (0, 1))
    assert abs(np.corrcoef(one.ravel(), two.ravel())[0, 1] - 0.5) < STATISTICAL * 0.75 / np.sqrt(one.size)
    twice = each(
        apply=lambda self, e, context: e + context.generator(1001).normal() + context.generator(1001).normal(),
        stream=1001,
        temporal=True,
    )
    with pytest.raises(InvalidValueError, match="Own asks for the generator of stream 1001 twice; it begins anew"):
        camera_with(twice).expose(GREY, **SMALL)
    both = each(
        apply=lambda self, e, context: e,
        over=lambda self, context: (context.frame_generator(1001), self)[1],
        stream=1001,
        temporal=True,
        phases=(camsim.Phase.CHARGE, camsim.Phase.READ),
    )
    assert camera_with(both).expose(GREY, **SMALL).shape == (12, 10)  # once in each of its phases
    still = each(apply=apply, stream=(1001, 1002))
    with pytest.raises(InvalidValueError, match="Own draws anew in each frame, and its temporal is False"):
        camera_with(still).expose(GREY, **SMALL)


def test_a_pattern_of_columns_goes_on_through_all_rows():
    """Normals of one row began anew with each block of 64 rows, whatever row it was."""
    stage = each(apply=lambda self, e, context: e + context.column_normals(1001, e.shape[1]), stream=1001)
    still = camera_with(stage, read_noise=None, full_well=None)
    for origin in ((0, 0), (150, 40)):
        frame = still.expose(GREY, **HOW | {"region": camsim.Region(rows=130, cols=90, origin=origin)})
        added = frame.electrons - frame.mean_electrons
        drawn = np.random.Generator(np.random.Philox(np.random.SeedSequence([still.serial, 1001, 0, 0])))
        columns = drawn.standard_normal(300, np.float32)[origin[1] : origin[1] + 90]
        np.testing.assert_allclose(added, np.tile(columns, (130, 1)), atol=1e-9)
    one_row = each(apply=lambda self, e, context: e + context.normals(1001, (1, e.shape[1])), stream=1001)
    with pytest.raises(InvalidValueError, match=r"Own asks for normals of shape \(1, 90\) for \(64, 90\) photosites"):
        camera_with(one_row).expose(GREY, **HOW)


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


@pytest.mark.parametrize(("stages", "message"), rows("wrong-stages.txt", "electronic stages"))
def test_what_cannot_join_is_refused(stages, message):
    with pytest.raises(InvalidValueError, match=message):
        camera_with(*eval(stages))


def own_optics():
    camera = camera_with()
    return camera.replace(
        lens=Blurred(sigma_um=1.0),
        extra_optics=[Motion(length_um=3.0)],
        olpf=SixSpotOlpf(radius_um=1.5),
        photosite=Diamond(half_um=2.0),
    )


EDGE = camsim.Scene(background=0.9, shapes=[camsim.Disc(radius_um=20.0, reflectance=0.1)])


def test_optical_stages_of_ones_own_join_a_camera():
    """Each is told, and the picture is that of the product of all transfers; files say that camsim alone cannot."""
    camera = own_optics()
    frame = camera.expose(EDGE, **SMALL, noise=False)
    names = [stated.partition("(")[0] for stated in frame.report.optics]
    assert names == ["Blurred", "Motion", "SixSpotOlpf", "Diamond"]
    stages = [camera.lens, *camera.extra_optics, camera.olpf, camera.photosite]
    rendering = camsim.render(EDGE, stages, camera.grid(SMALL["region"]), wavelength_nm=550.0, tolerance=1e-8)
    flat_e = camera.expose(GREY, **SMALL, noise=False).mean_electrons / 0.5
    assert np.abs(frame.mean_electrons / flat_e - rendering.image).max() < 2e-4
    assert frame.description["not_reproducible_by_camsim_alone"] == names
    assert frame.description["camera"]["lens"] == {"kind": "Blurred", "sigma_um": 1, "f_number": 8, "transmission": 0.9}
    assert ("custom-stages", ", ".join(names)) in [(note.code, note.where) for note in frame.report.notes]


def test_the_f_number_of_a_lens_of_ones_own_grows_with_the_magnification():
    camera = own_optics()
    light = [camera.replace(magnification=m).expose(GREY, **SMALL, noise=False).mean_electrons.mean() for m in (0, 1)]
    assert light[0] == pytest.approx(4.0 * light[1])
    assert light[1] > 50.0


def test_a_file_of_it_says_so(tmp_path):
    own_optics().replace(extra_stages=[TELEGRAPH]).expose(EDGE, **SMALL).save(tmp_path / "a.tiff")
    stated = text_of_file(str(tmp_path / "a.tiff"))
    assert "custom stages: Blurred, Motion, SixSpotOlpf, Diamond, Telegraph" in stated
    assert "Motion(length_um=3) → SixSpotOlpf(radius_um=1.5) → Diamond(half_um=2)" in stated
    assert "Telegraph(probability=0.1, step_e=50)" in stated


class Plain:
    f_number, transmission = 8.0, 1.0

    def otf(self, fx_per_um, fy_per_um, wavelength_nm):
        return np.ones_like(fx_per_um)


def Odd(transfer):
    """Return a blur that does what it is told, right or wrong."""

    class Odd:
        def otf(self, fx_per_um, fy_per_um, wavelength_nm):
            return transfer(fx_per_um, fy_per_um)

    return dataclass(frozen=True)(Odd)()


@pytest.mark.parametrize(("changes", "message"), rows("wrong-stages.txt", "optical stages"))
def test_what_is_no_optical_stage_is_refused(changes, message):
    with pytest.raises(InvalidValueError, match=message):
        camera_with().replace(**eval(changes))


@pytest.mark.parametrize(
    ("transfer", "message"),
    [(lambda x, y: None, r"Odd.otf gives shape \(\)"), (lambda x, y: {}[0], r"Odd.otf\(.*\) failed: KeyError")],
)
def test_a_lens_of_ones_own_is_looked_at_before_it_is_asked_how_far_it_passes_anything(transfer, message):
    lens, photosite = Odd(transfer), camsim.SquarePhotosite(side_um=4.0)
    grid = camsim.Grid(rows=4, cols=4, pitch_um=4.0)
    with pytest.raises(InvalidValueError, match=message):
        camsim.render(camsim.Scene(background=0.2), [lens, photosite], grid, wavelength_nm=550.0)


def test_the_page_names_what_is_there():
    page = Path(__file__).parents[2] / "docs" / "howto" / "own-noise.md"
    named = set(re.findall(r"context\.(\w+)", page.read_text(encoding="utf-8")))
    assert {"iso", "first", "generator", "normals"} <= named
    assert all(hasattr(camsim.Context, name) for name in named)
