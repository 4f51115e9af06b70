"""The figure of error against time, and figures as SVG and PNG.

Colours are those of Okabe and Ito, which are distinct for colour-blind people; every method also has a marker and its
name next to its line, so that figures are readable in grey.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, NamedTuple

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


class Mark(NamedTuple):
    """One marker: a setting's seconds and error, and its number in the page."""

    seconds: float
    error: float
    number: int


def check_matplotlib() -> None:
    """Raise UnsupportedError when there is no matplotlib."""
    if find_spec("matplotlib") is None:
        raise UnsupportedError(
            "camsim bench draws with matplotlib, which is not installed: python -m pip install 'camsim-spectral[plot]'"
        )


def work_precision(
    curves: Mapping[str, Sequence[Mark]], *, title: str, seconds_label: str, error_label: str, narrow: bool = False
) -> Figure:
    """Return error against time: a curve for each method, by its name; each marker's id is ``line-N``, N its number."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=NARROW if narrow else WIDE, layout="constrained")
    axes = figure.subplots()
    axes.set_xscale("log")
    axes.set_yscale("log")
    ends: list[tuple[float, float, str]] = []
    for name, (colour, marker, dash) in STYLES.items():
        mine = sorted(curves.get(name, ()))
        if not mine:
            continue
        times, errors = [m.seconds for m in mine], [m.error for m in mine]
        front = 5 if name == "auto" else 3
        axes.plot(times, errors, dash, color=colour, lw=2.2 if name == "auto" else 1.4, zorder=front)
        for mark in mine:
            axes.plot(
                [mark.seconds],
                [mark.error],
                marker,
                color=colour,
                ms=9 if name in HOLLOW else 6,
                mfc="none" if name in HOLLOW else colour,
                zorder=front,
                gid=f"line-{mark.number}",
            )
        ends.append((times[-1], errors[-1], name))
    _name_lines(axes, ends, narrow=narrow)
    axes.set_xlabel(seconds_label)
    axes.set_ylabel(error_label)
    axes.grid(which="major", alpha=0.3)
    axes.set_title(title, fontsize=10 if narrow else 11)
    return figure


def _name_lines(axes: Any, ends: list[tuple[float, float, str]], *, narrow: bool) -> None:
    """Write each method's name next to the plot, joined to its line's end, without overlap."""
    step = 0.062 if narrow else 0.066
    x0, x1 = axes.get_xlim()
    y0, y1 = axes.get_ylim()
    axes.set_xlim(x0, x1)
    axes.set_ylim(y0, y1)

    def height(error: float) -> float:
        return (math.log(error) - math.log(y0)) / (math.log(y1) - math.log(y0))

    ordered = sorted(ends, key=lambda end: end[1])
    places: list[float] = []
    for _, error, _ in ordered:  # from below: at its line's height, or above the previous one
        places.append(max(height(error), places[-1] + step if places else 0.01))
    above = 0.99 + step
    for k in reversed(range(len(places))):  # from above: none above the plot
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
