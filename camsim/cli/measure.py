"""``camsim measure mtf``: read, measure, print, write."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from camsim.cli.measured import Outputs
from camsim.cli.progress import Bar
from camsim.errors import CamsimError, InvalidValueError, UnknownNameError, UnsupportedError
from camsim.files.atomic import together, write_whole

if TYPE_CHECKING:
    from camsim.measure import CameraOtf, MtfReport, MtfSeries, Picture, Roi
    from camsim.measure.full_frame import Unit


@dataclass(frozen=True, slots=True, kw_only=True)
class MtfRequest:
    """The options of the command, as the user gave them."""

    files: tuple[str, ...]
    rois: tuple[str, ...]
    by: str | None
    unit: str
    channel: str
    tail: bool
    theory: bool
    gamma: str | None
    cfa: str | None
    layer: str | None
    map: str | None
    outputs: Outputs


def measure(request: MtfRequest) -> None:
    """Measure the edges of files; raises CamsimError with one sentence."""
    from camsim.cli.measure_mtf_table import curves_of, print_series
    from camsim.measure import Roi, mtf_series

    rois = tuple(Roi.parse(text) for text in request.rois)
    unit = _unit(request.unit)
    _check_outputs(request)
    with Bar(displayed=True, compiles=False) as bar:
        measured = [_measured(file, rois, request, bar) for file in request.files]
    series = mtf_series([report for report, _, _ in measured], by=request.by)
    _check_unit(series.reports, unit, request.unit)
    of_each = {theory.stages for _, theory, _ in measured if theory is not None}
    stages = of_each.pop() if len(of_each) == 1 else ()
    with together():
        request.outputs.write(*curves_of(series), functools.partial(_draw, series, unit, stages))
        if request.map is not None:
            from camsim.cli.plot_mtf_map import draw_map

            write_whole(request.map, draw_map(series.reports[0], request.map, unit))
    without = {report.file: why_not for report, _, why_not in measured if why_not}
    stated = series if len(series.reports) > 1 else series.reports[0]
    request.outputs.tell(stated, lambda _: print_series(series, unit, without))


def _draw(series: MtfSeries, unit: Unit, stages: Sequence[str], file: str) -> bytes:
    from camsim.cli.plot_mtf import draw

    return draw(series, file, unit, stages)


def _measured(file: str, rois: Sequence[Roi], request: MtfRequest, bar: Bar) -> tuple[MtfReport, CameraOtf | None, str]:
    """Return the report of a file, and its theory or the reason for its absence."""
    from camsim.measure import measure_mtf, read_picture

    picture = read_picture(file, gamma=gamma_of(request.gamma), cfa=request.cfa, layer=request.layer)
    theory, why_not = _theory(picture) if request.theory else (None, "")
    report = measure_mtf(
        picture, rois=rois, channel=request.channel, tail=request.tail, theory=theory, progress=bar.update
    )
    return report, theory, why_not


def gamma_of(text: str | None) -> float | str | None:
    """Return the value of ``--gamma``."""
    if text is None or text.lower() == "srgb":
        return text
    try:
        return float(text)
    except ValueError:
        raise InvalidValueError(f"{text!r}; give srgb or an exponent such as 2.2", key="--gamma") from None


def _unit(text: str) -> Unit:
    """Return the value of ``--unit``."""
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
    """Raise early for outputs that cannot be written."""
    request.outputs.check({"--map": request.map})
    if request.map is None:
        return
    from camsim.cli.plot import check_drawing

    check_drawing(request.map, force=request.outputs.force, option="--map")
    if len(request.files) > 1:
        raise InvalidValueError("is of one frame; give one FILE, or leave --map out", key="--map")


def _theory(picture: Picture) -> tuple[CameraOtf | None, str]:
    """Return the transfer function of the file's description, or the reason for its absence."""
    if picture.description is None:
        return None, "the file does not say what it was taken with"
    from camsim.config.from_record import capture_from_record
    from camsim.measure import CameraOtf

    try:
        return CameraOtf.of(capture_from_record(picture.description)), ""
    except CamsimError as error:
        return None, f"what the file says of its stages cannot be used ({error})"
