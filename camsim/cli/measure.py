"""``camsim measure mtf``: read, measure, print, write."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from camsim.cli.tables import check_text_file
from camsim.errors import CamsimError, InvalidValueError, UnknownNameError, UnsupportedError
from camsim.files.atomic import write_whole

if TYPE_CHECKING:
    from camsim.measure import CameraOtf, MtfReport, Picture, Roi
    from camsim.measure.full_frame import Unit


@dataclass(frozen=True, slots=True, kw_only=True)
class MtfRequest:
    """What the user asked for."""

    files: tuple[str, ...]
    rois: tuple[str, ...]
    by: str | None
    unit: str
    channel: str
    tail: bool
    gamma: str | None
    cfa: str | None
    layer: str | None
    as_json: bool
    csv: str | None
    plot: str | None
    map: str | None
    force: bool


def measure(request: MtfRequest) -> None:
    """Measure the edges of files; raises CamsimError with one sentence."""
    from camsim.cli.measure_mtf_table import csv_of, print_series
    from camsim.measure import Roi, mtf_series

    rois = tuple(Roi.parse(text) for text in request.rois)
    unit = _unit(request.unit)
    _check_outputs(request)
    measured = [_measured(file, rois, request) for file in request.files]
    series = mtf_series([report for report, _, _ in measured], by=request.by)
    _check_unit(series.reports, unit, request.unit)
    stages = next((theory.stages for _, theory, _ in measured if theory is not None), ())
    if request.csv is not None:
        write_whole(request.csv, csv_of(series).encode("utf-8"))
    if request.plot is not None:
        from camsim.cli.plot_mtf import draw

        write_whole(request.plot, draw(series, request.plot, unit, stages))
    if request.map is not None:
        from camsim.cli.plot_mtf_map import draw_map

        write_whole(request.map, draw_map(series.reports[0], request.map, unit))
    if request.as_json:
        tree = series.as_dict() if len(series.reports) > 1 else series.reports[0].as_dict()
        print(json.dumps(tree, indent=2, ensure_ascii=False))
        return
    print_series(series, unit, {report.file: why_not for report, _, why_not in measured if why_not})


def _measured(file: str, rois: Sequence[Roi], request: MtfRequest) -> tuple[MtfReport, CameraOtf | None, str]:
    """Return the report of a file, and the theory beside it or why there is none."""
    from camsim.measure import measure_mtf, read_picture

    picture = read_picture(file, gamma=gamma_of(request.gamma), cfa=request.cfa, layer=request.layer)
    theory, why_not = _theory(picture)
    report = measure_mtf(picture, rois=rois, channel=request.channel, tail=request.tail, theory=theory)
    return report, theory, why_not


def gamma_of(text: str | None) -> float | str | None:
    """Return what ``--gamma`` says."""
    if text is None or text.lower() == "srgb":
        return text
    try:
        return float(text)
    except ValueError:
        raise InvalidValueError(f"{text!r}; give srgb or an exponent such as 2.2", key="--gamma") from None


def _unit(text: str) -> Unit:
    """Return what ``--unit`` says."""
    from camsim.measure.full_frame import UNITS

    unit = next((name for name in UNITS if name == text.lower()), None)
    if unit is None:
        raise UnknownNameError("unit", text, UNITS, key="--unit")
    return unit


def _check_unit(reports: Sequence[MtfReport], unit: Unit, text: str) -> None:
    for report in reports:
        if math.isnan(report.full_frame.per_unit(unit)):
            raise UnsupportedError(
                f"{text} needs the distance between photosites, which this file does not say; leave --unit out",
                stage=report.file,
            )


def _check_outputs(request: MtfRequest) -> None:
    """Refuse outputs that cannot be written, before any work."""
    if request.csv is not None:
        check_text_file(request.csv, force=request.force)
    for option, file in (("--plot", request.plot), ("--map", request.map)):
        if file is not None:
            from camsim.cli.plot import check_drawing

            check_drawing(file, force=request.force, option=option)
    named = [Path(file).resolve() for file in (request.csv, request.plot, request.map) if file is not None]
    if len(set(named)) < len(named):
        raise InvalidValueError("two of --csv, --plot and --map name one file", key="--map")
    if request.map is not None and len(request.files) > 1:
        raise InvalidValueError("is of one frame; give one FILE, or leave --map out", key="--map")


def _theory(picture: Picture) -> tuple[CameraOtf | None, str]:
    """Return the transfer function that the file's own description gives, or why there is none."""
    if picture.description is None:
        return None, "the file does not say what it was taken with"
    from camsim.measure import CameraOtf
    from camsim.revive import revive_capture

    try:
        return CameraOtf.of(revive_capture(picture.description)), ""
    except CamsimError as error:
        return None, f"what the file says of its stages cannot be used ({error})"
