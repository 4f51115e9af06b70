"""Rankings as a picture: CPSNR and colour error of every method."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from camsim.cli.plot import bytes_of, new_figure

if TYPE_CHECKING:
    from camsim.measure.demosaic import Ranking


def draw(rankings: Sequence[Ranking], file: str) -> bytes:
    """Return the bytes of a bar chart, as PNG, SVG or PDF by the suffix of ``file``.

    Each subject has a row of two panels, CPSNR and ΔE.
    """
    heights = [0.3 * len(ranking.verdicts) + 1.0 for ranking in rankings]
    figure = new_figure(10.0, sum(heights) + 0.3)
    axes = figure.subplots(len(rankings), 2, squeeze=False, height_ratios=heights)
    for (left, right), ranking in zip(axes, rankings, strict=True):
        verdicts = ranking.verdicts[::-1]
        names = [verdict.method for verdict in verdicts]
        finite = [v.cpsnr_db for v in verdicts if math.isfinite(v.cpsnr_db)]
        # The bar of an identical picture would be infinite; it is drawn slightly longer than the others.
        longest = 1.1 * max(finite, default=50.0)
        values = [v.cpsnr_db if math.isfinite(v.cpsnr_db) else longest for v in verdicts]
        bars = left.barh(names, values, color="#2456a6")
        left.bar_label(
            bars, ["identical" if v.identical else f"{v.cpsnr_db:.2f}" for v in verdicts], padding=2, fontsize=8
        )
        left.set_xlim(0.0, 1.15 * max(values))
        left.set_xlabel("CPSNR in linear light, dB")
        left.set_title(ranking.subject, loc="left")
        bars = right.barh(names, [v.delta_e_mean for v in verdicts], color="#c0392b")
        right.bar_label(bars, [f"{v.delta_e_mean:.2f}" for v in verdicts], padding=2, fontsize=8)
        right.set_xlim(0.0, 1.15 * max(1e-6, *(v.delta_e_mean for v in verdicts)))
        right.set_yticks([])
        right.set_xlabel("mean ΔE2000")
    return bytes_of(figure, file)
