"""Crossings of curves with a level, and their standard errors."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from camsim.core.arrays import F64
from camsim.measure import spline
from camsim.measure.fit import EdgeFit, crossing
from camsim.measure.spline import TAIL, Model

Curve: TypeAlias = Callable[[F64], F64]

_BANDS = (2.0, 4.0)
"""Bands around a curve, in standard errors, whose crossings give the error."""


def falls_to(frequency: F64, mtf: F64, level: float) -> float:
    """Return the lowest frequency at which the MTF falls to ``level``, by linear interpolation; NaN if it never does.

    >>> falls_to(np.array([0.0, 0.5, 1.0]), np.array([1.0, 0.6, 0.2]), 0.5)
    0.625
    """
    below = np.flatnonzero((mtf[:-1] >= level) & (mtf[1:] < level))
    if not below.size:
        return math.nan
    i = below[0]
    return float(frequency[i] + (mtf[i] - level) / (mtf[i] - mtf[i + 1]) * (frequency[i + 1] - frequency[i]))


def errors_of(gradient: F64, covariance: F64) -> F64:
    """Return the standard errors of m figures, from their derivatives (m, n) with respect to n coefficients."""
    error: F64 = np.sqrt(np.maximum(np.sum(gradient @ covariance * gradient, axis=1), 0.0))
    return error


def limit(frequency: F64, mtf: F64, mtf_error: F64, level: float, at: Curve) -> tuple[float, float]:
    """Return the frequency at which the MTF falls to a level, and its standard error; NaN if noise hides it.

    The error follows from shifting the curve by two and by four of its errors: the larger shift of the crossing, halved
    and quartered. So a slope that noise makes steep, flat or negative there does not give too small an error. NaN if
    the curve does not fall to the level within its errors.
    """
    f = falls_to(frequency, mtf, level)
    if math.isnan(f):
        return math.nan, math.nan
    first, delta, slope, error = f, 1e-3, 0.0, 0.0
    for band in _BANDS:
        low, high = (falls_to(frequency, mtf + side * mtf_error, level) for side in (-band, band))
        if math.isnan(high):
            return math.nan, math.nan
        error = max(error, (0.0 if math.isnan(low) else first - low) / band, (high - first) / band)
    for _ in range(4):
        value = at(np.array([f - delta, f, f + delta]))
        slope = (value[2] - value[0]) / (2.0 * delta)
        if slope >= 0.0:
            return math.nan, math.nan
        f -= float(np.clip((value[1] - level) / slope, -0.01, 0.01))
    return f, max(float(np.interp(f, frequency, mtf_error)) / abs(slope), error)


def rise_of(fit: EdgeFit) -> tuple[float, float]:
    """Return the 10–90 % rise and its standard error; NaN if noise hides one end.

    The error of each end comes from shifting the curve by its errors, as in ``limit``, from the slope, or from
    the difference between models.
    """
    model, c = fit.model, fit.coefficients
    d, esf, rows = _esf(model, c)
    at = np.array([crossing(d, esf, 0.1), crossing(d, esf, 0.9)])
    at_rows, slopes = _above_dark(at, model), spline.line_rows(at, model) @ c
    if not np.all(slopes > 0.0):
        return math.nan, math.nan
    # A crossing moves by minus the change of the curve over its slope.
    step, ends = _step(model, c)
    moves = -(at_rows - np.array([[0.1], [0.9]]) * ends) / slopes[:, None]
    gradient = moves[1] - moves[0]
    linear = math.sqrt(max(float(gradient @ fit.covariance @ gradient), 0.0))
    ends_error = [0.0, 0.0]
    for k, (level, place) in enumerate(zip((0.1, 0.9), at, strict=True)):
        error = errors_of((rows - level * ends) / step, fit.covariance)
        for band in _BANDS:
            moved = [_nearest(d, esf + side * error, level, place) for side in (-band, band)]
            if any(math.isnan(m) for m in moved):
                return math.nan, math.nan
            ends_error[k] = max(ends_error[k], *(abs(m - place) / band for m in moved))
    rise = float(at[1] - at[0])
    others = []
    for other in fit.others:
        d, esf, _ = _esf(other.model, other.coefficients)
        others.append(float(other.error(crossing(d, esf, 0.9) - crossing(d, esf, 0.1) - rise, linear)))
    return rise, max(linear, math.hypot(*ends_error), *others)


def _step(model: Model, c: F64) -> tuple[float, F64]:
    """Return the step including tails, and the row that gives it."""
    row = spline.transform_rows(np.zeros(1), model, None)[0].real
    return float(row @ c), row


def _above_dark(d: F64, model: Model) -> F64:
    """Return (m, n) rows that give the ESF above the dark side's far end."""
    rows = spline.spread_rows(d, model)
    rows[:, 0] -= 1.0
    rows[:, model.columns + TAIL] += model.tail_end
    return rows


def _esf(model: Model, c: F64) -> tuple[F64, F64, F64]:
    """Return distances, the ESF from 0 to 1 at each, and the rows that give its multiple by the step."""
    d = np.linspace(-2.0 * model.half_width, 2.0 * model.half_width, 16 * model.columns + 1)
    rows = _above_dark(d, model)
    return d, rows @ c / _step(model, c)[0], rows


def _nearest(d: F64, curve: F64, level: float, place: float) -> float:
    """Return where a curve crosses a level upwards, nearest to a place; NaN when it never does."""
    up = np.flatnonzero((curve[:-1] < level) & (curve[1:] >= level))
    if not up.size:
        return math.nan
    where = d[up] + (level - curve[up]) / (curve[up + 1] - curve[up]) * (d[up + 1] - d[up])
    return float(where[np.argmin(np.abs(where - place))])
