"""The report of a bench: one HTML page and the diagram, made only from its records."""

from __future__ import annotations

from pathlib import Path

from camsim.bench import html
from camsim.bench.diagram import Mark, svg, work_precision
from camsim.bench.records import Bench, Point, rounded

PAGE, FIGURE = "bench.html", "bench.svg"
SECONDS = "seconds, set-up and check included"
ROUNDING = 1e-16  # errors of 0 are drawn here
ERROR = "largest error of any photosite (full scale is 1)"
CAPTION = (
    "Lower left is better. Point at a marker, or step through them with the tab key, for its figures. Errors below "
    "the accuracy of the truth are drawn there, and no error at all at 1e-16."
)
POINTS = {
    "method": "method",
    "setting": "label",
    "ran": "engine",
    "largest error": "error_max",
    "rms error": "error_rms",
    "own estimate": "error_estimate",
    "row": "row",
    "col": "col",
    "wall s": "wall_s",
    "CPU s": "cpu_s",
    "first lap, wall s": "first_wall_s",
    "laps": "laps",
    "truth": "truth",
    "accuracy of the truth": "accurate_to",
}
TRUTHS = {
    "engine": "engine",
    "tolerance": "tolerance",
    "largest difference from photosites computed directly": "checked_to",
    "so many photosites": "checked_photosites",
    "largest difference from the other truth": "difference",
    "accuracy": "accurate_to",
    "seconds": "seconds",
}


def write_report(bench: Bench, folder: Path) -> list[Path]:
    """Write the page and the diagram; return their paths."""
    written = [folder / PAGE]
    written[0].write_text(page(bench), encoding="utf-8")
    if bench.points:
        written.append(folder / FIGURE)
        written[1].write_text(diagram(bench, "bench"), encoding="utf-8")
    return written


def diagram(bench: Bench, prefix: str, *, narrow: bool = False) -> str:
    """Return error against time as SVG; ids begin with ``prefix``."""
    curves: dict[str, list[Mark]] = {}
    for number, point in enumerate(bench.points):
        curves.setdefault(point.method, []).append(Mark(point.wall_s, max(point.at_most, ROUNDING), number))
    head = bench.head
    title = f"{head.scene}: {head.camera}, {head.rows} × {head.cols} photosites"
    return svg(work_precision(curves, title=title, seconds_label=SECONDS, error_label=ERROR, narrow=narrow), prefix)


def page(bench: Bench) -> str:
    """Return the page."""
    head = bench.head
    about = (
        f"{head.machine['processor']}, {head.machine['cores']} cores, {head.machine['system']}; "
        + ", ".join(f"{name} {version}" for name, version in head.versions.items())
        + f". {head.wavelengths} wavelengths of light, channels {', '.join(head.channels)}."
    )
    figure = ""
    if bench.points:
        figure = html.two_widths(diagram(bench, "wide"), diagram(bench, "narrow", narrow=True), CAPTION)
    return html.document(
        f"camsim bench: {head.scene}",
        [
            html.paragraph(about, "run"),
            html.section("In words", html.bullets([finding.sentence for finding in bench.findings])),
            html.section("Error against time", figure),
            html.section("Everything measured", _points(bench)),
            html.section("Left out", _left_out(bench)),
            html.section("What the errors are taken against", _truths(bench)),
        ],
        {str(number): _stated(point) for number, point in enumerate(bench.points)},
        heading=f"Error against run time: {head.scene}, {head.camera}",
    )


def _points(bench: Bench) -> str:
    if not bench.points:
        return ""
    rows = [[rounded(getattr(point, name)) for name in POINTS.values()] for point in bench.points]
    caption = "Every setting. Errors are relative to full scale; times are of the window, the quickest lap's."
    return html.table(caption, list(POINTS), rows, tall=len(rows) > 30)


def _left_out(bench: Bench) -> str:
    if not bench.left_out:
        return ""
    return html.table("", ["setting", "why"], [[left.label, left.why] for left in bench.left_out], wide=(1,))


def _truths(bench: Bench) -> str:
    if not bench.truths:
        return ""
    rows = [[rounded(getattr(truth, name)) for name in TRUTHS.values()] for truth in bench.truths]
    return html.table("The truth of each engine is the other one where both render the scene.", list(TRUTHS), rows)


def _stated(point: Point) -> str:
    """Return the text of a marker."""
    figures = {
        name: html.displayed(rounded(getattr(point, name))) for name in ("error_max", "error_rms", "wall_s", "cpu_s")
    }
    return (
        f"{point.label} ({point.engine})\n"
        f"largest error {figures['error_max']}, rms {figures['error_rms']}\n"
        f"{figures['wall_s']} s, of all cores {figures['cpu_s']} s\n"
        f"truth: {point.truth}"
    )
