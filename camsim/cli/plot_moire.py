"""The ghosts of a zone plate as a picture: their contrasts, with theory."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from camsim.cli.plot import bytes_of, colour_of_channel, new_figure

if TYPE_CHECKING:
    from camsim.measure.target import MoireReport


def draw(report: MoireReport, file: str) -> bytes:
    """Return a plot of ghosts' contrasts ± two standard errors, theory as lines; its format by ``file``'s suffix."""
    figure = new_figure(9.0, 5.0)
    axes = figure.subplots()
    at = np.arange(len(report.ghosts))
    for k, ghost in enumerate(report.ghosts):
        colour = colour_of_channel(ghost.channel)
        axes.errorbar(k, ghost.contrast, 2.0 * ghost.contrast_error, fmt="o", ms=5, color=colour)
        if math.isfinite(ghost.theory):
            axes.plot([k - 0.3, k + 0.3], [ghost.theory] * 2, "--", lw=1.2, color=colour)
    named = [f"{g.channel}\n{g.fx_cycles_per_pixel:g}, {g.fy_cycles_per_pixel:g}" for g in report.ghosts]
    axes.set_xticks(at, named, fontsize=7)
    axes.set(
        xlabel="channel, and the sampling frequency of the ghost along x and y, cycles per pixel",
        ylabel="contrast over that of the plate's rings",
        title=f"{report.file}: ghosts of the zone plate; dashed: theory; bars: two standard errors",
        ylim=(0.0, None),
    )
    axes.grid(alpha=0.3, axis="y")
    return bytes_of(figure, file)
