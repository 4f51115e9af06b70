"""Sweeps: the same files whoever takes them, nothing twice, and what was finished survives."""

import csv
import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import psutil
import pytest
from filelock import FileLock

import camsim
from camsim.camera import optical_image
from camsim.cli.sweep_plot import draw_columns
from camsim.errors import CamsimError, ConfigError, OutputError
from camsim.study import batches, engines, forecast, work

SMALL = {
    "scene": "slanted-edge",
    "sensor": "mono-345",
    "set": {"region": {"rows": 8, "cols": 9}, "render.tolerance": 1e-3},
}
STUDY = {**SMALL, "vary": {"exposure.iso": [200, 800], "lens.f_number": [4, 8]}, "frames": 2}


def sums(folder):
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*.dng"))
    }


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    folder = tmp_path_factory.mktemp("swept")
    return camsim.sweep(STUDY, folder, workers=0)


def test_the_manifest_tells_every_file(swept):
    rows = list(csv.DictReader((swept.folder / "manifest.csv").read_text(encoding="utf-8").splitlines()))
    assert {row["file"]: row["sha256"] for row in rows} == sums(swept.folder)
    assert len(rows) == 8
    assert [(r["index"], r["frame"], r["exposure_iso"], r["lens_f_number"]) for r in rows[3:5]] == [
        ("1", "1", "200", "8"),
        ("2", "0", "800", "4"),
    ]
    assert (swept.taken, swept.found, swept.failed) == (4, 0, 0)
    from pyarrow import parquet

    table = parquet.read_table(swept.folder / "manifest.parquet").to_pylist()
    assert [row["sha256"] for row in table] == [row["sha256"] for row in rows]
    assert {type(row["error_estimate"]) for row in table} == {float}


def test_a_file_is_what_a_capture_of_its_own_gives(swept, tmp_path):
    """Light, time and gain scale one optical image; the bytes are those of a rendering for each."""
    overrides = ["region={rows: 8, cols: 9}", "render.tolerance=1e-3", "exposure.iso=800", "lens.f_number=8"]
    ready = camsim.load("slanted-edge", sensor="mono-345", overrides=overrides, seed=1 + 3)
    for number, frame in enumerate(ready.frames(2)):
        camsim.save(frame, tmp_path / "own.dng", force=True)
        assert (tmp_path / "own.dng").read_bytes() == (swept.folder / f"00003-{number}.dng").read_bytes()


def test_nothing_is_rendered_twice(monkeypatch, tmp_path):
    """Nor where one frame is work enough for a task, as large ones are."""
    monkeypatch.setattr(batches, "TASK", 0.0)
    rendered = []
    real = work.Capture.optical_image
    monkeypatch.setattr(
        work.Capture, "optical_image", lambda self, **how: rendered.append(self.optical_key) or real(self, **how)
    )
    vary = {
        "exposure.iso": [100, 400],
        "light.illuminance_lux": [1000, 3],
        "lens.f_number": [4, 8],
        "noise.seed": [1, 2],
    }
    assert camsim.sweep({**SMALL, "vary": vary}, tmp_path, workers=0).taken == 16
    assert len(rendered) == len(set(rendered)) == 2


def test_a_scene_is_named_once(monkeypatch):
    """A thousand captures of dead leaves took three times as long to plan as they do."""
    named = []
    real = optical_image._named
    monkeypatch.setattr(optical_image, "_named", lambda *parts: named.append(type(parts[0])) or real(*parts))
    vary = {"noise.seed": [1, 2, 3], "exposure.iso": [100, 400]}
    assert forecast({**SMALL, "scene": ["slanted-edge", "flat-field"], "vary": vary}).optical_images == 2
    assert named.count(camsim.Scene) == 2
    first, other = (camsim.Scene(background=white) for white in (0.5, 0.6))
    keys = [optical_image.key_of(scene, 1) for scene in (first, other, first, camsim.Scene(background=0.5))]
    assert keys[0] == keys[2] == keys[3] != keys[1]


