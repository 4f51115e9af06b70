"""``camsim measure mtf`` as people start it."""

import csv
import json
import re
import shutil
import sys

import pytest
from tolerances import STATISTICAL

from .conftest import full_disk, run_camsim

EDGE = """\
camsim: scene/1
sensor: d40-like
lens: {kind: airy, f_number: 8}
light: {illuminant: D55, illuminance_lux: 5000}
exposure: {time_s: 0.01, iso: 200}
region: {rows: 128, cols: 96}
scene:
  unit: pixel
  background: {reflectance: 0.9}
  shapes:
    - {kind: rectangle, width: 2000, height: 4000, centre: [997.6, 69.8], rotate_deg: 4, reflectance: 0.05}
render: {tolerance: 1e-5}
"""


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """One capture in every format."""
    there = tmp_path_factory.mktemp("edge")
    (there / "edge.yaml").write_text(EDGE, encoding="utf-8")
    outputs = ("edge.dng", "edge.tiff", "edge.png:mosaic", "look.png:preview", "edge.exr:truth", "edge.npy")
    arguments = [a for o in outputs for a in ("-o", o)]
    run_camsim(there, "capture", "edge.yaml", "-q", *arguments).check_returncode()
    return there


@pytest.fixture
def captured(folder, camsim, files):
    shutil.copytree(files, folder, dirs_exist_ok=True)
    return camsim


def test_json_table_plot_and_report(folder, captured):
    done = captured(
        "measure", "mtf", "edge.dng", "--roi", "0,0,128,96", "--json", "--csv", "edge.csv", "--plot", "edge.svg"
    )
    assert done.returncode == 0, done.stderr
    edges = json.loads(done.stdout)["edges"]
    assert [edge["channel"] for edge in edges] == ["R", "G1", "G2", "B"]
    for edge in edges:
        assert edge["roi"] == {"row": 0, "col": 0, "rows": 128, "cols": 96}
        assert edge["angle_deg"] == pytest.approx(4.0, abs=0.05)
        error = edge["standard_error"]["mtf50_cycles_per_pixel"]
        theory = edge["theory"]["mtf50_cycles_per_pixel"]
        assert abs(edge["mtf50_cycles_per_pixel"] - theory) < STATISTICAL * error
        assert error < 0.02 * theory
        assert edge["nyquist_cycles_per_pixel"] == 0.25
        for name in ("mtf_at_nyquist", "mtf_at_nyquist_of_sensor"):
            assert abs(edge[name] - edge["theory"][name]) < STATISTICAL * edge["standard_error"][name]
    with (folder / "edge.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == sum(len(edge["mtf"]) for edge in edges)
    assert float(rows[0]["mtf"]) == 1.0
    assert "<svg" in (folder / "edge.svg").read_text(encoding="utf-8")
    again = captured("measure", "mtf", "edge.dng", "--csv", "edge.csv")
    assert again.returncode == 2
    assert "--force" in again.stderr


@pytest.mark.parametrize("name", ["edge.tiff", "edge.npy"])
def test_every_file_of_the_mosaic_gives_the_same_figures(captured, name):
    options = ("--roi", "0,0,128,96", "--channel", "G1", "--json")
    dng = json.loads(captured("measure", "mtf", "edge.dng", *options).stdout)["edges"][0]
    plain = name == "edge.npy"  # which says nothing of filters, black level and stages
    other = json.loads(captured("measure", "mtf", name, *options, *(("--cfa", "RGGB") if plain else ())).stdout)[
        "edges"
    ][0]
    assert other["mtf50_cycles_per_pixel"] == pytest.approx(dng["mtf50_cycles_per_pixel"], rel=2e-3 if plain else 1e-12)
    assert ("theory" in other) == (not plain)


def test_edges_are_found_and_told_in_words(captured):
    done = captured("measure", "mtf", "edge.exr")
    assert done.returncode == 0, done.stderr
    assert "edge.exr: 1 edge, 1 px = 4.88 µm" in done.stdout
    assert re.search(r"at channel's Nyquist +theory +at sensor's Nyquist +theory", done.stdout)
    assert "MTF50" in done.stdout
    assert "added by a fit of 1/x²" in done.stdout
    plain = captured("measure", "mtf", "edge.exr", "--no-tail")
    assert "plain ISO 12233" in plain.stdout


def test_two_files_by_aperture_and_a_map(folder, captured):
    options = ("--roi", "0,0,128,96", "--channel", "G1")
    done = captured("measure", "mtf", "edge.dng", "edge.tiff", *options, "--by", "aperture", "--plot", "two.svg")
    assert done.returncode == 0, done.stderr
    first, heads, *rows = done.stdout.splitlines()
    assert first == "2 files by aperture"
    assert heads.split()[0] == "aperture"
    assert [row.split()[0] for row in rows[:2]] == ["8", "8"]
    assert "Nyquist frequency of the sensor 0.5 c/px = 102.5 lp/mm" in done.stdout
    assert "of G1 0.25 c/px = 51.23 lp/mm" in done.stdout
    assert re.search(r"\) at 0\.25 +0\.\d+ +0\.\d+\(\d+\) at 0\.5 +0\.\d+ ", done.stdout)
    assert "<svg" in (folder / "two.svg").read_text(encoding="utf-8")
    done = captured("measure", "mtf", "edge.dng", *options, "--map", "map.svg", "--unit", "lw/ph")
    assert done.returncode == 0, done.stderr
    assert "MTF50 LW/PH" in done.stdout
    assert "<svg" in (folder / "map.svg").read_text(encoding="utf-8")


def test_without_matplotlib_a_plot_says_what_to_install(captured, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    done = captured("measure", "mtf", "edge.dng", "--plot", "a.png")
    assert done.returncode == 2
    assert "camsim-spectral[plot]" in done.stderr


def test_a_full_disk_leaves_the_older_plot_and_no_half_one(folder, captured):
    (folder / "a.png").write_text("old")
    before = {path.name for path in folder.iterdir()}
    with full_disk():
        done = captured("measure", "mtf", "edge.dng", "--roi", "0,0,128,96", "--force", "--plot", "a.png")
    assert done.returncode == 2
    assert done.stderr == "cannot write 'a.png': the file would be larger than the system allows\n"
    assert {path.name for path in folder.iterdir()} == before
    assert (folder / "a.png").read_text() == "old"


def test_the_map_of_the_shipped_lens_grid(folder, camsim):
    """As the page about the MTF has it; four of its sides lie along an axis or at 45°."""
    camsim("capture", "lens-grid", "-q").check_returncode()
    done = camsim("measure", "mtf", "lens-grid.dng", "--map", "map.png", "--json")
    assert done.returncode == 0, done.stderr
    assert (folder / "map.png").stat().st_size > 10_000
    report = json.loads(done.stdout)
    places = {(edge["roi"]["row"], edge["roi"]["col"]) for edge in report["edges"]}
    assert len(places) + len(report["refused"]) == 140
    assert len(places) >= 132
    for edge in report["edges"]:
        off = edge["mtf50_cycles_per_pixel"] - edge["theory"]["mtf50_cycles_per_pixel"]
        assert abs(off) < STATISTICAL * edge["standard_error"]["mtf50_cycles_per_pixel"]
    directions = [edge["field"]["direction"] for edge in report["edges"]]
    assert min(directions.count("sagittal"), directions.count("tangential")) > 60
