"""The report: one HTML page without a network, made from the lines of a run alone."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path

from bench.paper.cases import CORE_PSFS, PSFS
from bench.paper.esf import PANELS
from bench.paper.figures import edge_panels, work_precision
from bench.paper.findings import TABLE_PSF, contender, seconds, true_error
from bench.paper.tables import paper_tables, point_table
from bench.results import Results, of_kind
from bench.scaling.figures import scaling_panels
from camsim.bench.diagram import png, svg
from camsim.bench.html import bullets, displayed, document, paragraph, section, table, two_widths
from camsim.bench.records import Line

FIGURE = "work-precision"
MOST_FIGURES = 12
TITLES = {
    "point": "Error against run time",
    "extreme": "Stiff and extreme cases",
    "scaling": "Time and memory against size",
    "run": "The paper's benchmark",
}
PAPER = (
    "The methods are those of F. van den Bergh, “On the rendering of synthetic images with specific point spread "
    "functions”. The paper's own entries stand beside ours, with the ratio of ours to them, in bench/paper/README.md."
)


def write_report(lines: Sequence[Line], folder: Path, name: str = "report.html") -> list[Path]:
    """Write the page, and the work–precision diagram as SVG and PNG; return what was written."""
    written = [folder / name]
    written[0].write_text(page(lines), encoding="utf-8")
    for psf in figure_psfs(lines)[:1]:
        figure = work_precision(lines, psf)
        written += [folder / f"{FIGURE}.svg", folder / f"{FIGURE}.png"]
        written[1].write_text(svg(figure, "wp"), encoding="utf-8")
        written[2].write_bytes(png(figure))
    return written


def figure_psfs(lines: Sequence[Line]) -> list[str]:
    """Return the systems that get a diagram: the README's first, then the core ones, then others."""
    clocked = {p["psf"] for p in of_kind(lines, "point") if "one_thread" in p}
    order = (TABLE_PSF, *CORE_PSFS, *PSFS)
    return [name for name in dict.fromkeys(order) if name in clocked][:MOST_FIGURES]


def page(lines: Sequence[Line]) -> str:
    """Return the page."""
    title = next(words for kind, words in TITLES.items() if kind == "run" or of_kind(lines, kind))
    parts = [
        _head(lines[0], lines),
        section("In words", bullets([line["sentence"] for line in of_kind(lines, "finding", "compared")])),
        _diagrams(lines),
        section("Everything measured", point_table(lines) if of_kind(lines, "point") else ""),
        section("The paper's tables beside ours", _paper(lines)),
        _panels(lines),
        _extremes(lines),
        _scaling(lines),
        _truths(lines),
    ]
    marks = {str(n): _words(p) for n, p in enumerate(lines) if p["kind"] == "point"}
    return document(f"camsim: {title}", parts, marks, heading=title)


@contextlib.contextmanager
def close(results: Results, name: str) -> Iterator[None]:
    """Print the findings and write the page when a run ends, also when somebody interrupts it."""
    words = "interrupted; what was measured is in"
    try:
        yield
        words = "written:"
    finally:
        for line in said(results.lines):
            print(line)
        files = [results.path, *write_report(results.lines, results.path.parent, name)]
        print(f"{words} {', '.join(os.path.relpath(file) for file in files)}")


def said(lines: Sequence[Line]) -> list[str]:
    """Return what a run says in words, and the table of extremes."""
    found = [str(line["sentence"]) for line in of_kind(lines, "machine", "finding", "compared")]
    extremes = of_kind(lines, "extreme")
    width = max((len(line["name"]) for line in extremes), default=0)
    return found + [
        f"{line['name']:{width}}  asked {line.get('asked', '–'):<8}  reached {line.get('reached', '–'):<10}  "
        f"{line['seconds']:>8.3g} s  {line['verdict']}"
        for line in extremes
    ]


