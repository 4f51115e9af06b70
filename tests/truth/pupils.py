"""Any pupil and any wavefront: the point image as the transform of the pupil, by Gauss rules along its rows.

Lengths on the pupil in half diameters. Zernike polynomials by OSA/ANSI index, root mean square 1 over the unit circle,
from their trigonometric definition. A circle has radius 1, a square half a side of 1, an iris its corners at 1.
"""

from __future__ import annotations

import functools
import math
from itertools import pairwise

import numba as nb
import numpy as np
from scipy import special

from tests.truth import sums

MOST_NODES = 10_000  # of a Gauss rule: twice as many take four times as long, these two seconds


class TooLarge(Exception):
    """What a system asks for takes too many numbers, or too long."""


@functools.cache
def gauss(order):
    """Gauss–Legendre nodes and weights on −1 … 1."""
    if order > MOST_NODES:
        raise TooLarge
    x, _ = special.roots_legendre(order)
    # Its weights are a part in 10⁹ off at both ends, in rules of hundreds of nodes.
    w = _legendre_weights(x)
    return x, w * (2.0 / w.sum())


@nb.njit(cache=True)
def _legendre_weights(x):
    w, n = np.empty(x.size), x.size
    for q in range(n):
        before, last = 1.0, x[q]
        for k in range(2, n + 1):
            before, last = last, ((2 * k - 1) * x[q] * last - (k - 1) * before) / k
        slope = n * (x[q] * last - before)
        w[q] = 2.0 * (1.0 - x[q] * x[q]) / (slope * slope)
    return w