def test_processes_take_the_same_and_one_that_dies_is_replaced(swept, tmp_path, monkeypatch):
    """The first worker that meets the mark kills itself; its captures are taken by the next, and no half file stays."""
    mark, half = tmp_path / "mark", tmp_path / "out" / ".00001-0.dng.0a1b2c3d.part"
    mark.touch()
    (tmp_path / "sitecustomize.py").write_text(
        "import os, signal, sys\n"
        "class Once:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        f"        if name == 'camsim.files.dng' and os.path.exists({str(mark)!r}):\n"
        f"            os.remove({str(mark)!r}); open({str(half)!r}, 'w').close()\n"
        "            os.kill(os.getpid(), signal.SIGKILL)\n"
        "sys.meta_path.insert(0, Once())\n"
    )
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}{os.pathsep}{Path(camsim.__file__).parents[1]}")
    out = tmp_path / "out"
    done = camsim.sweep(STUDY, out, workers=2)
    assert not mark.exists()
    assert not half.exists()
    assert (done.taken, done.failed) == (4, 0)
    assert sums(out) == sums(swept.folder)


def test_what_is_there_is_not_taken_again_and_what_is_not_whole_is(swept, tmp_path):
    first = camsim.sweep(STUDY, tmp_path, workers=0)
    assert (first.taken, sums(tmp_path)) == (4, sums(swept.folder))
    (tmp_path / "00001-0.dng").write_bytes(b"half")
    (tmp_path / "00002-1.dng").unlink()
    (tmp_path / ".00003-0.dng.0a1b2c3d.part").write_bytes(b"left by a process that was killed")
    with (tmp_path / ".sweep" / "journal.jsonl").open("a", encoding="ascii") as journal:
        journal.write('{"capture": "cut of')
    again = camsim.sweep(STUDY, tmp_path, workers=0)
    assert (again.taken, again.found) == (2, 2)
    assert sums(tmp_path) == sums(swept.folder)
    assert not list(tmp_path.rglob("*.part"))
    assert camsim.sweep(STUDY, tmp_path, workers=0).found == 4
    # A study that has grown keeps what it had; another noise seed goes with another index.
    grown = {**STUDY, "vary": {"exposure.iso": [200, 800, 1600], "lens.f_number": [4, 8]}}
    more = camsim.sweep(grown, tmp_path, workers=0)
    assert (more.taken, more.found) == (2, 4)


def test_a_sweep_that_is_killed_goes_on_where_it_was(swept, tmp_path):
    study = tmp_path / "study.yaml"
    study.write_text(_yaml(STUDY), encoding="utf-8")
    out = tmp_path / "out"
    words = [sys.executable, "-m", "camsim", "sweep", str(study), "-o", str(out), "--workers", "1", "-q"]
    process = subprocess.Popen(words)
    while not list(out.rglob("*.dng")) and process.poll() is None:
        time.sleep(0.01)
    workers = psutil.Process(process.pid).children()
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert not psutil.wait_procs(workers, timeout=60)[1]  # they end with it
    assert camsim.sweep(STUDY, out, workers=0).failed == 0
    assert sums(out) == sums(swept.folder)


def _yaml(study):
    return "\n".join(f"{key}: {json.dumps(value)}" for key, value in {"camsim": "study/1", **study}.items()) + "\n"


def test_two_sweeps_into_one_folder_are_refused(tmp_path):
    (tmp_path / ".sweep").mkdir()
    with FileLock(tmp_path / ".sweep" / "lock"), pytest.raises(OutputError, match="another sweep is writing into"):
        camsim.sweep(STUDY, tmp_path, workers=0)


def test_what_fails_is_a_row_and_does_not_stop_the_rest(tmp_path, monkeypatch):
    real = work.save

    def full(frame, path, **how):
        if frame.iso == 800.0:
            raise OutputError("the disk is full")
        real(frame, path, **how)

    monkeypatch.setattr(work, "save", full)
    done = camsim.sweep(STUDY, tmp_path, workers=0)
    assert (done.taken, done.failed) == (2, 2)
    failed = [row for row in done.rows if row["status"] == "failed"]
    assert [(row["index"], row["message"]) for row in failed] == [(2, "the disk is full"), (3, "the disk is full")]
    monkeypatch.setattr(work, "save", real)
    assert camsim.sweep(STUDY, tmp_path, workers=0).taken == 2  # those, and no other


