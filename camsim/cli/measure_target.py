"""``camsim measure star`` and ``camsim measure texture``: the MTF of charts other than edges."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from camsim.cli.measure_colour import picture_and_capture
from camsim.cli.measure_mtf_table import with_error
from camsim.cli.tables import check_text_file, csv_text, print_table
from camsim.files.atomic import write_whole

if TYPE_CHECKING:
    from camsim.measure.target import TargetReport

_HEADS = ("channel", "MTF50 c/px", "theory", "lp/mm", "LW/PH", "channel's Nyquist c/px", "frequencies c/px")
_COLUMNS = ("channel", "frequency_cycles_per_pixel", "mtf", "mtf_error", "theory_mtf")


@dataclass(frozen=True, slots=True, kw_only=True)
class TargetRequest:
    """What the user asked for."""

    file: str
    method: Literal["star", "texture"]
    as_json: bool
    csv: str | None
    plot: str | None
    force: bool


def measure(request: TargetRequest) -> None:
    """Measure, print and write; raises CamsimError with one sentence."""
    from camsim.measure.target import measure_star, measure_texture

    if request.csv is not None:
        check_text_file(request.csv, force=request.force)
    if request.plot is not None:
        from camsim.cli.plot import check_drawing

        check_drawing(request.plot, force=request.force)
    picture, capture = picture_and_capture(request.file)
    report = (measure_star if request.method == "star" else measure_texture)(picture, capture)
    if request.csv is not None:
        write_whole(request.csv, csv_text(_COLUMNS, _curves(report)).encode("utf-8"))
    if request.plot is not None:
        from camsim.cli.plot_target import draw

        write_whole(request.plot, draw(report, request.plot))
    if request.as_json:
        print(json.dumps(report.as_dict(), indent=2, ensure_ascii=False))
        return
    _print(report)


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
