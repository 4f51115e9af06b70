"""optiland's own transfer functions of the shipped lenses, and a Zemax prescription imported through it."""

from __future__ import annotations

import math
import runpy
from pathlib import Path

import numpy as np
import pytest

import camsim
from camsim.config.lens_import import import_zemax

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