def test_mistakes_are_found_before_anything_is_taken(tmp_path):
    out = tmp_path / "out"
    bad = {**SMALL, "vary": {"exposure.iso": [200, -5], "lens.f_numbr": [4]}}
    with pytest.raises(ConfigError) as caught:
        camsim.sweep(bad, out, workers=0)
    assert "vary.exposure.iso: must be a number from 0.001 to 1e+09, not -5" in str(caught.value)
    assert "vary.lens.f_numbr: unknown key; did you mean 'f_number'?" in str(caught.value)
    with pytest.raises(CamsimError, match=r"captures 0 and 1 both make 'a.dng'; add \{index\} to the name"):
        camsim.sweep({**SMALL, "vary": {"exposure.iso": [1, 2]}, "files": "a.dng"}, out, workers=0)
    with pytest.raises(CamsimError, match=r"capture 0 makes 'a0\.exr' twice; give each file a name"):
        camsim.sweep({**SMALL, "files": ["a{index}.exr:truth", "a{index}.exr:electrons"]}, out, workers=0)
    with pytest.raises(CamsimError, match="give 0"):
        camsim.sweep(STUDY, out, workers=-1)
    assert not out.exists()


def test_columns_are_measured(tmp_path):
    region = {"rows": 96, "cols": 96, "origin": [950, 1330]}
    study = {"scene": "slanted-edge", "set": {"region": region}, "vary": {"lens.f_number": [4, 16]}}
    rows = camsim.sweep({**study, "measure": ["signal", "mtf"], "files": ["{index}.dng"]}, tmp_path, workers=0).rows
    wide, narrow = rows
    assert wide["mtf50_cycles_per_pixel_G1"] > 1.3 * narrow["mtf50_cycles_per_pixel_G1"]
    for row in rows:
        assert row["edges_G1"] == 1
        off = row["mtf50_cycles_per_pixel_G1"] - row["mtf50_cycles_per_pixel_G1_theory"]
        assert abs(off) < max(5.0 * row["mtf50_cycles_per_pixel_G1_error"], 0.01)
    assert wide["mean_G_e"] == pytest.approx(16.0 * narrow["mean_G_e"], rel=0.01)


def test_what_cannot_be_measured_says_why_and_tables_have_columns(tmp_path):
    vary = {"sensor.olpf.split_pitches": [0.5, 1.0]}
    study = {"scene": "flat-field", "sensor": "d40-like", "set": {"region": {"rows": 16, "cols": 16}}, "vary": vary}
    done = camsim.sweep({**study, "measure": ["mtf", "moire"]}, tmp_path, workers=0)
    assert done.failed == 0
    assert [row["sensor_olpf_split_pitches"] for row in done.rows] == [0.5, 1.0]  # split_um of the file gives way
    assert all("mtf: " in row["message"] and "moire: " in row["message"] for row in done.rows)
    study["vary"] = {"sensor.olpf": [None, {"kind": "four-spot", "split_pitches": 0.75}]}
    rows = camsim.sweep({**study, "files": "{sensor_olpf}.dng"}, tmp_path, workers=0).rows
    assert [row["file"] for row in rows] == ["none.dng", "kind-four-spot_split_pitches-0.75.dng"]
    assert [row.get("sensor_olpf_split_pitches") for row in rows] == [None, 0.75]


def test_a_plot_has_a_line_for_each_combination(tmp_path, monkeypatch):
    import matplotlib.figure

    labels, save = [], matplotlib.figure.Figure.savefig
    monkeypatch.setattr(
        matplotlib.figure.Figure,
        "savefig",
        lambda self, *a, **k: (
            labels.extend(t.get_text() for t in self.axes[0].get_legend().get_texts()) or save(self, *a, **k)
        ),
    )
    rows = [{"pitch": p, "olpf": o, "mtf": p + len(str(o))} for p in (1.0, 2.0) for o in (None, {"split_um": 3.0})]
    draw_columns(rows, "pitch", "mtf", tmp_path / "plot.png", by=["pitch", "olpf"])
    assert labels == ["olpf none", "olpf 3"]
    assert (tmp_path / "plot.png").stat().st_size > 1000


def test_moire_is_a_column(tmp_path):
    study = {"scene": "zone-plate", "set": {"render.tolerance": 1e-2}, "measure": ["moire"]}
    (row,) = camsim.sweep(study, tmp_path, workers=0).rows
    found = {name: row[name] for name in row if name.startswith("moire_") and not name.endswith("_theory")}
    assert found
    for name, value in found.items():
        assert value == pytest.approx(row[f"{name}_theory"], abs=0.03)


