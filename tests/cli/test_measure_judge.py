"""``camsim measure truth``, ``demosaic`` and ``noise`` as people start them."""

import csv
import json
import re
import sys

import numpy as np
import pytest
from pages import assert_numbers_are_from

RINGS = """\
camsim: scene/1
sensor: d40-like
lens: {kind: airy, f_number: 5.6}
light: {illuminant: D65, illuminance_lux: 2000}
exposure: {time_s: auto, iso: 200}
region: {rows: 60, cols: 64}
scene:
  unit: pixel
  background: {reflectance: 0.6}
  shapes:
    - {kind: disc, radius: 18, reflectance: 0.1}
    - {kind: disc, radius: 14, reflectance: 0.7}
    - {kind: rectangle, width: 15, height: 12, centre: [18, 18], rotate_deg: 9, reflectance: orange}
render: {tolerance: 1e-2}
"""

# A program of someone's: nearest neighbours of the four filters, 16-bit linear TIFF.
PROGRAM = """\
import sys, numpy as np, tifffile
codes = tifffile.imread(sys.argv[1]).astype(float)
planes = [codes[0::2, 0::2], (codes[0::2, 1::2] + codes[1::2, 0::2]) / 2, codes[1::2, 1::2]]
image = np.stack([np.kron(p, np.ones((2, 2))) for p in planes], axis=2)
tifffile.imwrite(sys.argv[2], np.clip(image * 8, 0, 65535).astype(np.uint16), photometric="rgb")
"""


@pytest.fixture
def rings(folder):
    (folder / "rings.yaml").write_text(RINGS, encoding="utf-8")
    (folder / "mine.py").write_text(PROGRAM, encoding="utf-8")
    return folder


