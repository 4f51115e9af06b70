"""The reports of ``camsim bench SCENE`` and ``make bench`` in a browser: nothing overflows, everything answers."""

import json
import re
import shutil
from dataclasses import dataclass
from pathlib import Path

import pytest

import bench.report
import camsim.bench.report
from bench.results import read_results
from camsim.bench import bench_scene
from camsim.camera.window import Region
from tests.pages import assert_numbers_are_from

pytestmark = pytest.mark.clients

STORED = Path(__file__).parents[2] / "bench" / "paper" / "results.jsonl"
# It runs as root in containers, where its sandbox cannot; and it is to look for nothing elsewhere.
QUIET = (
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
)


@pytest.fixture(scope="module")
def chromium():
    from playwright.sync_api import sync_playwright  # of the extra that only make test-clients installs

    program = shutil.which("chromium")
    assert program, "chromium is not installed: make test-clients installs it"
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=program, args=list(QUIET))
        yield browser
        browser.close()


@dataclass(frozen=True)
class Report:
    """A page, the lines it was made from, and those that its markers tell by their numbers."""

    file: Path
    lines: list
    marked: dict


def its_scene(folder):
    found = bench_scene("paper-square", tolerances=(1e-3, 1e-6, 1e-9), region=Region(rows=40, cols=48, origin=(80, 80)))
    file = folder / "bench.html"
    file.write_text(camsim.bench.report.page(found), encoding="utf-8")
    points = [line for line in found.lines if line["kind"] == "point"]
    return Report(file, found.lines, dict(enumerate(points)))


def papers_square(folder):
    lines = read_results(STORED)
    file = folder / "report.html"
    file.write_text(bench.report.page(lines), encoding="utf-8")
    return Report(file, lines, {n: line for n, line in enumerate(lines) if line["kind"] == "point"})


@pytest.fixture(scope="module", params=[its_scene, papers_square], ids=["own scene", "paper's square"])
def report(request, tmp_path_factory):
    return request.param(tmp_path_factory.mktemp("report"))


@pytest.fixture(params=[(1280, 900), (390, 844)], ids=["1280", "390"])
def opened(request, chromium, report):
    """The report at one width, and what the browser had to say or to fetch."""
    width, height = request.param
    tab = chromium.new_page(viewport={"width": width, "height": height})
    said, fetched = [], []
    tab.on("console", lambda message: said.append(message.text))
    tab.on("pageerror", lambda error: said.append(str(error)))
    tab.on("request", lambda asked: fetched.append(asked.url))
    tab.goto(report.file.as_uri())
    yield tab, said, fetched
    tab.close()


def test_nothing_overflows_complains_or_is_fetched(opened, tmp_path):
    tab, said, fetched = opened
    wide, inner = tab.evaluate("[document.documentElement.scrollWidth, innerWidth]")
    assert wide <= inner
    # Nothing sticks out of the page but inside boxes that scroll.
    assert not tab.evaluate(
        """[...document.querySelectorAll("body *")].filter((part) => !part.closest(".table") && !part.closest("svg")
            && part.getBoundingClientRect().right > innerWidth + 0.5).map((part) => part.outerHTML.slice(0, 80))"""
    )
    assert not said
    assert [url.split(":")[0] for url in fetched] == ["file"]
    tab.screenshot(path=str(tmp_path / "report.png"), full_page=True)
    assert (tmp_path / "report.png").stat().st_size > 50_000


def test_markers_answer_to_pointer_and_keyboard(opened, report):
    tab, said, _ = opened
    marks = tab.locator("[data-point]:visible")
    assert marks.count() > 10
    for k in (0, marks.count() // 2, marks.count() - 1):
        mark = marks.nth(k)
        mark.scroll_into_view_if_needed()
        place = mark.bounding_box()
        tab.mouse.move(place["x"] + place["width"] / 2, place["y"] + place["height"] / 2)
        words = tab.locator("#hover").inner_text()
        assert report.marked[int(mark.get_attribute("data-point"))]["label"] in words
        assert "largest error" in words
        box = tab.locator("#hover").bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= tab.viewport_size["width"]
    tab.mouse.move(0, 0)
    marks.nth(0).focus()
    assert tab.locator("#hover").is_visible()
    assert not said


def test_tables_sort_by_value(opened):
    tab, said, _ = opened
    table = tab.locator("table.sortable", has_text="Every setting")
    column = [h.strip() for h in table.locator("thead th").all_inner_texts()].index("largest error")
    for order in ("ascending", "descending"):
        table.locator("thead button").nth(column).click()
        assert table.locator("thead th").nth(column).get_attribute("aria-sort") == order
        values = table.evaluate(f"(t) => [...t.tBodies[0].rows].map((r) => Number(r.cells[{column}].dataset.v))")
        assert len(values) > 10
        assert values == sorted(values, reverse=order == "descending")
    assert not said


def test_every_number_is_in_the_lines(report):
    text = report.file.read_text(encoding="utf-8")
    assert_numbers_are_from(text, report.lines)
    # What markers tell is theirs to the last digit.
    words = json.loads(re.search(r"id='words'>(.*?)</script>", text).group(1))
    assert set(words) == {str(number) for number in report.marked}


def test_it_prints(chromium, report, tmp_path):
    tab = chromium.new_page()
    tab.goto(report.file.as_uri())
    paper = tab.pdf(path=str(tmp_path / "report.pdf"), format="A4")
    assert paper.startswith(b"%PDF")
    tab.emulate_media(media="print")
    assert tab.locator("#hover").is_hidden()
    tab.close()
