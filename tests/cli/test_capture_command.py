"""``camsim capture`` as a user meets it: files, report, exit codes."""

import json
import os
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest

from camsim import api, rendering

from .conftest import COMMAND, Run, run_camsim


def files_in(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_one_command_writes_the_files_and_a_report(camsim: Run, folder: Path) -> None:
    done = camsim("capture", "small.yaml", "-o", "a.dng", "-o", "a.exr", "-o", "b.npy:truth", "-o", "a.png")
    assert (done.returncode, done.stdout) == (0, "")
    assert files_in(folder) == {"small.yaml", "a.dng", "a.exr", "b.npy", "a.png"}
    assert np.load(folder / "b.npy").shape == (16, 20, 3)
    for stated in (
        "small, 16 × 20 photosites of 4.88 µm",
        "D40-like, 4.88 µm, 12 bits, 10 e⁻ per DN",
        "0.01 s, ISO 200, seed 1",
        "Airy(f_number=8.0) → FourSpotOlpf(split_um=3.66) → SquarePhotosite(side_um=4.88)",
        "550 nm, one line",
        "tolerance 0.0001",
        "photosites recomputed",
        "mean e⁻",
        "clipped at 4095 DN",
        "render",
        "a.dng (mosaic, ",
        "a.exr (truth, ",
        "b.npy (truth, ",
        "a.png (preview, ",
    ):
        assert stated in done.stderr
    assert [line for line in done.stderr.splitlines() if line != line.rstrip()] == []


def test_json_goes_to_stdout_and_quiet_means_silent(camsim: Run, folder: Path) -> None:
    done = camsim("capture", "small.yaml", "--json", "-q", "--seed", "9", "--set", "exposure.iso=400")
    assert (done.returncode, done.stderr) == (0, "")
    report = json.loads(done.stdout)
    assert report["scene"] == "small"
    assert (report["seed"], report["iso"], report["rows"], report["cols"]) == (9, 400.0, 16, 20)
    assert 0 < report["error_estimate"] <= report["tolerance"] == 1e-4
    assert [signal["name"] for signal in report["signal"]] == ["R", "G", "B"]
    assert sum(signal["photosites"] for signal in report["signal"]) == 16 * 20
    size = (folder / "small.dng").stat().st_size
    assert report["outputs"] == [{"file": "small.dng", "product": "mosaic", "bytes": size}]


def test_the_same_seed_gives_the_same_bytes_and_force_overwrites(camsim: Run, folder: Path) -> None:
    assert camsim("capture", "small.yaml", "-q").returncode == 0
    first = (folder / "small.dng").read_bytes()
    refused = camsim("capture", "small.yaml", "--seed", "2")
    assert refused.returncode == 2
    assert refused.stderr == ("'small.dng' exists; overwrite it with --force, or write elsewhere with -o\n")
    assert (folder / "small.dng").read_bytes() == first
    assert camsim("capture", "small.yaml", "-q", "--force").returncode == 0
    assert (folder / "small.dng").read_bytes() == first
    assert camsim("capture", "small.yaml", "-q", "--force", "--seed", "2").returncode == 0
    assert (folder / "small.dng").read_bytes() != first


def test_several_frames_share_the_patterns_and_can_be_taken_again(camsim: Run, folder: Path) -> None:
    done = camsim("capture", "small.yaml", "--frames", "3", "-o", "a.tiff", "-q")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    frames = [(folder / f"a-{n}.tiff").read_bytes() for n in range(3)]
    assert len(set(frames)) == 3
    assert not (folder / "a.tiff").exists()
    assert camsim("capture", "small.yaml", "--set", "noise.frame_number=2", "-o", "b.tiff", "-q").returncode == 0
    assert (folder / "b.tiff").read_bytes() == frames[2]
    assert camsim("recapture", "a-2.tiff", "-o", "c.tiff", "-q").returncode == 0
    assert (folder / "c.tiff").read_bytes() == frames[2]
    done = camsim("capture", "small.yaml", "--frames", "2", "-o", "a.tiff")
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 2)


def test_a_shipped_scene_and_sensor_by_name_in_an_empty_folder(camsim: Run, folder: Path) -> None:
    done = camsim("capture", "flat-field", "--sensor", "mono-345", "--set", "region={rows: 8, cols: 8}", "-v")
    assert done.returncode == 0, done.stderr
    assert "kind: SquarePhotosite" in done.stderr  # what was computed
    assert len(done.stderr.splitlines()) < 150
    assert files_in(folder) == {"small.yaml", "flat-field.dng"}
    assert "Mono machine vision, 3.45 µm" in done.stderr


