"""optiland's own transfer functions of the shipped lenses, and a Zemax prescription imported through it."""

import dataclasses
import importlib.util
import math
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

import camsim
from camsim.config.lens_glass import by_name
from camsim.config.lens_import import _prescription, _read, import_zemax
from camsim.errors import InputError
from tests.tables import rows

# Importing optiland takes two seconds, which tests of other things need not wait for.
there = importlib.util.find_spec("optiland")
pytestmark = [pytest.mark.clients, pytest.mark.skipif(there is None, reason="the extra lens is not installed")]

MAKE = runpy.run_path(str(Path(__file__).parents[2] / "lenses" / "make.py"), run_name="make")
LINE_PAIRS_PER_MM = np.array([10.0, 20.0, 40.0])

DATA = Path(__file__).parents[1] / "data"
SINGLET = (DATA / "singlet.zmx").read_text(encoding="utf-8")


def optic_of(name):
    """A shipped lens as optiland has it."""
    from optiland.materials import AbbeMaterial
    from optiland.optic import Optic

    stated, optic = MAKE["LENSES"][name], Optic()
    optic.surfaces.add(index=0, radius=math.inf, thickness=math.inf)
    for index, (radius, thickness, glass, stop, *asphere) in enumerate(stated.surfaces, start=1):
        more = {} if glass is None else {"material": glass}
        if isinstance(glass, tuple) and isinstance(glass[0], float):
            more["material"] = AbbeMaterial(*glass, model="buchdahl")
        for conic, coefficients in asphere:
            more |= {"surface_type": "odd_asphere", "conic": conic, "coefficients": [0.0, 0.0, *coefficients]}
        optic.surfaces.add(index=index, radius=radius, thickness=thickness, is_stop=stop, **more)
    optic.surfaces.add(index=len(stated.surfaces) + 1)
    kind, value = stated.aperture
    optic.set_aperture(aperture_type={"FNO": "imageFNO"}.get(kind, kind), value=value)
    optic.fields.set_type(field_type="angle")
    for share in (0.0, 1.0):
        optic.fields.add(y=share * stated.half_deg)
    optic.wavelengths.add(value=0.55, is_primary=True)
    return optic


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", ["cooke-triplet", "double-gauss", "mobile"])
def test_rays_are_optilands(name):
    """Places and path lengths of rays through the paraxial entrance pupil."""
    optic, stated = optic_of(name), MAKE["prescription_of"](MAKE["LENSES"][name])
    lens = dataclasses.replace(stated, aim=False).of_wavelengths((450.0, 650.0))
    places = np.array([[0.0, 0.6, 0.0, -0.5, 0.9], [0.0, 0.0, 0.7, 0.4, 0.3]])
    full = math.radians(MAKE["LENSES"][name].half_deg)
    for share in (0.0, 0.6):
        beam = lens.beams([share * full], places)[0]
        for w, um in enumerate((0.45, 0.65)):
            angle_share = np.full(places.shape[1], share)
            rays = optic.trace_generic(angle_share, 0.0 * angle_share, places[0], places[1], um)
            np.testing.assert_allclose(beam.fallen_mm[:, w], [rays.x, rays.y], atol=1e-6)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", ["cooke-triplet", "double-gauss", "mobile"])
def test_optilands_transfer_on_the_axis_is_that_of_the_file(name):
    """Off the axis optiland's pupil is not aimed at the stop, and no ellipse; tests/config asks another trace there."""
    from optiland.mtf import FFTMTF

    optic, lens = optic_of(name), camsim.read_lens(name)
    per_um = LINE_PAIRS_PER_MM / 1e3
    for nm in (450.0, 550.0, 650.0):
        theirs = FFTMTF(optic, fields=[(0.0, 0.0)], wavelength=nm / 1e3, num_rays=256, grid_size=1024)
        # It counts frequencies by focal length over pupil, where the cone of light is as wide as its sine.
        counted = float(optic.paraxial.FNO()) / lens.f_number
        frequencies, curve = counted * np.ravel(theirs.freq[0]), np.ravel(theirs.mtf[0][0])
        each = np.abs(lens.at(0.0, 0.0).otf(per_um, 0 * per_um, nm))
        assert np.abs(each - np.interp(LINE_PAIRS_PER_MM, frequencies[: curve.size], curve)).max() <= 0.01


