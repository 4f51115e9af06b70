"""``camsim measure distortion``: marks of a chart, where they are seen against where the scene has them."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

from camsim.cli.measured import Outputs, picture_and_capture
from camsim.cli.tables import print_table

if TYPE_CHECKING:
    from camsim.measure.distortion import DistortionReport

_COLUMNS = ("channel", "x_pixel", "y_pixel", "dx_pixel", "dy_pixel", "error_pixel")
_HEADS = (
    "channel", "marks", "shift x px", "shift y px", "scale", "k1", "k2", "distortion at the farthest", "left px rms",
    "lateral px rms", "largest",
)  # fmt: skip


def measure(file: str, outputs: Outputs) -> None:
    """Measure, print and write; raises CamsimError with one sentence."""
    from camsim.measure.distortion import measure_distortion

    outputs.check()
    report = measure_distortion(*picture_and_capture(file))
    rows = [[getattr(mark, name) for name in _COLUMNS] for channel in report.channels for mark in channel.marks]
    outputs.write(_COLUMNS, rows, functools.partial(_draw, report))
    outputs.tell(report, _print)


def _draw(report: DistortionReport, file: str) -> bytes:
    from camsim.cli.plot_distortion import draw

    return draw(report, file)


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
