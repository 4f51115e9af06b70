"""How well the photosites tell an edge's direction: what the linear fit says of it is too little where they are few."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import scipy

from camsim.arrays import F64
from camsim.measure import spline
from camsim.measure.geometry import EdgeLine
from camsim.measure.solve import solve
from camsim.measure.spline import Model

_FEW = 4000
"""Photosites near an edge, above which the sum of squares is a parabola as far as it matters."""

_STEPS, _FARTHEST = 24, 8.0
_SURE = 4.0
"""Standard errors within which a figure has to be right."""


class Near(NamedTuple):
    """The photosites near the edge: centres in pixels, signals in units of the step."""

    x: F64
    y: F64
    signal: F64


class Direction(NamedTuple):
    """The standard error of the edge's direction, and the turn at which the photosites fit better (0: none)."""

    error_rad: float
    better_rad: float


def direction(near: Near, line: EdgeLine, model: Model, *, smooth: Model, even: float, linear_rad: float) -> Direction:
    """Return what is known of the direction of a line that was fitted.

    smooth     : the model whose slope told the direction;  even: variance of a photosite
    linear_rad : standard error of the linear fit

    Three things are missing from that. A variance from few photosites is itself uncertain (Student's t). The slope is
    an estimate, and noise adds its variance to the slope's square, so that the direction seems to be known better than
    it is: this part of the information is taken off. And of few photosites the sum of squares is no parabola about its
    least: turned by many standard errors they may fit nearly as well, or better. So the line is turned, all else fitted
    anew, and whatever raises the sum of squares by less than 4² variances must lie within four standard errors.
    """
    d, s = line.across_and_along(near.x, near.y)
    beside = np.abs(d) <= 1.25 * model.half_width
    near, d, s = Near(*(part[beside] for part in near)), d[beside], s[beside]
    freedom = max(d.size - model.columns, 3)
    few = float(scipy.stats.t.isf(scipy.stats.norm.sf(_SURE), freedom)) / _SURE
    error = few * linear_rad / math.sqrt(max(1.0 - _of_noise(d, s, near.signal, smooth, even), 1e-6))
    if d.size > _FEW or not error > 0.0:
        return Direction(error, 0.0)
    turns = np.linspace(-_FARTHEST, _FARTHEST, 2 * _STEPS + 1) * error
    squares = np.array([_squares(near, line, model, float(turn)) for turn in turns])
    best = int(np.argmin(squares))
    better = float(turns[best]) if squares[best] < squares[_STEPS] - even and abs(best - _STEPS) > 1 else 0.0
    for sure in (0.5 * _SURE, _SURE):
        likely = np.abs(turns[squares - squares[best] < (few * sure) ** 2 * even])
        error = max(error, float(likely.max()) / sure)
    return Direction(error, better)


def _of_noise(d: F64, s: F64, signal: F64, smooth: Model, even: float) -> float:
    """Return the part of Σ (slope·s)² that noise alone gives."""
    zero = np.zeros(d.size)
    coefficients, inverse = solve(d, s, zero, signal, smooth, tail=False)
    rows = spline.line_rows(d, smooth)
    variance = even * np.einsum("ij,ij->i", np.einsum("ij,jk->ik", rows, inverse, optimize=True), rows)
    squares = float(np.sum((spline.slopes(d, smooth, coefficients) * s) ** 2))
    return float(np.sum(variance * s**2)) / squares if squares > 0.0 else 1.0


def _squares(near: Near, line: EdgeLine, model: Model, turn_rad: float) -> float:
    """Return the sum of squares of a fit to a line turned by so much."""
    d, s = line.moved(0.0, math.tan(turn_rad), 0.0).across_and_along(near.x, near.y)
    zero = np.zeros(d.size)
    coefficients, _ = solve(d, s, zero, near.signal, model, tail=False)
    r = spline.residuals(d, s, zero, near.signal, model, coefficients)
    return float(np.einsum("i,i->", r, r))
