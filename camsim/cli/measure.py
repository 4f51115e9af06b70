"""``camsim measure mtf``: read, measure, print, write."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from camsim.errors import CamsimError, InvalidValueError, OutputError
from camsim.files.atomic import write_whole
from camsim.words import percent_range

if TYPE_CHECKING:
    from camsim.measure import CameraOtf, MtfReport, Picture

_CURVES = ("frequency_cycles_per_pixel", "mtf", "mtf_error", "theory_mtf")


@dataclass(frozen=True, slots=True, kw_only=True)
class MtfRequest:
    """What the user asked for."""

    file: str
    rois: tuple[str, ...]
    channel: str
    tail: bool
    gamma: str | None
    cfa: str | None
    layer: str | None
    as_json: bool
    csv: str | None
    plot: str | None
    force: bool


def measure(request: MtfRequest) -> None:
    """Measure the edges of a file; raises CamsimError with one sentence."""
    from camsim.measure import Roi, measure_mtf, read_picture

    rois = tuple(Roi.parse(text) for text in request.rois)
    _check_outputs(request)
    picture = read_picture(request.file, gamma=gamma_of(request.gamma), cfa=request.cfa, layer=request.layer)
    theory, why_not = _theory(picture)
    report = measure_mtf(picture, rois=rois, channel=request.channel, tail=request.tail, theory=theory)
    if request.csv is not None:
        write_whole(request.csv, _table(report).encode("utf-8"))
    if request.plot is not None:
        from camsim.cli.plot import draw

        stages = theory.stages if theory is not None else ()
        write_whole(request.plot, draw(report, Path(request.plot).suffix.lower()[1:], stages))
    if request.as_json:
        print(json.dumps(report.as_dict(), indent=2, ensure_ascii=False))
        return
    for line in _lines(report, why_not):
        print(line)


def gamma_of(text: str | None) -> float | str | None:
    """Return what ``--gamma`` says."""
    if text is None or text.lower() == "srgb":
        return text
    try:
        return float(text)
    except ValueError:
        raise InvalidValueError(f"{text!r}; give srgb or an exponent such as 2.2", key="--gamma") from None


def _check_outputs(request: MtfRequest) -> None:
    """Refuse outputs that cannot be written, before any work."""
    if request.csv is not None:
        if Path(request.csv).exists() and not request.force:
            raise OutputError(f"{request.csv!r} exists; overwrite it with --force, or write elsewhere")
        if not Path(request.csv).resolve().parent.is_dir():
            raise OutputError(f"cannot write {request.csv!r}: its folder does not exist; make it first")
    if request.plot is not None:
        from camsim.cli.plot import check_drawing

        check_drawing(request.plot, force=request.force)


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


def _table(report: MtfReport) -> str:
    """Return one row per edge, channel and frequency."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(("edge", "channel", "row", "col", "rows", "cols", "angle_deg", *_CURVES))
    for number, edge in enumerate(report.edges):
        roi = edge.roi
        head = [number, edge.channel, roi.row, roi.col, roi.rows, roi.cols, f"{edge.figures.angle_deg:.6g}"]
        for k, f in enumerate(edge.frequency_cycles_per_pixel):
            theory = "" if edge.theory is None else f"{edge.theory.mtf[k]:.8g}"
            writer.writerow([*head, f"{f:.6g}", f"{edge.mtf[k]:.8g}", f"{edge.mtf_error[k]:.3g}", theory])
    return text.getvalue()


def _lines(report: MtfReport, why_not: str) -> Iterator[str]:
    """Return the report for people: a row per edge and channel."""
    rows: list[tuple[str, ...]] = [
        (
            "row,col,rows,cols",
            "channel",
            "angle °",
            "MTF50 c/px",
            "theory",
            "MTF30",
            "MTF10",
            "at own Nyquist",
            "10–90 % px",
            "contrast",
            "SNR",
        )
    ]
    for edge in report.edges:
        f, e = edge.figures, edge.standard_error
        rows.append(
            (
                str(edge.roi),
                edge.channel,
                with_error(f.angle_deg, e.angle_deg),
                with_error(f.mtf50_cycles_per_pixel, e.mtf50_cycles_per_pixel),
                "–" if edge.theory is None else _number(edge.theory.mtf50_cycles_per_pixel),
                with_error(f.mtf30_cycles_per_pixel, e.mtf30_cycles_per_pixel),
                with_error(f.mtf10_cycles_per_pixel, e.mtf10_cycles_per_pixel),
                f"{with_error(f.mtf_at_nyquist, e.mtf_at_nyquist)} at {edge.nyquist_cycles_per_pixel:.3g}",
                with_error(f.rise_10_90_pixel, e.rise_10_90_pixel),
                _number(f.contrast),
                f"{f.snr:.3g}",
            )
        )
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    count = len({edge.roi for edge in report.edges})
    pitch = "" if report.pitch_um is None else f", 1 px = {report.pitch_um:g} µm"
    yield f"{report.file}: {count} edge{'s' if count != 1 else ''}{pitch}"
    for row in rows:
        yield "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
    if why_not:
        yield f"theory: none, {why_not}"
    if report.edges[0].tail:
        beyond = [edge.tail_fraction for edge in report.edges]
        yield f"line spread beyond the regions, added by a fit of 1/x²: {percent_range(min(beyond), max(beyond))}"
    else:
        yield "line spread beyond the regions left out (plain ISO 12233)"
    for edge in report.edges:
        for note in edge.notes:
            yield f"{edge.roi} {edge.channel}: {note}"
    for sentence in report.refused:
        yield f"left out: {sentence}"


def _number(value: float) -> str:
    return f"{value:.4g}" if math.isfinite(value) else "–"


def with_error(value: float, error: float) -> str:
    """Return a figure with its standard error in units of the last digits.

    >>> with_error(0.27058, 0.0031), with_error(0.25, 2e-9), with_error(math.nan, math.nan)
    ('0.2706(31)', '0.250000(0)', '–')
    """
    if not (math.isfinite(value) and math.isfinite(error)):
        return "–"
    if error < 1e-6:
        return f"{value:.6f}(0)"
    digits = max(0, 1 - math.floor(math.log10(error)))
    return f"{value:.{digits}f}({round(error * 10**digits)})"
