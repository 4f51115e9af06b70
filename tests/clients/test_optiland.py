"""optiland's own transfer functions of the shipped lenses, and a Zemax prescription imported through it."""

from __future__ import annotations

import math
import runpy
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

import camsim
from camsim.config import lens_import
from camsim.config.lens_import import import_zemax
from camsim.errors import InputError

pytestmark = pytest.mark.clients
pytest.importorskip("optiland", reason="the extra lens is not installed")

MAKE = runpy.run_path(str(Path(__file__).parents[2] / "lenses" / "make.py"), run_name="make")
LINE_PAIRS_PER_MM = np.array([10.0, 20.0, 40.0])

SINGLET = """\
VERS 181022
MODE SEQ
NAME singlet
UNIT MM X W X CM MR CPMM
ENPD 10.0
FTYP 0 0 2 3 0 0 0
XFLN 0 0
YFLN 0 5
WAVM 1 0.55 1
PWAV 1
SURF 0
  TYPE STANDARD
  CURV 0.0
  DISZ INFINITY
SURF 1
  STOP
  TYPE STANDARD
  CURV 0.01
  DISZ 5
  GLAS N-BK7 0 0 1.5168 64.17
SURF 2
  TYPE STANDARD
  CURV -0.01
  DISZ 94.5
SURF 3
  TYPE STANDARD
  CURV 0.0
  DISZ 0
"""


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", ["cooke-triplet", "double-gauss", "mobile"])
def test_optilands_transfer_is_that_of_the_file(name):
    """Where pupils overlap as much: off the axis optiland's cone of light is an ellipse, and camsim's a circle.

    By how much frequencies differ for that is said in docs/field.md.
    """
    from optiland.mtf import FFTMTF

    optic, lens = MAKE["optic_of"](MAKE["LENSES"][name]), camsim.read_lens(name)
    per_um = LINE_PAIRS_PER_MM / 1e3
    for nm in (450.0, 550.0, 650.0):
        on_axis = None
        for share in (0.0, 0.5, 1.0):
            theirs = FFTMTF(optic, fields=[(share, 0.0)], wavelength=nm / 1e3, num_rays=256, grid_size=1024)
            on_axis = np.ravel(theirs.freq[0]) if on_axis is None else on_axis
            chief_um = 1e3 * abs(np.ravel(optic.trace_generic(share, 0.0, 0.0, 0.0, 0.55).x)[0])
            placed = lens.at(min(float(chief_um), lens.height_um[-1]), 0.0)
            # The field lies along x. optiland's first curve is along y, whatever it is called.
            ours = [np.abs(placed.otf(0 * per_um, per_um, nm)), np.abs(placed.otf(per_um, 0 * per_um, nm))]
            for own, curve in zip(ours, theirs.mtf[0], strict=True):
                values = np.ravel(curve)
                assert np.abs(own - np.interp(LINE_PAIRS_PER_MM, on_axis[: values.size], values)).max() <= 0.01


@pytest.mark.filterwarnings("ignore")
def test_the_mobile_lens_is_that_of_another_program():
    """Rays at 587.56 nm as ray-optics prints them of the same patent: the chief one and the upper one, field 22.46°."""
    optic = MAKE["optic_of"](MAKE["LENSES"]["mobile"])
    share = math.degrees(math.asin(0.382041)) / 31.76
    for pupil, right_mm in ((0.0, 2.37370), (1.0, 2.41684)):
        assert abs(np.ravel(optic.trace_generic(0.0, share, 0.0, pupil, 0.5875618).y)[0] - right_mm) < 1e-5


@pytest.mark.filterwarnings("ignore")
def test_a_zemax_file_becomes_a_lens(tmp_path):
    prescription, made = tmp_path / "singlet.zmx", tmp_path / "singlet.yaml"
    prescription.write_text(SINGLET, encoding="utf-8")
    made.write_text(import_zemax(prescription), encoding="utf-8")
    lens = camsim.read_lens(made)
    focal_mm = 97.6  # of the lensmaker's equation, n = 1.5185 at 550 nm: 1/f = 0.5185·(0.02 − 0.5185·5·1e-4/1.5185)
    assert abs(1 / (0.5185 * (0.02 - 0.5185 * 5e-4 / 1.5185)) / 1.0 - focal_mm) < 1.0
    assert abs(lens.f_number - focal_mm / 10.0) < 0.1
    assert abs(lens.height_um[-1] / 1e3 - focal_mm * math.tan(math.radians(5.0))) < 0.3


