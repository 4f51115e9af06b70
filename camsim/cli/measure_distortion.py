"""``camsim measure distortion``: marks of a chart, where they are seen against where the scene has them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING

from camsim.cli.measure_colour import picture_and_capture
from camsim.cli.tables import check_text_file, csv_text, print_table
from camsim.files.atomic import write_whole

if TYPE_CHECKING:
    from camsim.measure.distortion import DistortionReport

_COLUMNS = ("channel", "x_pixel", "y_pixel", "dx_pixel", "dy_pixel", "error_pixel")
_HEADS = (
    "channel", "marks", "shift x px", "shift y px", "scale", "k1", "k2", "distortion at the farthest", "left px rms",
    "lateral px rms", "largest",
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class DistortionRequest:
    """What the user asked for."""

    file: str
    as_json: bool
    csv: str | None
    plot: str | None
    force: bool


def measure(request: DistortionRequest) -> None:
    """Measure, print and write; raises CamsimError with one sentence."""
    from camsim.measure.distortion import measure_distortion

    if request.csv is not None:
        check_text_file(request.csv, force=request.force)
    if request.plot is not None:
        from camsim.cli.plot import check_drawing

        check_drawing(request.plot, force=request.force)
    report = measure_distortion(*picture_and_capture(request.file))
    if request.csv is not None:
        rows = [[getattr(mark, name) for name in _COLUMNS] for channel in report.channels for mark in channel.marks]
        write_whole(request.csv, csv_text(_COLUMNS, rows).encode("utf-8"))
    if request.plot is not None:
        from camsim.cli.plot_distortion import draw

        write_whole(request.plot, draw(report, request.plot))
    if request.as_json:
        print(json.dumps(report.as_dict(), indent=2, ensure_ascii=False))
        return
    _print(report)


def _print(report: DistortionReport) -> None:
    rows = []
    for c in report.channels:
        lateral = (c.lateral_rms_pixel, c.lateral_largest_pixel)
        rows.append(
            (
                c.channel, str(len(c.marks)), f"{c.shift_x_pixel:+.4f}", f"{c.shift_y_pixel:+.4f}", f"{c.scale:.6f}",
                f"{c.k1:+.4g}", f"{c.k2:+.4g}", f"{100.0 * c.largest_distortion:+.3f} %", f"{c.rms_pixel:.4f}",
                *("reference" if value is None else f"{value:.4f}" for value in lateral),
            )
        )  # fmt: skip
    print_table(f"{report.file}: {report.kind}, against the scene's places", _HEADS, rows)
    for sentence in report.left_out:
        print(f"left out: {sentence}")
