"""The far form at many points at once: the contributions of edges at the nodes of a tile, or at its photosites.

The loops over points have no branches and call nothing that the compiler cannot vectorise.
"""

from __future__ import annotations

import math

from camsim.core.arrays import F64, U8
from camsim.core.kernels import kernel
from camsim.rendering.boundary.far import Moments, across, far_line, mirrored, smooth_tail, weigh
from camsim.rendering.boundary.records import Numbers, TabledEdges, moments_of

# Parts of an edge: all of it, its infinite line, or minus both ends (WHOLE = LINE + ENDS); all of a short one.
WHOLE, LINE, ENDS, BRIEF = 0, 1, 2, 3
HALF_PI, QUARTER_PI = 0.5 * math.pi, 0.25 * math.pi
TAN_EIGHTH = math.sqrt(2.0) - 1.0


@kernel(forceinline=True)
def _angle(y: float, x: float) -> float:
    """Return atan2(y, x) to 1e-16; nan for (0, 0).

    The polynomial is atan(√u)/√u at the eleven Chebyshev nodes of 0 ≤ u ≤ tan²(π/8); larger angles are turned by π/4.
    """
    ay, ax = abs(y), abs(x)
    low, high = (ay, ax) if ay < ax else (ax, ay)
    turned = low > TAN_EIGHTH * high
    t = (low - high if turned else low) / (low + high if turned else high)
    u = t * t
    p = 0.0568830340363325 + u * (-0.04347919839046537 + u * 0.021133752033748364)
    p = -0.09090773003240828 + u * (0.07689952488233016 + u * (-0.066402251735395 + u * p))
    p = -0.14285714180900647 + u * (0.11111106177375227 + u * p)
    p = t * (1.0 + u * (-0.33333333333328435 + u * (0.19999999998854168 + u * p)))
    p += QUARTER_PI if turned else 0.0
    p = HALF_PI - p if ay > ax else p
    p = math.pi - p if x < 0.0 else p
    return -p if y < 0.0 else p


@kernel(forceinline=True)
def _ends(h: float, s1: float, length: float, side: float, m: Moments) -> tuple[float, float, float, float]:
    """Return g of an edge without the smooth part of its line, which counts only between the ends' perpendiculars."""
    s2 = s1 + length
    up1 = 1.0 if s1 >= 0.0 else -1.0
    up2 = 1.0 if s2 >= 0.0 else -1.0
    a0, a1, a3, a5 = smooth_tail(h, abs(s1), m if s1 >= 0.0 else mirrored(m))
    b0, b1, b3, b5 = smooth_tail(h, abs(s2), m if s2 >= 0.0 else mirrored(m))
    angle = side * _angle(h * length, side * (h * h + s1 * s2))
    return angle + up1 * a0 - up2 * b0, up1 * a1 - up2 * b1, up1 * a3 - up2 * b3, up1 * a5 - up2 * b5


@kernel(forceinline=True)
def _brief(h: float, s: float, length: float, m: Moments) -> tuple[float, float, float, float]:
    """Return g of an edge that is short for its distance, with its middle at (s, h), behind a ``plain`` footprint.

    The angle is atan(x) with an error of x⁵/5; the rest is the derivative of ``smooth_tail`` at the middle, times the
    length, and of the largest term the second derivative too.
    """
    quarter = 0.25 * length * length
    u = 1.0 / (h * h + s * s - quarter)
    inv = math.sqrt(u)
    x, v, w = h * length * u, h * inv, s * inv
    e2_re, e2_im = w * w - v * v, -2.0 * w * v
    e4_re, e4_im = e2_re * e2_re - e2_im * e2_im, 2.0 * e2_re * e2_im
    e5_re, e5_im = e4_re * w + e4_im * v, e4_im * w - e4_re * v
    m4_re, m4_im, u2 = m.m4.real, m.m4.imag, u * u
    angle = x - x * x * x * (1.0 / 3.0) - length * inv * u2 * (m4_im * e5_re + m4_re * e5_im)
    quartic = m4_im * (4.0 * w * e4_re + 5.0 * v * e4_im) - m4_re * (5.0 * v * e4_re - 4.0 * w * e4_im)
    one = -x * inv
    first = one * (1.0 + u * (1.5 * m.sigma2 + quarter * (2.5 * w * w - 2.0)) + 0.703125 * m.m22 * u2)
    first += 0.546875 * length * u2 * u * quartic
    return angle, first, one * u * (1.0 + 7.5 * m.sigma2 * u), one * u2


