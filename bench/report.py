"""The report: one HTML page without a network, made from the lines of a run alone."""

from __future__ import annotations

import json
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from pathlib import Path

from camsim.bench.cases import CORE_PSFS, PSFS
from camsim.bench.diagram import edge_panels, png, scaling_panels, svg, work_precision
from camsim.bench.esf import PANELS
from camsim.bench.findings import TABLE_PSF, contender, seconds, true_error
from camsim.bench.results import Line, of_kind
from camsim.bench.tables import paper_tables, point_table, shown, table

FIGURE = "work-precision"
MOST_FIGURES = 12
TITLES = {
    "point": "Error against run time",
    "extreme": "Stiff and extreme cases",
    "scaling": "Time and memory against size",
    "run": "camsim bench",
}
PAPER = (
    "The methods are those of F. van den Bergh, “On the rendering of synthetic images with specific point spread "
    "functions”. Its tables are ours beside ours here: the entries that the paper prints are not repeated, because "
    "they were not at hand when this was written. What was at hand is its program's time and error on this square, "
    "which is among the findings."
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
    run, style = lines[0], files("camsim.bench.page")
    css, script = (style.joinpath(name).read_text(encoding="utf-8") for name in ("report.css", "report.js"))
    words = {str(n): _words(p) for n, p in enumerate(lines) if p["kind"] == "point"}
    marks = json.dumps(words, ensure_ascii=False).replace("<", "\\u003c")
    title = next(words for kind, words in TITLES.items() if kind == "run" or of_kind(lines, kind))
    parts = [
        "<!doctype html>\n<html lang='en'>\n<head>\n<meta charset='utf-8'>",
        "<meta name='viewport' content='width=device-width, initial-scale=1'>",
        "<link rel='icon' href='data:,'>",
        f"<title>camsim bench: {title}</title>\n<style>\n{css}</style>\n</head>\n<body>\n<h1>{title}</h1>",
        _head(run, lines),
        _found(lines),
        _diagrams(lines),
        _section("Everything measured", point_table(lines) if of_kind(lines, "point") else ""),
        _section("The paper's tables beside ours", _paper(lines)),
        _panels(lines),
        _extremes(lines),
        _scaling(lines),
        _truths(lines),
        "<p id='hover' role='status' hidden></p>",
        f"<script type='application/json' id='words'>{marks}</script>",
        f"<script>\n{script}</script>\n</body>\n</html>\n",
    ]
    return "\n".join(part for part in parts if part)


def _section(title: str, body: str) -> str:
    return f"<section>\n<h2>{escape(title)}</h2>\n{body}</section>" if body else ""


def _paragraph(text: str, mark: str = "") -> str:
    return f"<p class='{mark}'>{escape(text)}</p>\n" if mark else f"<p>{escape(text)}</p>\n"


def _head(run: Line, lines: Sequence[Line]) -> str:
    machine, versions = run["machine"], run["versions"]
    about = f"{run['started']}, {machine['processor']}, {machine['cores']} cores, {machine['system']}; " + ", ".join(
        f"{name} {version}" for name, version in versions.items()
    )
    text = _paragraph(about, "run")
    if run["quick"]:
        text += _paragraph(
            "A quick run: few systems, few shifts, few laps. camsim bench without --quick measures all.", "run"
        )
    for line in of_kind(lines, "machine"):
        text += _paragraph(line["sentence"], "busy" if line["busy"] else "run")
    if not of_kind(lines, "end"):
        text += _paragraph("The run was interrupted: what follows was measured before that.", "busy")
    return text


def _found(lines: Sequence[Line]) -> str:
    items = "".join(f"<li>{escape(line['sentence'])}</li>\n" for line in of_kind(lines, "finding", "compared"))
    return _section("In words", f"<ul>\n{items}</ul>\n" if items else "")


def _both(wide: str, narrow: str, caption: str) -> str:
    """Return a figure in two widths, of which the page shows the one that fits."""
    return (
        f"<figure><div class='wide'>{wide}</div><div class='narrow'>{narrow}</div>"
        f"<figcaption>{escape(caption)}</figcaption></figure>\n"
    )


def _diagrams(lines: Sequence[Line]) -> str:
    text = ""
    for name in figure_psfs(lines):
        wide = svg(work_precision(lines, name), f"{name.replace('.', '_')}-w")
        narrow = svg(work_precision(lines, name, narrow=True), f"{name.replace('.', '_')}-n")
        caption = "Lower left is better. Point at a marker, or step through them with the tab key, for its figures."
        text += f"<h3>{escape(PSFS[name].label)}</h3>\n" + _both(wide, narrow, caption)
    return _section("Error against time", text)


def _words(point: Line) -> str:
    """Return what a marker tells: figures of its line."""
    cpu = seconds(point)
    text = f"{contender(point)}: {point['label']}\n"
    text += f"largest error {shown(true_error(point))}, rms {shown(point['error_rms'])}"
    if cpu is not None:
        text += f"\n{shown(cpu)} s of one core"
    if "all_threads" in point:
        text += f", {shown(point['all_threads']['wall_s'])} s with all threads"
    return text + (f"\npeak {shown(point['peak_mb'])} MB" if "peak_mb" in point else "")


def _paper(lines: Sequence[Line]) -> str:
    text = paper_tables(lines)
    return _paragraph(PAPER) + text if text else ""


def _panels(lines: Sequence[Line]) -> str:
    text = ""
    for name, number in PANELS.items():
        if any(line["psf"] == name for line in of_kind(lines, "esf")):
            wide = svg(edge_panels(lines, name), f"esf{number}-w")
            narrow = svg(edge_panels(lines, name, narrow=True), f"esf{number}-n")
            text += f"<h3>As the paper's figure {number}: {escape(PSFS[name].label)}</h3>\n"
            text += _both(wide, narrow, "Error of every method across the edge; each panel has a scale of its own.")
    return _section("The edge as each method draws it", text)


def _extremes(lines: Sequence[Line]) -> str:
    cases = of_kind(lines, "extreme")
    heads = ["case", "input", "asked", "reached", "truth", "seconds", "verdict"]
    keys = ["name", "input", "asked", "reached", "truth", "seconds", "verdict"]
    rows = [[case.get(key) for key in keys] for case in cases]
    return _section("Stiff and extreme cases", table("", heads, rows, wide=(1, 4, 6)) if rows else "")


def _scaling(lines: Sequence[Line]) -> str:
    found = of_kind(lines, "scaling")
    if not found:
        return ""
    wide, narrow = (svg(scaling_panels(lines, narrow=n), f"scaling-{n}") for n in (False, True))
    heads = ["against", "size", "CPU s", "wall s", "MB beyond", "laps"]
    keys = ["over", "size", "cpu_s", "wall_s", "beyond_mb", "laps"]
    caption = "Airy f/8 and photosite, tolerance 1e-6 (edges: 1e-5), method auto, all threads unless they are counted."
    rows = [[line.get(key) for key in keys] for line in found]
    return _section("Time and memory against size", _both(wide, narrow, caption) + table("", heads, rows))


def _truths(lines: Sequence[Line]) -> str:
    truths = of_kind(lines, "truth")
    heads = ["system", "photosites", "shifts", "checked twice", "largest difference of two truths", "seconds"]
    keys = ["label", "photosites", "shifts", "checked", "largest_difference", "seconds"]
    rows = [[line[key] for key in keys] for line in truths]
    caption = (
        "The truth is a Fourier sum that no engine of camsim's shares; samples of it are computed again by plain "
        "quadrature of the boundary integral."
    )
    return _section("What the errors are taken against", table(caption, heads, rows) if rows else "")
