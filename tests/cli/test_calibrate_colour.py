"""From a photograph of a chart to a sensor file and a capture, as users do it."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import tifffile

import camsim as package
from camsim.spectra.colour_science import colour_science
from tests.colour_data import aligned
from tests.files.test_camera_curves import rawtoaces
from tests.maker_files import mosaic_tags, tiff_raw
from tests.photographed_chart import CAMERA, NODES_NM

from .conftest import Run, run_camsim

CHART = ("--set", "region={rows: 186, cols: 246}", "--set", "scene.shapes.0.width=215", "--set", "light.illuminant=D55")
BABEL = ("--chart", "BabelColor Average")


def done(camsim: Run, *arguments: str) -> str:
    ran = camsim(*arguments)
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


@pytest.fixture(scope="module")
def taken(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A capture of a chart by a camera that nobody ships, as DNG."""
    there = tmp_path_factory.mktemp("chart")
    points = ", ".join(f"{nm:g}" for nm in NODES_NM)
    curves = "\n".join(
        f"    {letter}: {{wavelength_nm: [{points}], values: [{', '.join(f'{v:.6g}' for v in curve)}], outside: zero}}"
        for letter, curve in zip("RGB", CAMERA.T, strict=True)
    )
    text = (
        "camsim: sensor/1\nname: Truth\nframe: {rows: 800, cols: 1000, pitch_um: 5.0}\n"
        "cfa: {kind: bayer, pattern: RGGB}\n"
        f"quantum_efficiency:\n  curves:\n{curves}\n  per: energy\n  peak: 0.5\n"
        "charge: {full_well_e: 40000}\n"
        "readout: {bit_depth: 14, black_level_dn: 512, base_iso: 100, electrons_per_dn: 2.6, read_noise_e: 4}\n"
    )
    (there / "truth.yaml").write_text(text, "utf-8")
    words = ("capture", "colorchecker-card", "--sensor", "truth.yaml", *CHART, "-o", "chart.dng", "-q")
    run_camsim(there, *words).check_returncode()
    return there / "chart.dng"


@pytest.fixture
def chart(taken: Path, folder: Path) -> Path:
    """The capture in the test's own folder."""
    return Path(shutil.copy(taken, folder))


def test_a_chart_becomes_a_sensor_that_sees_as_the_camera_did(chart: Path, folder: Path, camsim: Run) -> None:
    stated = json.loads(
        done(camsim, "calibrate", "colour", "chart.dng", "--light", "D55", *BABEL, "-o", "mine.yaml", "--json")
    )
    assert stated["delta_e_2000_mean"]["after"] < 1.6
    assert stated["delta_e_2000_mean"]["after"] <= stated["delta_e_2000_mean"]["before"]
    power = aligned("light", "D55") @ CAMERA
    assert stated["white_balance"] == pytest.approx((power / power[1]).tolist(), rel=0.02)
    assert "no faults" in done(camsim, "validate", "mine.yaml")
    # The same chart, taken by the profile, is developed by its matrix: the colours are the camera's own.
    done(camsim, "capture", "colorchecker-card", "--sensor", "mine.yaml", *CHART, "-o", "again.dng", "-q")
    again = json.loads(done(camsim, "measure", "colour", "again.dng", "--json"))
    assert again["delta_e_2000_mean"] < 2.5
    assert again["white_balance"]["r_over_g"] == pytest.approx(1.0, abs=0.01)
    # Its DNG carries the matrix, as XYZ under D65.
    with tifffile.TiffFile(folder / "again.dng") as file:
        tags = {tag.code: tag.value for tag in file.pages[0].tags}
    assert 50722 not in tags
    assert tags[50778] == 21
    numbers = np.array(tags[50721], float)
    to_camera = (numbers[0::2] / numbers[1::2]).reshape(3, 3)
    d55, d65 = (colour_science().xy_to_XYZ(colour_science().CCS_ILLUMINANTS["CIE 1931 2 Degree Standard Observer"][k])
                for k in ("D55", "D65"))  # fmt: skip
    adapt = colour_science().adaptation.matrix_chromatic_adaptation_VonKries(d65, d55, "Bradford")
    expected = np.linalg.inv(np.array(stated["camera_to_xyz"])) @ adapt
    assert to_camera / np.abs(to_camera).max() == pytest.approx(expected / np.abs(expected).max(), abs=3e-3)


def test_the_rest_of_a_sensor_stays_and_a_second_light_is_added(chart: Path, folder: Path, camsim: Run) -> None:
    first = ("calibrate", "colour", "chart.dng", *BABEL)
    done(camsim, *first, "--light", "D55", "--sensor", "d40-like", "-o", "one.yaml")
    done(camsim, *first, "--light", "A", "--sensor", "./one.yaml", "-o", "two.yaml")
    done(camsim, *first, "--light", "D55", "--sensor", "./two.yaml", "-o", "three.yaml")
    text = (folder / "three.yaml").read_text("utf-8")
    assert [line.strip() for line in text.splitlines() if "- light:" in line] == ['- light: "A"', '- light: "D55"']
    assert "# the paper's box over the whole pitch" in text
    assert "olpf: {kind: four-spot, split_um: 3.66" in text
    camera = package.Camera.from_yaml(folder / "three.yaml", lens=package.Airy(f_number=8.0))
    shipped = package.Camera.from_yaml("d40-like", lens=package.Airy(f_number=8.0))
    same = camera.replace(quantum_efficiency=shipped.quantum_efficiency, colour_matrices=())
    assert same == shipped
    assert [matrix.light for matrix in camera.colour_matrices] == ["A", "D55"]
    exists = camsim("calibrate", "colour", "chart.dng", "--light", "A", "-o", "two.yaml")
    assert exists.returncode == 2
    assert "exists; overwrite it with --force" in exists.stderr


