"""MTF curves as a picture: of one file by channel, of several by file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from camsim.cli.plot import bytes_of, colour_of_channel, new_figure

if TYPE_CHECKING:
    from camsim.measure import EdgeMtf, MtfReport, MtfSeries
    from camsim.measure.full_frame import Unit

_MOST_CURVES, _MOST_NAMED = 24, 12
_DASHES = {"R": ":", "G": "-", "G1": "-", "G2": "-.", "B": "--"}


def draw(series: MtfSeries, file: str, unit: Unit, stages: Sequence[str] = ()) -> bytes:
    """Return measured curves, theory and their difference, in the format of the file's suffix.

    stages : stages of the theory, if equal in all files
    """
    from camsim.measure.full_frame import UNITS

    several = len(series.reports) > 1
    most = max(1, _MOST_CURVES // len(series.reports))
    compared = any(edge.theory is not None for report in series.reports for edge in report.edges[:most])
    figure = new_figure(9.0, 6.6 if compared else 4.8)
    if compared:
        top, below = figure.subplots(2, 1, sharex=True, height_ratios=[3, 1])
    else:
        top, below = figure.subplots(), None
    seen: set[str] = set()
    for number, (label, report) in enumerate(zip(series.labels, series.reports, strict=True)):
        for edge in report.edges[:most]:
            colour = f"C{number % 10}" if several else colour_of_channel(edge.channel)
            dash = _DASHES.get(edge.channel, "-") if several else "-"
            name = f"{edge.channel}, {edge.figures.angle_deg:.2f}°, roi {edge.roi}"
            if len(report.edges) > _MOST_NAMED:
                name = f"{edge.channel}, {min(most, len(report.edges))} of {len(report.edges)} edges"
            if several:
                name = f"{series.by or ''} {label}, {edge.channel}".strip()
            style = {"color": colour, "ls": dash, "label": None if name in seen else name}
            seen.add(name)
            factor = report.full_frame.per_unit(unit)
            _curve(top, below, edge, factor, style, shaded=len(report.edges) <= _MOST_NAMED)
            if edge.theory is not None:
                named = f"theory: {' · '.join(stages)}" if stages else "theory"
                stated = None if "theory" in seen else named
                f = factor * edge.frequency_cycles_per_pixel
                top.plot(f, edge.theory.mtf, color=colour if several else "black", lw=1.0, ls=(0, (2, 2)), label=stated)
                seen.add("theory")
    _nyquists(series.reports, most, unit, top, below)
    top.set_ylim(0.0, 1.05)
    top.set_xlim(0.0, max(report.full_frame.per_unit(unit) for report in series.reports))
    top.set_ylabel("MTF")
    top.grid(alpha=0.3)
    top.legend(fontsize=8, loc="upper right")
    by = f" by {series.by}" if series.by else ""
    top.set_title(f"{len(series.reports)} files{by}" if several else series.reports[0].file, pad=16)
    last = top if below is None else below
    if below is not None:
        below.axhline(0.0, color="black", lw=0.8)
        below.set_ylabel("measured − theory")
        below.grid(alpha=0.3)
    shaded = any(len(report.edges) <= _MOST_NAMED for report in series.reports)
    last.set_xlabel(f"{UNITS[unit]}{'; shaded: two standard errors' if shaded else ''}")
    return bytes_of(figure, file)


def _curve(top: Any, below: Any, edge: EdgeMtf, factor: float, style: dict[str, Any], *, shaded: bool) -> None:
    f, colour = factor * edge.frequency_cycles_per_pixel, style["color"]
    error = 2 * edge.mtf_error if shaded else 0.0 * edge.mtf_error
    top.plot(f, edge.mtf, lw=1.2, **style)
    top.fill_between(f, edge.mtf - error, edge.mtf + error, color=colour, alpha=0.15, lw=0)
    top.plot([factor * edge.figures.mtf50_cycles_per_pixel], [0.5], "o", color=colour, ms=4)
    if edge.theory is not None and below is not None:
        below.plot(f, edge.theory.difference, color=colour, ls=style["ls"], lw=1.0)
        below.fill_between(f, -error, error, color=colour, alpha=0.15, lw=0)


def _nyquists(reports: Sequence[MtfReport], most: int, unit: Unit, top: Any, below: Any) -> None:
    """Draw and label the Nyquist frequencies of sensors and channels."""
    whose: dict[float, list[str]] = {}
    for report in reports:
        factor, displayed = report.full_frame.per_unit(unit), {edge.channel for edge in report.edges[:most]}
        for name, units in report.nyquist().items():
            if name == "sensor" or name in displayed:
                at = round(factor * units["cycles_per_pixel"], 9)
                called = "the sensor" if name == "sensor" else name
                whose.setdefault(at, [])
                if called not in whose[at]:
                    whose[at].append(called)
    for at, names in sorted(whose.items()):
        for axes in (top, below):
            if axes is not None:
                axes.axvline(at, color="grey", lw=0.8, ls=":")
        words = f"Nyquist of {', '.join(names)} "
        top.text(at, 1.03, words, ha="right", va="top", rotation=90, fontsize=8, color="grey")
