"""Where a picture would surprise, the report says why and what to do; and elsewhere it is silent."""

import dataclasses
from typing import Any

import pytest

import camsim
from camsim.spectra.named import sensitivities

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


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"scene": moved(400.0, 0.0)}, "no edge in the window, x from -24 to 24 µm and y from -24 to 24 µm of the opt"),
        ({"scene": moved(30.0, 30.0)}, ""),
        # Its corner points at the window's; the boxes about its sides meet the window's, its sides do not.
        ({"scene": camsim.Scene(background=0.8, shapes=[dataclasses.replace(SQUARE, rotate_deg=45.0,
          centre_um=(38.0, 38.0))])}, "no edge in the window"),
        ({"scene": camsim.Scene(background=0.8, shapes=[dataclasses.replace(SQUARE, reflectance=0.8)])},
         "or only between surfaces that are equal"),
        ({"scene": camsim.Scene(background=0.8)}, ""),
        ({"scene": camsim.Scene(background=0.8, shapes=[GRATING])}, ""),
        ({"scene": camsim.Scene(background=0.8, shapes=[dataclasses.replace(GRATING, centre_um=(400.0, 0.0))])},
         "no edge in the window"),
        ({"scene": moved(400.0, 0.0), "lens": camsim.Wavefront(f_number=8.0, defocus_um=5.0)}, "no edge in the window"),
        ({"exposure": exposed(1e-7)}, "DN above black, less than one code: the picture is all noise; more light"),
        ({"exposure": exposed(1.0), "dark_current": None}, "every photosite is clipped at 3850 DN: nothing is left"),
        ({"exposure": exposed(0.038)}, "of G is clipped; exposure.time_s: auto"),
        ({"olpf": camsim.FourSpotOlpf(split_um=12.0)}, "split of 12 µm is 3 pitches of 4 µm; low-pass"),
        ({"olpf": camsim.FourSpotOlpf(split_um=3.0, split_y_um=1.0)}, "split of 1 µm is 0.25 pitches of 4 µm"),
        ({"olpf": camsim.TwoSpotOlpf(split_um=4.0, rotate_deg=45.0)}, ""),
        ({"olpf": None}, ""),
        ({"lens": camsim.Gaussian(sigma_um=1.0, f_number=0.5)}, ""),
        ({"dark_current": camsim.DarkCurrent(2000.0), "exposure": exposed(0.01)},
         "holds 20 e⁻ (5 DN) of dark current in the mean, which mean_electrons and truth, of light alone, do not"),
        ({"dark_current": camsim.DarkCurrent(2000.0), "exposure": exposed(0.01), "noise": False}, ""),
        ({"full_well": camsim.FullWell(50000.0)}, "the well is never seen full"),
        ({"prnu": camsim.Prnu(0.15)}, "a PRNU of 0.15 is 15 % of the signal; sensors have about 1 %, and prnu is a fr"),
        ({"exposure": camsim.Exposure(time_s="auto", iso=50)},
         "ISO 50 is below the base of 100: a code stands for 8 e⁻, the well holds no more than at the base, and white "
         "is 1975 DN of 4095; cameras that offer it expose as at ISO 100"),
        ({"exposure": camsim.Exposure(time_s="auto", iso=25), "full_well": None},
         "a code stands for 16 e⁻, and white for 63920 e⁻, more than at the base, as no full well ends it"),
    ],
)  # fmt: skip
def test_what_surprises_is_said(changes: dict[str, Any], said: str) -> None:
    found = notes(**changes)
    assert said in found
    assert found.count("\n") == 0
    assert bool(said) == bool(found)


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
