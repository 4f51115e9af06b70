"""What ``camsim measure mtf`` prints, and its table of curves."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from camsim.cli.tables import print_table
from camsim.core.words import percent_range
from camsim.measure.full_frame import NYQUIST_OF_SENSOR_CYCLES_PER_PIXEL

if TYPE_CHECKING:
    from camsim.measure import EdgeMtf, MtfReport, MtfSeries
    from camsim.measure.full_frame import Unit

_HEADS = ("edge", "channel", "row", "col", "rows", "cols", "angle_deg")
_FREQUENCIES = ("frequency_cycles_per_pixel", "frequency_lp_per_mm", "frequency_lw_per_ph")
_MOST_REFUSED = 20
_SHORT: Mapping[str, str] = {"cycles/px": "c/px", "lp/mm": "lp/mm", "lw/ph": "LW/PH"}


def curves_of(series: MtfSeries) -> tuple[Sequence[str], Sequence[Sequence[object]]]:
    """Return heads and one row per file, edge, channel and frequency."""
    rows: list[tuple[object, ...]] = []
    for value, report in zip(series.values, series.reports, strict=True):
        for number, edge in enumerate(report.edges):
            roi = edge.roi
            place = report.place(edge)
            where = number, edge.channel, roi.row, roi.col, roi.rows, roi.cols, f"{edge.figures.angle_deg:.6g}"
            one = report.file, "" if value is None else value, *where, place.direction, f"{place.radius_pixel:.6g}"
            for k, f in enumerate(edge.frequency_cycles_per_pixel.tolist()):
                units = report.full_frame.in_units(f).values()
                theory = "" if edge.theory is None else f"{edge.theory.mtf[k]:.8g}"
                each = ("" if math.isnan(unit) else f"{unit:.6g}" for unit in units)
                rows.append((*one, *each, f"{edge.mtf[k]:.8g}", f"{edge.mtf_error[k]:.3g}", theory))
    heads = ("file", series.by or "name", *_HEADS, "direction", "radius_pixel", *_FREQUENCIES)
    return (*heads, "mtf", "mtf_error", "theory_mtf"), rows


def print_series(series: MtfSeries, unit: Unit, why_not: Mapping[str, str]) -> None:
    """Print a row per file, edge and channel; ``why_not``: for files without theory, the reason."""
    several = len(series.reports) > 1
    short = _SHORT[unit]
    heads = (
        *((series.by or "file",) if several else ()), "row,col,rows,cols", "channel", "angle °", f"MTF50 {short}",
        "theory", f"MTF30 {short}", f"MTF10 {short}", "at channel's Nyquist", "theory", "at sensor's Nyquist", "theory",
        "10–90 % px", "contrast", "SNR", "acutance 2 PH", "radius px", "direction",
    )  # fmt: skip
    rows = []
    for label, report in zip(series.labels, series.reports, strict=True):
        rows += [(*((label,) if several else ()), *_row(report, edge, unit)) for edge in report.edges]
    print_table(_title(series), heads, rows)
    nyquists = [_nyquist(report) for report in series.reports]
    alike = len(set(nyquists)) == 1
    if alike:
        print(nyquists[0])
    for report, stated in zip(series.reports, nyquists, strict=True):
        before = f"{report.file}: " if several else ""
        if not alike:
            print(before + stated)
        _print_rest(report, before, why_not.get(report.file, ""))


def _title(series: MtfSeries) -> str:
    if len(series.reports) > 1:
        by = f" by {series.by}" if series.by else ""
        return f"{len(series.reports)} files{by}"
    report = series.reports[0]
    count = len({edge.roi for edge in report.edges})
    pitch = "" if report.pitch_um is None else f", 1 px = {report.pitch_um:g} µm"
    return f"{report.file}: {count} edge{'s' if count != 1 else ''}{pitch}"


def _row(report: MtfReport, edge: EdgeMtf, unit: Unit) -> tuple[str, ...]:
    f, e = edge.figures, edge.standard_error
    factor = report.full_frame.per_unit(unit)
    place = report.place(edge)
    known = edge.theory
    theory = (
        ("–",) * 3
        if known is None
        else tuple(
            map(_number, (factor * known.mtf50_cycles_per_pixel, known.mtf_at_nyquist, known.mtf_at_nyquist_of_sensor))
        )
    )
    half, third, tenth = (
        with_error(
            factor * getattr(f, f"mtf{level}_cycles_per_pixel"), factor * getattr(e, f"mtf{level}_cycles_per_pixel")
        )
        for level in (50, 30, 10)
    )
    return (
        str(edge.roi), edge.channel, with_error(f.angle_deg, e.angle_deg), half, theory[0], third, tenth,
        f"{with_error(f.mtf_at_nyquist, e.mtf_at_nyquist)} at {factor * edge.nyquist_cycles_per_pixel:.3g}", theory[1],
        f"{with_error(f.mtf_at_nyquist_of_sensor, e.mtf_at_nyquist_of_sensor)} at "
        f"{factor * NYQUIST_OF_SENSOR_CYCLES_PER_PIXEL:.3g}", theory[2],
        with_error(f.rise_10_90_pixel, e.rise_10_90_pixel), _number(f.contrast), f"{f.snr:.3g}",
        f"{report.acutance(edge, 2.0):.4f}", f"{place.radius_pixel:.0f}", place.direction,
    )  # fmt: skip


def _nyquist(report: MtfReport) -> str:
    """Print the Nyquist frequencies of the sensor and its channels."""
    stated = "; ".join(
        f"{'of the sensor' if name == 'sensor' else f'of {name}'} {_in_words(each)}"
        for name, each in report.nyquist().items()
    )
    return f"Nyquist frequency {stated}; picture height {report.full_frame.rows} px"


def _print_rest(report: MtfReport, before: str, why_not: str) -> None:
    if why_not:
        print(f"{before}theory: none, {why_not}")
    if report.edges[0].tail:
        beyond = [edge.tail_fraction for edge in report.edges]
        stated = percent_range(min(beyond), max(beyond))
        print(f"{before}line spread beyond the regions, added by a fit of 1/x²: {stated}")
    else:
        print(f"{before}line spread beyond the regions left out (plain ISO 12233)")
    for edge in report.edges:
        for note in edge.notes:
            print(f"{before}{edge.roi} {edge.channel}: {note}")
    for sentence in report.refused[:_MOST_REFUSED]:
        print(f"left out: {sentence}")
    if more := len(report.refused[_MOST_REFUSED:]):
        print(f"{before}left out: {more} more edges or channels; --json tells each")


def _in_words(units: Mapping[str, float]) -> str:
    displayed = zip(_SHORT.values(), units.values(), strict=True)
    return " = ".join(f"{value:.4g} {name}" for name, value in displayed if math.isfinite(value))


def _number(value: float) -> str:
    return f"{value:.4g}" if math.isfinite(value) else "–"


def with_error(value: float, error: float) -> str:
    """Return a figure with its standard error in brackets, in units of the last digits.

    >>> with_error(0.27058, 0.0031), with_error(0.25, 2e-9), with_error(math.nan, math.nan)
    ('0.2706(31)', '0.250000(0)', '–')
    """
    if not (math.isfinite(value) and math.isfinite(error)):
        return "–"
    if error < 1e-6:
        return f"{value:.6f}(0)"
    digits = max(0, 1 - math.floor(math.log10(error)))
    return f"{value:.{digits}f}({round(error * 10**digits)})"
