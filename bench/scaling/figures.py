"""Figures of time and memory against size."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from bench.results import of_kind
from camsim.bench.records import Line

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def scaling_panels(lines: Sequence[Line], *, narrow: bool = False) -> Figure:
    """Return CPU time against every kind of size, wall time against threads."""
    from matplotlib.figure import Figure

    kinds = list(dict.fromkeys(line["over"] for line in of_kind(lines, "scaling")))
    across = min(2 if narrow else 3, len(kinds))
    down = math.ceil(len(kinds) / across)
    figure = Figure(figsize=(5.2 if narrow else 9.2, 2.6 * down + 0.3), layout="constrained")
    grid = figure.subplots(down, across, squeeze=False)
    for axes in grid.ravel()[len(kinds) :]:
        axes.remove()
    for axes, over in zip(grid.ravel(), kinds, strict=False):
        mine = [line for line in of_kind(lines, "scaling") if line["over"] == over]
        clock = "wall_s" if over == "threads" else "cpu_s"
        axes.loglog([m["size"] for m in mine], [m[clock] for m in mine], "o-", color="#0072B2", ms=5)
        axes.set_xlabel(over, fontsize=9)
        axes.set_ylabel("wall s" if over == "threads" else "CPU s", fontsize=9)
        axes.tick_params(labelsize=8)
        axes.grid(which="major", alpha=0.3)
    return figure
