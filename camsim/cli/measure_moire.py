"""``camsim measure moire``: the ghosts of a zone plate."""

from __future__ import annotations

import functools
import math
from dataclasses import fields
from typing import TYPE_CHECKING

from camsim.cli.measure_mtf_table import with_error
from camsim.cli.measured import Outputs, capture_of
from camsim.cli.tables import print_table
from camsim.errors import InvalidValueError

if TYPE_CHECKING:
    from camsim.measure.target import MoireReport

_HEADS = ("channel", "fx c/px", "fy c/px", "x px", "y px", "contrast", "theory")


def measure(file: str, cfa: str | None, rim_pixel: float | None, outputs: Outputs) -> None:
    """Measure, print and write what is requested; raises CamsimError with one sentence."""
    from camsim.measure import read_picture
    from camsim.measure.target import Ghost, measure_moire, measure_plate

    outputs.check()
    picture = read_picture(file, cfa=cfa)
    if picture.description is None:
        report = measure_plate(picture, rim_pixel=rim_pixel)
    elif rim_pixel is not None:
        raise InvalidValueError("is of anybody's files; this one says what it was taken of; leave it out", key="--rim")
    else:
        report = measure_moire(picture, capture_of(picture, file))
    names = [field.name for field in fields(Ghost)]
    rows = [[getattr(ghost, name) for name in names] for ghost in report.ghosts]
    outputs.write(names, rows, functools.partial(_draw, report))
    outputs.tell(report, _print)


def _draw(report: MoireReport, file: str) -> bytes:
    from camsim.cli.plot_moire import draw

    return draw(report, file)


def _print(report: MoireReport) -> None:
    rows = [
        [
            g.channel,
            *(f"{value:.4g}" for value in (g.fx_cycles_per_pixel, g.fy_cycles_per_pixel, g.x_pixel, g.y_pixel)),
            with_error(g.contrast, g.contrast_error),
            f"{g.theory:.4f}" if math.isfinite(g.theory) else "–",
        ]
        for g in report.ghosts
    ]
    print_table(f"{report.file}: ghosts of the zone plate", _HEADS, rows)
    for channel in dict.fromkeys(ghost.channel for ghost in report.ghosts):
        print(f"moiré of {channel}: {report.moire(channel):.4f} of the rings' contrast")
    if report.middle_pixel is not None:
        x, y = report.middle_pixel
        print(f"rings about ({x:.2f}, {y:.2f}) px, taken to reach {report.rim_pixel:.4g} px from there (--rim)")
