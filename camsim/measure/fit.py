"""Fit of one edge: line, spread function and transform, with their errors."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64
from camsim.errors import UnsupportedError
from camsim.measure import spline
from camsim.measure.direction import Near, direction_error_rad
from camsim.measure.geometry import EdgeLine, longest_gap
from camsim.measure.locate import Guess
from camsim.measure.picture import Channel, Samples
from camsim.measure.sampling import refuse_gap
from camsim.measure.shared import shared_scatter
from camsim.measure.solve import fitted, solve
from camsim.measure.spline import (
    ACROSS,
    ALONG,
    BEND,
    EXTRAS,
    FAR_ELSE,
    STRAY,
    STRAY_POWERS,
    TAIL,
    TURN,
    Model,
    Placed,
    Shape,
)
from camsim.measure.variance import variances

FINEST_SPACING, COARSEST_SPACING = 0.08, 1.0
_COARSEST_FOR_NOISE = 0.5
"""Widest knots: the flat ends of coarser splines hide coma (knots of 1: MTF50 off by 3 % in a region of 48 px)."""

SAMPLES_PER_KNOT = 1.5
_OUTLIER = 8.0
_NOISY = 0.01
_GAPS_PER_KNOT = 0.75
_MOST_PASSES, _SAME = 6, 1e-5
_NO_TAIL = 1e-9
_COARSER = 1.25
_NEARER, _NEARER_NOISE = 0.7, 2.0
"""Smaller reach, relative to the region's: light spread beyond it looks like shading, more so for a smaller reach."""

_CELL, _MOST_CELLS = 5.0, 10_000
"""Side in samples, and number, of cells of photosites with correlated misfit."""

_MOST_BEYOND = 100_000
_MOST_TURN_RAD = math.radians(1.0)


class Other(NamedTuple):
    """A second fit, with another model or a smaller region; as no model is exact, its difference counts as an error.

    noise : differences of figures due to noise, in units of their errors; subtracted
    """

    model: Model
    coefficients: F64
    noise: float = 0.0

    @property
    def turn_rad(self) -> float:
        """The correction that this fit would make to the direction of the edge."""
        return float(self.coefficients[self.model.columns + TURN]) / self.model.scale

    def error(self, difference: F64 | float, by_noise: F64 | float) -> F64:
        """Return the model error of a figure: the part of its difference between fits that noise does not explain."""
        beyond: F64 = np.sqrt(np.maximum(np.square(difference) - np.square(self.noise * by_noise), 0.0))
        return beyond


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EdgeFit:
    """The fitted model; signals are in units of ``scale`` above ``dark``.

    line         : the edge;  model, coefficients: see ``spline``
    others       : with coarser knots and another tail, without light from other edges, and in a smaller region
    covariance   : covariance of the coefficients, from the scatter of photosites about the fit
    rise         : distance from 10 to 90 %, by the fit that set the line
    dark, scale  : signal of the dark side and first estimate of the step, above black
    residual_rms : root mean square residual of a photosite, in units of ``scale``
    noise        : on the dark and on the bright side, away from the edge
    gap_pixel    : longest stretch across the edge without a photosite
    turn_rad     : remaining correction of the direction, a fraction of its error turn_error_rad
    left_out     : photosites rejected as far from the fit (defects)
    """

    line: EdgeLine
    model: Model
    coefficients: F64
    covariance: F64
    others: tuple[Other, ...]
    rise: float
    dark: float
    scale: float
    residual_rms: float
    noise: tuple[float, float]
    gap_pixel: float
    left_out: int
    photosites: int
    turn_rad: float
    turn_error_rad: float


def fit_edge(samples: Samples, channel: Channel, guess: Guess, *, reach: float, what: str) -> EdgeFit:
    """Fit the photosites of a channel in a region.

    reach : distance from the edge to the region's nearer side
    """
    fit = _fit(samples, channel, guess, reach=reach, what=what)
    if not fit.turn_error_rad < _MOST_TURN_RAD:
        raise UnsupportedError(
            f"noise hides the edge's direction ({fit.line.angle_deg:.2f}° might be wrong by degrees); take a longer "
            "region or less noise",
            stage=what,
        )
    return fit