def test_all_faults_of_files_options_and_outputs_at_once_before_any_work(camsim: Run, folder: Path) -> None:
    (folder / "here").write_text("a file")
    text = (folder / "small.yaml").read_text().replace("width: 6", "width: .nan").replace("line_nm", "line")
    (folder / "bad.yaml").write_text(text)
    before = files_in(folder)
    done = camsim(
        "capture", "bad.yaml", "--sensor", "d40like", "--set", "iso=3", "-o", "good.dng", "-o", "x.foo",
        "-o", "x.dng:preview", "-o", "x.exr:pixels", "-o", "no/x.dng", "-o", "here/x.dng", "-o", "./good.dng",
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.splitlines() == [
        "--sensor: unknown sensor 'd40like'; did you mean 'd40-like'? "
        "(known: astronomy-376, d40-like, machine-colour-345, medium-format-376, mono-345, paper-488, "
        "phone-080, pi-155, x-trans-376); "
        "your own lies beside the scene, in sensors there or in ../sensors, in --sensors DIR, or is named by its path",
        "--set iso: unknown key here; did you mean 'exposure.iso'?",
        "bad.yaml:4:1: light.illuminant: missing; give an illuminant such as D55, or line_nm for a single wavelength",
        "bad.yaml:4:9: light.line: unknown key; did you mean 'line_nm'? "
        "(instead: a single wavelength (a laser, say), nm)",
        "bad.yaml:11:32: scene.shapes.0.width: must be a finite number above 0, not .nan "
        "(side along x before it is turned, in the scene's unit)",
        "cannot write 'x.foo': unknown suffix '.foo' (known: .dng, .exr, .tiff, .tif, .png, .npy, .npz)",
        "cannot write 'x.dng': DNG holds mosaic or truth and not preview; preview goes into .png",
        "cannot write 'x.exr': unknown product 'pixels' (known: mosaic, electrons, truth, spectral, preview, frame)",
        f"cannot write 'no/x.dng': the folder '{folder}/no' does not exist; make it first",
        f"cannot write 'here/x.dng': '{folder}/here' is a file and not a folder",
        "'./good.dng' is named twice; each product needs a separate file",
    ]
    assert files_in(folder) == before


def test_control_c_ends_it_with_130_and_no_file(folder: Path) -> None:
    # A pipe for a scene: the command waits in it until the interrupt comes.
    pipe = folder / "pipe.yaml"
    os.mkfifo(pipe)
    process = subprocess.Popen(
        [COMMAND, "capture", "pipe.yaml"],
        cwd=folder,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        # What runs in a shell's background inherits that Ctrl-C is ignored.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    with pipe.open("w"):
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=600)
    assert process.returncode == 130
    assert said == "camsim: interrupted\n"
    assert files_in(folder) == {"small.yaml", "pipe.yaml"}


def test_a_bug_is_a_plain_traceback_and_1(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*given: object, **named: object) -> None:
        secret = "value of a local"
        raise ValueError(len(secret))

    monkeypatch.setattr(api, "load_any", broken)
    done = run_camsim(folder, "capture", "small.yaml")
    assert done.returncode == 1
    assert "Traceback (most recent call last)" in done.stderr
    assert done.stderr.endswith("ValueError: 16\nThis is a bug of camsim: please report it with the lines above.\n")
    # No frame is printed with its locals.
    assert done.stderr.count("value of a local") <= 1
    assert files_in(folder) == {"small.yaml"}


def test_the_systems_word_is_one_line_and_1(camsim: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*given: object, **named: object) -> None:
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(api, "load_any", broken)
    done = camsim("capture", "small.yaml")
    assert (done.returncode, done.stderr) == (1, "camsim: the system says: [Errno 5] Input/output error\n")


def test_first_use_says_once_that_it_compiles(camsim: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rendering, "kernels_compiled", lambda: False)
    done = camsim("capture", "small.yaml")
    assert done.returncode == 0
    line = "camsim: compiling its kernels, once on this machine (about 20 s)"
    assert done.stderr.splitlines().count(line) == 1
    assert done.stderr.startswith(line)
    assert camsim("capture", "small.yaml", "-q", "--force").stderr == ""
