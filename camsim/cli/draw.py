"""Drawing of a scene on the sensor: outlines over frame and window, without rendering."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from camsim.core.arrays import F64
from camsim.core.words import kebab, percent
from camsim.scene.outlines import loops_of
from camsim.spectra.curve import Curve, Spectrum, spectrum_at

if TYPE_CHECKING:
    from camsim.camera.capture import Capture

_RED_GREEN_BLUE_NM = ((600.0, 700.0), (500.0, 600.0), (400.0, 500.0))
_DISPLAY_GAMMA = 2.2
_ROUND = 1 / 300  # sides of round outlines in a picture, relative to the window's larger side
_MOST_GRID, _MOST_LETTERS, _MOST_NUMBERS, _MOST_LINES = 80, 24, 60, 40
_COLUMNS, _LINES, _CELL = 76, 34, 2.0  # of a terminal, whose cells are twice as high as wide
_SHADES = " ░▒▓█"


def colour_of(spectrum: Spectrum) -> tuple[float, float, float]:
    """Return the approximate display colour of a surface: its mean in three bands."""
    bands = [float(np.mean(spectrum_at(spectrum, np.linspace(*ends, 21)))) for ends in _RED_GREEN_BLUE_NM]
    red, green, blue = (min(1.0, band) ** (1.0 / _DISPLAY_GAMMA) for band in bands)
    return red, green, blue


class Painted(NamedTuple):
    """A painted primitive: index of its shape, loops (n, 2) in pitches, and surface."""

    number: int
    loops: list[F64]
    surface: Spectrum


def painted(capture: Capture, side_pitch: float) -> list[Painted]:
    """Return all painted primitives in painter's order, in pitches from the optical axis.

    side_pitch : length of the straight sides that replace round outlines, in pitches; short enough to be hardly visible
    """
    pitch_um = capture.camera.pitch_um
    return [
        Painted(number, [loop / pitch_um for loop in loops_of(one, side_pitch * pitch_um)], one.reflectance)
        for number, shape in enumerate(capture.scene.shapes)
        for one in shape.primitives()
    ]


def ends_of(capture: Capture) -> tuple[float, float, float, float]:
    """Return the left, right, top and bottom of the window, in pitches from the optical axis."""
    grid = capture.grid
    left, top = (centre - 0.5 for centre in grid.first_centre)
    return left, left + grid.cols, top, top + grid.rows


def picture(capture: Capture, suffix: str) -> bytes:
    """Return outlines, frame, window, photosites and a scale as bytes of a PNG, SVG or PDF."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib.collections import PathCollection
    from matplotlib.figure import Figure
    from matplotlib.path import Path

    camera = capture.camera
    left, right, top, bottom = ends_of(capture)
    wide, high = right - left, bottom - top
    figure = Figure(figsize=(9.0, min(12.0, max(4.0, 1.6 + 7.4 * high / wide))), layout="constrained")
    axes = figure.subplots()
    axes.set_facecolor(colour_of(capture.scene.background))
    seen = [one for one in painted(capture, _ROUND * max(wide, high)) if one.loops]
    paths = [
        Path.make_compound_path(*(Path(np.vstack([loop, loop[:1]]), closed=True) for loop in one.loops)) for one in seen
    ]
    colours = [colour_of(one.surface) for one in seen]
    axes.add_collection(PathCollection(paths, facecolors=colours, edgecolors="#c0392b", linewidths=0.6))
    firsts = {one.number: one.loops[0] for one in reversed(seen) if one.number < _MOST_NUMBERS}
    for number, outline in firsts.items():
        x, y = np.clip(outline.mean(axis=0), (left, top), (right, bottom))
        axes.annotate(str(number), (x, y), color="#c0392b", fontsize=8, ha="center", va="center", clip_on=True)
    _rectangle(axes, (-camera.cols / 2, camera.cols / 2, -camera.rows / 2, camera.rows / 2), "black", "frame")
    _rectangle(axes, (left, right, top, bottom), "#2456a6", "window")
    _photosites(axes, capture)
    axes.plot([0.0], [0.0], "+", color="#2456a6", ms=12, label="optical axis")
    margin = 0.06 * max(wide, high)
    axes.set(xlim=(left - margin, right + margin), ylim=(bottom + margin, top - margin), aspect="equal")
    axes.set(xlabel="photosites from the optical axis, to the right", ylabel="photosites from the optical axis, down")
    pitch_um = camera.pitch_um
    scale = (lambda pitches: pitches * pitch_um, lambda um: um / pitch_um)
    axes.secondary_xaxis("top", functions=scale).set_xlabel(f"µm; a photosite is {pitch_um:g} µm")
    axes.legend(fontsize=7, loc="lower right")
    figure.suptitle(f"{capture.scene_name}: {capture.grid.rows} × {capture.grid.cols} photosites of {camera.name}")
    out = io.BytesIO()
    figure.savefig(out, format=suffix, dpi=130, metadata={"Date": None} if suffix == "svg" else None)
    return out.getvalue()


def _rectangle(axes: Any, ends: tuple[float, float, float, float], colour: str, name: str) -> None:
    left, right, top, bottom = ends
    x, y = (left, right, right, left, left), (top, top, bottom, bottom, top)
    axes.plot(x, y, color=colour, lw=1.4, label=name)