def _fit(samples: Samples, channel: Channel, guess: Guess, *, reach: float, what: str) -> EdgeFit:
    """Fit from one initial guess."""
    x, y, pitch = samples.x, samples.y, channel.pitch_pixel
    scale = guess.bright - guess.dark
    v = (samples.signal - guess.dark) / scale
    line = guess.line
    length = max(float(np.ptp(line.across_and_along(x, y)[1])), 1.0)
    dark = guess.dark / scale

    # First a model for any edge; the fitted width then sets the final model.
    half_width = min(0.75 * reach, 8.0 * pitch)
    chosen = _near(x, y, line, 2.5 * half_width)
    line, rise, _ = _settle(
        x[chosen],
        y[chosen],
        v[chosen],
        line,
        half_width,
        max(0.5, 0.25 * channel.period_pixel),
        dark,
        length,
        passes=4,
        what=what,
    )
    half_width = min(0.75 * reach, max(1.5 + 2.5 * rise, 5.0))
    chosen = _near(x, y, line, 2.5 * half_width)
    xn, yn, vn = x[chosen], y[chosen], v[chosen]
    d = line.across_and_along(xn, yn)[0]
    count = np.count_nonzero(np.abs(d) < half_width)
    if not count:  # all are farther away: the edge is sharper than estimated
        raise _no_edge(what)
    density = count / (2.0 * half_width)
    gap = longest_gap(d, min(half_width, 2.0 * pitch))
    spacing = max(FINEST_SPACING, rise / 16.0, SAMPLES_PER_KNOT / density, _GAPS_PER_KNOT * gap)
    spacing = min(spacing, COARSEST_SPACING)
    # The slope determines the edge's position: a smooth one is best with noise, the true one without.
    smoother = max(spacing, 0.3 * rise)
    line, rise, shape = _settle(xn, yn, vn, line, half_width, smoother, dark, length, passes=6, what=what)
    scatter = _scatter_near(xn, yn, vn, line, half_width, spacing, shape)
    noisy = min(1.0, scatter / _NOISY)
    finer = max(spacing, smoother * noisy)
    # Knots that only follow noise are dropped: six over the rise resolve an edge.
    spacing = max(spacing, min(_COARSEST_FOR_NOISE, noisy * rise / 6.0))
    if finer < smoother:
        line, rise, shape = _settle(xn, yn, vn, line, half_width, finer, dark, length, passes=6, what=what)

    d, s = line.across_and_along(x, y)
    enough = _enough(d, 2.0 * half_width)
    d, s, v = d[enough], s[enough], v[enough]
    gap = longest_gap(d, min(half_width, 2.0 * pitch))
    along = s[np.abs(d) <= channel.period_pixel]
    refuse_gap(gap, line, length, float(np.ptp(along)) + channel.period_pixel if along.size else 0.0, channel, what)
    x, y = x[enough], y[enough]
    model = Model.of(half_width=half_width, spacing=spacing, scale=0.5 * length)
    line, rows, stray, coefficients, inverse = _whole(x, y, v, line, shape, model, reach)
    r = spline.residuals(rows, v, model, coefficients)
    keep = _ordinary(rows.d, r, half_width)
    for _ in range(5):
        if keep.all():
            break
        coefficients, inverse = solve(rows.only(keep), v[keep], model, stray=stray)
        r = spline.residuals(rows, v, model, coefficients)
        # A defect distorts the fit: without it its neighbours may no longer be outliers.
        before, keep = keep, _ordinary(rows.d, r, half_width)
        if np.array_equal(before, keep):
            break
    left_out = int(np.count_nonzero(~keep))
    rows, v, r, x, y = rows.only(keep), v[keep], r[keep], x[keep], y[keep]
    d = rows.d
    coarser = Model.of(half_width=half_width, spacing=_COARSER * spacing, scale=model.scale)._replace(far=FAR_ELSE)
    near = np.abs(d) <= _NEARER * reach
    nearer = Model.of(half_width=min(half_width, 0.75 * _NEARER * reach), spacing=spacing, scale=model.scale)
    others = (
        Other(coarser, fitted(rows, v, coarser, stray=stray)),
        Other(model, fitted(rows, v, model)),
        Other(nearer, fitted(rows.only(near), v[near], nearer, stray=stray), noise=_NEARER_NOISE),
    )
    free = max(1, d.size - coefficients.size)
    variance = float(r @ r) / free
    away = min(2.0 + rise, 0.5 * half_width)
    noise = tuple(float(np.std(r[side])) if np.count_nonzero(side) > 1 else 0.0 for side in (d < -away, d > away))
    leverage = spline.leverages(rows, model, inverse)
    one = variances(d, v - r, r, leverage, away=away, rise=rise)
    thrown = spline.scatter(rows, one, model)
    # Model misfit is correlated between neighbouring photosites.
    side = max(_CELL * pitch, math.sqrt(float(np.ptp(x)) * float(np.ptp(y)) / _MOST_CELLS))
    for place in (x, y, np.floor(x / side) + 2.0**20 * np.floor(y / side)):
        thrown += shared_scatter(place, rows, r, one, model, inverse)
    n = model.columns
    # Quantities limited by penalties are as uncertain as noise.
    thrown[range(n + STRAY, n + EXTRAS), range(n + STRAY, n + EXTRAS)] += stray * variance
    covariance = inverse @ thrown @ inverse
    turn_rad = float(coefficients[n + TURN]) / model.scale
    # For fits smoother than the final one the profile is too sharp.
    turn_error_rad = direction_error_rad(
        Near(x=xn, y=yn, signal=vn),
        line,
        model,
        shape=shape,
        rise=rise,
        variance=variance,
        most=float(one.max()),
        linear_rad=math.sqrt(max(float(covariance[n + TURN, n + TURN]), 0.0)) / model.scale,
    )
    return EdgeFit(
        line=line,
        model=model,
        coefficients=coefficients,
        covariance=_with_turn(covariance, n + TURN, turn_error_rad * model.scale),
        others=others,
        rise=rise,
        dark=guess.dark,
        scale=scale,
        residual_rms=math.sqrt(variance),
        noise=(noise[0], noise[1]),
        gap_pixel=gap,
        left_out=left_out,
        photosites=int(d.size),
        turn_rad=turn_rad,
        turn_error_rad=max(
            turn_error_rad, *(float(one.error(one.turn_rad - turn_rad, turn_error_rad)) for one in others)
        ),
    )