def order(index):
    """n, and m: how often it goes round, above 0 as cosines, below as sines."""
    n = 0
    while (n + 1) * (n + 2) // 2 <= index:
        n += 1
    return n, 2 * (index - n * (n + 1) // 2) - n


def rounded(order):
    """Up to the next sixteen, or a fiftieth: rules are kept, and wavelengths share them."""
    step = 16 * math.ceil(order / 800.0)
    return step * math.ceil(order / step)


def zernike(index, x, y):
    x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
    return _at(x.ravel(), y.ravel(), np.array([[*order(index), 1.0]]), 0.0).reshape(x.shape)


def waves(lens, x, y, wavelength_nm):
    """Path difference in waves."""
    x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
    return _at(x.ravel(), y.ravel(), *_terms(lens, wavelength_nm)).reshape(x.shape)


def _terms(lens, wavelength_nm):
    """Zernikes (n, m, waves), and what r² is multiplied by."""
    terms = [(*order(j), c * lens["reference_nm"] / wavelength_nm) for j, c in lens["zernike_waves"]]
    square = lens["defocus_um"] * 1e3 / (8.0 * lens["f_number"] ** 2 * wavelength_nm)
    return np.array(terms, float).reshape(-1, 3), square


@nb.njit(cache=True)
def _at(x, y, terms, square):
    total = np.empty(x.size)
    for q in range(x.size):
        total[q] = _sum_of_terms(x[q], y[q], terms, square)
    return total


@nb.njit(cache=True)
def _sum_of_terms(x, y, terms, square):
    """Zernikes added up: r^|m| cos mθ is a power of x + iy, the rest Jacobi's polynomial in r², by its recurrence.

    Powers of r lose seven digits at order 20.
    """
    r2 = x * x + y * y
    total, t = square * r2, 2.0 * r2 - 1.0
    for p in range(len(terms)):
        n, signed, coefficient = terms[p, 0], terms[p, 1], terms[p, 2]
        m = abs(signed)
        before, last = 0.0, 1.0
        for j in range(1, int(n - m) // 2 + 1):
            if j == 1:
                before, last = last, 1.0 + 0.5 * (m + 2.0) * (t - 1.0)
                continue
            s = 2.0 * j + m
            up = (s - 1.0) * (s * (s - 2.0) * t - m * m) * last - 2.0 * (j - 1.0) * (j + m - 1.0) * s * before
            before, last = last, up / (2.0 * j * (j + m) * (s - 2.0))
        cos, sin = 1.0, 0.0
        for _ in range(int(m)):
            cos, sin = cos * x - sin * y, cos * y + sin * x
        norm = math.sqrt((n + 1.0) * (1.0 if m == 0 else 2.0))
        total += coefficient * norm * last * (cos if signed >= 0 else sin)
    return total


@nb.njit(cache=True)
def _strengths(rows, t, v, terms, square):
    """Places along rows (y, weight, begin, end) at a Gauss rule's nodes, and the amplitude times the weight there."""
    places, strength = np.empty((len(rows), t.size)), np.empty((len(rows), t.size), np.complex128)
    for k in range(len(rows)):
        middle, half = 0.5 * (rows[k, 2] + rows[k, 3]), 0.5 * (rows[k, 3] - rows[k, 2])
        for q in range(t.size):
            places[k, q] = middle + half * t[q]
            phase = 2.0 * math.pi * _sum_of_terms(places[k, q], rows[k, 0], terms, square)
            share = rows[k, 1] * half * v[q]
            strength[k, q] = complex(share * math.cos(phase), share * math.sin(phase))
    return places, strength


def corners(pupil):
    turn = math.radians(pupil["rotate_deg"])
    if pupil["shape"] == "square":
        angle, radius = turn + math.pi * (0.25 + 0.5 * np.arange(4)), math.sqrt(2.0)
    else:
        angle, radius = turn + 2.0 * math.pi * np.arange(pupil["blades"]) / pupil["blades"], 1.0
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def extent(pupil):
    """Largest |x| and |y| of the opening."""
    if pupil["shape"] == "circular":
        return 1.0, 1.0
    return tuple(float(v) for v in np.abs(corners(pupil)).max(axis=0))


def area(pupil):
    hole = math.pi * pupil["obstruction"] ** 2
    if pupil["shape"] == "circular":
        return math.pi - hole
    p = corners(pupil)
    q = np.roll(p, -1, axis=0)
    return 0.5 * float(np.sum(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])) - hole


def rows_of(pupil, nodes):
    """Rows y with weights, each with its one or two intervals of x: (y, weight, begin, end)."""
    levels = {-1.0, 1.0} if pupil["shape"] == "circular" else {float(v) for v in corners(pupil)[:, 1]}
    e = pupil["obstruction"]
    if e:
        levels |= {-e, e}
    levels = sorted(levels)
    levels = [a for a, b in zip(levels, [*levels[1:], math.inf], strict=True) if b - a > 1e-12]
    found = []
    for low, high in pairwise(levels):
        # A side that lies nearly along the rows crosses many columns in few rows.
        ends = np.abs(np.subtract(_chord(pupil, low + 1e-9), _chord(pupil, high - 1e-9))).max()
        count = rounded(nodes * (0.8 * (high - low + ends) / extent(pupil)[1] + 0.1) + 16)
        x, w = gauss(count)
        # y = middle − half·cos(u): takes the square roots at the ends of a circle.
        u = 0.5 * math.pi * (1.0 + x)
        y = 0.5 * (low + high) - 0.5 * (high - low) * np.cos(u)
        weight = 0.25 * math.pi * (high - low) * np.sin(u) * w
        begin, end = _chord(pupil, y)
        if e and abs(0.5 * (low + high)) < e:
            half = np.sqrt((e - y) * (e + y))
            found += [(y, weight, begin, -half), (y, weight, half, end)]
        else:
            found.append((y, weight, begin, end))
    return np.concatenate([np.stack(each, axis=1) for each in found])


def _chord(pupil, level):
    level = np.asarray(level, float)
    if pupil["shape"] == "circular":
        half = np.sqrt(np.maximum((1.0 - level) * (1.0 + level), 0.0))
        return -half, half
    begin, end = np.full(level.shape, -math.inf), np.full(level.shape, math.inf)
    p = corners(pupil)
    for (ax, ay), (bx, by) in zip(p, np.roll(p, -1, axis=0), strict=True):
        # Inside: (b − a) × (x − a) ≥ 0.
        if abs(by - ay) > 1e-12:
            x = ax + (level - ay) / (by - ay) * (bx - ax)
            begin, end = (begin, np.minimum(end, x)) if by > ay else (np.maximum(begin, x), end)
    return np.minimum(begin, end), end


def nodes_for(lens, wavelength_nm, turns):
    """Nodes along a row of the opening when the image's phase turns ``turns`` times over it, and the wavefront besides.

    The wavefront's own turns are measured: the longest way that it goes up and down along any row or column.
    """
    wide, high = extent(lens["pupil"])
    x, y = np.meshgrid(np.linspace(-wide, wide, 201), np.linspace(-high, high, 201))
    w = waves(lens, x, y, wavelength_nm)
    begin, end = _chord(lens["pupil"], y)  # of rows below a flat side, longer ones
    w = np.where((x >= begin - 0.01) & (x <= end + 0.01), w, np.nan)
    steps = [np.abs(np.diff(w, axis=axis)) for axis in (0, 1)]
    one = max(float(np.nansum(step, axis=axis).max()) for axis, step in enumerate(steps))
    steepest = 200.0 * max(float(np.nanmax(step)) for step in steps)
    return math.ceil(1.02 * math.pi * (turns + max(one, 0.3 * steepest))) + 32


def pattern(lens, wavelength_nm, x, y, spare=1.0, digits=16.0):
    """Point image of unit power, (y, x), on even lattices x and y (any unit; f_number·wavelength gives λN in it).

    ``lens['blur']`` is λN in that unit.
    """
    pupil, blur = lens["pupil"], lens["blur"] * wavelength_nm
    per = 0.5 / blur
    turns = 2.0 * per * max(float(np.abs(x).max()), float(np.abs(y).max())) * max(extent(pupil))
    nodes = rounded(spare * nodes_for(lens, wavelength_nm, turns))
    t, v = gauss(nodes)
    rows = rows_of(pupil, nodes)
    at, strength = _strengths(rows, t, v, *_terms(lens, wavelength_nm))
    inner = sums.of_rows(at, strength, -2.0 * np.pi * per * x[0], -2.0 * np.pi * per * (x[1] - x[0]), x.size, digits)
    amplitude = sums.of_columns(
        rows[:, 0], inner, -2.0 * np.pi * per * y[0], -2.0 * np.pi * per * (y[1] - y[0]), y.size, digits
    )
    return np.abs(amplitude) ** 2 * per**2 / area(pupil)