def test_the_mobile_lens_is_that_of_another_program():
    """Rays at 587.56 nm as ray-optics prints them of the same patent: the chief one and the upper one, field 22.46°."""
    lens = MAKE["prescription_of"](MAKE["LENSES"]["mobile"]).of_wavelengths((587.5618,))
    [beam] = dataclasses.replace(lens, aim=False).beams([math.asin(0.382041)], np.array([[0.0, 1.0], [0.0, 0.0]]))
    np.testing.assert_allclose(beam.fallen_mm[0, 0], [2.37370, 2.41684], atol=1e-5)


@pytest.mark.filterwarnings("ignore")
def test_a_zemax_file_becomes_a_lens(tmp_path):
    prescription, made = tmp_path / "singlet.zmx", tmp_path / "singlet.yaml"
    prescription.write_text(SINGLET, encoding="utf-8")
    made.write_text(import_zemax(prescription), encoding="utf-8")
    lens = camsim.read_lens(made)  # 1.4 mm before its focus, so that its f-number is that of the focus
    focal_mm = 97.6  # of the lensmaker's equation, n = 1.5185 at 550 nm: 1/f = 0.5185·(0.02 − 0.5185·5·1e-4/1.5185)
    assert abs(1 / (0.5185 * (0.02 - 0.5185 * 5e-4 / 1.5185)) / 1.0 - focal_mm) < 1.0
    assert abs(lens.f_number - focal_mm / 10.0) < 0.1
    assert abs(lens.height_um[-1] / 1e3 - focal_mm * math.tan(math.radians(5.0))) < 0.3


def in_unit(unit, mm):
    """The singlet with lengths in another unit."""
    lengths = {"ENPD 10.0": 10.0, "DISZ 5\n": 5.0, "DISZ 94.5": 94.5}
    text = SINGLET.replace("UNIT MM", f"UNIT {unit}").replace("CURV 0.01", f"CURV {0.01 * mm!r}")
    text = text.replace("CURV -0.01", f"CURV {-0.01 * mm!r}")
    for said, length in lengths.items():
        text = text.replace(said, f"{said.split()[0]} {length / mm!r}" + "\n" * said.endswith("\n"))
    return text


@pytest.mark.filterwarnings("ignore")
def test_one_lens_told_in_many_ways(tmp_path):
    """One singlet told in four units, in none, and by its stop, is one lens."""
    prescription, tables = tmp_path / "singlet.zmx", []
    stated = [(in_unit(unit, mm), "utf-8") for unit, mm in (("MM", 1.0), ("CM", 10.0), ("METER", 1000.0))]
    stated += [(in_unit("IN", 25.4), "utf-16"), (SINGLET.replace("UNIT MM", "NOTE"), "utf-8")]
    # A stop that the pupil floats by: as Zemax writes it, by half of its diameter.
    stated += [(SINGLET.replace("ENPD 10.0", "FLOA").replace("  STOP\n", '  STOP\n  DIAM 5.0 1 0 0 1 ""\n'), "utf-8")]
    for text, encoding in stated:
        prescription.write_text(text, encoding=encoding)
        tables.append(yaml.safe_load(import_zemax(prescription)))
    for table in tables[1:]:
        assert table["f_number"] == tables[0]["f_number"]
        np.testing.assert_allclose(table["height_um"], tables[0]["height_um"], atol=0.002)
        assert table["zernike"] == tables[0]["zernike"]
        np.testing.assert_allclose(np.array(table["waves"], float), np.array(tables[0]["waves"], float), atol=2e-5)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(("said", "instead", "sentence"), rows("wrong-prescriptions.txt", "Zemax"))
def test_a_zemax_file_that_would_be_read_wrongly_is_refused(tmp_path, said, instead, sentence):
    prescription = tmp_path / "singlet.zmx"
    text = SINGLET.replace(said.replace("\\n", "\n"), instead.replace("\\n", "\n"))
    assert text != SINGLET
    prescription.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=rf"^'singlet\.zmx' has .*{sentence}"):
        import_zemax(prescription)