def _no_edge(what: str) -> UnsupportedError:
    return UnsupportedError(
        "no single straight edge fits; choose a region that one edge crosses from side to side", stage=what
    )


def _with_turn(covariance: F64, turn: int, error: float) -> F64:
    """Return the covariance with another standard error of the coefficient ``turn``, propagated to all others."""
    variance = float(covariance[turn, turn])
    if not (variance > 0.0 and math.isfinite(error)):
        return covariance
    along = covariance[:, turn] / variance
    more: F64 = covariance + np.outer(along, along) * (error**2 - variance)
    return more


def _whole(
    x: F64, y: F64, v: F64, line: EdgeLine, shape: Shape, model: Model, reach: float
) -> tuple[EdgeLine, Placed, F64, F64, F64]:
    """Fit a whole region; return line, photosites, penalties on light from other edges, coefficients, inverse.

    Another edge at distance L with a diffraction tail a/d² adds a/(L − d) to the region, which begins as a/L·(d/L). No
    edge is nearer than the region's reach, so the powers of d/reach have coefficients of at most a/reach. The penalties
    allow that much, less if noise would exceed it, and nothing for an edge without a tail.
    """
    n, scale = model.columns, model.scale
    usual = (scale / reach) ** np.array(STRAY_POWERS)[:, 0] / reach
    stray = np.full(usual.size, math.inf)
    rows = shape.placed(*line.across_and_along(x, y))
    coefficients, inverse = solve(rows, v, model)
    for _ in range(_MOST_PASSES):
        r = spline.residuals(rows, v, model, coefficients)
        variance = float(r @ r) / max(1, v.size - coefficients.size)
        stray = variance / np.maximum(abs(coefficients[n + TAIL]) * usual, _NO_TAIL) ** 2
        # The line has converged.
        turned = np.clip(coefficients[[n + TURN, n + BEND]] / scale, -_MOST_TURN_RAD, _MOST_TURN_RAD)
        turn, bent = turned.tolist()
        line = line.moved(0.0, turn, bent / scale)
        d, s = line.across_and_along(x, y)
        level = Shape(model, coefficients, shape.dark).placed(d, s).level
        moved = max(abs(turn), abs(bent)) * scale + float(np.abs(level - rows.level).max())
        shading = (coefficients[n + ACROSS] * d + coefficients[n + ALONG] * s) / scale
        slope = shape.placed(d, s).slope * (1.0 + shading)
        rows = Placed(d, s, slope, level)
        coefficients, inverse = solve(rows, v, model, stray=stray)
        if moved < _SAME:
            break
    return line, rows, stray, coefficients, inverse


def _near(x: F64, y: F64, line: EdgeLine, distance: float) -> np.ndarray:
    """Return a mask of photosites near the edge: only these determine its position."""
    near: np.ndarray = np.abs(line.across_and_along(x, y)[0]) <= distance
    return near


