"""What type checkers make of calls: the right ones pass and run, each of the wrong ones is refused."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

RIGHT = """\
import numpy as np

import camsim

a = np.array([400.0, 500.0])
camsim.Curve([400, 500], [0.1, 0.2])
camsim.Curve((400.0, 500.0), a)
camsim.Curve(a, a, outside="hold")
camsim.Airy(f_number=8)
camsim.Airy(f_number=np.float64(8))
camsim.Airy(f_number=8.0, transmission=camsim.Curve(a, [0.5, 0.9]))
camsim.Polygon(points_um=[(0, 0), (1, 0), (0, 1)], reflectance=0.1)
camsim.Polygon(points_um=[[0, 0], [1, 0], [0, 1]], reflectance=0.1)
camsim.Polygon(points_um=np.eye(3)[:, :2], reflectance=0.1)
camsim.Wavefront(f_number=4, zernike_waves={4: 0.1})
camsim.Wavefront(f_number=4, zernike_waves=[(4, 0.1)])
camsim.Wavefront(f_number=4, zernike_waves=((4, 0.1),))
camsim.Scene(background=0.5, shapes=[camsim.Disc(radius_um=1, reflectance=0.1)])
camsim.Crosstalk([[0, 0, 0], [0, 1, 0], [0, 0, 0]])
camsim.Crosstalk(np.eye(3) / 3)
camsim.MeasuredPsf(irradiance=np.ones((3, 3)), spacing_um=1)
camsim.MeasuredPsf(irradiance=[[1.0, 2.0], [3.0, 4.0]], spacing_um=1)
camsim.Cfa(["RG", "GB"])
camsim.Cfa(("RG", "GB"))
camsim.QuantumEfficiency([("Y", camsim.Curve(a, a))], "photon", 0.5)
camsim.QuantumEfficiency((("Y", camsim.Curve(a, a)),), per="photon", peak=0.5)
camsim.QuantumEfficiency([("Y", camsim.Curve([400, 700], [0.1, 0.2]))], "energy", "as given")
camsim.Region(rows=4, cols=4, origin=(0, 0))
camsim.Defects(hot=[(1, 2, 3.0)], dead=[(1, 2)])
camsim.Light("D55", illuminance_lux=5)
camsim.Light(camsim.Curve(a, a), irradiance_w_per_m2=5)
camsim.Exposure(time_s="auto", iso=100)
camsim.RadialFalloff(radius_mm=[0, 1], values=[1.0, 0.5])
camsim.Adc(bit_depth=12, black_level_dn=1, electrons_per_dn=1, base_iso=100, black_offsets_dn=[[0, 1], [1, 0]])
camsim.PolynomialResponse([0.1], 1e4)
camsim.ResponseTable(a, [1, 2])
x: float = camsim.Curve(a, a).wavelength_nm[0]


def with_files() -> None:
    camsim.Curve.from_csv("qe.csv", column="Y")
    camsim.Curve.from_csv("qe.csv", column=2, outside="hold", name="measured").at(a)
    camsim.capture("flat-field", sensor="mine", sensors=["sensors"])
"""
WRONG = """\
import camsim

camsim.Airy(f_number="8")
camsim.Airy(8)
camsim.Curve("400", [1])
camsim.Light(5, illuminance_lux=5)
camsim.Exposure(time_s="atuo", iso=100)
camsim.Scene(background="18")
camsim.Scene(background=0.5, shapes=camsim.Disc(radius_um=1, reflectance=0.1))
camsim.Region(rows="3", cols=4)
camsim.Wavefront(f_number=4, zernike_waves=0.1)
camsim.Polygon(points_um=5, reflectance=0.1)
camsim.Adc(bit_depth=12.5, black_level_dn=1, electrons_per_dn=1, base_iso=100)
camsim.QuantumEfficiency([("Y", 3)], "photon", 0.5)
camsim.QuantumEfficiency([], "photons", 0.5)
camsim.QuantumEfficiency([], "photon", "as is")
camsim.Curve.from_csv("qe.csv", column=[1])
camsim.capture("flat-field", sensors=5)
camsim.Pupil(shape="round")
"""


def refused_lines(path: Path, text: str) -> set[int]:
    """Return the lines in which mypy finds an error."""
    path.write_text(text, encoding="utf-8")
    arguments = ("--strict", "--no-error-summary", "--cache-dir", str(path.parent), "--python-version", "3.11")
    told = subprocess.run([sys.executable, "-m", "mypy", *arguments, path.name], cwd=path.parent, capture_output=True)
    assert not told.stderr, told.stderr.decode()
    return {int(line) for line in re.findall(rf"^{path.name}:(\d+): error", told.stdout.decode(), re.MULTILINE)}


def test_type_checkers_take_right_calls_and_refuse_wrong_ones(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    assert not refused_lines(tmp_path / "right.py", RIGHT)
    wrong = {number for number, line in enumerate(WRONG.splitlines(), 1) if line.startswith("camsim.")}
    assert refused_lines(tmp_path / "wrong.py", WRONG) == wrong


def test_the_right_calls_run() -> None:
    exec(compile(RIGHT, "right.py", "exec"), {})
