"""The far form: the contribution of an edge when all of it (or one of its ends) is many λN away.

Beyond a few λN the encircled energy is E = 1 − c1'/r − c3'/r³ − … plus oscillatory terms, and the footprint matters
only through its moments. With z = s + ih (s along the edge, h across it) the terms below are

    θ averaged to 6th order      the angle, and its change by harmonic moments:  −Im(M2/2z² + M4/4z⁴ + M6/6z⁶)
    1/r  averaged to 4th order   r⁻¹ + ½σ²·r⁻³ + Re(M2·∂² r⁻¹) + 9/64·M22·r⁻⁵ + 1/12·Re(M31·∂² r⁻³) + 1/12·Re(M4·∂⁴ r⁻¹)
    1/r³ averaged to 2nd order   ⅓·(r⁻³ + … + Re(M2·∂² r⁻³)),   1/r⁵ as it is

each integrated over s from the end to infinity and differentiated across the edge. ∂ = ½(∂_s − i∂_h), and

    ∫∂²(r⁻ᵏ) ds = [∂ r⁻ᵏ] − ¼k²·∫r⁻ᵏ⁻² ds                    (use ∂_s = ∂ + ∂̄ and 4∂∂̄ = ∇²)
    ∫∂⁴(1/r) ds = [∂³(1/r)] − ¼[∂ r⁻³] + (9/16)·∫r⁻⁵ ds      (twice)

M2 = ⟨ζ²⟩, M31 = ⟨ζ³ζ̄⟩ and M6 = ⟨ζ⁶⟩ vanish for a footprint with the symmetry of a quarter turn.

Every result is four numbers g; a weight set with w_j at λ_j contributes Σ_m g[m]·far[m], where far holds the
moments Σw, Σw·c1, Σw·c3, Σw·c5 over 2π. Nothing is divided by the net contrast.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64
from camsim.core.kernels import kernel
from camsim.optics.pattern import Pattern

TWO_PI = 2.0 * math.pi


class Moments(NamedTuple):
    """A footprint's moments in the frame of one edge's tail: ζ's real axis runs along the edge, away from its end."""

    sigma2: float  # ½⟨|ζ|²⟩
    m22: float  # ⟨|ζ|⁴⟩
    m2: complex
    m31: complex
    m4: complex
    m6: complex


@kernel(forceinline=True)
def mirrored(m: Moments) -> Moments:
    """Return the moments in the frame of a tail towards −∞."""
    return Moments(m.sigma2, m.m22, m.m2.conjugate(), m.m31.conjugate(), m.m4.conjugate(), m.m6.conjugate())


def far_moments(pattern: Pattern, blur: F64, weights: F64) -> F64:
    """Return (k, 4): Σw, Σw·c1, Σw·c3, Σw·c5 over 2π for (k, j) weights at (j,) blurs."""
    c1, c3, c5 = pattern.powers
    terms = np.stack([np.ones_like(blur), c1 * blur, c3 * blur**3, c5 * blur**5], axis=1)
    moments: F64 = weights @ terms / TWO_PI
    return moments


@kernel(forceinline=True)
def weigh(g: tuple[float, float, float, float], far: F64) -> float:
    """Return Σ_m g[m]·far[m]: the contribution for one weight set."""
    total: float = g[0] * far[0] + g[1] * far[1] + g[2] * far[2] + g[3] * far[3]
    return total


