"""Where a picture would surprise, the report says why and what to do; and elsewhere it is silent."""

import dataclasses
from typing import Any

import pytest

import camsim
from camsim.spectra.named import sensitivities
from tests.tables import rows

CURVES = sensitivities("Nikon 5100 (NPL)")
CAMERA = camsim.Camera(
    rows=400,
    cols=600,
    pitch_um=4.0,
    lens=camsim.Airy(f_number=8.0),
    olpf=camsim.FourSpotOlpf.from_pitches(pitch_um=4.0, split_pitches=0.75),
    photosite=camsim.SquarePhotosite(side_um=4.0),
    cfa=camsim.Cfa.bayer(),
    quantum_efficiency=camsim.QuantumEfficiency([*CURVES.items()], per="energy", peak=0.5),
    adc=camsim.Adc(bit_depth=12, black_level_dn=100, electrons_per_dn=4.0, base_iso=100.0),
    full_well=camsim.FullWell(15000.0),
    read_noise=camsim.ReadNoise(5.0),
    dark_current=camsim.DarkCurrent(2.0),
)
SQUARE = camsim.Rectangle(width_um=24.0, height_um=20.0, rotate_deg=4.0, reflectance=0.1)
SCENE = camsim.Scene(background=0.8, shapes=[SQUARE])
READY = camsim.Capture(
    camera=CAMERA,
    scene=SCENE,
    light=camsim.Light("D55", illuminance_lux=5000),
    exposure=camsim.Exposure(time_s="auto", iso=100),
    region=camsim.Region(rows=12, cols=12),
    tolerance=1e-3,
)


GRATING = camsim.SineGrating(width_um=200.0, height_um=200.0, period_um=20.0, low=0.1, high=0.9)


def notes(*, products: tuple[str, ...] = ("mosaic",), **changes: Any) -> str:
    on_camera = {key: changes.pop(key) for key in list(changes) if key in CAMERA.__dataclass_fields__}
    ready = dataclasses.replace(READY, camera=CAMERA.replace(**on_camera), **changes)
    return "\n".join(map(str, ready.frame(products=products).report.notes))


def moved(x_um: float, y_um: float) -> camsim.Scene:
    return camsim.Scene(background=0.8, shapes=[dataclasses.replace(SQUARE, centre_um=(x_um, y_um))])


def exposed(time_s: float) -> camsim.Exposure:
    return camsim.Exposure(time_s=time_s, iso=100)


def test_a_usual_picture_has_none() -> None:
    assert notes() == ""


@pytest.mark.parametrize(("changes", "said"), rows("notes.txt", "captures"))
def test_what_surprises_is_said(changes: str, said: str) -> None:
    """Of a turned square with its corner at the window's, the sides' boxes meet the window, and they do not."""
    found = notes(**eval(changes))
    assert said == "nothing" or said in found
    assert found.count("\n") == 0
    assert (said == "nothing") == (not found)


def test_a_camera_of_python_has_the_notes_that_a_sensors_file_gets() -> None:
    assert CAMERA.notes == ()
    slips = CAMERA.replace(prnu=camsim.Prnu(0.8), full_well=camsim.FullWell(40_000.0))
    where = {note.code: note.where for note in slips.notes}
    assert where["large-prnu"] == "sensor.charge.prnu"
    assert where["well-not-reached"] == where["gain-or-its-inverse"] == "sensor.readout.electrons_per_dn"


def test_a_tolerance_far_finer_than_the_noise_is_said_where_it_costs() -> None:
    """Planned and not rendered. A coarser one is as good where there is noise, and wanted where the mean is."""
    costly = dataclasses.replace(
        READY, tolerance=1e-8, region=None, camera=CAMERA.replace(lens=camsim.Wavefront(f_number=8.0, defocus_um=40.0))
    )
    choice = costly.plan()
    (note,) = costly.notes(choice)
    assert "the tolerance of 1e-08 is " in note.text
    assert f"takes about {choice.plan.cost.seconds:.2g} s of one core" in note.text
    would_do = float(note.text.split(" would do")[0].rpartition(" ")[2])
    coarser = dataclasses.replace(costly, tolerance=would_do)
    assert coarser.plan().plan.cost.seconds < 0.5 * choice.plan.cost.seconds
    assert coarser.notes(coarser.plan()) == ()
    # A hundredth of the darkest photosite's noise at most.
    diffuser_e = CAMERA.diffuser_electrons(READY.light, READY.time_s).max()
    assert 1e-3 < would_do * diffuser_e / 5.1 < 1e-2
    assert costly.notes(choice, ("mosaic", "truth")) == ()
    assert dataclasses.replace(costly, noise=False).notes(choice) == ()
    assert READY.notes(dataclasses.replace(READY, tolerance=1e-8).plan()) == ()  # it takes no time here