def counted(optic, inner_mm, outer_mm, shares):
    """The light of an even sky that falls into a ring of the flat sensor, ray by ray, over the ring's area."""
    draws = np.random.default_rng(7)
    share = shares[0] + (shares[1] - shares[0]) * (np.arange(200_000) + draws.random(200_000)) / 200_000
    radius, angle = np.sqrt(draws.random(share.size)), 2.0 * np.pi * draws.random(share.size)
    rays = optic.trace_generic(share, 0.0 * share, radius * np.cos(angle), radius * np.sin(angle), 0.55)
    theta = np.radians(share * float(optic.fields.max_field))
    of_sky = np.sin(theta) * np.cos(theta) * (shares[1] - shares[0])
    fallen = np.hypot(rays.x, rays.y)
    ring = (fallen >= inner_mm) & (fallen < outer_mm) & (np.asarray(rays.i) > 0.0)
    return of_sky[ring].sum() / (outer_mm**2 - inner_mm**2)


def judge_light(optic, lens):
    heights_mm = np.array(lens.height_um) / 1e3
    on_axis = counted(optic, 0.0, 0.5 * heights_mm[1], (0.0, 0.08))
    for share, k in ((0.5, 6), (10 / 12, 10)):
        reach_mm = 0.3 * (heights_mm[k + 1] - heights_mm[k])
        right = counted(optic, heights_mm[k] - reach_mm, heights_mm[k] + reach_mm, (share - 0.06, share + 0.06))
        # The axis's ring is a part of the field whose light falls by 0.1 to 0.3 %.
        assert lens.relative_illumination[k] == pytest.approx(right / on_axis, rel=0.01)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", ["cooke-triplet", "double-gauss", "mobile"])
def test_the_light_of_the_file_is_that_of_rays_counted_on_the_sensor(name):
    judge_light(MAKE["optic_of"](MAKE["LENSES"][name]), camsim.read_lens(name))


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("aperture", ["", "  CLAP 0 5.2 0\n"], ids=["open", "vignetted"])
def test_a_curved_field_and_rims_of_glass_cost_light(tmp_path, monkeypatch, aperture):
    """20° off the axis the image lies millimetres before the sensor: the cone of light alone would say 1.07."""
    from optiland.fileio import load_zemax_file

    monkeypatch.setattr(lens_import, "WAVELENGTHS_NM", (550.0,))
    prescription = tmp_path / "singlet.zmx"
    wide = SINGLET.replace("YFLN 0 5", "YFLN 0 20").replace("  CURV -0.01\n", f"  CURV -0.01\n{aperture}")
    prescription.write_text(wide, encoding="utf-8")
    table = yaml.safe_load(import_zemax(prescription))  # which has more waves than a lens is taken with
    judge_light(load_zemax_file(str(prescription)), SimpleNamespace(**table))


def in_unit(unit, mm):
    """The singlet with lengths in another unit."""
    lengths = {"ENPD 10.0": 10.0, "DISZ 5\n": 5.0, "DISZ 94.5": 94.5}
    text = SINGLET.replace("UNIT MM", f"UNIT {unit}").replace("CURV 0.01", f"CURV {0.01 * mm!r}")
    text = text.replace("CURV -0.01", f"CURV {-0.01 * mm!r}")
    for said, length in lengths.items():
        text = text.replace(said, f"{said.split()[0]} {length / mm!r}" + "\n" * said.endswith("\n"))
    return text