FULL_MM = 8.0


def test_what_stops_the_axis_is_the_stop(tmp_path):
    """An aperture that is narrower than the entrance pupil, and vignetting factors that say the same."""
    prescription, pupils = tmp_path / "singlet.zmx", []
    for said, instead in (
        ("  STOP\n", "  STOP\n  CLAP 0 4 0\n"),
        ("WAVM 1", "VCXN 0.2 0.2\nVCYN 0.2 0.2\nWAVM 1"),
        ("ENPD 10.0", "ENPD 8.0"),
    ):
        prescription.write_text(SINGLET.replace(said, instead), encoding="utf-8")
        pupils.append(yaml.safe_load(import_zemax(prescription)))
    for one in pupils[:2]:
        assert one["f_number"] == pytest.approx(pupils[2]["f_number"], rel=1e-3)
        assert one["height_um"] == pytest.approx(pupils[2]["height_um"], rel=1e-3)


def test_a_field_is_told_in_many_ways(tmp_path):
    """By the angle, by the height in the paraxial and in the real image, and by the command."""
    prescription, heights = tmp_path / "singlet.zmx", []
    for text, more in (
        (SINGLET.replace("FTYP 0", "FTYP 3").replace("YFLN 0 5", f"YFLN 0 {FULL_MM}"), {}),
        (SINGLET.replace("YFLN 0 5", "YFLN 0 0"), {"field_mm": FULL_MM}),
        (SINGLET.replace("FTYP 0", "FTYP 2").replace("YFLN 0 5", f"YFLN 0 {FULL_MM}"), {}),
    ):
        prescription.write_text(text, encoding="utf-8")
        heights.append(yaml.safe_load(import_zemax(prescription, **more))["height_um"][-1] / 1e3)
    assert heights[0] == pytest.approx(FULL_MM, abs=2e-6)
    assert heights[1] == pytest.approx(FULL_MM, abs=2e-6)
    # Of a stop at the lens there is little distortion.
    assert heights[2] == pytest.approx(FULL_MM, rel=2e-3)
    angle_deg = math.degrees(math.atan(FULL_MM / 97.0))
    by_angle = yaml.safe_load(import_zemax(prescription, field_deg=angle_deg))["height_um"][-1] / 1e3
    assert by_angle == pytest.approx(FULL_MM, rel=0.02)


def test_wavelengths_in_one_line_are_read(tmp_path):
    prescription = tmp_path / "singlet.zmx"
    prescription.write_text(SINGLET.replace("WAVM 1 0.55 1", "WAVL 0.48 0.55 0.65").replace("PWAV 1", "PWAV 2"))
    stated = import_zemax(prescription)
    prescription.write_text(SINGLET, encoding="utf-8")
    assert import_zemax(prescription) == stated


def test_rays_are_aimed_at_the_stop_where_the_file_says_so(tmp_path):
    """A stop far behind a lens, which sees it through aberrations: rims' rays meet its rim."""
    behind = """\
  DISZ 20
SURF 3
  STOP
  TYPE STANDARD
  CURV 0.0
  DISZ 74.5
SURF 4"""
    text = SINGLET.replace("  STOP\n", "").replace("  DISZ 94.5\nSURF 3", behind).replace("YFLN 0 5", "YFLN 0 12")
    met = []
    for aims in (0, 2):
        prescription = tmp_path / "behind.zmx"
        prescription.write_text(text.replace("FTYP", f"RAIM 0 {aims} 1 1 0 0 0\nFTYP"), encoding="utf-8")
        stated, _ = _prescription(*_read(prescription), "behind.zmx")
        lens = stated.of_wavelengths((550.0,))
        turned = np.linspace(0.0, 2.0 * np.pi, 9)
        beams = lens.beams([0.0, math.radians(12.0)], np.stack([np.cos(turned), np.sin(turned)]))
        stop = lens.trace(math.radians(12.0), beams[1].entry_mm).stop_mm
        met.append(np.abs(np.hypot(*stop) / lens.stop_mm - 1.0).max())
    assert met[0] > 0.005
    assert met[1] < 1e-6


