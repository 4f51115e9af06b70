"""``python -m bench.paper`` as people start it: lines, page, figures, bad input, Ctrl-C."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from bench.paper.__main__ import main
from bench.results import Results, read_results
from tests.pages import assert_numbers_are_from

ROOT = Path(__file__).parents[2]
STRIPS = ("--quick", "--psf", "gaussian-0.40", "--method", "strips")
SMALL = (*STRIPS, "--method", "boundary")


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """One small run: its folder, what it said and its lines."""
    folder = tmp_path_factory.mktemp("bench")
    command, where = [sys.executable, "-m", "bench.paper", *SMALL, "-o", "out"], os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, cwd=folder, env=where, text=True, capture_output=True, timeout=600)
    assert done.returncode == 0, done.stderr
    return folder / "out", done.stdout, done.stderr, read_results(folder / "out" / "results.jsonl")


def test_the_lines_hold_what_was_measured(small):
    _, out, err, lines = small
    assert lines[0]["kind"] == "run"
    assert lines[-1]["kind"] == "end"
    assert {"load", "truth", "point", "refused", "machine"} <= {line["kind"] for line in lines}
    (truth,) = (line for line in lines if line["kind"] == "truth")
    assert truth["largest_difference"] < 1e-12
    points = [line for line in lines if line["kind"] == "point"]
    (strips,) = (p for p in points if p["method"] == "strips")
    assert strips["error_max"] < 1e-7
    # Rounding to 16 bits leaves 0.29 parts in 65535 where the image is grey, nothing where it is black or white.
    assert 0.03 / 65535 < strips["error_rms_16bit"] < 0.29 / 65535
    boundary = [p for p in points if p["method"] == "boundary"]
    assert len(boundary) == 4
    for p in boundary:
        assert max(p["error_max"], p["error_frame_max"]) <= p["tolerance"]
        assert p["all_threads"]["laps"] >= 1
        if sys.platform == "linux":
            assert 20.0 < p["peak_mb"] < 2000.0
            assert p["beyond_mb"] < p["peak_mb"]
    for p in points:
        assert p["one_thread"]["cpu_s"] > 0.0
        assert p["setup_cpu_s"] > 0.0
    assert "100 %" in err
    assert "written: out/results.jsonl, out/report.html, out/work-precision.svg, out/work-precision.png" in out


def test_every_number_of_the_page_is_in_the_lines_and_the_figures_are_drawn(small):
    folder, _, _, lines = small
    assert (folder / "work-precision.png").read_bytes().startswith(b"\x89PNG")
    svg = (folder / "work-precision.svg").read_text(encoding="utf-8")
    assert all(word in svg for word in ("<svg", "strips", "boundary", "CPU seconds of one core"))
    text = (folder / "report.html").read_text(encoding="utf-8")
    assert_numbers_are_from(text, lines)
    assert "http" not in re.sub(r"http://www\.w3\.org/\S+", "", text)


def test_ctrl_c_keeps_what_was_measured(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["bench.paper", *STRIPS, "-o", "out"])
    add = Results.add

    def interrupted(results, kind, **values):
        add(results, kind, **values)
        if kind == "point":
            raise KeyboardInterrupt

    monkeypatch.setattr(Results, "add", interrupted)
    assert main() == 130
    assert "interrupted; what was measured is in out/results.jsonl" in capsys.readouterr().out
    lines = read_results(tmp_path / "out" / "results.jsonl")
    assert any(line["kind"] == "point" for line in lines)
    assert not any(line["kind"] == "end" for line in lines)
    assert "was interrupted" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--psf", "airy-f9"), r"unknown psf 'airy-f9'; did you mean 'airy-f8'"),
        (
            ("--compare", "none.jsonl"),
            r"'none.jsonl' does not exist; give the results.jsonl of an earlier make bench",
        ),
        (("-o", "file/within"), r"cannot write 'file/within/results.jsonl': Not a directory; choose a folder with -o"),
    ],
)
def test_bad_input_is_one_sentence_before_any_work(tmp_path, monkeypatch, capsys, arguments, words):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["bench.paper", *arguments])
    (tmp_path / "file").write_text("")
    began = sorted(tmp_path.iterdir())
    assert main() == 2
    assert re.fullmatch(words + r".*\n", capsys.readouterr().err)
    assert sorted(tmp_path.iterdir()) == began
