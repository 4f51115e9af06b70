"""Kernels of the paper's methods: rectangles clipped against edges, and a Gaussian integrated strip by strip."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64
from camsim.core.kernels import kernel


class Steps(NamedTuple):
    """Edges and the contrast across them."""

    start: F64  # (n, 2)
    end: F64
    contrast: F64  # (n,) left minus right


class Boxes(NamedTuple):
    """Rectangles about a photosite and their weights, see ``rules.Rule``."""

    width: float
    height: float
    places: F64
    shares: F64


@kernel(forceinline=True)
def _ramp(q: float, side: float) -> float:
    """Integral of min(max(q, 0), side) over q, from 0."""
    if q <= 0.0:
        return 0.0
    return 0.5 * q * q if q < side else side * (q - 0.5 * side)


@kernel()
def _covered(left: float, top: float, width: float, height: float, steps: Steps) -> float:
    """Return the scene's mean over a rectangle by exact clipping against every edge; zero width or height is a point.

    An edge that runs upwards in y adds its contrast to all places of lower x within its span of y (a region is the sum
    of such bands over its outline), so its share of a rectangle is ∫ min(max(x_edge(y) − left, 0), width) dy.
    """
    start, end, contrast = steps.start, steps.end, steps.contrast
    inside = 0.0
    for e in range(len(contrast)):
        ya, yb = start[e, 1], end[e, 1]
        low, high = min(ya, yb), max(ya, yb)
        sign = contrast[e] if yb > ya else -contrast[e]
        if high <= top or low > top + height or low == high:
            continue
        slope = (end[e, 0] - start[e, 0]) / (yb - ya)
        if width == 0.0 or height == 0.0:
            if low <= top < high and start[e, 0] + slope * (top - ya) > left:
                inside += sign
            continue
        from_y, to_y = max(low, top), min(high, top + height)
        q1 = start[e, 0] + slope * (from_y - ya) - left
        q2 = start[e, 0] + slope * (to_y - ya) - left
        if abs(q2 - q1) < 1e-7 * width:
            area = (to_y - from_y) * min(max(0.5 * (q1 + q2), 0.0), width)
        else:
            area = (to_y - from_y) * (_ramp(q2, width) - _ramp(q1, width)) / (q2 - q1)
        inside += sign * area / (width * height)
    return inside


@kernel()
def weighted(
    x0: float, y0: float, steps: Steps, background: float, boxes: Boxes, image: F64, begin: int, end: int
) -> None:
    """Sum the weighted samples of every photosite in rows begin … end."""
    for r in range(begin, end):
        for c in range(image.shape[1]):
            total = 0.0
            for k in range(len(boxes.shares)):
                left = x0 + c + boxes.places[k, 0] - 0.5 * boxes.width
                top = y0 + r + boxes.places[k, 1] - 0.5 * boxes.height
                total += boxes.shares[k] * _covered(left, top, boxes.width, boxes.height, steps)
            image[r, c] = background + total


@kernel(allocates=True)
def each_sample(x: float, y: float, steps: Steps, boxes: Boxes) -> F64:
    """Return the value of every sample of the photosite at (x, y), minus the background."""
    values = np.empty(len(boxes.places))
    for k in range(len(boxes.places)):
        left, top = x + boxes.places[k, 0] - 0.5 * boxes.width, y + boxes.places[k, 1] - 0.5 * boxes.height
        values[k] = _covered(left, top, boxes.width, boxes.height, steps)
    return values


@kernel(forceinline=True)
def _strip(y: float, x_edge: float) -> float:
    """Density of a Gaussian with σ = 1 at height y, integrated over all x below x_edge."""
    return math.exp(-0.5 * y * y) / math.sqrt(2.0 * math.pi) * 0.5 * math.erfc(-x_edge / math.sqrt(2.0))


@kernel(allocates=True)
def strips(
    x0: float, y0: float, steps: Steps, background: float, whiten: F64, image: F64, first_row: int, end_row: int
) -> None:
    """Integrate a Gaussian PSF over the bands of every edge in some rows: erf along x, adaptive Simpson along y.

    steps : in the plane to which ``whiten`` maps, where σ = 1 in every direction; photosites are mapped here
    """
    start, end, contrast = steps.start, steps.end, steps.contrast
    depth = 24
    allowed = 1e-10
    a_stack, b_stack = np.empty(depth + 2), np.empty(depth + 2)
    for r in range(first_row, end_row):
        for c in range(image.shape[1]):
            total = background
            x = whiten[0, 0] * (x0 + c) + whiten[0, 1] * (y0 + r)
            y = whiten[1, 0] * (x0 + c) + whiten[1, 1] * (y0 + r)
            for e in range(len(contrast)):
                xa, ya = start[e, 0] - x, start[e, 1] - y
                xb, yb = end[e, 0] - x, end[e, 1] - y
                if ya == yb:
                    continue
                slope = (xb - xa) / (yb - ya)
                low, high = max(min(ya, yb), -9.0), min(max(ya, yb), 9.0)
                if low >= high:
                    continue
                # Start from pieces of one σ, so that no narrow bell is missed; then halve where Simpson disagrees.
                pieces = math.ceil(high - low)
                band = 0.0
                for p in range(pieces):
                    a_stack[0] = low + (high - low) * p / pieces
                    b_stack[0] = low + (high - low) * (p + 1) / pieces
                    top = 1
                    while top > 0:
                        top -= 1
                        a, b = a_stack[top], b_stack[top]
                        m = 0.5 * (a + b)
                        fa, fb = _strip(a, xa + slope * (a - ya)), _strip(b, xa + slope * (b - ya))
                        fm = _strip(m, xa + slope * (m - ya))
                        f1 = _strip(0.5 * (a + m), xa + slope * (0.5 * (a + m) - ya))
                        f2 = _strip(0.5 * (m + b), xa + slope * (0.5 * (m + b) - ya))
                        coarse = (b - a) / 6.0 * (fa + 4.0 * fm + fb)
                        fine = (b - a) / 12.0 * (fa + 4.0 * f1 + 2.0 * fm + 4.0 * f2 + fb)
                        if abs(fine - coarse) <= 15.0 * allowed or top >= depth:
                            band += fine + (fine - coarse) / 15.0
                        else:
                            a_stack[top], b_stack[top] = a, m
                            a_stack[top + 1], b_stack[top + 1] = m, b
                            top += 2
                total += contrast[e] * band if yb > ya else -contrast[e] * band
            image[r, c] = total