@kernel(forceinline=True, error_model="numpy", fastmath={"contract"})
def far_at_points(
    e: int, part: int, x0: float, y0: float, x: F64, y: F64, edges: TabledEdges, n: Numbers, g: F64
) -> None:
    """Write to ``g`` (4, points) the far form of a part of edge ``e`` at the points (x0 + x, y0 + y).

    It is not valid at points that are not far away; between the perpendiculars at an edge's ends, |h| is taken as at
    least ``near``.
    """
    tx, ty, length = edges.tx[e], edges.ty[e], edges.length[e]
    dx, dy = edges.x[e] - x0, edges.y[e] - y0
    m = moments_of(e, edges, n)
    plain = Moments(m.sigma2, m.m22, 0j, 0j, m.m4, 0j)  # literal zeros, so that the compiler drops their terms
    is_plain = m.m2 == 0.0 and m.m31 == 0.0 and m.m6 == 0.0
    d = across(m)
    if part == LINE:
        for i in range(x.size):
            g[0, i], g[1, i], g[2, i], g[3, i] = far_line((dx - x[i]) * ty - (dy - y[i]) * tx, d)
        return
    if part == BRIEF:
        for i in range(x.size):
            h = (dx - x[i]) * ty - (dy - y[i]) * tx
            s1 = (dx - x[i]) * tx + (dy - y[i]) * ty
            g[0, i], g[1, i], g[2, i], g[3, i] = _brief(h, s1 + 0.5 * length, length, plain)
        return
    side = -1.0 if part == ENDS else 1.0
    if is_plain:
        for i in range(x.size):
            h = (dx - x[i]) * ty - (dy - y[i]) * tx
            s1 = (dx - x[i]) * tx + (dy - y[i]) * ty
            g[0, i], g[1, i], g[2, i], g[3, i] = _ends(h, s1, length, side, plain)
    else:
        for i in range(x.size):
            h = (dx - x[i]) * ty - (dy - y[i]) * tx
            s1 = (dx - x[i]) * tx + (dy - y[i]) * ty
            g[0, i], g[1, i], g[2, i], g[3, i] = _ends(h, s1, length, side, m)
    alongside = 0
    for i in range(x.size):
        s1 = (dx - x[i]) * tx + (dy - y[i]) * ty
        alongside += (s1 < 0.0) & (s1 + length >= 0.0)
    if part == ENDS or alongside == 0:
        return
    for i in range(x.size):
        h = (dx - x[i]) * ty - (dy - y[i]) * tx
        s1 = (dx - x[i]) * tx + (dy - y[i]) * ty
        counts = 1.0 if (s1 < 0.0) & (s1 + length >= 0.0) else 0.0
        _, c1, c3, c5 = far_line(math.copysign(max(abs(h), n.near), h), d)
        g[1, i] += counts * c1
        g[2, i] += counts * c3
        g[3, i] += counts * c5


@kernel(forceinline=True, fastmath={"contract"})
def add_weighed(g: F64, far: F64, sums: F64) -> None:
    """Add to ``sums`` (channels, points) the contribution of g (4, points) for weight sets ``far`` (channels, 4)."""
    for k in range(len(sums)):
        for i in range(g.shape[1]):
            sums[k, i] += weigh((g[0, i], g[1, i], g[2, i], g[3, i]), far[k])


@kernel(fastmath={"contract"})
def far_and_negligible(
    e: int, x0: float, y0: float, x: F64, y: F64, edges: TabledEdges, n: Numbers, negligible: U8
) -> None:
    """Write 1 to ``negligible`` (points) where the far form suffices: no ringing counts and no line is looked up."""
    tx, ty, length = edges.tx[e], edges.ty[e], edges.length[e]
    dx, dy = edges.x[e] - x0, edges.y[e] - y0
    line = n.reach if edges.response[e] >= 0 else n.near
    end2 = n.near * n.near
    for i in range(x.size):
        h = (dx - x[i]) * ty - (dy - y[i]) * tx
        s1 = (dx - x[i]) * tx + (dy - y[i]) * ty
        s2 = s1 + length
        ends = min(s1 * s1, s2 * s2) + h * h >= end2
        negligible[i] = ends & ((s1 >= 0.0) | (s2 <= 0.0) | (abs(h) >= line))