def test_all_published_methods_and_a_program(rings, camsim):
    run = f"{sys.executable} mine.py {{tiff}} {{out}}"
    done = camsim(
        "measure", "demosaic", "--all", "rings.yaml", "--run", run, "--json", "--csv", "a.csv", "--html", "a.html"
    )
    assert done.returncode == 0, done.stderr
    (ranking,) = json.loads(done.stdout)
    verdicts = ranking["verdicts"]
    assert len(verdicts) == 12
    assert [verdict["cpsnr_db"] for verdict in verdicts] == sorted((v["cpsnr_db"] for v in verdicts), reverse=True)
    (mine,) = (verdict for verdict in verdicts if verdict["method"] == run)
    # It never subtracts the black level, and makes four pixels of every two by two.
    assert {fault["name"] for fault in mine["faults"]} == {"wrong black level", "channel shifted", "enlarged"}
    with (rings / "a.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["cpsnr_db"]) for row in rows] == [verdict["cpsnr_db"] for verdict in verdicts]
    page = (rings / "a.html").read_text(encoding="utf-8")
    assert_numbers_are_from(page.split("<ul>")[0], verdicts)
    assert "http" not in page
    assert page.count("data:image/png;base64,") == 1 + 2 * 12


def test_truth_and_results(rings, camsim):
    outputs = ("-o", "mosaic.dng", "-o", "truth.exr", "-o", "truth.npy:truth")
    assert camsim("capture", "rings.yaml", "-q", *outputs).returncode == 0
    truth = np.load(rings / "truth.npy")
    np.save(rings / "good.npy", truth * np.float32(0.01))
    np.save(rings / "swapped.npy", truth[..., ::-1])
    np.save(rings / "small.npy", truth[1:])
    # Of the DNG alone the truth is computed again.
    done = camsim("measure", "demosaic", "mosaic.dng", "good.npy", "swapped.npy")
    assert done.returncode == 0, done.stderr
    assert "∞ (identical)" in done.stdout
    assert "swapped.npy: R and B are swapped" in done.stdout
    refused = camsim("measure", "demosaic", "truth.exr", "small.npy")
    assert refused.returncode == 2
    assert "59 × 64 pixels, and the truth has 60 × 64" in refused.stderr
    assert "Traceback" not in refused.stderr


def test_truth_of_a_file_in_another_space(rings, camsim):
    assert camsim("capture", "rings.yaml", "-q", "-o", "mosaic.dng").returncode == 0
    done = camsim("measure", "truth", "mosaic.dng", "--space", "srgb", "-o", "t.npy", "--json")
    assert done.returncode == 0, done.stderr
    stated = json.loads(done.stdout)
    image = np.load(rings / "t.npy")
    assert image.shape == (60, 64, 3)
    np.testing.assert_allclose(image[2, 2], 0.6, atol=0.01)
    np.testing.assert_allclose([channel["mean"] for channel in stated["channels"]], image.mean((0, 1)), rtol=1e-5)
    assert camsim("measure", "truth", "rings.yaml", "--space", "xyz", "-o", "t.exr").returncode == 0


def test_noise_of_a_sensor(folder, camsim):
    done = camsim(
        "measure", "noise", "--sensor", "mono-345", "--side", "40", "--frames", "3", "--csv", "n.csv",
        "--plot", "n.svg", "--set", "sensor.charge.dsnu_e=0",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "dynamic range" in done.stdout
    assert re.search(r"\nDSNU +e⁻ +≤ 0\.\d", done.stdout)
    assert "\nDSNU of Y is not measurable: noise gives as much by chance" in done.stdout
    assert len((folder / "n.csv").read_text().splitlines()) == 13
    assert "<svg" in (folder / "n.svg").read_text(encoding="utf-8")


def test_colour_of_a_chart_in_a_file(folder, camsim):
    chart = "scene.shapes=[{kind: chart, name: colorchecker, width: 250, centre: [0, -40.5]}]"
    changes = ("region={rows: 48, cols: 64}", "render.tolerance=1e-2", chart)
    made = camsim("capture", "colorchecker-card", "-q", "-o", "a.dng", *(a for c in changes for a in ("--set", c)))
    assert made.returncode == 0, made.stderr
    done = camsim("measure", "colour", "a.dng", "--json", "--csv", "a.csv", "--plot", "a.svg", "--picture", "a.png")
    assert done.returncode == 0, done.stderr
    stated = json.loads(done.stdout)
    assert [patch["name"] for patch in stated["patches"]] == ["red", "yellow", "neutral 6.5", "neutral 5"]
    with (folder / "a.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["delta_e_2000"]) for row in rows] == pytest.approx(
        [patch["delta_e_2000"] for patch in stated["patches"]], rel=1e-5
    )
    assert (folder / "a.png").read_bytes().startswith(b"\x89PNG")
    words = camsim("measure", "colour", "a.dng", "--plot", "a.svg", "--force")
    assert "white balance on 2 greys" in words.stdout
    again = camsim("measure", "colour", "a.dng", "--picture", "a.png")
    assert (again.returncode, again.stdout) == (2, "")
    assert "--force" in again.stderr


def test_a_star_in_a_file(folder, camsim):
    chart = "scene.shapes=[{kind: chart, name: siemens-star, radius: 26, cycles: 16, light: 0.9}]"
    changes = ("region={rows: 48, cols: 48}", "lens.f_number=16", "render.tolerance=1e-2", chart)
    made = camsim("capture", "siemens-star", "-q", "-o", "a.dng", *(a for c in changes for a in ("--set", c)))
    assert made.returncode == 0, made.stderr
    done = camsim("measure", "star", "a.dng", "--json", "--csv", "a.csv", "--plot", "a.svg")
    assert done.returncode == 0, done.stderr
    stated = json.loads(done.stdout)
    assert stated["nyquist_of_sensor"]["cycles_per_pixel"] == 0.5
    (grey,) = stated["channels"]
    assert grey["mtf50_cycles_per_pixel"] == pytest.approx(grey["theory_mtf50_cycles_per_pixel"], rel=0.03)
    with (folder / "a.csv").open(newline="") as file:
        assert [float(row["mtf"]) for row in csv.DictReader(file)] == grey["mtf"]
    assert "Siemens star, mean over directions" in camsim("measure", "star", "a.dng").stdout
    refused = camsim("measure", "star", "a.tiff")
    assert (refused.returncode, refused.stdout) == (2, "")


def test_distortion_of_a_dot_grid_in_a_file(folder, camsim):
    changes = ("region={rows: 64, cols: 64}", "render.tolerance=1e-2")
    made = camsim("capture", "dot-grid", "-q", "-o", "a.dng", *(a for c in changes for a in ("--set", c)))
    assert made.returncode == 0, made.stderr
    done = camsim("measure", "distortion", "a.dng", "--json", "--csv", "a.csv", "--plot", "a.svg")
    assert done.returncode == 0, done.stderr
    (grey,) = json.loads(done.stdout)["channels"]
    assert grey["scale"] == pytest.approx(1.0, abs=2e-3)
    with (folder / "a.csv").open(newline="") as file:
        assert [float(row["dx_pixel"]) for row in csv.DictReader(file)] == [m["dx_pixel"] for m in grey["marks"]]
    assert "dot-grid, against the scene's places" in camsim("measure", "distortion", "a.dng").stdout
