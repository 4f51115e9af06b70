"""Help, list, show, validate: nothing heavy loaded, honest about mistakes, and fit for pipes."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from camsim.api import load

from .conftest import COMMAND, Run

# One of these alone takes longer to import than the help may take to print (bench/waits.py measures that).
HEAVY = ("numpy", "numba", "scipy", "shapely", "colour", "pydantic", "yaml", "tifffile", "OpenEXR", "PIL")


def test_help_names_the_commands(camsim: Run) -> None:
    done = camsim("--help")
    assert done.returncode == 0
    for command in ("capture", "list", "show", "validate", "--version"):
        assert command in done.stdout


def test_help_imports_nothing_heavy() -> None:
    code = "import sys, camsim.cli.app; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert set(loaded.stdout.split()) & set(HEAVY) == set()


def test_version(camsim: Run) -> None:
    done = camsim("--version")
    assert done.returncode == 0
    assert done.stdout.startswith("camsim 0.")


def test_no_arguments_is_a_call_for_help(camsim: Run) -> None:
    assert "Usage: camsim" in "".join((camsim().stdout, camsim().stderr))


@pytest.mark.parametrize(
    ("what", "one"),
    [
        ("sensors", "d40-like            A 6-megapixel"),
        ("scenes", "slanted-edge       A dark square"),
        ("illuminants", "D65"),
        ("reflectances", "dark skin"),
        ("sensitivities", "Nikon 5100 (NPL)"),
    ],
)
def test_list(camsim: Run, what: str, one: str) -> None:
    done = camsim("list", what)
    assert (done.returncode, done.stderr) == (0, "")
    assert any(line.startswith(one) for line in done.stdout.splitlines())


def test_show_a_sensor(camsim: Run) -> None:
    done = camsim("show", "d40-like")
    assert (done.returncode, done.stderr) == (0, "")
    # The figures are comments: what is printed is the file again.
    printed, shipped = done.stdout, Path(__file__).parents[2] / "sensors" / "d40-like.yaml"
    assert yaml.safe_load(printed) == yaml.safe_load(shipped.read_text(encoding="utf-8"))
    figures = [line.strip("# ") for line in printed.splitlines() if line.startswith("#   ")]
    stated = {line[:18].strip(): line[18:].strip() for line in figures}
    assert stated["photosites"] == "2000 × 3008, 6.0 million"
    # 1/(2 · 4.88 µm); 1/(2 · 3.66 µm), 4.88/3.66 times as high.
    assert stated["Nyquist frequency"] == "0.10246 cycles/µm (102.5 line pairs/mm), all photosites"
    assert stated["OLPF null"] == "0.13661 cycles/µm along x and y, 1.33 of Nyquist"
    # 4095 − 128 codes of 10 e⁻ are less than the full well of 40 000 e⁻.
    assert stated["saturation"] == "39670 e⁻ at ISO 200"
    # 39670/√(39670 + 9.4516²).
    assert stated["SNR maximum"] == "199, 46.0 dB, 7.6 bits"
    assert stated["lux·s to white"].endswith("of D55 on the sensor")
    # √(9² + 10²/12) e⁻; as large as its noise: √(9.4516² + ¼) + ½ e⁻; 20·log10(39670/9.9648) dB.
    assert stated["dark noise"] == "9.45 e⁻ (read noise and rounding)"
    assert stated["dynamic range"] == "72.0 dB, 12.0 stops, at ISO 200: saturation over 9.96 e⁻, SNR 1"


def test_show_a_scene_and_files_of_ones_own(camsim: Run) -> None:
    done = camsim("show", "small.yaml")
    assert (done.returncode, done.stderr) == (0, "")
    # λN = 550 nm · 8; 5000 lx / (4 · 8²).
    assert "λN = 4.4 µm at 550 nm, 0.902 pitches; cut-off 0.2273 cycles/µm" in done.stdout
    assert "5000 lx on the scene, 19.53 lx on the sensor" in done.stdout


@pytest.mark.parametrize(
    "lens",
    [
        "{kind: airy, f_number: 4, magnification: 0.5}",
        "{kind: annular-airy, f_number: 4, obstruction: 0.8}",
        "{kind: wavefront, f_number: 4, pupil: {shape: bladed, blades: 5}}",
    ],
)
def test_lux_on_the_sensor_are_those_that_expose_alike(camsim: Run, folder: Path, lens: str) -> None:
    """Given there instead, they make the same electrons; an obstruction took none."""
    scene = (folder / "small.yaml").read_text(encoding="utf-8").replace("{kind: airy, f_number: 8}", lens)
    (folder / "own.yaml").write_text(scene, encoding="utf-8")
    (lux,) = re.findall(r"([\d.]+) lx on the sensor from white", camsim("show", "own.yaml").stdout)
    given = f"light={{line_nm: 550, illuminance_lux: {lux}, at: sensor}}"
    there, here = (load(folder / "own.yaml", overrides=change) for change in ([], [given]))
    electrons = [each.camera.diffuser_electrons(each.light, each.time_s) for each in (there, here)]
    assert electrons[0] == pytest.approx(electrons[1], rel=1e-3)


def test_a_terminal_without_these_letters_still_shows() -> None:
    ascii_only = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run([COMMAND, "show", "d40-like"], env=ascii_only, capture_output=True, text=True, check=True)
    assert "0.10246 cycles/?m" in done.stdout


def test_validate(camsim: Run, folder: Path) -> None:
    here = Path(__file__).parents[2]
    good = [str(path) for path in sorted([*here.glob("scenes/*.yaml"), *here.glob("sensors/*.yaml")])]
    done = camsim("validate", *good)
    assert (done.returncode, done.stderr) == (0, "")
    assert [line.split(": ")[0] for line in done.stdout.splitlines()] == good

    # Where no sensor is known a window may have any shape: one fault, not two.
    text = (folder / "small.yaml").read_text(encoding="utf-8")
    tall = text.replace("rows: 16, cols: 20", "rows: 40, cols: 8").replace("sensor: d40-like\n", "")
    (folder / "tall.yaml").write_text(tall, encoding="utf-8")
    (fault,) = camsim("validate", "tall.yaml").stderr.splitlines()
    assert fault.startswith("tall.yaml:1:1: sensor: missing; ")

    (folder / "a.yaml").write_text("camsim: sensor/1\nname: A\n")
    (folder / "b.yaml").write_text("camsim: 'scene/1\n")
    done = camsim("validate", "a.yaml", "small.yaml", "b.yaml", "c.yaml")
    assert done.returncode == 2
    assert done.stdout == "small.yaml: a scene, no faults\n"
    assert [line.split(" ")[0] for line in done.stderr.splitlines()] == [
        *["a.yaml:1:1:"] * 4,
        "b.yaml:1:9:",
        "c.yaml:",
    ]


def test_a_reader_that_stops_early_is_no_error(folder: Path) -> None:
    command = f"'{COMMAND}' list reflectances | head -n 1"
    done = subprocess.run(command, shell=True, cwd=folder, capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("dark skin\n", "")


@pytest.mark.parametrize("kind", ["scene", "sensor"])
def test_schema(camsim: Run, kind: str) -> None:
    done = camsim("schema", kind)
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout)["title"] == f"camsim {kind}/1"
    assert camsim("schema", "camera").returncode == 2