def _enough(d: F64, distance: float) -> np.ndarray:
    """Return a mask of photosites to use: all near the edge, and of those beyond enough for a level."""
    near = np.abs(d) <= distance
    beyond = d.size - int(np.count_nonzero(near))
    if beyond <= _MOST_BEYOND:
        return np.ones(d.size, bool)
    # Knuth's multiplicative hash: spread evenly and incommensurate with the rows.
    drawn = (np.arange(d.size, dtype=np.uint64) * np.uint64(2654435761)) % np.uint64(2**32)
    enough: np.ndarray = near | (drawn < np.uint64(2**32 * _MOST_BEYOND / beyond))
    return enough


def _settle(
    x: F64,
    y: F64,
    v: F64,
    line: EdgeLine,
    half_width: float,
    spacing: float,
    dark: float,
    length: float,
    *,
    passes: int,
    what: str,
) -> tuple[EdgeLine, float, Shape]:
    """Move the edge to where the model fits best; return it with its 10–90 % rise and the last fit."""
    rise = 1.0
    model = Model.of(half_width=half_width, spacing=spacing, scale=0.5 * length)
    shape = None
    for _ in range(passes):
        d, s = line.across_and_along(x, y)
        near = np.abs(d) <= 1.25 * half_width
        d, s, vn = d[near], s[near], v[near]
        flat = np.zeros(d.size)
        # For unknown quantities, a step gives the level.
        level: F64 = dark + np.asarray(d > 0.0, np.float64)
        rows = Placed(d, s, flat, level) if shape is None else shape.placed(d, s)
        straight = fitted(rows.straight(), vn, model, tail=False)
        shape = Shape(model, straight, dark)
        full = fitted(shape.placed(d, s), vn, model, tail=False)
        n = model.columns
        turn, bend = full[n + TURN] / model.scale, full[n + BEND] / model.scale**2
        middle, rise = _middle_and_rise(straight, model)
        moved = line.moved(middle, turn, bend)
        if not (abs(turn) < 0.5 and abs(bend) * length < 0.5 and abs(middle) < 2.0 * half_width):
            raise _no_edge(what)
        settled = max(abs(turn), abs(bend) * length) * length < 1e-4 and abs(middle) < 1e-2
        line = moved
        if not _near(x, y, line, half_width).any():  # the edge has left its region
            raise _no_edge(what)
        if settled:
            break
    assert shape is not None
    return line, rise, shape


def _scatter_near(x: F64, y: F64, v: F64, line: EdgeLine, half_width: float, spacing: float, shape: Shape) -> float:
    """Return the scatter of photosites near the edge about a flexible fit."""
    rows = shape.placed(*line.across_and_along(x, y)).straight()
    near = np.abs(rows.d) <= 1.25 * half_width
    rows, v = rows.only(near), v[near]
    model = Model.of(half_width=half_width, spacing=spacing, scale=shape.model.scale)
    coefficients = fitted(rows, v, model, tail=False)
    r = spline.residuals(rows, v, model, coefficients)
    return math.sqrt(float(r @ r) / max(1, v.size - model.columns))


def _middle_and_rise(coefficients: F64, model: Model) -> tuple[float, float]:
    """Return where the spread function crosses half its height, and its rise from 10 to 90 %."""
    d = np.linspace(-model.half_width, model.half_width, 4 * model.columns + 1)
    esf = spline.spread_rows(d, model) @ coefficients
    low, high = esf[0], esf[-1]
    if not high > low:
        return 0.0, 1.0
    tenth, half, nine = (crossing(d, (esf - low) / (high - low), level) for level in (0.1, 0.5, 0.9))
    return half, max(nine - tenth, 0.1)


def crossing(d: F64, esf: F64, level: float) -> float:
    """Return where a rising curve crosses a level: of several places the one nearest to the middle of the curve.

    >>> crossing(np.array([-1.0, 0.0, 1.0]), np.array([0.0, 0.5, 1.0]), 0.75)
    0.5
    """
    up = np.flatnonzero((esf[:-1] < level) & (esf[1:] >= level))
    if not up.size:
        return 0.0
    i = up[np.argmin(np.abs(d[up]))]
    return float(d[i] + (level - esf[i]) / (esf[i + 1] - esf[i]) * (d[i + 1] - d[i]))


def _ordinary(d: F64, r: F64, half_width: float) -> np.ndarray:
    """Return a mask of photosites that are not defects, i.e. outliers of their side's scatter and of the fit."""
    size = np.abs(r)
    usual = [float(np.median(size[side])) if np.any(side) else 0.0 for side in (d < 0.0, d >= 0.0)]
    # Signal and noise change near the edge, so the noisier side's scatter applies there.
    limit = np.where(np.abs(d) < half_width, max(usual), np.where(d < 0.0, *usual))
    keep: np.ndarray = size <= np.maximum(_OUTLIER * 1.4826 * limit, 0.02)
    return keep
