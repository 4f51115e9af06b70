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

MOST_NODES = 10_000  # of a Gauss rule: twice as many take four times as long, these two seconds


class TooLarge(Exception):
    """What a system asks for takes too many numbers, or too long."""


@functools.cache
def gauss(order):
    """Gauss–Legendre nodes and weights on −1 … 1."""
    if order > MOST_NODES:
        raise TooLarge
    return special.roots_legendre(order)


def zernike(index, x, y):
    n = 0
    while (n + 1) * (n + 2) // 2 <= index:
        n += 1
    m = 2 * (index - n * (n + 1) // 2) - n
    r, angle = np.hypot(x, y), np.arctan2(y, x)
    # Powers of r lose seven digits at order 20, Jacobi's polynomials none.
    radial = r ** abs(m) * special.eval_jacobi((n - abs(m)) // 2, 0, abs(m), 2.0 * r**2 - 1.0)
    norm = math.sqrt(n + 1.0) * (1.0 if m == 0 else math.sqrt(2.0))
    return norm * radial * (np.cos(m * angle) if m >= 0 else np.sin(-m * angle))


def waves(lens, x, y, wavelength_nm):
    """Path difference in waves."""
    total = lens["defocus_um"] * 1e3 / (8.0 * lens["f_number"] ** 2 * wavelength_nm) * (x * x + y * y)
    for index, coefficient in lens["zernike_waves"]:
        total = total + coefficient * lens["reference_nm"] / wavelength_nm * zernike(index, x, y)
    return total


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
        count = math.ceil(nodes * (0.8 * (high - low + ends) / extent(pupil)[1] + 0.1)) + 16
        x, w = gauss(count)
        # y = middle − half·cos(u): takes the square roots at the ends of a circle.
        u = 0.5 * math.pi * (1.0 + x)
        y = 0.5 * (low + high) - 0.5 * (high - low) * np.cos(u)
        weight = 0.25 * math.pi * (high - low) * np.sin(u) * w
        for level, share in zip(y, weight, strict=True):
            begin, end = _chord(pupil, level)
            if e and abs(level) < e:
                half = math.sqrt((e - level) * (e + level))
                found += [(level, share, begin, -half), (level, share, half, end)]
            else:
                found.append((level, share, begin, end))
    return found


def _chord(pupil, level):
    if pupil["shape"] == "circular":
        half = math.sqrt(max((1.0 - level) * (1.0 + level), 0.0))
        return -half, half
    begin, end = -math.inf, math.inf
    p = corners(pupil)
    for (ax, ay), (bx, by) in zip(p, np.roll(p, -1, axis=0), strict=True):
        # Inside: (b − a) × (x − a) ≥ 0.
        if abs(by - ay) > 1e-12:
            x = ax + (level - ay) / (by - ay) * (bx - ax)
            begin, end = (begin, min(end, x)) if by > ay else (max(begin, x), end)
    return min(begin, end), end


def nodes_for(lens, wavelength_nm, turns):
    """Nodes along a row of the opening when the image's phase turns ``turns`` times over it, and the wavefront besides.

    The wavefront's own turns are measured: the longest way that it goes up and down along any row or column.
    """
    wide, high = extent(lens["pupil"])
    x, y = np.meshgrid(np.linspace(-wide, wide, 401), np.linspace(-high, high, 401))
    w = waves(lens, x, y, wavelength_nm)
    ends = np.array([_chord(lens["pupil"], level) for level in y[:, 0]])  # of rows below a flat side, longer ones
    w = np.where((x >= ends[:, :1] - 0.01) & (x <= ends[:, 1:] + 0.01), w, np.nan)
    steps = [np.abs(np.diff(w, axis=axis)) for axis in (0, 1)]
    one = max(float(np.nansum(step, axis=axis).max()) for axis, step in enumerate(steps))
    steepest = 400.0 * max(float(np.nanmax(step)) for step in steps)
    return math.ceil(1.02 * math.pi * (turns + max(one, 0.3 * steepest))) + 32


def pattern(lens, wavelength_nm, x, y, spare=1.0):
    """Point image of unit power, (y, x), on even lattices x and y (any unit; f_number·wavelength gives λN in it).

    ``lens['blur']`` is λN in that unit.
    """
    pupil, blur = lens["pupil"], lens["blur"] * wavelength_nm
    per = 0.5 / blur
    turns = 2.0 * per * max(float(np.abs(x).max()), float(np.abs(y).max())) * max(extent(pupil))
    nodes = math.ceil(spare * nodes_for(lens, wavelength_nm, turns))
    t, v = gauss(nodes)
    rows = rows_of(pupil, nodes)
    inner = np.empty((len(rows), x.size), complex)
    levels = np.array([row[0] for row in rows])
    for k, (level, share, begin, end) in enumerate(rows):
        at = 0.5 * (begin + end) + 0.5 * (end - begin) * t
        strength = (
            share
            * 0.5
            * (end - begin)
            * v
            * np.exp(2j * np.pi * waves(lens, at, np.full(at.shape, level), wavelength_nm))
        )
        inner[k] = _along(at, strength, -2.0 * np.pi * per * x[0], -2.0 * np.pi * per * (x[1] - x[0]), x.size)
    outer = np.exp(-2j * np.pi * per * np.outer(y, levels))
    amplitude = outer @ inner
    return np.abs(amplitude) ** 2 * per**2 / area(pupil)


@nb.njit(cache=True, fastmath=True)
def _along(at, strength, first, step, count):
    """Σ strength·exp(i·at·(first + step·m)), m = 0 … count − 1; phases are started afresh every 32 terms."""
    out = np.zeros(count, np.complex128)
    turn_re, turn_im = np.cos(at * step), np.sin(at * step)
    re, im = np.zeros(at.size), np.zeros(at.size)
    for m in range(count):
        if m % 32 == 0:
            for q in range(at.size):
                phase = at[q] * (first + step * m)
                c, s = math.cos(phase), math.sin(phase)
                re[q] = strength[q].real * c - strength[q].imag * s
                im[q] = strength[q].real * s + strength[q].imag * c
        sum_re, sum_im = 0.0, 0.0
        for q in range(at.size):
            a, b = re[q], im[q]
            sum_re += a
            sum_im += b
            re[q] = a * turn_re[q] - b * turn_im[q]
            im[q] = a * turn_im[q] + b * turn_re[q]
        out[m] = complex(sum_re, sum_im)
    return out
