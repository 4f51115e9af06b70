"""Curves from CSV files: as people have them, anywhere a curve may stand, nothing from outside the file's folder."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import camsim
from camsim.api import load
from camsim.config.from_record import capture_from_record
from camsim.errors import CamsimError, ConfigError
from camsim.files.reading import read_file

POINTS = ((400.0, 550.5, 700.0), (0.1, 0.35, 0.2))

# The same three points, as programs and people write them; the column that is meant.
FILES: dict[str, tuple[str | bytes, str | int | None]] = {
    "two columns": ("wavelength_nm,QE\n400,0.1\n550.5,0.35\n700,0.2\n", None),
    "one of several": ("nm,R,G\n400,9,0.1\n550.5,9,0.35\n700,9,0.2\n", "G"),
    "a column by its number": ("400 9 0.1\n550.5 9 0.35\n700 9 0.2\n", 3),
    "a name in other letters": ("nm,Red,green \n400,9,0.1\n550.5,9,0.35\n700,9,0.2\n", "Green"),
    "a name among others, with its unit": ("nm;QE_G [%];QE_R [%]\n400;90;10\n550,5;90;35\n700;90;20\n", "R"),
    "decimal commas": ("Wellenlänge / nm;QE / %\n400;10\n550,5;35,0\n700;20\n", None),
    "decimal commas in quotes": ('"nm","QE"\n"400","0,1"\n"550,5","0,35"\n"700","0,2"\n', None),
    "decimal commas and spaces": ("400,0   0,1\n550,5   0,35\n700,0   0,2\n", None),
    "from the top down": ("nm\tQE\n700\t0.2\n550.5\t0.35\n400\t0.1\n", None),
    "micrometres": ("lambda (µm),QE\n0.4,0.1\n0.5505,0.35\n0.7,0.2\n", None),
    "micrometres of Windows": ("Wellenlänge (µm);QE\n0,4;0,1\n0,5505;0,35\n0,7;0,2\n".encode("cp1252"), None),
    "ångströms": ("# wavelength [Å], QE\n4000, 0.1\n5505, 0.35\n7000, 0.2\n", None),
    "Excel's Unicode text": ("nm\tQE\r\n400\t0.1\r\n550.5\t0.35\r\n700\t0.2\r\n".encode("utf-16"), None),
    "a data frame with its index": (",wavelength,R,G\n0,400,9,0.1\n1,550.5,9,0.35\n2,700,9,0.2\n", "G"),
    "numpy.savetxt": ("# wl R G\n4.000e+02 9 1.0e-01\n5.505e+02 9 3.5e-01\n7e2 9 2e-1\n", "G"),
    "a title, units in a row of their own": (
        "Camera 3, 20 °C\n\nwavelength,R,G\nnm,%,%\n400,9,10\n550.5,9,35\n700,9,20\n",
        "G",
    ),
    "its unit in a remark": ("# measured at home; wavelengths in µm\n0.4 0.1\n0.5505 0.35\n0.7 0.2\n", None),
    "comments and blank lines": ("# mine\nnm,QE\n\n// first\n400,0.1\n# half\n550.5,0.35\n700,0.2\n\n", None),
    "a remark above the header": ("# measured twice, in %\nnm,QE\n400,0.1\n550.5,0.35\n700,0.2\n", None),
    "cells left empty": ("nm,R,G\n400,9,0.1\n500,9,\n550.5,,0.35\n700,,0.2\n", "G"),
    "signs of per cent": ("nm;QE\n400;10%\n550.5;35 %\n700;20%\n", None),
    "signs of per cent in the header too": ("nm;T / %\n400;10%\n550.5;35 %\n700;20\n", None),
    "signs of per cent between spaces": ("400 10 %\n550.5 35 %\n700 20 %\n", 2),
    "a zero without a sign": ("nm;R;G\n400;0;10%\n550.5;5%;35%\n700;0.0;20%\n", "G"),
    "per cent in words": ("nm,QE_percent\n400,10\n550.5,35\n700,20\n", None),
    "per cent before the name": ("nm,% T\n400,10\n550.5,35\n700,20\n", None),
    "per mille": ("nm,T [‰]\n400,100\n550.5,350\n700,200\n", None),
    "percentiles": ("nm,percentile\n400,0.1\n550.5,0.35\n700,0.2\n", None),
    "per cent of another thing": ("nm,T at 45 % RH\n400,0.1\n550.5,0.35\n700,0.2\n", None),
    "per cent in prose": ("# Filter FB550, relative humidity 45 %\n400 0.1\n550.5 0.35\n700 0.2\n", None),
    "per cent in prose with as many commas": ("# Filter FB550, humidity 45 %\n400,0.1\n550.5,0.35\n700,0.2\n", None),
    "per cent in an address": ("# https://lab.org/a%20b\n400 0.1\n550.5 0.35\n700 0.2\n", None),
    "a length in prose": ("# thickness 200 um\n400 0.1\n550.5 0.35\n700 0.2\n", None),
    "a length in prose with as many commas": ("# Filter, thickness in um\n400,0.1\n550.5,0.35\n700,0.2\n", None),
    "a length beside the wavelengths": ("wavelength at 5 um steps,T\n400,0.1\n550.5,0.35\n700,0.2\n", None),
    "a length before the wavelengths": ("QE at 25 um pitch,wavelength\n.1,400\n.35,550.5\n.2,700\n", None),
    "a length before their unit": ("QE;pitch um;nm\n.1;5;400\n.35;5;550.5\n.2;5;700\n", "QE"),
    "of a length": ("x,photons/nm\n400,0.1\n550.5,0.35\n700,0.2\n", None),
    "of a length, before": ("W/m2/nm,Wavelength (nm)\n0.1,400\n0.35,550.5\n0.2,700\n", None),
    "of a length and an area, before": ("W/(m² nm);våglängd/nm\n0.1;400\n0.35;550.5\n0.2;700\n", None),
    "wavenumbers too": ("wavenumber,wavelength,T\n25000,400,.1\n18165,550.5,.35\n14286,700,.2\n", "T"),
    "ångströms as A": ("wavelength (A),T\n4000,.1\n5505,.35\n7000,.2\n", None),
    "ångströms in a remark": ("# wavelengths are given in Å\n4000 .1\n5505 .35\n7000 .2\n", None),
    "units in a comment below the names": ("wavelength,R\n# um,%\n.4,10\n.5505,35\n.7,20\n", "R"),
    "remarks, names and units in comments": ("#a\n#b\n#c\n# wavelength,R\n# um,%\n.4,10\n.5505,35\n.7,20\n", "R"),
    "names and units in comments": ("# Dr. No, 5 %\n# wavelength,R\n# um,%\n# --\n.4,10\n.5505,35\n.7,20\n", "R"),
    "a comment separated otherwise": ("# wavelength  T [%]\n400,10\n550.5,35\n700,20\n", None),
    "a comment with units between spaces": ("# T (%) wavelength / um\n10 .4\n35 .5505\n20 .7\n", None),
    "a header separated otherwise": ("T [%], wavelength [um]\n10 .4\n35 .5505\n20 .7\n", None),
    "names without wavelengths in a comment": ("# x y z\n400 0.1 9\n550.5 0.35 9\n700 0.2 9\n", "y"),
    "three decimals": ("nm;QE\n400;0,100\n550,5;0,350\n700;0,200\n", None),
}


@pytest.mark.parametrize("case", FILES)
def test_files_as_people_have_them(tmp_path: Path, case: str) -> None:
    text, column = FILES[case]
    (tmp_path / "qe.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    curve = camsim.Curve.from_csv(tmp_path / "qe.csv", column=column, outside="hold")
    assert (curve.wavelength_nm, curve.values, curve.outside) == (*POINTS, "hold")


REFUSED: dict[str, tuple[str | bytes, str | int | None, str]] = {
    "no such column": ("nm,R,G\n1,1,1\n", "QE", "has no column 'QE' (known: R, G)"),
    "which column": ("nm,R,G\n1,1,1\n", None, "has the columns 'R', 'G'; say which, as column: 'R'"),
    "a number too high": ("400 1 1\n500 2 2\n", 4, "has no column 4 (known: 2, 3)"),
    "a name twice": ("nm,R,R\n400,1,1\n", "R", "has 2 columns 'R'; give its number"),
    "a wavelength twice": ("nm,R\n400,1\n500,2\n400,3\n", None, "line 4: 400 nm is there twice, first on line 2; keep"),
    "not a number": ("nm,R\n400,NaN\n", None, "line 2: 'NaN' is no number; leave a cell empty where nothing was"),
    "a remark below": ("nm,R\n400,1\n500,2\nmine, 2020\n", None, "line 4: 'mine' is no number"),
    "below zero": ("nm,R\n400,-0.01\n", None, "line 2: -0.01 is below 0; a spectrum is not, write 0"),
    "commas that do all": ("nm,R\n400,0,5\n", None, "line 2: 3 cells, and the header has 2; of numbers with decimal"),
    "two decimal marks": ("nm;R\n400,5;1\n500;0.5\n", None, "line 3: '0.5', where numbers above have a ','; use one"),
    "thousands": ("nm;R\n400;1.000,5\n", None, "'1.000,5' is no number; write it with one decimal mark and nothing"),
    "no unit": ("lambda,R\n0.4,1\n0.7,1\n", None, "wavelengths from 0.4 to 0.7 nm are no light; name their unit in"),
    "one wavelength too short": ("nm,R\n40,1\n700,1\n", None, "wavelengths from 40 to 700 nm are no light"),
    "wavenumbers": ("cm-1,R\n20000,1\n25000,1\n", None, "'cm-1' is no wavelength; give nm or µm"),
    "wavenumbers by name": ("wavenumber,T\n10000,.5\n20000,.6\n", None, "'wavenumber' is no wavelength; give nm or µm"),
    "wavenumbers in a comment": ("# wavenumber T\n1e4 .5\n2e4 .6\n", None, "line 1: 'wavenumber' is no wavelength"),
    "wavenumbers in 1/µm": ("um^-1,T\n1,.5\n2,.6\n", None, "'um^-1' is no wavelength; give nm or µm"),
    "frequencies": ("frequency,T\n400,.5\n700,.6\n", None, "'frequency' is no wavelength; give nm or µm"),
    "energies": ("E (meV),T\n1400,.5\n1700,.6\n", None, "'E (meV)' is no wavelength; give nm or µm"),
    "too long for light": ("wavelength_um,R\n400,.5\n700,.6\n", None, "from 400000 to 700000 nm are no light; give nm"),
    "two units of length": ("nm (not um),R\n400,.5\n700,.6\n", None, "'nm (not um)' in two units; name one, such as"),
    "two units in remarks": ("# wavelength nm, wavelength um,\n40 1\n70 1\n", None, "'wavelengths' in two units; name"),
    "two columns of wavelengths": ("nm,R,nm,G\n400,.5,410,.2\n", "G", "'nm' (1) and 'nm' (3) are columns of"),
    "per cent of what": ("nm,Filter 2 %\n400,.5\n700,.6\n", None, "'Filter 2 %' may be of per cent or not; write [%]"),
    "per cent of a range": ("nm,T (0-100 %)\n400,.5\n700,.6\n", None, "'T (0-100 %)' may be of per cent or not; write"),
    "per cent in a remark": ("# by me\n# T in %\n400 .5\n700 .6\n", None, "line 2: '%' stands in no header, and may"),
    "Å in a remark": ("# all in Å\n4000 .5\n7000 .6\n", None, "line 1: 'å' stands in no header, and may be the"),
    "per cent and per mille": ("nm,% or ‰\n400,5\n700,6\n", None, "'% or ‰' in two units; name one, such as [%]"),
    "a sign in some cells": ("nm,R\n400,50%\n500,0\n700,0.6\n", None, "line 4: '0.6' has no %, and other cells have"),
    "a sign at a wavelength": ("nm,R\n400%,.5\n700,.6\n", None, "line 2: '400%' is no number"),
    "densities": ("nm,OD\n400,.5\n700,.6\n", None, "'OD' is a logarithm; give fractions or per cent"),
    "decibels": ("nm,T (dB)\n400,.5\n700,.6\n", None, "'T (dB)' is a logarithm; give fractions or per cent"),
    "marks between thousands": ("nm;R\n400;900\n700;1,000\n", None, "line 3: '1,000' may be 1000; write no mark"),
    "one point": ("nm,R\n400,1\n", None, "column 'R' has fewer than 2 numbers; a curve needs 2"),
    "one column": ("400\n500\n", None, "one column only; a curve needs wavelengths and values"),
    "nothing": ("", None, "no line begins with a number; give a row for each wavelength"),
    "no table": (b"\x89PNG\r\n1\0\0", None, "not a text; a table of numbers is wanted"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_one_sentence_for_what_cannot_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, case: str) -> None:
    text, column, said = REFUSED[case]
    monkeypatch.chdir(tmp_path)
    Path("qe.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(CamsimError) as caught:
        camsim.Curve.from_csv("qe.csv", column=column)
    assert "'qe.csv'" in str(caught.value)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"path": 3}, "Curve.from_csv.path: must be a text or a PathLike, not 3"),
        ({"path": "qe.csv", "column": 0}, "Curve.from_csv.column: must be a whole number of 1 or more"),
        ({"path": "qe.csv", "column": [1]}, "Curve.from_csv.column: must be a whole number of 1 or more"),
        ({"path": "qe.csv", "column": True}, "Curve.from_csv.column: must be a whole number of 1 or more"),
        ({"path": "qe.csv", "outside": "holt"}, "Curve.outside: must be 'zero' or 'hold' or None, not 'holt'; did you"),
    ],
)
def test_wrong_arguments(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: dict[str, object], said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("qe.csv").write_text("nm,R\n400,0.1\n500,0.2\n")
    with pytest.raises(CamsimError) as caught:
        camsim.Curve.from_csv(**arguments)  # type: ignore[arg-type]
    assert str(caught.value).startswith(said)


def test_files_that_are_none(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.csv")
    for name, said in (("gone.csv", "no such file"), (".", "not a file"), ("pipe.csv", "not a file"), ("a\0", "null")):
        with pytest.raises(CamsimError, match=said):
            camsim.Curve.from_csv(tmp_path / name)
    (tmp_path / "large.csv").write_bytes(b"400,1\n" * 3_000_000)
    with pytest.raises(CamsimError, match="larger than 16 MB"):
        camsim.Curve.from_csv(tmp_path / "large.csv")


TABLE = "{wavelength_nm: [300, 550.5, 900], values: [0.1, 0.35, 0.2], outside: zero}"
CSV = "# of several\nnm;a;b\n900;1;0,2\n550,5;1;0,35\n300;1;0,1\n"
LETTERS = "{{R: {0}, G: {0}, B: {0}}}"
PLACES = (
    "sensor.quantum_efficiency.curves",
    "sensor.filters",
    "lens.filters",
    "lens.transmission",
    "scene.background.reflectance",
    "scene.shapes.1.reflectance",
    "light.table",
)


def text_at(place: str, curve: str) -> str:
    if place.endswith("curves"):
        return LETTERS.format(curve)
    if place == "light.table":
        return curve.replace(", outside: zero", "")
    return f"[{curve}, 0.9]" if place.endswith("filters") else curve


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("place", PLACES)
def test_anywhere_a_curve_may_stand(place: str) -> None:
    """A file's numbers, and the same ones written out: one capture, down to its description."""
    Path("qe.csv").write_text(CSV)
    before = ["light.illuminant=null"] if place == "light.table" else []
    given, read = (
        load("good.yaml", overrides=[*before, f"{place}={text_at(place, curve)}"])
        for curve in (TABLE, "{csv: qe.csv, column: b, outside: zero}")
    )
    assert given == read
    assert given != load("good.yaml")