@pytest.mark.parametrize("offsets", [[[0]], [[0, 600], [0, 0]]])
def test_noise_is_that_of_the_sensor(tmp_path, offsets):
    """An offset fills a fourth of the photosites in the last exposure; they are left out (111 e⁻ where 74 are)."""
    small = {"region": {"rows": 60, "cols": 60}, "sensor.readout.black_offsets_dn": offsets}
    study = {"scene": "flat-field", "sensor": "mono-345", "set": small}
    study |= {"vary": {"exposure.time_s": [1e-3, 4e-3, 1.6e-2]}, "measure": ["signal", "noise"]}
    for row in camsim.sweep(study, tmp_path, workers=0).rows:
        mean = row["mean_Y_e"]
        gain = row["electrons_per_dn"]
        # The profile's PRNU of 0.5 %, DSNU of 0.6 and read noise of 2.4 e⁻, and rounding.
        wanted = (mean + (0.005 * mean) ** 2 + 0.6**2 + 2.4**2 + gain**2 / 12.0) ** 0.5
        assert row["noise_Y_e"] == pytest.approx(wanted, rel=4.0 / (2.0 * 3600) ** 0.5)
        assert row["snr_Y"] == pytest.approx(mean / wanted, rel=4.0 / (2.0 * 3600) ** 0.5)


def test_a_worker_of_another_version_is_refused():
    with pytest.raises(CamsimError, match=r"the work was begun by camsim 0\.0\.0; install that one"):
        work.refuse_other_software("camsim 0.0.0")


def test_what_nobody_brought_back_is_no_success(tmp_path, monkeypatch):
    monkeypatch.setattr(engines, "here", lambda tasks: iter(()))
    with pytest.raises(RuntimeError, match="4 of 4 tasks came back from nobody"):
        camsim.sweep(STUDY, tmp_path, workers=0)


def test_what_it_would_take_is_told(tmp_path):
    expected = forecast({**STUDY, "files": ["{index}.dng", "{index}.exr:truth"]})
    assert (expected.captures, expected.files, expected.optical_images) == (4, 16, 2)
    # 400 captures of 48² took 4.3 s, of which photosites and rendering are 0.3.
    assert 8 * 5e-3 < expected.seconds < 10.0
    assert expected.disk_bytes >= 16 * 72 * 2


def test_the_noise_of_captures_is_their_own(swept):
    frames = [camsim.measure.read_picture(swept.folder / f"0000{index}-0.dng").planes[0] for index in (0, 1)]
    assert not np.array_equal(frames[0].samples, frames[1].samples)


def test_sharpness_and_moire_of_one_frame(tmp_path):
    """A plate and a slanted square beside it: what an OLPF takes from both is read from one study."""
    plate = {"kind": "chart", "name": "zone-plate", "radius": 56, "rim_period": 0.833333, "centre": [-70, 0]}
    square = {"kind": "rectangle", "width": 90, "height": 90, "rotate_deg": 7, "centre": [70, 0], "reflectance": 0.05}
    given = {"region": {"rows": 124, "cols": 270}, "scene.shapes": [plate, square], "render.tolerance": 1e-2}
    vary = {"sensor.olpf": [None, {"kind": "four-spot", "split_pitches": 0.4}]}
    study = {"scene": "zone-plate", "set": given, "vary": vary, "measure": ["mtf", "moire"]}
    without, behind = camsim.sweep(study, tmp_path, workers=0).rows
    for row in (without, behind):
        assert row["edges_Y"] >= 2
        assert not row["message"]
        assert row["moire_Y"] == pytest.approx(row["moire_Y_theory"], abs=0.03)
        off = row["mtf50_cycles_per_pixel_Y"] - row["mtf50_cycles_per_pixel_Y_theory"]
        assert abs(off) < 5.0 * row["mtf50_cycles_per_pixel_Y_error"] + 0.005
    assert without["mtf50_cycles_per_pixel_Y"] > behind["mtf50_cycles_per_pixel_Y"]


@pytest.mark.parametrize(
    ("column", "unit"),
    [("sensor.frame.pitch_um", "µm"), ("mtf50_lp_per_mm_G1", "lp/mm"), ("noise_G_e", "e⁻"), ("snr_G", "")],
)
def test_axes_have_units(tmp_path, monkeypatch, column, unit):
    import matplotlib.figure

    labels, save = [], matplotlib.figure.Figure.savefig
    monkeypatch.setattr(
        matplotlib.figure.Figure,
        "savefig",
        lambda self, *a, **k: (labels.append(self.axes[0].get_xlabel()), save(self, *a, **k)),
    )
    draw_columns([{column: 1.0, "y": 2.0}, {column: 2.0, "y": 3.0}], column, "y", tmp_path / "plot.png")
    assert labels == [f"{column}, {unit}" if unit else column]
