"""What notebooks show of objects: small tables and drawings, as HTML."""

from __future__ import annotations

import base64
from collections.abc import Iterable
from html import escape

import numpy as np
import numpy.typing as npt

_CELL = "text-align:left;vertical-align:top"
_WIDE, _HIGH = 360, 120


def table(rows: Iterable[tuple[str, str]], title: str = "") -> str:
    """Return a table of names and what they are.

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
    """Return a picture; nothing for None."""
    if png is None:
        return ""
    return f'<img alt="preview" src="data:image/png;base64,{base64.b64encode(png).decode("ascii")}"/>'


def line(x: npt.ArrayLike, y: npt.ArrayLike) -> str:
    """Return a curve from 0 up, its highest point at the top, as a drawing."""
    across, up = np.asarray(x, float), np.asarray(y, float)
    across = _WIDE * (across - across.min()) / np.ptp(across)
    down = _HIGH * (1.0 - up / (up.max() or 1.0))
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across, down, strict=True))
    return _drawing(
        f'<polyline points="{points}" fill="none" stroke="#06c" stroke-width="1.5"/>', (0.0, 0.0, _WIDE, _HIGH)
    )


def outlines(shapes: Iterable[tuple[npt.NDArray[np.float64], float]], background: float) -> str:
    """Return shapes, (corners, grey 0..1) from the lowest to the uppermost, over a background."""
    found = [(corners, grey) for corners, grey in shapes if np.isfinite(corners).all()]
    if not found:
        return ""
    every = np.concatenate([corners for corners, _ in found])
    (left, top), (right, bottom) = every.min(axis=0).tolist(), every.max(axis=0).tolist()
    margin = 0.05 * max(right - left, bottom - top)
    box = left - margin, top - margin, right - left + 2.0 * margin, bottom - top + 2.0 * margin
    place = " ".join(f'{name}="{side:.6g}"' for name, side in zip(("x", "y", "width", "height"), box, strict=True))
    parts = [f'<rect {place} fill="{_grey(background)}"/>']
    for corners, grey in found:
        points = " ".join(f"{a:.6g},{b:.6g}" for a, b in corners.tolist())
        parts.append(f'<polygon points="{points}" fill="{_grey(grey)}"/>')
    return _drawing("".join(parts), box)


def _drawing(parts: str, box: tuple[float, float, float, float]) -> str:
    seen = " ".join(f"{number:.6g}" for number in box)
    style = f"max-width:{_WIDE}px;max-height:{2 * _WIDE}px;width:100%"
    return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{seen}" style="{style}">{parts}</svg>'


def _grey(reflectance: float) -> str:
    """Return a reflectance as a screen shows it."""
    code = round(255.0 * min(max(reflectance, 0.0), 1.0) ** (1.0 / 2.2))
    return f"#{code:02x}{code:02x}{code:02x}"
