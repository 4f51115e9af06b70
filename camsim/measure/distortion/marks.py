"""The marks of a chart in the scene, and the location of a mark from the photosites of a channel.

A dot is a disc with a soft rim, a corner of a checkerboard the product of two soft edges through one point:

    dot     light + (dark − light)·Φ((R − |p − c|)/σ)
    corner  mean + step·erf(u/√2σ)·erf(v/√2σ),  u and v across the two edges, whose directions are free
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
import scipy

from camsim.core.arrays import F64
from camsim.scene import Scene
from camsim.scene.charts import Chart
from camsim.scene.charts.chart import Card
from camsim.spectra.curve import Spectrum

Kind: TypeAlias = Literal["dot-grid", "checkerboard"]

KINDS: tuple[Kind, ...] = ("dot-grid", "checkerboard")

_LEAST_SAMPLES = 24
_SOFT_PX = 0.6
_CORNER_SHARE = 0.7


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Marks:
    """Marks of one kind.

    places_um : (n, 2) positions of the marks in the scene
    reach_um  : radius within which photosites belong to a mark
    size_um   : radius of a dot; 0 for a corner
    turn_rad  : rotation of the chart
    surfaces  : the two surfaces of the chart
    """

    kind: Kind
    places_um: F64
    reach_um: float
    size_um: float
    turn_rad: float
    surfaces: tuple[Spectrum, Spectrum]


def marks_of(scene: Scene) -> Marks | None:
    """Return the marks of the last dot grid or checkerboard of a scene; None without one."""
    for shape in reversed(scene.shapes):
        if isinstance(shape, Chart) and shape.name in KINDS:
            given = shape.parameters
            surfaces = given["dark"], scene.background if given["light"] is None else given["light"]
            return (_dots if shape.name == "dot-grid" else _corners)(given, surfaces)
    return None


def _dots(given: Any, surfaces: tuple[Spectrum, Spectrum]) -> Marks:
    places = _grid(int(given["rows"]), int(given["cols"]), given["spacing_um"])
    return Marks(
        kind="dot-grid",
        places_um=Card(given["centre_um"], given["rotate_deg"]).placed_um(places),
        reach_um=0.5 * given["spacing_um"],
        size_um=given["radius_um"],
        turn_rad=math.radians(given["rotate_deg"]),
        surfaces=surfaces,
    )


def _corners(given: Any, surfaces: tuple[Spectrum, Spectrum]) -> Marks:
    places = _grid(int(given["rows"]) - 1, int(given["cols"]) - 1, given["side_um"])
    return Marks(
        kind="checkerboard",
        places_um=Card(given["centre_um"], given["rotate_deg"]).placed_um(places),
        reach_um=_CORNER_SHARE * given["side_um"],
        size_um=0.0,
        turn_rad=math.radians(given["rotate_deg"]),
        surfaces=surfaces,
    )


def _grid(rows: int, cols: int, spacing_um: float) -> F64:
    x, y = np.meshgrid(np.arange(cols) - 0.5 * (cols - 1), np.arange(rows) - 0.5 * (rows - 1))
    return spacing_um * np.stack([x.ravel(), y.ravel()], axis=1)


def locate_mark(x: F64, y: F64, signal: F64, marks: Marks, pitch_um: float) -> tuple[float, float, float] | None:
    """Return the position of a mark and its standard error, from photosites at (x, y) pixels from its expected place.

    None if there are too few photosites, or no fit.
    """
    if signal.size < _LEAST_SAMPLES:
        return None
    low, high = (float(level) for level in np.percentile(signal, (5, 95)))
    if not high > low:
        return None
    model, start = _model(x, y, marks, pitch_um, low, high, signal)

    def off(p: F64) -> F64:
        return model(p) - signal

    try:
        fit = scipy.optimize.least_squares(off, start, x_scale="jac", method="lm")
    except ValueError:
        return None
    freedom, slopes = signal.size - start.size, np.asarray(fit.jac)
    inverse = np.linalg.pinv(np.einsum("ni,nj->ij", slopes, slopes))
    variance = 2.0 * fit.cost / max(freedom, 1)
    error = math.sqrt(max(variance * 0.5 * (inverse[0, 0] + inverse[1, 1]), 0.0))
    reach = marks.reach_um / pitch_um
    # Reject a fit that left its photosites, or whose residuals are as large as what it explains.
    if not fit.success or math.hypot(fit.x[0], fit.x[1]) > reach or variance > 0.05 * (high - low) ** 2:
        return None
    return float(fit.x[0]), float(fit.x[1]), error


def _model(
    x: F64, y: F64, marks: Marks, pitch_um: float, low: float, high: float, signal: F64
) -> tuple[Callable[[F64], F64], F64]:
    """Return the model of the signal, with the position as first two parameters, and initial parameters."""
    if marks.kind == "dot-grid":

        def dot(p: F64) -> F64:
            rim = (p[2] - np.hypot(x - p[0], y - p[1])) / p[3]
            light: F64 = p[4] + p[5] * scipy.special.ndtr(rim)
            return light

        # Centroid of the deviation from the surroundings, for marks brighter or darker than these.
        around = float(np.median(signal[np.hypot(x, y) > 0.8 * marks.reach_um / pitch_um]))
        weight = np.abs(signal - around) > 0.5 * max(high - around, around - low)
        at = (float(x[weight].mean()), float(y[weight].mean())) if weight.any() else (0.0, 0.0)
        step = low - around if around - low > high - around else high - around
        return dot, np.array([*at, marks.size_um / pitch_um, _SOFT_PX, around, step])

    def corner(p: F64) -> F64:
        u = math.cos(p[2]) * (x - p[0]) + math.sin(p[2]) * (y - p[1])
        v = math.cos(p[3]) * (y - p[1]) - math.sin(p[3]) * (x - p[0])
        light: F64 = p[5] + p[6] * scipy.special.erf(u / p[4]) * scipy.special.erf(v / p[4])
        return light

    turn = marks.turn_rad
    u, v = math.cos(turn) * x + math.sin(turn) * y, math.cos(turn) * y - math.sin(turn) * x
    same = float(np.mean(signal * np.sign(u * v)))
    step = math.copysign(0.5 * (high - low), same)
    return corner, np.array([0.0, 0.0, turn, turn, _SOFT_PX, 0.5 * (high + low), step])
