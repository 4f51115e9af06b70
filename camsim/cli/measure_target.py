"""``camsim measure star`` and ``camsim measure texture``: the MTF of charts other than edges."""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Literal

from camsim.cli.measure_mtf_table import with_error
from camsim.cli.measured import Outputs, picture_and_capture
from camsim.cli.tables import print_table

if TYPE_CHECKING:
    from camsim.measure.target import TargetReport

_HEADS = ("channel", "MTF50 c/px", "theory", "lp/mm", "LW/PH", "channel's Nyquist c/px", "frequencies c/px")
_COLUMNS = ("channel", "frequency_cycles_per_pixel", "mtf", "mtf_error", "theory_mtf")


def measure(file: str, method: Literal["star", "texture"], outputs: Outputs) -> None:
    """Measure, print and write what is requested; raises CamsimError with one sentence."""
    from camsim.measure.target import measure_star, measure_texture

    outputs.check()
    picture, capture = picture_and_capture(file)
    report = (measure_star if method == "star" else measure_texture)(picture, capture)
    outputs.write(_COLUMNS, _curves(report), functools.partial(_draw, report))
    outputs.tell(report, _print)


def _draw(report: TargetReport, file: str) -> bytes:
    from camsim.cli.plot_target import draw

    return draw(report, file)


def _curves(report: TargetReport) -> list[tuple[object, ...]]:
    rows: list[tuple[object, ...]] = []
    for channel in report.channels:
        theory = [""] * channel.mtf.size if channel.theory is None else channel.theory.tolist()
        columns = (channel.frequency_cycles_per_pixel.tolist(), channel.mtf.tolist(), channel.mtf_error.tolist())
        rows += [(channel.channel, *row) for row in zip(*columns, theory, strict=True)]
    return rows


def _print(report: TargetReport) -> None:
    rows = []
    for channel in report.channels:
        half = channel.mtf50_cycles_per_pixel
        units = list(report.full_frame.in_units(half).values())
        theory, f = channel.theory_mtf50_cycles_per_pixel, channel.frequency_cycles_per_pixel
        rows.append(
            (
                channel.channel,
                with_error(half, channel.mtf50_error),
                *("–" if value is None or math.isnan(value) else f"{value:.4g}" for value in (theory, *units[1:])),
                f"{channel.nyquist_cycles_per_pixel:g}",
                f"{f[0]:.3f} to {f[-1]:.3f}",
            )
        )
    what = "Siemens star" if report.method == "star" else "texture, against the scene's own spectrum"
    print_table(f"{report.file}: {what}, mean over directions", _HEADS, rows)
