"""Figures of the paper's benchmark: error against time, and the edge as each method draws it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from bench.paper.findings import contender, seconds, true_error
from bench.results import of_kind
from camsim.bench import diagram
from camsim.bench.diagram import STYLES, Mark
from camsim.bench.records import Line

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def work_precision(lines: Sequence[Line], psf: str, *, narrow: bool = False) -> Figure:
    """Return error against time for one system; each marker's number is its line's."""
    curves: dict[str, list[Mark]] = {}
    for number, point in enumerate(lines):
        if point["kind"] == "point" and point["psf"] == psf and "one_thread" in point:
            mark = Mark(seconds(point) or 0.0, true_error(point), number)
            curves.setdefault(contender(point), []).append(mark)
    label = next((line["label"] for line in of_kind(lines, "truth") if line["psf"] == psf), psf)
    return diagram.work_precision(
        curves,
        title=f"{label}, 446 × 446 photosites",
        seconds_label="CPU seconds of one core, set-up and check included",
        error_label="largest error of any photosite (white is 1)",
        narrow=narrow,
    )


def edge_panels(lines: Sequence[Line], psf: str, *, narrow: bool = False) -> Figure:
    """Return the edge as each method draws it (points) and its error, the paper's figures 13 and 14."""
    from matplotlib.figure import Figure

    panels = [line for line in of_kind(lines, "esf") if line["psf"] == psf]
    across = min(2 if narrow else 3, len(panels))
    down = math.ceil(len(panels) / across)
    figure = Figure(figsize=(5.2 if narrow else 9.2, 2.3 * down + 0.6), layout="constrained")
    grid = figure.subplots(down, across, squeeze=False, sharex=True)
    for axes in grid.ravel()[len(panels) :]:
        axes.remove()
    for axes, line in zip(grid.ravel(), panels, strict=False):
        colour, marker, _ = STYLES[line["method"]]
        most = max(abs(e) for e in line["error"]) or 1.0
        power = math.floor(math.log10(most))
        axes.plot(line["distance_px"], [e / 10.0**power for e in line["error"]], marker, color=colour, ms=2.5)
        axes.axhline(0.0, color="black", lw=0.6)
        axes.set_title(line["label"], fontsize=9)
        axes.set_ylabel(f"error, 1e{power}", fontsize=8)
        axes.tick_params(labelsize=8)
        axes.grid(alpha=0.25)
        edge = axes.twinx()
        edge.plot(line["distance_px"], line["value"], color="#999999", lw=0.8, zorder=0)
        edge.set_ylim(-0.05, 1.05)
        edge.set_yticks([])
    figure.supxlabel("distance from the edge, pixels; grey: the edge as drawn, from 1 to 0", fontsize=9)
    return figure
