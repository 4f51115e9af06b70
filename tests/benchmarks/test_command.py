"""``camsim bench`` as people start it: lines, page, figures, bad input, Ctrl-C."""

import json
import re
import signal
import subprocess
import sys
import time

import pytest

from camsim.bench import extremes, scaling, sensor_extremes
from camsim.bench.lists import start as start_lines
from camsim.bench.report import page
from camsim.bench.results import Results, read_results, rounded
from camsim.bench.tables import shown
from camsim.errors import InputError
from camsim.scene import arrange
from tests.cli.conftest import COMMAND

from .lines import head

SMALL = ("bench", "--quick", "--psf", "gaussian-0.40", "--method", "strips", "--method", "boundary")


def start(*arguments, folder, **how):
    return subprocess.Popen([COMMAND, *arguments], cwd=folder, text=True, stdout=-1, stderr=-1, **how)


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """One small run: its folder, what it said and its lines."""
    folder = tmp_path_factory.mktemp("bench")
    process = start(*SMALL, "-o", "out", folder=folder)
    out, err = process.communicate(timeout=600)
    assert process.returncode == 0, err
    return folder / "out", out, err, read_results(folder / "out" / "results.jsonl")


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


def test_every_number_of_the_page_is_in_the_lines(small):
    folder, _, _, lines = small
    text = (folder / "report.html").read_text(encoding="utf-8")
    assert_numbers_are_from(text, lines)
    assert "http" not in re.sub(r"http://www\.w3\.org/\S+", "", text)


def assert_numbers_are_from(text, lines):
    """Cells carry the value they show; that value is in the lines, and sentences are lines' own."""
    values = set(numbers_of(lines))
    cells = re.findall(r'<td data-v="([^"]+)">([^<]+)</td>', text)
    assert len(cells) > 10
    for value, printed in cells:
        assert float(value) in values, value
        assert printed == shown(float(value))
    assert not re.findall(r"<td[^>]*>\s*[-+]?\d[\d.e-]*\s*</td>", re.sub(r"<td data-v=[^<]+</td>", "", text))
    said = "\n".join(line["sentence"] for line in lines if "sentence" in line)
    for item in re.findall(r"<li>([^<]+)</li>", text):
        assert item.replace("&#x27;", "'") in said


def numbers_of(value):
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        for part in value:
            yield from numbers_of(part)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield float(value)


def test_the_figures_are_drawn(small):
    folder, *_ = small
    assert (folder / "work-precision.png").read_bytes().startswith(b"\x89PNG")
    svg = (folder / "work-precision.svg").read_text(encoding="utf-8")
    assert svg.startswith("<svg")
    assert all(word in svg for word in ("strips", "boundary", "CPU seconds of one core"))


def test_ctrl_c_keeps_what_was_measured(tmp_path):
    words = ("bench", "--quick", "--psf", "gaussian-*", "--method", "boundary", "-o", "out")
    # What runs in a shell's background inherits that Ctrl-C is ignored.
    process = start(*words, folder=tmp_path, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    results = tmp_path / "out" / "results.jsonl"
    deadline = time.monotonic() + 600
    while not (results.exists() and '"point"' in results.read_text()):
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=600)
    assert process.returncode == 130, err
    assert "Traceback" not in err
    assert "interrupted; what was measured is in out/results.jsonl" in out
    lines = read_results(results)
    assert any(line["kind"] == "point" for line in lines)
    assert not any(line["kind"] == "end" for line in lines)
    assert "was interrupted" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--psf", "airy-f9"), r"unknown psf 'airy-f9'; did you mean 'airy-f8'"),
        (("--method", "bondary"), r"unknown method 'bondary'; did you mean 'boundary'\?"),
        (
            ("--compare", "none.jsonl"),
            r"'none.jsonl' does not exist; give the results.jsonl of an earlier camsim bench",
        ),
        (("-o", "file/within"), r"cannot write into 'file/within': Not a directory; choose a folder with -o"),
    ],
)
def test_bad_input_is_one_sentence_before_any_work(tmp_path, arguments, words):
    (tmp_path / "file").write_text("")
    began = sorted(tmp_path.iterdir())
    process = start("bench", *arguments, folder=tmp_path)
    _, err = process.communicate(timeout=600)
    assert process.returncode == 2
    assert re.fullmatch(words + r".*\n", err), err
    assert sorted(tmp_path.iterdir()) == began


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (json.dumps(head(format="camsim-bench/0")), "of version 'camsim-bench/0', and this camsim compares"),
        (json.dumps({"kind": "point"}), "its first line is not a run"),
        ("7", "its first line is not a run"),
        ("", "its first line is not a run"),
        ("a,b\n1,2", "it is not JSON lines"),
    ],
)
def test_other_files_are_refused(tmp_path, text, words):
    (tmp_path / "old.jsonl").write_text(text)
    with pytest.raises(InputError, match=words):
        read_results(tmp_path / "old.jsonl")