def test_what_is_written_is_read_and_says_what_it_leaves(tmp_path):
    """A mirror, whose focal length is negative by its surfaces; and a singlet with more waves than a file holds."""
    mirror = SINGLET.split("SURF 1")[0].replace("ENPD 10.0", "ENPD 100.0").replace("YFLN 0 5", "YFLN 0 0.25")
    mirror += (
        "SURF 1\n  STOP\n  CURV -0.000625\n  CONI -1\n  DISZ -800\n  GLAS MIRROR 0 0\nSURF 2\n  CURV 0\n  DISZ 0\n"
    )
    blurred = SINGLET.replace("DISZ 94.5", "DISZ 60").replace("ENPD 10", "ENPD 20")
    ended = {}
    for name, text in (("mirror", mirror), ("blurred", blurred)):
        (tmp_path / f"{name}.zmx").write_text(text, encoding="utf-8")
        command = [sys.executable, "-m", "camsim", "lens", "import", f"{name}.zmx", "-o", f"{name}.yaml"]
        ended[name] = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert ended["mirror"].returncode == 0, ended["mirror"].stderr
    assert "waves rms; MTF off the rays' by 0.000" in ended["mirror"].stdout
    assert camsim.read_lens(tmp_path / "mirror.yaml").f_number == pytest.approx(8.0, rel=2e-3)
    assert ended["blurred"].returncode == 2
    assert "waves rms, and a lens file holds 50; give it a smaller field (--field)" in ended["blurred"].stderr
    assert not (tmp_path / "blurred.yaml").exists()


@pytest.mark.filterwarnings("ignore")
def test_a_glass_is_the_nearest_of_its_name():
    """Of two measurements of fluorite that of the file's own index, of a model what has its name; printed indices."""
    d_nm = np.array([587.5618])
    for stated, right in (((1.43388, 95.15), 1.43388), ((1.43385, 95.0), 1.43385), (None, 1.43385)):
        assert by_name("CAF2", (), stated)[0](d_nm)[0] == pytest.approx(right, abs=5e-6)
    index, note = by_name("N-SK16", ("SCHOTT",), (1.6207047, 60.2795))
    assert index(d_nm)[0] == pytest.approx(1.62041, abs=1e-6)
    assert note == "N-SK16 of the catalogue, index 1.62041; the file has 1.62070"
    index, note = by_name("N-SK16", ("SCHOTT",), (1.7, 50.0))
    assert index(d_nm)[0] == pytest.approx(1.7, abs=1e-6)
    assert "own index 1.7" in note


@pytest.mark.filterwarnings("ignore")
def test_a_model_glass_may_have_the_numbers_that_elsewhere_are_none(tmp_path):
    """1.5 and 40 behind a 1: n = 1.5 by the lensmaker's equation; behind a 0 they stand beside every glass."""
    prescription, heights = tmp_path / "singlet.zmx", []
    for line in ("___BLANK 1 0 1.5 40", "N-BK7 0 0 1.5 40"):
        prescription.write_text(SINGLET.replace("N-BK7 0 0 1.5168 64.17", line), encoding="utf-8")
        stated, _ = _prescription(*_read(prescription), "singlet.zmx")
        heights.append(stated.of_wavelengths((587.5618,)).index[0].item())
    assert heights == [pytest.approx(1.5, abs=1e-5), pytest.approx(1.5168, abs=1e-5)]


@pytest.mark.filterwarnings("ignore")
def test_rays_that_are_lost_as_they_are_not_aimed_are_said_to_be(tmp_path):
    """A stop far behind a strong lens, seen from 50°: aimed rays find it."""
    behind = SINGLET.replace("  STOP\n", "").replace("CURV 0.01\n", "CURV -0.05\n").replace("YFLN 0 5", "YFLN 0 55")
    behind = behind.replace("  DISZ 94.5\n", "  DISZ 30\nSURF 3\n  STOP\n  CURV 0\n  DISZ 20\n").replace(
        "SURF 3\n  TYPE", "SURF 4\n  TYPE"
    )
    prescription = tmp_path / "behind.zmx"
    prescription.write_text(behind, encoding="utf-8")
    with pytest.raises(InputError, match=r"no chief ray past .* aim its rays at the stop \(RAIM 0 2 in place of RAIM"):
        import_zemax(prescription)
