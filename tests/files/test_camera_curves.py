"""Sensitivities in other people's formats, each made here as its program writes it."""

import json
from pathlib import Path

import numpy as np
import pytest
import scipy

from camsim.errors import InputError, UnknownNameError
from camsim.files.camera_curves import camera_of, read_cameras
from tests.tables import rows

NM = np.arange(380.0, 781.0, 5.0)
VALUES = np.random.default_rng(1).uniform(0.0, 0.6, (NM.size, 3))
JIANG_NM = np.arange(400, 721, 10)


def rawtoaces(path: Path, values: np.ndarray = VALUES, index: tuple[str, ...] = ("R", "G", "B")) -> None:
    """As the Academy's camera data are written, schema 0.1.0."""
    data = {f"{nm:g}": row.tolist() for nm, row in zip(NM, values, strict=True)}
    spectral = {
        "units": "relative", "reflection_geometry": None, "transmission_geometry": None, "bandwidth_FWHM": None,
        "bandwidth_corrected": None, "index": {"main": list(index)}, "data": {"main": data},
    }  # fmt: skip
    header = {"schema_version": "0.1.0", "catalog_number": None, "manufacturer": "Acme", "model": "One"}
    path.write_text(json.dumps({"header": header, "spectral_data": spectral}), "utf-8")


def jiang(path: Path, names: tuple[str, ...] = ("Canon 1DMarkIII", "Nikon D40"), count: int = 33) -> np.ndarray:
    values = np.random.default_rng(2).uniform(0.0, 1.0, (len(names), 3, count)).round(6)
    lines = []
    for name, camera in zip(names, values, strict=True):
        lines += [name, *("\t".join(f"{value:.6f}" for value in row) + "\t" for row in camera)]
    path.write_text("\r\n".join(lines) + "\r\n", "utf-8")
    return values


def test_rawtoaces(tmp_path: Path) -> None:
    rawtoaces(tmp_path / "one.json")
    [camera] = read_cameras(tmp_path / "one.json")
    assert (camera.name, camera.per, camera.absolute, camera.whole) == ("Acme One", "energy", False, True)
    for k, letter in enumerate("RGB"):
        assert camera.curves[letter].at(NM) == pytest.approx(VALUES[:, k])
        assert camera.curves[letter].outside == "zero"


def test_the_28_cameras(tmp_path: Path) -> None:
    values = jiang(tmp_path / "camspec_database.txt")
    cameras = read_cameras(tmp_path / "camspec_database.txt")
    assert [camera.name for camera in cameras] == ["Canon 1DMarkIII", "Nikon D40"]
    for camera, one in zip(cameras, values, strict=True):
        assert list(camera.curves) == ["R", "G", "B"]
        for letter, row in zip("RGB", one, strict=True):
            assert camera.curves[letter].at(JIANG_NM.astype(float)) == pytest.approx(row)
    assert camera_of(tmp_path / "camspec_database.txt", "Nikon D40").name == "Nikon D40"
    with pytest.raises(InputError, match="has 2 cameras; say which by --camera: Canon 1DMarkIII, Nikon D40"):
        camera_of(tmp_path / "camspec_database.txt", None)
    with pytest.raises(UnknownNameError, match=r"Nikon D4O.*did you mean 'Nikon D40'"):
        camera_of(tmp_path / "camspec_database.txt", "Nikon D4O")


def test_isetcam(tmp_path: Path) -> None:
    held = {
        "wavelength": NM[:, None], "data": VALUES, "comment": "Acme",
        "filterNames": np.array(["rOne", "gOne", "bOne"], dtype=object),
    }  # fmt: skip
    scipy.io.savemat(tmp_path / "AcmeOne.mat", held)
    [camera] = read_cameras(tmp_path / "AcmeOne.mat")
    assert (camera.name, camera.per, camera.whole) == ("AcmeOne", "photon", False)
    for k, letter in enumerate("RGB"):
        assert camera.curves[letter].at(NM) == pytest.approx(VALUES[:, k])


@pytest.mark.parametrize(
    ("head", "letters", "per", "scale"),
    [
        ("wavelength / nm;QE R / %;QE G / %;QE B / %", ["R", "G", "B"], "photon", 100.0),
        ("Wavelength [nm];Red;Green;Blue", ["R", "G", "B"], "photon", 1.0),
        ("nm;QE Red [%];QE GreenR [%];QE GreenB [%]", ["R", "Gr", "Gb"], "photon", 100.0),
        ("nm;R (A/W);G (A/W);B (A/W)", ["R", "G", "B"], "energy", 1.0),
    ],
)
def test_tables_of_quantum_efficiencies(head: str, letters: list[str], per: str, scale: float, tmp_path: Path) -> None:
    rows = [f"{nm:g};" + ";".join(f"{value * scale:.6f}" for value in row) for nm, row in zip(NM, VALUES, strict=True)]
    (tmp_path / "qe.csv").write_text("\n".join([head, *rows]), "utf-8")
    [camera] = read_cameras(tmp_path / "qe.csv")
    assert (list(camera.curves), camera.per, camera.absolute) == (letters, per, True)
    for k, letter in enumerate(letters):
        assert camera.curves[letter].at(NM) == pytest.approx(VALUES[:, k], abs=1e-6)


def test_a_monochrome_chip(tmp_path: Path) -> None:
    rows = [f"{nm:g},{100 * value:.4f}" for nm, value in zip(NM, VALUES[:, 0], strict=True)]
    (tmp_path / "mono.csv").write_text("\n".join(["Wavelength [nm],QE [%]", *rows]), "utf-8")
    [camera] = read_cameras(tmp_path / "mono.csv")
    assert camera.curves["Y"].at(NM) == pytest.approx(VALUES[:, 0], abs=1e-6)


@pytest.mark.parametrize(("name", "content", "why"), rows("wrong-contents.txt", "sensitivities"))
def test_what_is_no_such_file_is_refused(name: str, content: str, why: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(eval(content))
    with pytest.raises(InputError, match=why) as refused:
        read_cameras(tmp_path / name)
    assert name in str(refused.value)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_cameras(tmp_path / "none.json")
