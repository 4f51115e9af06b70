"""Figures: error against time, and the edge as each method draws it. Made from the lines of a run, never typed.

Colours are those of Okabe and Ito, which colour-blind people tell apart; every method also has a marker and its name
beside its line, so the figures read in grey too.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from camsim.bench.findings import contender, seconds, true_error
from camsim.bench.results import Line, of_kind
from camsim.errors import UnsupportedError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STYLES: dict[str, tuple[str, str, str]] = {
    "auto": ("#000000", "o", "-"),
    "boundary": ("#0072B2", "s", "--"),
    "fourier": ("#D55E00", "D", "--"),
    "importance": ("#009E73", "P", "-"),
    "strips": ("#56B4E9", "*", "-"),
    "uniform": ("#E69F00", "^", "-"),
    "uniform-pixel": ("#CC79A7", "v", "-"),
    "area": ("#777777", "x", "-"),
    "GalSim": ("#882255", "h", "-"),
    "GalSim, constant subtracted": ("#882255", "H", ":"),
    "prysm": ("#44AA99", "X", "-"),
}
WIDE, NARROW = (9.2, 5.4), (5.2, 6.2)  # inches
HOLLOW = ("auto", "GalSim, constant subtracted")


def check_matplotlib() -> None:
    """Raise UnsupportedError when there is no matplotlib."""
    if find_spec("matplotlib") is None:
        raise UnsupportedError(
            "camsim bench draws with matplotlib, which is not installed: python -m pip install 'camsim-spectral[bench]'"
        )


def work_precision(lines: Sequence[Line], psf: str, *, narrow: bool = False) -> Figure:
    """Return error against time for one system; each marker's id is ``line-N``, N the number of its line."""
    from matplotlib.figure import Figure

    clocked = [(n, p) for n, p in enumerate(lines) if p["kind"] == "point" and p["psf"] == psf and "one_thread" in p]
    figure = Figure(figsize=NARROW if narrow else WIDE, layout="constrained")
    axes = figure.subplots()
    axes.set_xscale("log")
    axes.set_yscale("log")
    ends: list[tuple[float, float, str]] = []
    for name, (colour, marker, dash) in STYLES.items():
        mine = sorted(((seconds(p) or 0.0, true_error(p), n) for n, p in clocked if contender(p) == name))
        if not mine:
            continue
        times, errors = [t for t, _, _ in mine], [e for _, e, _ in mine]
        front = 5 if name == "auto" else 3
        axes.plot(times, errors, dash, color=colour, lw=2.2 if name == "auto" else 1.4, zorder=front)
        for time_s, error, number in mine:
            axes.plot(
                [time_s],
                [error],
                marker,
                color=colour,
                ms=9 if name in HOLLOW else 6,
                mfc="none" if name in HOLLOW else colour,
                zorder=front,
                gid=f"line-{number}",
            )
        ends.append((times[-1], errors[-1], name))
    _name_lines(axes, ends, narrow=narrow)
    axes.set_xlabel("CPU seconds of one core, set-up and check included")
    axes.set_ylabel("largest error of any photosite (white is 1)")
    axes.grid(which="major", alpha=0.3)
    label = next((line["label"] for line in of_kind(lines, "truth") if line["psf"] == psf), psf)
    axes.set_title(f"{label}, 446 × 446 photosites", fontsize=10 if narrow else 11)
    return figure


def _name_lines(axes: Any, ends: list[tuple[float, float, str]], *, narrow: bool) -> None:
    """Write each method's name beside the plot, joined to its line's end, none over another."""
    step = 0.062 if narrow else 0.066
    x0, x1 = axes.get_xlim()
    y0, y1 = axes.get_ylim()
    axes.set_xlim(x0, x1)
    axes.set_ylim(y0, y1)

    def height(error: float) -> float:
        return (math.log(error) - math.log(y0)) / (math.log(y1) - math.log(y0))

    ordered = sorted(ends, key=lambda end: end[1])
    places: list[float] = []
    for _, error, _ in ordered:  # from below: each at its line's height, or clear of the one beneath
        places.append(max(height(error), places[-1] + step if places else 0.01))
    above = 0.99 + step
    for k in reversed(range(len(places))):  # from above: none higher than the plot
        above = places[k] = min(places[k], above - step)
    for (time_s, error, name), place in zip(ordered, places, strict=True):
        words = name.replace(", constant", ",\nconstant") if narrow else name
        axes.annotate(
            words,
            xy=(time_s, error),
            xytext=(1.02, place),
            textcoords="axes fraction",
            color=STYLES[name][0],
            fontsize=9,
            va="center",
            annotation_clip=False,
            arrowprops={"arrowstyle": "-", "color": STYLES[name][0], "lw": 0.5, "alpha": 0.6, "shrinkB": 4},
        )