@kernel(forceinline=True)
def smooth_tail(h: float, s: float, m: Moments) -> tuple[float, float, float, float]:
    """Return g of the half line from s ≥ 0 to infinity, without the angle itself; h and s are not both 0."""
    r2 = h * h + s * s
    r = math.sqrt(r2)
    inv = 1.0 / r
    u = s * inv
    v = h * inv
    q = 1.0 / (r2 + r * s)
    g3 = q
    g5 = (2.0 + u) * q * q * (1.0 / 3.0)
    g7 = (8.0 + 9.0 * u + 3.0 * u * u) * q * q * q * (1.0 / 15.0)
    # e = z̄/r = u − iv and its powers
    e2_re, e2_im = u * u - v * v, -2.0 * u * v
    e3_re, e3_im = e2_re * u + e2_im * v, e2_im * u - e2_re * v
    e4_re, e4_im = e2_re * e2_re - e2_im * e2_im, 2.0 * e2_re * e2_im
    inv2 = inv * inv
    inv4 = inv2 * inv2
    m4_re, m4_im = m.m4.real, m.m4.imag
    shift = -0.25 * inv4 * (m4_re * e4_im + m4_im * e4_re)
    b_re = -5.625 * e2_im + 13.125 * v * e3_re - 1.875 * v * u
    b_im = 5.625 * e2_re + 13.125 * v * e3_im - 0.375 + 1.875 * v * v
    hg7 = h * g7
    quartic = -(m4_re * b_re - m4_im * b_im) * inv4 * inv - 2.8125 * m4_re * hg7
    first = -h * (g3 + 1.5 * m.sigma2 * g5) - 0.703125 * m.m22 * hg7 + quartic * (1.0 / 12.0)
    third = -h * g5 - 7.5 * m.sigma2 * hg7
    if m.m2 != 0.0 or m.m31 != 0.0 or m.m6 != 0.0:
        e = complex(u, -v)
        e2 = e * e
        shift -= (m.m2 * e2).imag * 0.5 * inv2 + (m.m6 * e2 * e2 * e2).imag * (1.0 / 6.0) * inv4 * inv2
        inv3 = inv * inv2
        from_first = complex(0.75 * h * g5, 0.0) - inv3 * (0.5j + 1.5 * v * e)
        from_third = complex(11.25 * hg7, 0.0) - inv3 * inv2 * (1.5j + 7.5 * v * e)
        first += (m.m2 * from_first).real + (m.m31 * from_third).real * (1.0 / 12.0)
        third += (m.m2 * from_third).real * (1.0 / 3.0)
    return shift, first, third, -hg7


@kernel(forceinline=True)
def far_tail(h: float, s: float, m: Moments) -> tuple[float, float, float, float]:
    """Return g of the half line from s ≥ 0 to infinity at signed distance h; not both 0."""
    a0, a1, a3, a5 = smooth_tail(h, s, m)
    return math.atan2(h, s) + a0, a1, a3, a5


@kernel(forceinline=True)
def across(m: Moments) -> tuple[float, float]:
    """Return ⟨d²⟩ and ⟨d⁴⟩ of the footprint's offsets d across the edge, on which a whole line depends."""
    return m.sigma2 - 0.5 * m.m2.real, 0.375 * m.m22 - 0.5 * m.m31.real + 0.125 * m.m4.real


@kernel(forceinline=True)
def far_line(h: float, d: tuple[float, float]) -> tuple[float, float, float, float]:
    """Return g of the whole line at signed distance h ≠ 0; d of ``across``.

    A line's integrals are π, 2/h, 4/(3h³) and 16/(15h⁵), averaged over h + d.
    """
    d2, d4 = d
    u = 1.0 / h
    u2 = u * u
    u3 = u * u2
    first = -2.0 * (u + u3 * (d2 + d4 * u2))
    third = (-4.0 / 3.0) * u3 * (1.0 + 6.0 * d2 * u2)
    return math.copysign(math.pi, h), first, third, (-16.0 / 15.0) * u3 * u2


@kernel(forceinline=True)
def far_edge(h: float, s1: float, s2: float, m: Moments) -> tuple[float, float, float, float]:
    """Return g of the edge s1 < s2 at signed distance h, every point of it far away.

    A tail towards −∞ is the mirror image of one towards +∞, and reflection conjugates the moments. The tails of both
    ends have the same direction unless the foot of the perpendicular lies strictly between them.
    """
    angle = math.atan2(h * (s2 - s1), h * h + s1 * s2)
    if s1 >= 0.0:
        a0, a1, a3, a5 = smooth_tail(h, s1, m)
        b0, b1, b3, b5 = smooth_tail(h, s2, m)
        return angle + a0 - b0, a1 - b1, a3 - b3, a5 - b5
    a0, a1, a3, a5 = smooth_tail(h, -s1, mirrored(m))
    if s2 <= 0.0:
        b0, b1, b3, b5 = smooth_tail(h, -s2, mirrored(m))
        return angle + b0 - a0, b1 - a1, b3 - a3, b5 - a5
    b0, b1, b3, b5 = smooth_tail(h, s2, m)
    _, c1, c3, c5 = far_line(h, across(m))
    return angle - a0 - b0, c1 - a1 - b1, c3 - a3 - b3, c5 - a5 - b5
