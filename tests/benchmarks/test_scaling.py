"""Time and memory against size: lines, words, a page; scenes as large as they say."""

import pytest

from bench.report import page
from bench.results import Results, read_results
from bench.scaling import sizes
from camsim.scene import arrange
from tests.pages import assert_numbers_are_from


def test_scaling_is_lines_and_words(monkeypatch, tmp_path):
    monkeypatch.setattr(sizes, "SIZES", {"photosites": (100, 400), "threads": (1,)})
    monkeypatch.setattr(sizes, "cores", lambda: 2)
    monkeypatch.setattr(sizes, "LAPS", 1)  # each a process of its own
    with Results(tmp_path / "scaling.jsonl") as results:
        results.start(quick=True)
        sizes.run_scaling(results, lambda fraction, words: None, quick=True)
    lines = read_results(tmp_path / "scaling.jsonl")
    found = [(line["over"], line["size"]) for line in lines if line["kind"] == "scaling"]
    assert found == [("photosites", 100), ("photosites", 400), ("threads", 1), ("threads", 2)]
    assert [line["over"] for line in lines if line["kind"] == "finding"] == ["photosites", "threads"]
    text = page(lines)
    assert "Time and memory against size" in text
    assert_numbers_are_from(text, lines)


@pytest.mark.parametrize(("over", "size"), [("photosites", 10_000), ("edges", 1000), ("patches", 24), ("threads", 1)])
def test_scenes_of_every_size_are_as_large_as_they_say(over, size):
    task = sizes.task_of(over, size)
    edges = arrange(task.scene).start_um.shape[0]
    if over == "photosites":
        assert task.rows * task.cols == size
    if over == "edges":
        assert edges == size // 3 * 3  # none lies over another
    if over == "patches":
        assert edges == 4 * size
        assert len({shape.reflectance for shape in task.scene.shapes}) == size