def _head(run: Line, lines: Sequence[Line]) -> str:
    machine, versions = run["machine"], run["versions"]
    about = f"{run['started']}, {machine['processor']}, {machine['cores']} cores, {machine['system']}; " + ", ".join(
        f"{name} {version}" for name, version in versions.items()
    )
    text = paragraph(about, "run")
    if run["quick"]:
        text += paragraph("A quick run: few systems, few shifts, few laps. make bench-all measures all.", "run")
    for line in of_kind(lines, "machine"):
        text += paragraph(line["sentence"], "busy" if line["busy"] else "run")
    if not of_kind(lines, "end"):
        text += paragraph("The run was interrupted: what follows was measured before that.", "busy")
    return text


def _diagrams(lines: Sequence[Line]) -> str:
    text = ""
    for name in figure_psfs(lines):
        wide = svg(work_precision(lines, name), f"{name.replace('.', '_')}-w")
        narrow = svg(work_precision(lines, name, narrow=True), f"{name.replace('.', '_')}-n")
        caption = "Lower left is better. Point at a marker, or step through them with the tab key, for its figures."
        text += f"<h3>{escape(PSFS[name].label)}</h3>\n" + two_widths(wide, narrow, caption)
    return section("Error against time", text)


def _words(point: Line) -> str:
    """Return what a marker tells: figures of its line."""
    cpu = seconds(point)
    text = f"{contender(point)}: {point['label']}\n"
    text += f"largest error {displayed(true_error(point))}, rms {displayed(point['error_rms'])}"
    if cpu is not None:
        text += f"\n{displayed(cpu)} s of one core"
    if "all_threads" in point:
        text += f", {displayed(point['all_threads']['wall_s'])} s with all threads"
    return text + (f"\npeak {displayed(point['peak_mb'])} MB" if "peak_mb" in point else "")


def _paper(lines: Sequence[Line]) -> str:
    text = paper_tables(lines)
    return paragraph(PAPER) + text if text else ""


def _panels(lines: Sequence[Line]) -> str:
    text = ""
    for name, number in PANELS.items():
        if any(line["psf"] == name for line in of_kind(lines, "esf")):
            wide = svg(edge_panels(lines, name), f"esf{number}-w")
            narrow = svg(edge_panels(lines, name, narrow=True), f"esf{number}-n")
            text += f"<h3>As the paper's figure {number}: {escape(PSFS[name].label)}</h3>\n"
            text += two_widths(
                wide, narrow, "Error of every method across the edge; each panel has a scale of its own."
            )
    return section("The edge as each method draws it", text)


def _extremes(lines: Sequence[Line]) -> str:
    cases = of_kind(lines, "extreme")
    heads = ["case", "input", "asked", "reached", "truth", "seconds", "verdict"]
    keys = ["name", "input", "asked", "reached", "truth", "seconds", "verdict"]
    rows = [[case.get(key) for key in keys] for case in cases]
    return section("Stiff and extreme cases", table("", heads, rows, wide=(1, 4, 6)) if rows else "")


def _scaling(lines: Sequence[Line]) -> str:
    found = of_kind(lines, "scaling")
    if not found:
        return ""
    wide, narrow = (svg(scaling_panels(lines, narrow=n), f"scaling-{n}") for n in (False, True))
    heads = ["against", "size", "CPU s", "wall s", "MB beyond", "laps"]
    keys = ["over", "size", "cpu_s", "wall_s", "beyond_mb", "laps"]
    caption = "Airy f/8 and photosite, tolerance 1e-6 (edges: 1e-5), method auto, all threads unless they are counted."
    rows = [[line.get(key) for key in keys] for line in found]
    return section("Time and memory against size", two_widths(wide, narrow, caption) + table("", heads, rows))


def _truths(lines: Sequence[Line]) -> str:
    truths = of_kind(lines, "truth")
    heads = ["system", "photosites", "shifts", "checked twice", "largest difference of two truths", "seconds"]
    keys = ["label", "photosites", "shifts", "checked", "largest_difference", "seconds"]
    rows = [[line[key] for key in keys] for line in truths]
    caption = (
        "The truth is a Fourier sum that no engine of camsim's shares; samples of it are computed again by plain "
        "quadrature of the boundary integral."
    )
    return section("What the errors are taken against", table(caption, heads, rows) if rows else "")
