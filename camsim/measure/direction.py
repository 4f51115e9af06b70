"""How well the photosites tell an edge's direction: what the linear fit says of it is too little where they are few."""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

import numpy as np
import scipy

from camsim.core.arrays import F64
from camsim.measure import spline
from camsim.measure.geometry import EdgeLine
from camsim.measure.solve import solve
from camsim.measure.spline import TURN, Model, Placed, Shape

_FEW = 4000
"""Photosites near an edge, above which the sum of squares is a parabola as far as it matters."""

_COARSE = 0.4
"""Of the rise: knots that are as far apart as a Gaussian's sigma follow it to a hundredth."""

_STEPS, _FARTHEST = 24, 8.0
_MOST_RAD = math.radians(5.0)  # no direction is known that may be off by more
_SURE = 4.0
"""Standard errors within which a figure has to be right."""


class Near(NamedTuple):
    """The photosites near the edge: centres in pixels, signals in units of the step."""

    x: F64
    y: F64
    signal: F64


def direction_error_rad(
    near: Near,
    line: EdgeLine,
    model: Model,
    *,
    shape: Shape,
    rise: float,
    variance: float,
    most: float,
    linear_rad: float,
) -> float:
    """Return the standard error of the direction of a line that was fitted.

    shape      : the spread function whose slope told the direction;  rise: of the edge
    variance   : of a photosite, the mean;  most: the largest
    linear_rad : standard error of the linear fit

    Three things are missing from that. A variance from few photosites is itself uncertain (Student's t). The slope is
    an estimate, whose noise looks like information about the direction (``_of_noise``). And of few photosites the sum
    of squares is no parabola about its least: turned by many standard errors they may fit nearly as well, or better.
    So the line is turned, all else fitted anew, and whatever raises the least sum of squares by less than 4² variances
    must lie within four standard errors. (Fitted again from where it is least, figures were no better: of 3000 small
    edges four ended otherwise, two of them no longer refused and then wrong by more than three standard errors.)
    """
    rows = shape.placed(*line.across_and_along(near.x, near.y))
    close = np.abs(rows.d) <= 1.25 * model.half_width
    near, rows = Near(*(part[close] for part in near)), rows.only(close)
    freedom = max(rows.d.size - model.columns, 3)
    few = -float(scipy.special.stdtrit(freedom, scipy.special.ndtr(-_SURE))) / _SURE  # scipy.stats takes half a second
    error = few * linear_rad * _of_noise(rows, near.signal, model, shape.model, rise, variance)
    if rows.d.size > _FEW or not 0.0 < error < math.inf:
        return error
    # Few photosites tell a bend from a turn no better.
    lines, reached = {line, dataclasses.replace(line, curvature_per_pixel=0.0)}, True
    while reached and error < _MOST_RAD:
        turns = np.linspace(-_FARTHEST, _FARTHEST, 2 * _STEPS + 1) * error
        squares = np.array([[_squares(near, bent, model, shape, float(turn)) for turn in turns] for bent in lines])
        above = (squares - float(squares.min())).min(axis=0)
        for sure in (0.5 * _SURE, _SURE):
            likely = np.abs(turns[above < (few * sure) ** 2 * most])
            error = max(error, float(likely.max()) / sure)
        reached = bool(likely.max() == turns[-1])  # and what lies farther may be as likely
    return error


def _of_noise(rows: Placed, signal: F64, model: Model, smooth: Model, rise: float, variance: float) -> float:
    """Return by what the linear fit's standard error is too small because noise is in the slope that it takes.

    The direction is told by what of slope·s no other column can follow; I is the sum of its squares. The fit weighs
    noise of variance σ² by the slope that it has, which gives the direction an error of σ·√I / I₀: I with the noisy
    slope, I₀ with the true one. The linear fit says σ/√I. A slope of knots as coarse as the rise allows has little
    noise, whose share of the squares is known and taken off, and stands for the true one.
    """
    coarse = Model.of(
        half_width=model.half_width,
        spacing=max(smooth.spacing, _COARSE * rise),
        scale=model.scale,
    )
    noisy, true = (_Slope.of(rows, signal, model, shape) for shape in (smooth, coarse))
    stated = true.information - (variance * true.noise(rows) if rows.d.size <= _FEW else 0.0)
    return max(noisy.information / stated, 1.0) if stated > 0.0 else math.inf


class _Slope(NamedTuple):
    """The slope by a fit of ``shape``; information: the sum of squares of what other columns leave of slope·s."""

    model: Model
    shape: Model
    slopes: F64
    inverse: F64
    information: float

    @classmethod
    def of(cls, rows: Placed, signal: F64, model: Model, shape: Model) -> _Slope:
        straight, inverse = solve(rows.straight(), signal, shape, tail=False)
        slopes = Shape(shape, straight, 0.0).placed(rows.d, rows.s).slope
        _, whole = solve(rows._replace(slope=slopes), signal, model, tail=False)
        variance = float(whole[model.columns + TURN, model.columns + TURN]) / model.scale**2
        return cls(model, shape, slopes, inverse, 1.0 / variance if variance > 0.0 else 0.0)

    def noise(self, rows: Placed) -> float:
        """Return the mean of the information, had the fit nothing but noise of variance 1."""
        d, s = rows.d, rows.s
        others = (spline.spread_rows(d, self.model)[:, : self.model.columns], (self.slopes * s * s)[:, None])
        columns, _ = np.linalg.qr(np.concatenate(others, axis=1))
        noise = s[:, None] * spline.line_rows(d, self.shape)
        left = noise - columns @ (columns.T @ noise)
        return float(np.einsum("ij,jk,ik->", left, self.inverse, left, optimize=True))


def _squares(near: Near, line: EdgeLine, model: Model, shape: Shape, turn_rad: float) -> float:
    """Return the sum of squares of a fit to a line turned by so much."""
    rows = shape.placed(*line.moved(0.0, math.tan(turn_rad), 0.0).across_and_along(near.x, near.y)).straight()
    coefficients, _ = solve(rows, near.signal, model, tail=False)
    r = spline.residuals(rows, near.signal, model, coefficients)
    return float(np.einsum("i,i->", r, r))