def test_numbers_are_kept_to_four_digits():
    assert rounded({"a": [1.23456e-9, 3], "b": None, "c": True}) == {"a": [1.235e-9, 3], "b": None, "c": True}


BROKEN = """
from camsim.bench import extremes, sensor_extremes
from camsim.bench.extremes import ExtremeCase, Outcome


def breaks():
    raise RuntimeError("no")


def outcome(verdict):
    return Outcome(reached=2e-7, asked=1e-6, seconds=0.1, verdict=verdict, truth="quadrature")


CASES = [
    ExtremeCase(name="good", input="a <square>", run=lambda: outcome("right")),
    ExtremeCase(name="refused", input="a bow tie", run=lambda: outcome("refused")),
    ExtremeCase(name="bad", input="another", run=lambda: outcome("wrong")),
    ExtremeCase(name="broken", input="a third", run=breaks),
]
extremes.cases, sensor_extremes.cases = lambda: CASES[:{count}], lambda: []
from camsim.cli import main
main()
"""


@pytest.mark.parametrize(("count", "code", "words"), [(2, 0, "all are right or refused"), (4, 1, "2 are wrong")])
def test_extremes_are_a_table_and_an_exit_code(tmp_path, count, code, words):
    done = subprocess.run(
        [sys.executable, "-c", BROKEN.replace("{count}", str(count)), "bench", "--extremes", "-o", "out"],
        cwd=tmp_path,
        capture_output=True,
        encoding="utf-8",
        timeout=600,
        check=False,
    )
    assert done.returncode == code, done.stderr
    assert f"{count} stiff and extreme cases: {words}" in done.stdout
    assert re.search(r"good +asked 1e-06 +reached 2e-07 +0\.1 s +right", done.stdout)
    lines = read_results(tmp_path / "out" / "extremes.jsonl")
    assert [line["name"] for line in lines if line["kind"] == "extreme"] == ["good", "refused", "bad", "broken"][:count]
    text = (tmp_path / "out" / "extremes.html").read_text(encoding="utf-8")
    assert "a &lt;square&gt;" in text
    assert ("RuntimeError: no" in text) == (count == 4)


def test_the_list_of_extremes_is_whole_and_its_names_differ():
    cases = (*extremes.cases(), *sensor_extremes.cases())
    assert len(cases) > 60
    assert len({case.name for case in cases}) == len(cases)


def test_every_extreme_of_the_sensor_is_right_or_refused():
    for case in sensor_extremes.cases():
        found = case.run()
        assert found.verdict in ("right", "refused"), (case.name, found)


def test_scaling_is_lines_and_words(monkeypatch, tmp_path):
    monkeypatch.setattr(scaling, "SIZES", {"photosites": (100, 400), "threads": (1,)})
    monkeypatch.setattr(scaling, "cores", lambda: 2)
    with Results(tmp_path / "scaling.jsonl") as results:
        start_lines(results, quick=True)
        scaling.run_scaling(results, lambda fraction, words: None, quick=True)
    lines = read_results(tmp_path / "scaling.jsonl")
    found = [(line["over"], line["size"]) for line in lines if line["kind"] == "scaling"]
    assert found == [("photosites", 100), ("photosites", 400), ("threads", 1), ("threads", 2)]
    assert [line["over"] for line in lines if line["kind"] == "finding"] == ["photosites", "threads"]
    text = page(lines)
    assert "Time and memory against size" in text
    assert_numbers_are_from(text, lines)


@pytest.mark.parametrize(("over", "size"), [("photosites", 10_000), ("edges", 1000), ("patches", 24), ("threads", 1)])
def test_scenes_of_every_size_are_as_large_as_they_say(over, size):
    task = scaling.task_of(over, size)
    edges = arrange(task.scene, max_segment_um=1.0).start_um.shape[0]
    if over == "photosites":
        assert task.rows * task.cols == size
    if over == "edges":
        assert edges == size // 3 * 3  # none lies over another
    if over == "patches":
        assert edges == 4 * size
        assert len({shape.reflectance for shape in task.scene.shapes}) == size