def _photosites(axes: Any, capture: Capture) -> None:
    """Draw the lattice if visible, and the letters of the filters if readable."""
    grid, cfa = capture.grid, capture.camera.cfa
    left, right, top, bottom = ends_of(capture)
    if max(grid.rows, grid.cols) <= _MOST_GRID:
        axes.vlines(left + np.arange(grid.cols + 1), top, bottom, color="grey", lw=0.3)
        axes.hlines(top + np.arange(grid.rows + 1), left, right, color="grey", lw=0.3)
    if max(grid.rows, grid.cols) <= _MOST_LETTERS:
        index = cfa.channel_index(grid.rows, grid.cols, grid.origin)
        for row in range(grid.rows):
            for col in range(grid.cols):
                letter = cfa.channels[index[row, col]]
                place = (left + col + 0.5, top + row + 0.5)
                axes.annotate(letter, place, fontsize=6, color="grey", ha="center", va="center")


def lines(capture: Capture) -> Iterator[str]:
    """Yield the window as shaded cells for a terminal, a scale, and a line for each shape."""
    left, right, top, bottom = ends_of(capture)
    wide, high = right - left, bottom - top
    cols = max(2, min(_COLUMNS, math.floor(_LINES * _CELL * wide / high)))
    rows = max(1, round(cols * high / wide / _CELL))
    x = left + (np.arange(cols) + 0.5) * wide / cols
    y = top + (np.arange(rows) + 0.5) * high / rows
    on_top = np.full((rows, cols), -1)
    everything = painted(capture, wide / cols)
    for place, one in enumerate(everything):
        if one.loops:
            _paint(on_top, place, one.loops, x, y)
    surfaces = [*(one.surface for one in everything), capture.scene.background]
    shade = [_SHADES[min(len(_SHADES) - 1, round(float(np.mean(colour_of(s))) * (len(_SHADES) - 1)))] for s in surfaces]
    yield f"┌{'─' * cols}┐"
    for row in on_top:
        yield f"│{''.join(shade[number] for number in row)}│"
    yield f"└{'─' * cols}┘"
    camera = capture.camera
    yield from _scale(wide / cols, cols, camera.pitch_um)
    window = f"rows {round(top + camera.rows / 2)} to {round(bottom + camera.rows / 2) - 1}"
    window += f", cols {round(left + camera.cols / 2)} to {round(right + camera.cols / 2) - 1}"
    yield f"window: {window} of {camera.rows} × {camera.cols} photosites of {camera.name}"
    yield from _legend(capture, everything, on_top)


def _scale(pitches_per_cell: float, cols: int, pitch_um: float) -> Iterator[str]:
    """Yield a bar of a round number of photosites, about a quarter of the width."""
    about = max(1.0, 0.25 * cols * pitches_per_cell)
    decade = 10.0 ** math.floor(math.log10(about))
    pitches = next(step * decade for step in (5.0, 2.0, 1.0) if step * decade <= about)
    yield f"├{'─' * max(0, round(pitches / pitches_per_cell) - 2)}┤ {pitches:g} photosites, {pitches * pitch_um:g} µm"


def _legend(capture: Capture, everything: list[Painted], on_top: Any) -> Iterator[str]:
    shapes: Sequence[Any] = capture.scene.shapes
    owner = np.array([*(one.number for one in everything), -1])
    for number, shape in enumerate(shapes[:_MOST_LINES]):
        share = float(np.mean(owner[on_top] == number))
        seen = f"{percent(share)} of the window" if share else "not seen in the window, or smaller than a cell"
        kind = getattr(shape, "name", kebab(type(shape)))  # a chart's own
        surfaces = list(dict.fromkeys(_words(one.surface) for one in everything if one.number == number))
        surface = surfaces[0] if len(surfaces) == 1 else f"{len(surfaces)} surfaces"
        yield f"  scene.shapes.{number}: {kind}, reflectance {surface}: {seen}"
    if len(shapes) > _MOST_LINES:
        yield f"  … and {len(shapes) - _MOST_LINES} more shapes"
    yield f"  background: reflectance {_words(capture.scene.background)}: {percent(float(np.mean(on_top < 0)))}"


def _words(spectrum: Spectrum) -> str:
    return (spectrum.name or "by a table") if isinstance(spectrum, Curve) else f"{spectrum:g}"


def _paint(on_top: Any, place: int, loops: list[F64], x: F64, y: F64) -> None:
    """Write the index into painted cells: inside, a ray to the right crosses an odd number of sides."""
    corners = np.concatenate(loops)
    following = np.concatenate([np.roll(loop, -1, axis=0) for loop in loops])
    low, high = corners.min(axis=0), corners.max(axis=0)
    cols, rows = (np.flatnonzero((at >= low[k]) & (at <= high[k])) for k, at in enumerate((x, y)))
    if not cols.size or not rows.size:
        return
    px, py = x[cols][None, :], y[rows][:, None]
    inside = np.zeros((rows.size, cols.size), bool)
    for (x0, y0), (x1, y1) in zip(corners, following, strict=True):
        if y0 != y1:
            inside ^= ((y0 > py) != (y1 > py)) & (px < x0 + (x1 - x0) * (py - y0) / (y1 - y0))
    on_top[np.ix_(rows, cols)] = np.where(inside, place, on_top[np.ix_(rows, cols)])