def edge_panels(lines: Sequence[Line], psf: str, *, narrow: bool = False) -> Figure:
    """Return the edge as each method draws it (points) and its error, the paper's figures 13 and 14."""
    from matplotlib.figure import Figure

    panels = [line for line in of_kind(lines, "esf") if line["psf"] == psf]
    across = min(2 if narrow else 3, len(panels))
    down = math.ceil(len(panels) / across)
    figure = Figure(figsize=(5.2 if narrow else 9.2, 2.3 * down + 0.6), layout="constrained")
    grid = figure.subplots(down, across, squeeze=False, sharex=True)
    for axes in grid.ravel()[len(panels) :]:
        axes.remove()
    for axes, line in zip(grid.ravel(), panels, strict=False):
        colour, marker, _ = STYLES[line["method"]]
        most = max(abs(e) for e in line["error"]) or 1.0
        power = math.floor(math.log10(most))
        axes.plot(line["distance_px"], [e / 10.0**power for e in line["error"]], marker, color=colour, ms=2.5)
        axes.axhline(0.0, color="black", lw=0.6)
        axes.set_title(line["label"], fontsize=9)
        axes.set_ylabel(f"error, 1e{power}", fontsize=8)
        axes.tick_params(labelsize=8)
        axes.grid(alpha=0.25)
        edge = axes.twinx()
        edge.plot(line["distance_px"], line["value"], color="#999999", lw=0.8, zorder=0)
        edge.set_ylim(-0.05, 1.05)
        edge.set_yticks([])
    figure.supxlabel("distance from the edge, pixels; grey: the edge as drawn, from 1 to 0", fontsize=9)
    return figure


def scaling_panels(lines: Sequence[Line], *, narrow: bool = False) -> Figure:
    """Return CPU time against every kind of size, wall time against threads."""
    from matplotlib.figure import Figure

    kinds = list(dict.fromkeys(line["over"] for line in of_kind(lines, "scaling")))
    across = min(2 if narrow else 3, len(kinds))
    down = math.ceil(len(kinds) / across)
    figure = Figure(figsize=(5.2 if narrow else 9.2, 2.6 * down + 0.3), layout="constrained")
    grid = figure.subplots(down, across, squeeze=False)
    for axes in grid.ravel()[len(kinds) :]:
        axes.remove()
    for axes, over in zip(grid.ravel(), kinds, strict=False):
        mine = [line for line in of_kind(lines, "scaling") if line["over"] == over]
        clock = "wall_s" if over == "threads" else "cpu_s"
        axes.loglog([m["size"] for m in mine], [m[clock] for m in mine], "o-", color="#0072B2", ms=5)
        axes.set_xlabel(over, fontsize=9)
        axes.set_ylabel("wall s" if over == "threads" else "CPU s", fontsize=9)
        axes.tick_params(labelsize=8)
        axes.grid(which="major", alpha=0.3)
    return figure


def svg(figure: Figure, prefix: str) -> str:
    """Return a figure as SVG with text as text; every id begins with ``prefix``, so that a page can hold many."""
    import matplotlib as mpl

    out = io.StringIO()
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": prefix, "font.family": "sans-serif"}):
        figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None})
    text = out.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
    text = re.sub(r'\bid="([^"]+)"', rf'id="{prefix}-\1"', text)
    return re.sub(r'((?:url\(|xlink:href=")#)', rf"\1{prefix}-", text)


def png(figure: Figure) -> bytes:
    """Return a figure as PNG."""
    out = io.BytesIO()
    figure.savefig(out, format="png", dpi=150)
    return out.getvalue()
