"""``camsim measure distortion``: measured positions of a chart's marks against those in the scene."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

from camsim.cli.measure_mtf_table import with_error
from camsim.cli.measured import Outputs, capture_of
from camsim.cli.progress import Bar
from camsim.cli.tables import print_table

if TYPE_CHECKING:
    from camsim.measure import Picture
    from camsim.measure.distortion import ChannelDistortion, Displacement, DistortionReport, GridReport

_COLUMNS = (
    "channel", "x_pixel", "y_pixel", "dx_pixel", "dy_pixel", "error_pixel", "theory_dx_pixel", "theory_dy_pixel",
)  # fmt: skip
_HEADS = (
    "channel", "marks", "shift x px", "shift y px", "scale", "k1", "k2", "distortion at the farthest", "left px rms",
    "lateral px rms", "largest", "off theory px rms",
)  # fmt: skip


def measure(file: str, cfa: str | None, outputs: Outputs) -> None:
    """Measure, print and write what is requested; raises CamsimError with one sentence."""
    from camsim.measure import read_picture
    from camsim.measure.distortion import measure_distortion

    outputs.check()
    picture = read_picture(file, cfa=cfa)
    if picture.description is None:
        _measure_grid(picture, outputs)
        return
    with Bar(displayed=True, compiles=False) as bar:
        report = measure_distortion(picture, capture_of(picture, file), progress=bar.update)
    rows = [[getattr(mark, name) for name in _COLUMNS] for channel in report.channels for mark in channel.marks]
    outputs.write(_COLUMNS, rows, functools.partial(_draw, report))
    outputs.tell(report, _print)


def _measure_grid(picture: Picture, outputs: Outputs) -> None:
    """Measure the dots of any picture."""
    from camsim.measure.distortion import measure_grid

    with Bar(displayed=True, compiles=False) as bar:
        report = measure_grid(picture, progress=bar.update)
    columns = _COLUMNS[:6]
    rows = [[getattr(dot, name) for name in columns] for channel in report.channels for dot in channel.dots]
    outputs.write(columns, rows, functools.partial(_draw_grid, report))
    outputs.tell(report, _print_grid)


def _draw_grid(report: GridReport, file: str) -> bytes:
    from camsim.cli.plot_distortion import draw_grid

    return draw_grid(report, file)


def _print_grid(report: GridReport) -> None:
    rows = []
    for channel in report.channels:
        lateral = (channel.lateral_rms_pixel, channel.lateral_largest_pixel)
        stated = ("reference" if value is None else f"{value:.4f}" for value in lateral)
        rows.append((channel.channel, str(len(channel.dots)), *stated))
    print_table(f"{report.file}: dot grid, projection and radial polynomial", ("channel", "dots", *_HEADS[9:11]), rows)
    k1, k2 = with_error(report.k1, report.k1_error), with_error(report.k2, report.k2_error)
    largest = with_error(100.0 * report.largest_distortion, 100.0 * report.largest_distortion_error)
    print(f"k1 {k1}, k2 {k2}; at the farthest dot {largest} %; left {report.rms_pixel:.4f} px rms")


def _draw(report: DistortionReport, file: str) -> bytes:
    from camsim.cli.plot_distortion import draw

    return draw(report, file)


def _print(report: DistortionReport) -> None:
    rows = []
    for c in report.channels:
        rows.append((c.channel, str(len(c.marks)), *_with_errors(c), *_rest(c), f"{c.off_theory_rms_pixel:.4f}"))
        rows.append(("theory", "", *_figures(c.theory), *_rest(c.theory), ""))
    print_table(f"{report.file}: {report.kind}, against the scene's places", _HEADS, rows)
    for sentence in report.left_out:
        print(f"left out: {sentence}")


def _with_errors(found: ChannelDistortion) -> tuple[str, ...]:
    """Return the polynomial's figures with digits according to their standard errors."""
    error = found.standard_error
    names = ("shift_x_pixel", "shift_y_pixel", "scale", "k1", "k2")
    stated = (with_error(getattr(found, name), getattr(error, name)) for name in names)
    return *stated, f"{with_error(100.0 * found.largest_distortion, 100.0 * error.largest_distortion)} %"


def _figures(found: Displacement) -> tuple[str, ...]:
    return (
        f"{found.shift_x_pixel:+.4f}", f"{found.shift_y_pixel:+.4f}", f"{found.scale:.6f}", f"{found.k1:+.4g}",
        f"{found.k2:+.4g}", f"{100.0 * found.largest_distortion:+.3f} %",
    )  # fmt: skip


def _rest(found: Displacement) -> tuple[str, ...]:
    lateral = (found.lateral_rms_pixel, found.lateral_largest_pixel)
    return f"{found.rms_pixel:.4f}", *("reference" if value is None else f"{value:.4f}" for value in lateral)
