"""Curves as pictures; matplotlib is looked for only when a plot is asked for."""

from __future__ import annotations

import io
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from camsim.errors import OutputError, UnsupportedError

if TYPE_CHECKING:
    from camsim.measure import MtfReport

_COLOURS = {"R": "#c0392b", "G": "#1e8449", "G1": "#1e8449", "G2": "#58a55c", "B": "#2456a6", "Y": "#333333"}
_OTHER_COLOUR = "#7d3c98"
_MOST_EDGES = 12


SUFFIXES = (".png", ".svg", ".pdf")


def check_drawing(file: str, *, force: bool, option: str = "--plot") -> None:
    """Refuse what cannot be drawn, before any work: raises OutputError, UnsupportedError without matplotlib."""
    if Path(file).suffix.lower() not in SUFFIXES:
        raise OutputError(f"cannot write {file!r}: a plot is one of {', '.join(SUFFIXES)}")
    if not Path(file).parent.is_dir():
        raise OutputError(f"cannot write {file!r}: the folder {str(Path(file).parent)!r} does not exist; make it first")
    if Path(file).exists() and not force:
        raise OutputError(f"{file!r} exists; overwrite it with --force")
    if find_spec("matplotlib") is None:
        raise UnsupportedError(
            "needs matplotlib, which is not installed: python -m pip install 'camsim-spectral[plot]'", key=option
        )


def colour_of_channel(name: str) -> str:
    """Return what a channel is drawn in."""
    return _COLOURS.get(name, _OTHER_COLOUR)


def draw(report: MtfReport, suffix: str, stages: Sequence[str] = ()) -> bytes:
    """Return a picture of measured curves, theory and their difference, as bytes of a PNG, SVG or PDF.

    stages : what the theory is the product of
    """
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib.figure import Figure

    edges = report.edges[:_MOST_EDGES]
    compared = any(edge.theory is not None for edge in edges)
    figure = Figure(figsize=(9.0, 6.6 if compared else 4.8), layout="constrained")
    if compared:
        top, below = figure.subplots(2, 1, sharex=True, height_ratios=[3, 1])
    else:
        top, below = figure.subplots(), None
    seen: set[str] = set()
    for edge in edges:
        colour = colour_of_channel(edge.channel)
        f = edge.frequency_cycles_per_pixel
        name = f"{edge.channel}, {edge.figures.angle_deg:.2f}°, roi {edge.roi}"
        top.plot(f, edge.mtf, color=colour, lw=1.2, label=name)
        top.fill_between(
            f, edge.mtf - 2 * edge.mtf_error, edge.mtf + 2 * edge.mtf_error, color=colour, alpha=0.15, lw=0
        )
        half = edge.figures.mtf50_cycles_per_pixel
        top.plot([half], [0.5], "o", color=colour, ms=4)
        if edge.theory is not None and below is not None:
            label = None if "theory" in seen else f"theory: {' · '.join(stages)}"
            top.plot(f, edge.theory.mtf, color="black", lw=1.0, ls="--", label=label)
            seen.add("theory")
            below.plot(f, edge.theory.difference, color=colour, lw=1.0)
            below.fill_between(f, -2 * edge.mtf_error, 2 * edge.mtf_error, color=colour, alpha=0.15, lw=0)
    for nyquist in sorted({edge.nyquist_cycles_per_pixel for edge in edges}):
        channels = dict.fromkeys(edge.channel for edge in edges if edge.nyquist_cycles_per_pixel == nyquist)
        for axes in (top, below):
            if axes is not None:
                axes.axvline(nyquist, color="grey", lw=0.8, ls=":")
        words = f"Nyquist of {', '.join(channels)} "
        top.text(nyquist, 1.03, words, ha="right", va="top", rotation=90, fontsize=8, color="grey")
    top.set_ylim(0.0, 1.05)
    top.set_xlim(0.0, float(edges[0].frequency_cycles_per_pixel[-1]))
    top.set_ylabel("MTF")
    top.grid(alpha=0.3)
    top.legend(fontsize=8, loc="upper right")
    top.set_title(report.file, pad=16)
    last = top if below is None else below
    if below is not None:
        below.axhline(0.0, color="black", lw=0.8)
        below.set_ylabel("measured − theory")
        below.grid(alpha=0.3)
    last.set_xlabel("cycles per pixel (of the sensor's pitch); shaded: two standard errors")
    out = io.BytesIO()
    figure.savefig(out, format=suffix, dpi=130, metadata={"Date": None} if suffix == "svg" else None)
    return out.getvalue()
