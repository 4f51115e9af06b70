"""Common parts of plots; matplotlib is imported only when a plot is requested."""

from __future__ import annotations

import io
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from camsim.errors import OutputError, UnsupportedError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLOURS = {"R": "#c0392b", "G": "#1e8449", "G1": "#1e8449", "G2": "#58a55c", "B": "#2456a6", "Y": "#333333"}
_OTHER_COLOUR = "#7d3c98"


SUFFIXES = (".png", ".svg", ".pdf")


def check_drawing(file: str, *, force: bool, option: str = "--plot") -> None:
    """Raise OutputError if a plot could not be written, or UnsupportedError if matplotlib is missing."""
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
    """Return the colour of a channel in plots."""
    return _COLOURS.get(name, _OTHER_COLOUR)


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure, in inches, that needs no screen."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def bytes_of(figure: Figure, file: str) -> bytes:
    """Return a figure as a PNG, SVG or PDF, by the suffix of ``file``; without a date."""
    suffix = Path(file).suffix.lower()[1:]
    out = io.BytesIO()
    figure.savefig(out, format=suffix, dpi=130, metadata={"Date": None} if suffix == "svg" else None)
    return out.getvalue()