def test_a_measured_light_is_a_table(chart: Path, folder: Path, camsim: Run) -> None:
    rows = [f"{nm:g},{power:.5f}" for nm, power in zip(NODES_NM, aligned("light", "D55"), strict=True)]
    (folder / "lamp.csv").write_text("\n".join(["wavelength_nm,power", *rows]), "utf-8")
    stated = [
        json.loads(
            done(camsim, "calibrate", "colour", "chart.dng", "--light", light, *BABEL, "-o", f"{k}.yaml", "--json")
        )
        for k, light in enumerate(("D55", "lamp.csv"))
    ]
    assert stated[1]["light"] == "lamp"
    for one, other in zip(*(each["camera_to_xyz"] for each in stated), strict=True):
        assert other == pytest.approx(one, abs=2e-3)


def test_a_makers_raw_and_a_strangers_dng_are_measured_as_the_capture_is(
    chart: Path, folder: Path, camsim: Run
) -> None:
    codes = np.asarray(tifffile.imread(chart)).astype(np.int64)
    # LibRaw knows no black level of this camera's 16-bit files.
    above = np.maximum(codes - 512, 0).astype(np.uint16)
    tags = mosaic_tags(above, 16)
    tiff_raw(folder / "chart.nef", above.astype("<u2").tobytes(), tags, make="NIKON CORPORATION", model="NIKON D3")
    stranger(folder / "other.dng", codes.astype(np.uint16), package.measure.read_picture(chart).noted)
    light = ("--light", "D55", *BABEL)
    item = json.loads(done(camsim, "measure", "colour", "chart.dng", *light, "--json"))
    other = json.loads(done(camsim, "measure", "colour", "other.dng", *light, "--json"))
    maker = json.loads(done(camsim, "measure", "colour", "chart.nef", *light, "--json"))
    assert other["delta_e_2000_mean"] == pytest.approx(item["delta_e_2000_mean"], abs=0.02)
    assert item["delta_e_2000_mean"] < 2.5
    # The maker's matrix is another camera's: its colours are wrong, and that is what is measured.
    assert maker["delta_e_2000_mean"] > 3.0
    assert maker["white_balance"] is None
    assert "taken from the chart's greys" in done(camsim, "measure", "colour", "chart.nef", *light)
    for name in ("chart.dng", "chart.nef", "other.dng"):
        done(camsim, "calibrate", "colour", name, *light, "-o", f"{name}.yaml", "--pitch", "5")
    matrices = [
        package.Camera.from_yaml(folder / f"{name}.yaml", lens=package.Airy(f_number=8.0)).colour_matrices[0].matrix
        for name in ("chart.dng", "chart.nef", "other.dng")
    ]
    assert matrices[2] == pytest.approx(matrices[0], abs=1e-5)
    assert matrices[1] == pytest.approx(matrices[0], abs=0.03)


def stranger(path: Path, codes: np.ndarray, noted: object) -> None:
    """A DNG as other programs write it: no record, a matrix of its own for D50."""
    colour = colour_science()
    d50, d65 = (
        colour.xy_to_XYZ(colour.CCS_ILLUMINANTS["CIE 1931 2 Degree Standard Observer"][k]) for k in ("D50", "D65")
    )
    adapt = colour.adaptation.matrix_chromatic_adaptation_VonKries(d50, d65, "Bradford")
    matrix = (np.array(noted.xyz_to_camera) @ adapt).ravel()
    neutral = [1.0 / factor for factor in noted.white_balance]
    shift = 10**6
    srational = [part for value in matrix for part in (round(value * shift), shift)]
    rational = [part for value in neutral for part in (round(value * shift), shift)]
    extra = [
        (33421, "H", 2, (2, 2), True), (33422, "B", 4, bytes((0, 1, 1, 2)), True),
        (50706, "B", 4, bytes((1, 4, 0, 0)), True),
        (50714, "H", 1, 512, True), (50717, "I", 1, int(codes.max()) + 10_000, True),
        (50721, "2i", 9, srational, True), (50728, "2I", 3, rational, True), (50778, "H", 1, 23, True),
    ]  # fmt: skip
    tifffile.imwrite(path, codes, photometric=32803, extratags=extra, metadata=None)


def test_curves_of_other_programs_become_a_sensor(folder: Path, camsim: Run) -> None:
    values = np.stack([np.interp(NODES_NM, NODES_NM, curve) for curve in CAMERA.T], axis=1)
    rawtoaces(folder / "acme.json", values)
    stated = done(camsim, "sensor", "import", "acme.json", "--sensor", "d40-like", "-o", "acme.yaml")
    assert "acme.yaml: Acme One: R, G, B per energy from 380 to 780 nm; relative" in stated
    assert "no faults" in done(camsim, "validate", "acme.yaml")
    camera = package.Camera.from_yaml(folder / "acme.yaml", lens=package.Airy(f_number=8.0))
    efficiency = camera.quantum_efficiency.at(NODES_NM)
    expected = CAMERA.T / NODES_NM
    assert efficiency == pytest.approx(0.42 * expected / expected.max(), rel=2e-3, abs=1e-4)
    assert camera.full_well == package.FullWell(40000.0)
    wrong = camsim("sensor", "import", "acme.json", "--sensor", "mono-345", "-o", "mono.yaml")
    assert wrong.returncode == 2
    assert "no curve for Y" in wrong.stderr
    assert not (folder / "mono.yaml").exists()
