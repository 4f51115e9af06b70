"""``camsim measure moire``: the ghosts of a zone plate."""

from __future__ import annotations

import json
from dataclasses import dataclass, fields

from camsim.cli.measure_colour import picture_and_capture
from camsim.cli.measure_mtf_table import with_error
from camsim.cli.tables import check_text_file, csv_text, print_table
from camsim.files.atomic import write_whole

_HEADS = ("channel", "fx c/px", "fy c/px", "x px", "y px", "contrast", "theory")


@dataclass(frozen=True, slots=True, kw_only=True)
class MoireRequest:
    """What the user asked for."""

    file: str
    as_json: bool
    csv: str | None
    force: bool


def measure(request: MoireRequest) -> None:
    """Measure, print and write; raises CamsimError with one sentence."""
    from camsim.measure.target import Ghost, measure_moire

    if request.csv is not None:
        check_text_file(request.csv, force=request.force)
    report = measure_moire(*picture_and_capture(request.file))
    if request.csv is not None:
        names = [field.name for field in fields(Ghost)]
        rows = [[getattr(ghost, name) for name in names] for ghost in report.ghosts]
        write_whole(request.csv, csv_text(names, rows).encode("utf-8"))
    if request.as_json:
        print(json.dumps(report.as_dict(), indent=2, ensure_ascii=False))
        return
    rows = [
        [
            g.channel,
            *(f"{value:.4g}" for value in (g.fx_cycles_per_pixel, g.fy_cycles_per_pixel, g.x_pixel, g.y_pixel)),
            with_error(g.contrast, g.contrast_error),
            f"{g.theory:.4f}",
        ]
        for g in report.ghosts
    ]
    print_table(f"{report.file}: ghosts of the zone plate", _HEADS, rows)
    for channel in dict.fromkeys(ghost.channel for ghost in report.ghosts):
        print(f"moiré of {channel}: {report.moire(channel):.4f} of the rings' contrast")
