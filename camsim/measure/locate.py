"""A first estimate of the edge's position in a region, and a check for other edges."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from camsim.core.arrays import F64
from camsim.core.words import percent
from camsim.errors import UnsupportedError
from camsim.measure.geometry import EdgeLine, Roi
from camsim.numerics.filtering import bell, filtered

LEAST_CONTRAST = 0.05
_MOST_LINES = 256
_SMOOTH = 1.2
_OTHER_EDGE = 0.35


@dataclass(frozen=True, slots=True, kw_only=True)
class Guess:
    """A first estimate: the edge to a fraction of a pixel, and the signals above black on its two sides."""

    line: EdgeLine
    dark: float
    bright: float


def locate(samples: npt.NDArray[Any], x: F64, y: F64, *, roi: Roi, what: str) -> Guess:
    """Find the edge in samples (n, m) with centres x (m,) and y (n,), above black level.

    The steepest point of every line is found and a straight line fitted through these points by iterative reweighting,
    robust against noise and a few wrong lines. Raises UnsupportedError in one sentence when the region holds
    no edge, or more than one.
    """
    # A few hundred lines locate the edge as well as thousands.
    every = [max(1, size // _MOST_LINES) for size in samples.shape]
    image = np.asarray(samples[:: every[0], :: every[1]], np.float64)
    x, y = x[:: every[1]], y[:: every[0]]
    if min(image.shape) < 8:
        raise UnsupportedError(
            f"{image.shape[0]} × {image.shape[1]} samples are too few; give a region with at least 8 rows and "
            "8 columns of this channel, 32 or more for good figures",
            stage=what,
        )
    smooth = filtered(image, bell(_SMOOTH), bell(_SMOOTH), beyond="edge")
    gx, gy = _central(smooth, 1) / (x[1] - x[0]), _central(smooth, 0) / (y[1] - y[0])
    upright = float(np.sum(gx**4)) >= float(np.sum(gy**4))
    if not upright:
        image, smooth, gx, x, y = image.T, smooth.T, gy.T, y, x
    return _upright(image, smooth, gx, x, y, upright=upright, roi=roi, what=what)


def _upright(image: F64, smooth: F64, gx: F64, x: F64, y: F64, *, upright: bool, roi: Roi, what: str) -> Guess:
    """Find an edge that crosses the rows."""
    lines = len(image)
    step = x[1] - x[0]
    # Polarity of the edge: from the steepest points.
    weight = gx**3
    rising = 1.0 if weight.sum() >= 0.0 else -1.0
    slope = np.maximum(rising * gx, 0.0)
    # A subset of the lines of a long edge suffices.
    some = np.arange(0, lines, max(1, lines // _MOST_LINES))
    steep = slope[some]
    peak = steep.argmax(axis=1)
    place = x[peak] + step * _vertex(steep, peak)
    at = y[some]
    strength = steep.max(axis=1)
    slant, offset = _robust_line(at - y.mean(), place, strength, step)
    for _ in range(2):
        predicted = offset + slant * (at - y.mean())
        near = np.abs(x - predicted[:, None]) <= 6.0 * step
        inside = np.where(near, steep, 0.0) ** 2
        total = inside.sum(axis=1)
        good = total > 0.0
        if good.sum() < 4:
            break
        centroid = (inside[good] @ x) / total[good]
        slant, offset = _robust_line(at[good] - y.mean(), centroid, np.sqrt(total[good]), step)
    predicted = offset + slant * (y - y.mean())
    cos = 1.0 / math.hypot(1.0, slant)
    away = rising * (x - predicted[:, None]) * cos
    margin = 3.0 * step
    dark_side, bright_side = image[away < -margin], image[away > margin]
    if dark_side.size < 0.02 * image.size or bright_side.size < 0.02 * image.size:
        dark, bright = float(np.percentile(image, 5)), float(np.percentile(image, 95))
        _refuse_flat(dark, bright, _scatter(image, smooth), what)
        raise UnsupportedError(
            "the edge leaves less than 3 samples on one of its sides; move the region so that the edge runs "
            "through its middle",
            stage=what,
        )
    dark, bright = float(np.median(dark_side)), float(np.median(bright_side))
    noise = _scatter(image, smooth)
    _refuse_flat(dark, bright, noise, what)
    _refuse_others(image, gx, slope, x, place, at, some, (slant, offset), y, step, bright - dark, noise, what)
    turn = math.atan2(-slant * rising, rising) if upright else math.atan2(rising, -slant * rising)
    middle = y.mean()
    point = (offset, middle) if upright else (middle, offset)
    line = EdgeLine(x_pixel=float(point[0]), y_pixel=float(point[1]), normal_rad=turn)
    return Guess(line=line, dark=dark, bright=bright)


def _central(image: F64, axis: int) -> F64:
    gradient: F64 = np.gradient(image, axis=axis)
    return gradient


def _vertex(values: F64, peak: npt.NDArray[np.intp]) -> F64:
    """Return the offset of the parabola's vertex from each peak, in samples."""
    last = values.shape[1] - 1
    row = np.arange(len(values))
    left, middle, right = (
        values[row, np.maximum(peak - 1, 0)],
        values[row, peak],
        values[row, np.minimum(peak + 1, last)],
    )
    bend = 2.0 * middle - left - right
    shift: F64 = np.where(bend > 0.0, 0.5 * (right - left) / np.where(bend > 0.0, bend, 1.0), 0.0)
    return np.clip(shift, -0.5, 0.5)


