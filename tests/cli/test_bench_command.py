"""``camsim bench SCENE`` as people start it: words, lines, page, diagram, bad input, Ctrl-C."""

import json
import re
import signal
import subprocess
import time

import pytest

from tests.pages import assert_numbers_are_from

from .conftest import COMMAND, SCENE, run_camsim

# Upright sides are seen; of a Gaussian lens truths take a tenth of a second.
GAUSSIAN = "lens={kind: gaussian, f_number: 4, sigma_um: 2}"
SMALLER = ("--set", GAUSSIAN, "--set", "region={rows: 6, cols: 8}")
FEW = ("--methods", "auto,boundary", "--tolerances", "1e-3,1e-6")


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """One small bench: its folder, what it said and its lines."""
    folder = tmp_path_factory.mktemp("bench")
    (folder / "small.yaml").write_text(SCENE, encoding="utf-8")
    done = run_camsim(folder, "bench", "small.yaml", *FEW, *SMALLER)
    assert done.returncode == 0, done.stderr
    texts = (folder / "small-bench" / "bench.jsonl").read_text(encoding="utf-8").splitlines()
    return folder / "small-bench", done.stdout, [json.loads(text) for text in texts]


def test_words_say_what_was_found(small):
    _, out, lines = small
    assert "Rendered: 6 × 8 photosites from [996, 1500], all that the scene captures." in out
    assert re.search(r"Truth: fourier at 1e-9; \d+ of its photosites computed directly differ by \S+ at most\.", out)
    assert re.search(r"auto at 1e-6 \(boundary\): \S+ s, error \S+; .*\.", out)
    assert "written: small-bench/bench.jsonl, small-bench/bench.html, small-bench/bench.svg" in out
    assert [line["sentence"] for line in lines if line["kind"] == "finding"] == out.splitlines()[:-1]


def test_lines_hold_what_was_measured(small):
    *_, lines = small
    assert [line["kind"] for line in lines[:3]] == ["run", "truth", "truth"]
    points = [line for line in lines if line["kind"] == "point"]
    assert [p["label"] for p in points] == ["auto 1e-3", "auto 1e-6", "boundary 1e-3", "boundary 1e-6"]
    for p in points:
        assert p["error_max"] <= p["tolerance"]
        assert p["error_rms"] <= p["error_max"]
        assert p["truth"].startswith("fourier")
        assert 0.0 < p["wall_s"] <= p["first_wall_s"]
        assert 996 <= p["row"] < 1002
        assert 1500 <= p["col"] < 1508


def test_page_and_diagram_are_whole_and_of_the_lines(small):
    folder, _, lines = small
    text = (folder / "bench.html").read_text(encoding="utf-8")
    assert_numbers_are_from(text, lines)
    assert "http" not in re.sub(r"http://www\.w3\.org/\S+", "", text)
    svg = (folder / "bench.svg").read_text(encoding="utf-8")
    assert svg.startswith("<svg")
    assert all(word in svg for word in ("auto", "boundary", "small: D40-like, 4.88 µm, 6 × 8 photosites"))


def test_json_is_all_that_is_printed_and_a_report_is_not_overwritten(camsim, folder):
    arguments = (
        "bench",
        "small.yaml",
        "--methods",
        "boundary",
        "--tolerances",
        "1e-3",
        "--longest",
        "0.5",
        *SMALLER,
        "-o",
        "out",
        "-q",
    )
    done = camsim(*arguments, "--json")
    assert (done.returncode, done.stderr) == (0, "")
    stated = json.loads(done.stdout)
    assert stated["files"] == ["out/bench.jsonl", "out/bench.html", "out/bench.svg"]
    assert stated["lines"] == [json.loads(line) for line in (folder / "out" / "bench.jsonl").read_text().splitlines()]
    again = camsim(*arguments)
    assert again.returncode == 2
    assert again.stderr == ("'out/bench.jsonl' exists; overwrite it with --force, or choose another folder with -o\n")
    forced = camsim(*arguments, "--force")
    assert (forced.returncode, forced.stdout) == (0, "")


def test_what_a_method_cannot_is_said_once(camsim):
    methods = ("--methods", "importance,strips,boundary", "--tolerances", "1e-3,1e-10,1e-11", "--longest", "0.5")
    done = camsim("bench", "small.yaml", *methods, *SMALLER)
    assert done.returncode == 0, done.stderr
    left = [line for line in done.stdout.splitlines() if line.startswith("Left out: ")]
    assert [line.split(": ")[1] for line in left] == ["importance", "strips", "boundary 1e-10 and beyond"]
    assert "renders one wavelength at a time" in left[0]
    assert "tolerance: 1e-10 is outside" in left[2]


def test_ctrl_c_keeps_what_was_measured(folder):
    # What runs in a shell's background inherits that Ctrl-C is ignored.
    process = subprocess.Popen(
        [COMMAND, "bench", "small.yaml", "--longest", "0.5", *SMALLER, "-o", "out"],
        cwd=folder,
        text=True,
        stdout=-1,
        stderr=-1,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    lines = folder / "out" / "bench.jsonl"
    deadline = time.monotonic() + 600
    while not (lines.exists() and '"point"' in lines.read_text()):
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=600)
    assert process.returncode == 130, err
    assert "Traceback" not in err
    assert "interrupted; what was measured is in out/bench.jsonl" in out
    assert "was interrupted" in (folder / "out" / "bench.html").read_text()