@pytest.mark.filterwarnings("ignore")
def test_one_lens_told_in_many_ways(tmp_path, monkeypatch):
    """One singlet told in four units, in none, and by its stop, is one lens."""
    monkeypatch.setattr(lens_import, "WAVELENGTHS_NM", (550.0,))
    prescription, tables = tmp_path / "singlet.zmx", []
    told = [(in_unit(unit, mm), "utf-8") for unit, mm in (("MM", 1.0), ("CM", 10.0), ("METER", 1000.0))]
    told += [(in_unit("IN", 25.4), "utf-16"), (SINGLET.replace("UNIT MM", "NOTE"), "utf-8")]
    # A stop that the pupil floats by: as Zemax writes it, by half of its diameter.
    told += [(SINGLET.replace("ENPD 10.0", "FLOA").replace("  STOP\n", '  STOP\n  DIAM 5.0 1 0 0 1 ""\n'), "utf-8")]
    for text, encoding in told:
        prescription.write_text(text, encoding=encoding)
        tables.append(yaml.safe_load(import_zemax(prescription)))
    for table in tables[1:]:
        assert table["f_number"] == tables[0]["f_number"]
        np.testing.assert_allclose(table["height_um"], tables[0]["height_um"], atol=0.002)
        assert table["zernike"] == tables[0]["zernike"]
        np.testing.assert_allclose(np.array(table["waves"], float), np.array(tables[0]["waves"], float), atol=2e-5)


ROUND = r"rays that fall elsewhere when they are turned about the axis; .*leave out tilts, decentres and toroids"
REFUSED = {
    "feet": ("UNIT MM", "UNIT FEET", r"lengths in 'FEET'; save it in one of MM, CM, IN, METER"),
    "object heights": ("FTYP 0", "FTYP 1", r"fields by object heights \(FTYP 1\); .*fields as angles \(FTYP 0"),
    "paraxial image heights": ("FTYP 0", "FTYP 2", r"fields by paraxial image heights \(FTYP 2\); .*angles"),
    "real image heights": ("FTYP 0", "FTYP 3", r"fields by real image heights \(FTYP 3\); .*angles"),
    "near": ("DISZ INFINITY", "DISZ 1000", r"object at a finite distance; .*object at infinity \(DISZ INFINITY"),
    "axis": ("YFLN 0 5", "YFLN 0 0", r"no field but the axis; give it the largest one"),
    "hole": ("  STOP\n", "  STOP\n  OBSC 0 2 0\n", r"an obstruction \(OBSC\), .*circular apertures"),
    "rectangle": ("  STOP\n", "  STOP\n  SQAP 2 5\n", r"a rectangular aperture \(SQAP\), .*circular apertures"),
    "factors": ("WAVM 1", "VCXN 0 0\nVCYN 0 0.3\nWAVM 1", r"vignetting factors \(VCYN\), .*clear them"),
    "stopped": ("  STOP\n", "  STOP\n  CLAP 0 4 0\n", r"apertures that stop 36 % of the axis's light, .*open them"),
    "toroid": ("CURV -0.01", "TYPE TOROIDAL\n  PARM 2 -90\n  CURV -0.01", ROUND),
    "tilt": ("SURF 2\n", "SURF 2\n  TYPE COORDBRK\n  DISZ 0\n  PARM 3 1.0\nSURF 3\n", ROUND),
    "decentre": ("SURF 2\n", "SURF 2\n  TYPE COORDBRK\n  DISZ 0\n  PARM 1 0.1\nSURF 3\n", ROUND),
}


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("case", REFUSED)
def test_a_zemax_file_that_would_be_read_wrongly_is_refused(tmp_path, case):
    said, instead, sentence = REFUSED[case]
    prescription = tmp_path / "singlet.zmx"
    prescription.write_text(SINGLET.replace(said, instead), encoding="utf-8")
    with pytest.raises(InputError, match=rf"^'singlet\.zmx' has .*{sentence}"):
        import_zemax(prescription)


@pytest.mark.filterwarnings("ignore")
def test_nothing_is_written_of_what_is_refused(tmp_path):
    (tmp_path / "singlet.zmx").write_text(in_unit("FEET", 304.8), encoding="utf-8")
    command = [sys.executable, "-m", "camsim", "lens", "import", "singlet.zmx", "-o", "singlet.yaml"]
    ended = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert ended.returncode == 2
    assert "lengths in 'FEET'" in ended.stderr
    assert not (tmp_path / "singlet.yaml").exists()