def test_a_capture_needs_the_file_no_more_once_it_is_taken(
    folder: Path, edited: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    (folder / "measured").mkdir()
    (folder / "measured/qe.csv").write_text("nm,R,G,B\n390,0,10,30\n500,10,60,20\n720,30,5,0\n".replace("nm,", "% nm,"))
    letters = ", ".join(f"{c}: {{csv: measured/qe.csv, column: {c}, outside: zero}}" for c in "RGB")
    edited(
        "curves: Nikon 5100 (NPL)\n  per: energy\n  peak: 0.5",
        f"curves: {{{letters}}}\n  per: photon\n  peak: 0.6",
        sensor=True,
    )
    # The sensor's files lie in the sensor's folder, wherever one stands.
    monkeypatch.chdir("/")
    frame = load(folder / "good.yaml").frame()
    camsim.save(frame, folder / "a.dng")
    shutil.rmtree(folder / "measured")
    again = capture_from_record(read_file(folder / "a.dng").description).frame()
    np.testing.assert_array_equal(again.mosaic, frame.mosaic)


def test_the_users_own_word_goes_anywhere(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    (outside := tmp_path_factory.mktemp("outside") / "qe.csv").write_text(CSV)
    word = f"scene.shapes.1.reflectance={{csv: {outside}, column: b}}"
    assert load("good.yaml", overrides=[word]).scene.shapes[1].reflectance.values == (0.1, 0.35, 0.2)


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("per", "values", "per_photon"),
    # A photon of 800 nm carries 1.5498 eV: as many A/W make an electron of each.
    [("photon", (0.25, 0.5), (0.25, 0.5)), ("energy", (0.4, 0.4), (0.4 * 3.0996, 0.4 * 1.5498))],
)
def test_absolute_efficiencies_stay_as_they_are(
    per: str, values: tuple[float, float], per_photon: tuple[float, float]
) -> None:
    Path("qe.csv").write_text(f"nm,QE\n400,{values[0] if per == 'photon' else 0.3}\n800,{values[1]}\n")
    wanted = (per_photon[0] if per == "photon" else 0.3 * 3.0996, per_photon[1])
    curve = "{csv: qe.csv, outside: zero}"
    changes = [
        f"sensor.quantum_efficiency={{curves: {{Y: {curve}}}, per: {per}, peak: as given}}",
        "sensor.cfa={kind: mono}",
        "light={line_nm: 550, illuminance_lux: 5000}",
    ]
    efficiency = load("good.yaml", overrides=changes).camera.quantum_efficiency
    np.testing.assert_allclose(efficiency.at(np.array([400.0, 800.0]))[0], wanted, rtol=1e-4)
    with pytest.raises(ConfigError, match=r"curves: as given they reach .* electrons per photon, and 1 is the most"):
        load(
            "good.yaml",
            overrides=[*changes, "sensor.quantum_efficiency.curves.Y={wavelength_nm: [400, 800], values: [1, 20]}"],
        )