def _robust_line(at: F64, place: F64, weight: F64, step: float) -> tuple[float, float]:
    """Return slope and intercept of a robust line fit."""
    # Start from the median of slopes between points far apart (Theil and Sen), then reweigh (Tukey's biweight).
    half = len(at) // 2
    with np.errstate(divide="ignore", invalid="ignore"):
        slopes = (place[half:] - place[: len(at) - half]) / (at[half:] - at[: len(at) - half])
    slant = float(np.median(slopes))
    offset = float(np.median(place - slant * at))
    trust = weight / max(float(np.median(weight)), 1e-300)
    trust = np.minimum(trust, 2.0)
    for _ in range(20):
        miss = place - offset - slant * at
        spread = max(1.4826 * float(np.median(np.abs(miss))), 0.05 * step)
        w = trust * np.clip(1.0 - (miss / (4.685 * spread)) ** 2, 0.0, None) ** 2
        total = w.sum()
        if total <= 0.0:
            break
        mean_at, mean_place = (w @ at) / total, (w @ place) / total
        variance = w @ (at - mean_at) ** 2
        new = float(w @ ((at - mean_at) * (place - mean_place)) / variance) if variance > 0.0 else slant
        done = abs(new - slant) * (at[-1] - at[0]) < 1e-3 * step
        slant, offset = new, float(mean_place - new * mean_at)
        if done:
            break
    return slant, offset


def _scatter(image: F64, smooth: F64) -> float:
    """Return the noise of a sample, from second differences along rows (robust, insensitive to edges)."""
    second = image[:, 2:] - 2.0 * image[:, 1:-1] + image[:, :-2]
    return 1.4826 * float(np.median(np.abs(second))) / math.sqrt(6.0)


def _refuse_flat(dark: float, bright: float, noise: float, what: str) -> None:
    step = bright - dark
    contrast = step / (bright + dark) if bright + dark > 0.0 else math.inf
    if step <= 0.0 or step < 3.0 * noise:
        raise UnsupportedError(
            f"no edge found (the two sides differ by {step:.3g}, the noise is {noise:.3g}); "
            "put the region on a dark-to-bright edge",
            stage=what,
        )
    if contrast < LEAST_CONTRAST:
        raise UnsupportedError(
            f"contrast {percent(contrast)} is under {100.0 * LEAST_CONTRAST:g} %; "
            "take an edge between darker and brighter surfaces",
            stage=what,
        )


def _refuse_others(
    image: F64,
    gx: F64,
    slope: F64,
    x: F64,
    place: F64,
    at: F64,
    some: npt.NDArray[np.intp],
    line: tuple[float, float],
    y: F64,
    step_px: float,
    step: float,
    noise: float,
    what: str,
) -> None:
    """Raise UnsupportedError if some lines are inconsistent with one edge."""
    slant, offset = line
    predicted = offset + slant * (at - y.mean())
    # With several surfaces, the medians of the two sides do not give the step.
    low, high = np.percentile(image, (3, 97))
    if noise > 0.1 * max(step, float(high - low)):
        return
    peak = slope[some].max(axis=1)
    usual = float(np.median(peak))
    aside = 4.0 * step_px + 2.0 * float(high - low) / max(usual, 1e-300)
    elsewhere = np.where(np.abs(x - predicted[:, None]) > aside, np.abs(gx[some]), 0.0).max(axis=1)
    other = float(np.mean(elsewhere > _OTHER_EDGE * usual))
    if other > 0.2:
        raise UnsupportedError(
            f"{100.0 * other:.0f} % of its lines cross a second edge; make the region narrower, so that it "
            "holds one edge, or move it",
            stage=what,
        )
    miss = np.abs(place - predicted)
    # A slight bend is not another edge; noise may shift single lines.
    allowed = 3.0 * step_px + 0.02 * (y[-1] - y[0])
    wrong = float(np.mean(miss > allowed))
    if wrong > 0.04:
        raise UnsupportedError(
            f"in {100.0 * wrong:.0f} % of its lines the steepest place is not on the edge; the region holds a "
            "corner, the end of an edge or a second edge: make it smaller, so that one straight edge crosses all of it",
            stage=what,
        )
