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
from tests.tables import rows

POINTS = ((400.0, 550.5, 700.0), (0.1, 0.35, 0.2))

Case = tuple[str | bytes, str | int | None]


def in_file(text: str, column: str = "") -> Case:
    """Return the text of a row of a table, and the column that it names, by its number or by its name."""
    for mark, meant in (("\\n", "\n"), ("\\t", "\t"), ("\\r", "\r")):
        text = text.replace(mark, meant)
    return text, int(column) if column.isdigit() else column or None


# The same three points, as programs and people write them; the column that is meant.
FILES = {name: in_file(*rest) for name, *rest in rows("curves.txt", "as people")} | {
    "micrometres of Windows": ("Wellenlänge (µm);QE\n0,4;0,1\n0,5505;0,35\n0,7;0,2\n".encode("cp1252"), None),
    "Excel's Unicode text": ("nm\tQE\r\n400\t0.1\r\n550.5\t0.35\r\n700\t0.2\r\n".encode("utf-16"), None),
}


@pytest.mark.parametrize("case", FILES)
def test_files_as_people_have_them(tmp_path: Path, case: str) -> None:
    text, column = FILES[case]
    (tmp_path / "qe.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    curve = camsim.Curve.from_csv(tmp_path / "qe.csv", column=column, outside="hold")
    assert (curve.wavelength_nm, curve.values, curve.outside) == (*POINTS, "hold")


REFUSED = {name: (said, in_file(text, *rest)) for name, text, said, *rest in rows("curves.txt", "refused")}
REFUSED["no table"] = ("not a text; a table of numbers is wanted", (b"\x89PNG\r\n1\0\0", None))


@pytest.mark.parametrize("case", REFUSED)
def test_one_sentence_for_what_cannot_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, case: str) -> None:
    said, (text, column) = REFUSED[case]
    monkeypatch.chdir(tmp_path)
    Path("qe.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(CamsimError) as caught:
        camsim.Curve.from_csv("qe.csv", column=column)
    assert "'qe.csv'" in str(caught.value)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


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
