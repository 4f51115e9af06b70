"""A distant edge as a line of dipoles: with z = source − photosite in the complex plane, a piece dz contributes

    dK = Im(F(z)·dz),   F = 2∂⟨Φ⟩,   Φ = (1/2π)·(ln r + c1/r + c3/3r³ + c5/5r⁵)

where ⟨ ⟩ is the average over the footprint, with the moments of far.py; with m = M·(z̄/r)ⁿ, M = ⟨ζⁿ⟩ or ⟨ζ³ζ̄⟩,

    2∂Re(M·∂ⁿ ln r)/n! = m/(z·rⁿ),   2∂Re(M·∂² r⁻ᵏ) = −¼k(k + 2)·(z̄/r)·r⁻ᵏ⁻³·[(k + 2)·Re m + 2i·Im m].

F is smooth over anything far enough away: many edges are replaced by a few nodes (crowd.py), and an edge that is short
relative to its distance by two.
"""

from __future__ import annotations

import math

from camsim.core.arrays import F64
from camsim.core.kernels import kernel
from camsim.rendering.boundary.far import Moments

GAUSS = 0.5 / math.sqrt(3.0)  # of an edge's length, to either side of its middle: the two-point Gauss rule
LOST = 0.04  # error of that rule for a line of edges, over u⁴


def longest_dipoles(distance: float, allowed: float) -> float:
    """Return the largest length of edges that two nodes can replace from a distance on.

    The error of two nodes for an edge's angle 2u + … (u: half its length over its distance) is (8/45)·u⁵; for a line of
    such edges it is at most 0.019·u⁴ over 2π, and twice that with the powers of 1/r.
    """
    return 2.0 * distance * math.sqrt(math.sqrt(allowed / LOST))


@kernel(forceinline=True)
def dipole(zx: float, zy: float, m: Moments) -> tuple[float, float, float, float, float, float, float, float]:
    """Return the factors of (dx, dy) in the four numbers g: for each first that of dx, then that of dy."""
    inv2 = 1.0 / (zx * zx + zy * zy)
    inv = math.sqrt(inv2)
    # e = z̄/r; F is e/r times a factor for each moment of the far form.
    e_re, e_im = zx * inv, -zy * inv
    e2_re, e2_im = e_re * e_re - e_im * e_im, 2.0 * e_re * e_im
    e4_re, e4_im = e2_re * e2_re - e2_im * e2_im, 2.0 * e2_re * e2_im
    c_re, c_im = m.m4.real * e4_re - m.m4.imag * e4_im, m.m4.real * e4_im + m.m4.imag * e4_re
    f0_re, f0_im = 1.0 + inv2 * inv2 * c_re, inv2 * inv2 * c_im
    second, fourth = 1.5 * m.sigma2, 0.703125 * m.m22 + 2.734375 * c_re
    f1_im = 2.1875 * inv2 * c_im
    third = 7.5 * m.sigma2
    f3_im = 0.0
    if m.m2 != 0.0 or m.m31 != 0.0 or m.m6 != 0.0:
        e6_re, e6_im = e4_re * e2_re - e4_im * e2_im, e4_re * e2_im + e4_im * e2_re
        a_re, a_im = m.m2.real * e2_re - m.m2.imag * e2_im, m.m2.real * e2_im + m.m2.imag * e2_re
        b_re, b_im = m.m31.real * e2_re - m.m31.imag * e2_im, m.m31.real * e2_im + m.m31.imag * e2_re
        d_re, d_im = m.m6.real * e6_re - m.m6.imag * e6_im, m.m6.real * e6_im + m.m6.imag * e6_re
        f0_re += inv2 * (a_re + inv2 * inv2 * d_re)
        f0_im += inv2 * (a_im + inv2 * inv2 * d_im)
        second += 2.25 * a_re
        fourth += 1.5625 * b_re
        f1_im += 1.5 * a_im + 0.625 * inv2 * b_im
        third += 6.25 * a_re
        f3_im = 2.5 * inv2 * a_im
    f1_re, f1_im = 1.0 + inv2 * (second + inv2 * fourth), inv2 * f1_im
    f3_re = 1.0 + inv2 * third
    w1 = -inv2
    w3 = inv2 * w1
    w5 = inv2 * w3
    return (
        inv * (e_re * f0_im + e_im * f0_re),
        inv * (e_re * f0_re - e_im * f0_im),
        w1 * (e_re * f1_im + e_im * f1_re),
        w1 * (e_re * f1_re - e_im * f1_im),
        w3 * (e_re * f3_im + e_im * f3_re),
        w3 * (e_re * f3_re - e_im * f3_im),
        w5 * e_im,
        w5 * e_re,
    )


@kernel(error_model="numpy", fastmath={"contract"})
def dipole_at_points(dx: float, dy: float, x: F64, y: F64, m: Moments, sends: F64) -> None:
    """Write to ``sends`` (8, points) the result of ``dipole`` for one at (dx, dy), relative to points (x, y)."""
    plain = Moments(m.sigma2, m.m22, 0j, 0j, m.m4, 0j)  # literal zeros, so that the compiler drops their terms
    if m.m2 == 0.0 and m.m31 == 0.0 and m.m6 == 0.0:
        for p in range(x.size):
            (
                sends[0, p], sends[1, p], sends[2, p], sends[3, p], sends[4, p], sends[5, p], sends[6, p], sends[7, p]
            ) = dipole(dx - x[p], dy - y[p], plain)  # fmt: skip
    else:
        for p in range(x.size):
            (
                sends[0, p], sends[1, p], sends[2, p], sends[3, p], sends[4, p], sends[5, p], sends[6, p], sends[7, p]
            ) = dipole(dx - x[p], dy - y[p], m)  # fmt: skip
