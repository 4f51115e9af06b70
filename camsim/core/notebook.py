"""HTML representations of objects in notebooks: small tables and drawings."""

from __future__ import annotations

import base64
from collections.abc import Iterable
from html import escape

import numpy as np
import numpy.typing as npt

_CELL = "text-align:left;vertical-align:top"
_WIDE, _HIGH = 360, 120


def table(rows: Iterable[tuple[str, str]], title: str = "") -> str:
    """Return a table of names and descriptions.

    >>> table([("camera", "<mine>")])  # doctest: +ELLIPSIS
    '<table><tr><th ...>camera</th><td ...>&lt;mine&gt;</td></tr></table>'
    """
    caption = f"<caption>{escape(title)}</caption>" if title else ""
    lines = (
        f'<tr><th style="{_CELL}">{escape(name)}</th><td style="{_CELL}">{escape(value)}</td></tr>'
        for name, value in rows
    )
    return f"<table>{caption}{''.join(lines)}</table>"


def image(png: bytes | None) -> str:
    """Return a picture as HTML; an empty text for None."""
    if png is None:
        return ""
    return f'<img alt="preview" src="data:image/png;base64,{base64.b64encode(png).decode("ascii")}"/>'


def line(x: npt.ArrayLike, y: npt.ArrayLike) -> str:
    """Return a plot of a curve as SVG, from 0 to its maximum."""
    across, up = np.asarray(x, float), np.asarray(y, float)
    across = _WIDE * (across - across.min()) / np.ptp(across)
    down = _HIGH * (1.0 - up / (up.max() or 1.0))
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across, down, strict=True))
    style = f"max-width:{_WIDE}px;width:100%"
    drawn = f'<polyline points="{points}" fill="none" stroke="#06c" stroke-width="1.5"/>'
    return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDE} {_HIGH}" style="{style}">{drawn}</svg>'
