"""Standard error of an edge's direction, which the linear fit underestimates if photosites are few."""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64
from camsim.measure import spline
from camsim.measure.geometry import EdgeLine
from camsim.measure.solve import fitted, solve
from camsim.measure.spline import TURN, Model, Placed, Shape
from camsim.measure.student import student

_FEW = 4000
"""Photosites near an edge above which the sum of squares is close enough to a parabola."""

_COARSE = 0.4
"""Knot spacing relative to the rise: at the sigma of a Gaussian, a spline follows it to a hundredth."""

_STEPS, _FARTHEST = 24, 8.0
_MOST_RAD = math.radians(5.0)  # a direction with a larger error counts as unknown
_SURE = 4.0
"""Standard errors within which a figure must be right."""


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
    """Return the standard error of the direction of a fitted line.

    shape      : the spread function whose slope determined the direction;  rise: rise of the edge
    variance   : mean variance of a photosite;  most: the largest one
    linear_rad : standard error of the linear fit

    The linear error lacks three contributions. A variance from few photosites is itself uncertain (Student's t). The
    slope is an estimate, whose noise looks like information about the direction (``_of_noise``). And for few photosites
    the sum of squares is not a parabola: at many standard errors the fit may be nearly as good, or better. So the line
    is turned and everything else refitted: directions that raise the least sum of squares by less than 4² variances
    must lie within four standard errors.
    """
    rows = shape.placed(*line.across_and_along(near.x, near.y))
    close = np.abs(rows.d) <= 1.25 * model.half_width
    near, rows = Near(*(part[close] for part in near)), rows.only(close)
    freedom = max(rows.d.size - model.columns, 3)
    few = student(freedom, math.erfc(_SURE / math.sqrt(2.0))) / _SURE
    error = few * linear_rad * _of_noise(rows, near.signal, model, shape.model, rise, variance)
    if rows.d.size > _FEW or not 0.0 < error < math.inf:
        return error
    # With few photosites the curvature is no better determined than the direction.
    lines, reached = {line, dataclasses.replace(line, curvature_per_pixel=0.0)}, True
    while reached and error < _MOST_RAD:
        angles = np.linspace(-_FARTHEST, _FARTHEST, 2 * _STEPS + 1) * error
        squares = np.array([[_squares(near, bent, model, shape, float(angle)) for angle in angles] for bent in lines])
        above = (squares - float(squares.min())).min(axis=0)
        for sure in (0.5 * _SURE, _SURE):
            likely = np.abs(angles[above < (few * sure) ** 2 * most])
            error = max(error, float(likely.max()) / sure)
        reached = bool(likely.max() == angles[-1])  # directions beyond the range may be as likely
    return error


def _of_noise(rows: Placed, signal: F64, model: Model, smooth: Model, rise: float, variance: float) -> float:
    """Return the factor by which noise in the slope makes the linear fit's standard error too small.

    The direction is determined by the part of slope·s orthogonal to other columns; I is the sum of its squares. The fit
    weights noise of variance σ² by its slope, which gives the direction an error of σ·√I / I₀: I with the noisy
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
    """The slope by a fit of ``shape``; information: sum of squares of slope·s orthogonal to other columns."""

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
        """Return the expected information from noise of variance 1 alone."""
        d, s = rows.d, rows.s
        others = (spline.spread_rows(d, self.model)[:, : self.model.columns], (self.slopes * s * s)[:, None])
        columns, _ = np.linalg.qr(np.concatenate(others, axis=1))
        noise = s[:, None] * spline.line_rows(d, self.shape)
        left = noise - columns @ (columns.T @ noise)
        return float(np.sum(left @ self.inverse * left))


def _squares(near: Near, line: EdgeLine, model: Model, shape: Shape, turn_rad: float) -> float:
    """Return the sum of squares of a fit to a line turned by ``turn_rad``."""
    rows = shape.placed(*line.moved(0.0, math.tan(turn_rad), 0.0).across_and_along(near.x, near.y)).straight()
    coefficients = fitted(rows, near.signal, model, tail=False)
    r = spline.residuals(rows, near.signal, model._replace(tail=False, stray=False), coefficients)
    return float(r @ r)
