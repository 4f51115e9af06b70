"""Hankel transforms of a piecewise cubic: a rotationally symmetric PSF from its transfer.

Far out the integrand oscillates a thousand times, and the integral is determined by the cubic's knots alone. The Bessel
function is the real part of a Hankel function, which decays upwards in the complex plane. So the path of each piece is
deformed to run straight up from its ends, and a knot contributes the difference of the cubics on its two sides along
the path upwards. The Hankel function has a pole at zero; the path leaves the axis at F, where 2πFr is ``UP_FROM``, and
up to there ordinary nodes are used. With z = f + iy the path upwards is
exp(2πi·f·r)·i∫Δc(iy)·z^{1−n}·h(2πrz)·exp(−2πry) dy: a Gauss–Laguerre rule, whose integrand is smooth in r.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import scipy

from camsim.core.arrays import C128, F64
from camsim.numerics.quadrature import chebyshev, gauss_legendre, interpolation

# Argument of the Bessel function at which paths leave the axis, nodes on a path, and Chebyshev nodes between a radius
# and twice it for interpolation of the smooth factor: relative error 1e-12 at any distance (16 nodes: 1e-9).
UP_FROM, STEEP, PLACES = 30.0, 24, 24
NODES, SPARE = 0.3, 20  # on the axis: per radian of phase on a panel, and in addition
CHUNK = 2_000_000  # Bessel functions at a time


def hankel(curve: scipy.interpolate.PPoly, r: F64, order: int) -> F64:
    """Return 2π ∫ c(f)·J_n(2πfr)·f^{1−n} df at radii of any shape, for n = 0 or 1.

    curve : piecewise cubic from 0 to its last knot, where it is 0

    >>> cone = scipy.interpolate.PPoly(np.array([[0.0], [0.0], [-1.0], [1.0]]), np.array([0.0, 1.0]))  # 1 − f
    >>> float(hankel(cone, np.array(0.0), 0).round(12) == round(np.pi / 3.0, 12))
    1.0
    """
    flat, bessel = r.ravel(), scipy.special.j1 if order else scipy.special.j0
    by_radius, last, out = np.argsort(flat), float(curve.x[-1]), np.empty(flat.shape)
    radii, start = flat[by_radius], 0
    while start < flat.size:
        # Radii up to twice the smallest of a group share quadrature rules.
        least = max(float(radii[start]), 2.0 / last)
        stop = max(int(np.searchsorted(radii, 2.0 * least, side="right")), start + 1)
        up_from = min(UP_FROM / (2.0 * math.pi * least), last)
        f, share = _on_the_axis(curve, order, up_from, float(radii[stop - 1]))
        points, parts = _upwards(curve, order, up_from, least)
        step = max(1, CHUNK // (f.size + points.size))
        for first in range(start, stop, step):
            one = radii[first : min(first + step, stop)]
            values = bessel(2.0 * np.pi * f[:, None] * one).T @ share
            if points.size:
                smooth = interpolation(chebyshev(PLACES), 2.0 * one / least - 3.0)
                turned = np.exp(2j * np.pi * np.multiply.outer(one, points))
                values += np.real((smooth @ parts) * turned).sum(axis=1)
            out[by_radius[first : first + one.size]] = values
        start = stop
    values_at: F64 = out.reshape(r.shape)
    return values_at


def _on_the_axis(curve: scipy.interpolate.PPoly, order: int, end: float, longest: float) -> tuple[F64, F64]:
    """Return nodes (n,) up to ``end`` that resolve the phase at the radius ``longest``, and the curve times weights."""
    nodes, weights = [], []
    for low, high in pairwise([*curve.x[curve.x < end], end]):
        x, w = gauss_legendre(math.ceil(NODES * 2.0 * math.pi * longest * (high - low)) + SPARE)
        nodes.append(0.5 * (low + high) + 0.5 * (high - low) * x)
        weights.append(0.5 * (high - low) * w)
    f = np.concatenate(nodes)
    share: F64 = 2.0 * np.pi * np.concatenate(weights) * curve(f) * f ** (1 - order)
    return f, share


def _upwards(curve: scipy.interpolate.PPoly, order: int, start: float, least: float) -> tuple[F64, C128]:
    """Return frequencies (m,) of paths upwards, and their contributions (n, m) at ``PLACES`` radii up to 2·least."""
    x, one = curve.x, np.searchsorted(curve.x, start, side="right") - 1
    if one == x.size - 1:
        return np.empty(0), np.empty((PLACES, 0), complex)
    points = np.concatenate([[start], x[one + 1 :]])
    begin = np.concatenate([[start - x[one]], np.zeros(x.size - 1 - one)])
    after = _about(np.pad(curve.c, ((0, 0), (0, 1)))[:, one:], begin)
    before = _about(curve.c[:, one:], np.diff(x)[one:])
    after[:, 1:] -= before
    t, w = np.polynomial.laguerre.laggauss(STEEP)
    radii = least * (1.5 + 0.5 * chebyshev(PLACES))
    iy = 1j * t / (2.0 * np.pi * radii[:, None, None])  # (n, 1, steep)
    differ = sum(after[d][:, None] * iy**d for d in range(4))
    z = points[:, None] + iy
    hankels = scipy.special.hankel1e(order, 2.0 * np.pi * radii[:, None, None] * z)
    parts: C128 = 1j * np.sum(differ * z ** (1 - order) * hankels * w, axis=-1) / radii[:, None]
    return points, parts


def _about(cubics: F64, by: F64) -> F64:
    """Return coefficients (4, m) of 1, h, h², h³ of cubics (4, m; h³ first), about places ``by`` from their starts."""
    c3, c2, c1, c0 = cubics
    return np.array(
        [c0 + by * (c1 + by * (c2 + by * c3)), c1 + by * (2.0 * c2 + 3.0 * by * c3), c2 + 3.0 * by * c3, c3]
    )
