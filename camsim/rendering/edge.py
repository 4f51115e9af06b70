"""One edge seen from one photosite: line, ends, near and far. Lengths are in pitches."""

from __future__ import annotations

import math
from typing import NamedTuple

import numba as nb
import numpy as np

from camsim.arrays import C128, F64, I64, U8
from camsim.rendering.far import Moments, across, far_edge, far_line, far_tail, mirrored, weigh
from camsim.rendering.rings import ring_tail


class Edges(NamedTuple):
    """Edges in pitches, with what each needs from the tables."""

    x: F64  # start
    y: F64
    tx: F64  # unit direction
    ty: F64
    length: F64
    m2: C128  # the footprint's moments in the edge's frame, see far.Moments
    m31: C128
    m4: C128
    m6: C128
    pair: I64  # which two spectra
    response: I64  # which edge response, −1 for none


class Tables(NamedTuple):
    """Everything that is tabulated, by pair of spectra and channel."""

    far: F64  # (pairs, channels, 4)
    field: F64  # (pairs, channels, 2, n, n)
    response: F64  # (directions, pairs, channels, cells, 6)
    base: F64  # (channels,) the background
    rings: C128  # amplitudes of the rings by wavelength (rings.airy_rings), none without rings
    ring_weights: F64  # (pairs, channels, wavelengths)
    blur: F64  # (wavelengths,)


class Numbers(NamedTuple):
    """The plan's settings as the kernels read them; lengths in pitches."""

    near: float  # an end within this distance is integrated
    quiet_end: float  # beyond this one it sends no rings
    reach: float  # an edge response is looked up to this distance
    quiet_line: float  # beyond this one a line sends no rings
    field_step: float
    response_step: float
    piece: float  # the longest that one rule integrates
    gauss_x: F64  # (lengths, most): rules for pieces of 1/lengths, 2/lengths … of it
    gauss_w: F64
    gauss_count: I64  # (lengths,) nodes of each
    sigma2: float  # footprint: ½⟨|ζ|²⟩, ⟨|ζ|⁴⟩
    m22: float
    harmonic: C128  # (4,) its ⟨ζ²⟩, ⟨ζ³ζ̄⟩, ⟨ζ⁴⟩, ⟨ζ⁶⟩ in the photosite's own frame
    turns: int  # its symmetry: a half turn (2) or a quarter turn (4) leaves it as it is
    apart: F64  # (c, 2): the field is the mean of its table at these offsets
    separation: float  # half-widths of a tile, or of a cell of sources, from which one is smooth over the other
    nodes: F64  # (n,) Chebyshev nodes on −1 … 1
    to_children: F64  # (2, n, n)
    to_photosites: F64  # (levels, root, n), level 0 the root
    root: int  # photosites along the largest tile
    leaf: int  # tiles of this size are finished whatever is left


@nb.njit(cache=True, inline="always")
def moments_of(e: int, edges: Edges, n: Numbers) -> Moments:
    """Return the footprint's moments as the end of edge ``e`` sees them."""
    return Moments(n.sigma2, n.m22, edges.m2[e], edges.m31[e], edges.m4[e], edges.m6[e])


@nb.njit(cache=True, inline="always")
def _weights(t: float) -> tuple[float, float, float, float, float, float, float, float]:
    """Lagrange weights of the eight nodes −3 … 4 at 0 ≤ t < 1; scalars, so that they stay in registers."""
    d0, d1, d2, d3 = t + 3.0, t + 2.0, t + 1.0, t
    d4, d5, d6, d7 = t - 1.0, t - 2.0, t - 3.0, t - 4.0
    p01, p23, p45, p67 = d0 * d1, d2 * d3, d4 * d5, d6 * d7
    p0123, p4567 = p01 * p23, p45 * p67
    a, b, c, d = p23 * p4567, p01 * p4567, p0123 * p67, p0123 * p45
    return (
        d1 * a * (-1.0 / 5040.0),
        d0 * a * (1.0 / 720.0),
        d3 * b * (-1.0 / 240.0),
        d2 * b * (1.0 / 144.0),
        d5 * c * (-1.0 / 144.0),
        d4 * c * (1.0 / 240.0),
        d7 * d * (-1.0 / 720.0),
        d6 * d * (1.0 / 5040.0),
    )


@nb.njit(cache=True, fastmath={"contract"})
def _flux(
    h: float,
    s_from: float,
    s_to: float,
    tx: float,
    ty: float,
    field: F64,
    n: Numbers,
) -> float:
    """Integrate −V·n along the edge from s_from to s_to, seen from signed distance h."""
    panels = max(1, math.ceil((s_to - s_from) / n.piece))
    half = 0.5 * (s_to - s_from) / panels
    rule = min(int(2.0 * half / n.piece * n.gauss_count.size), n.gauss_count.size - 1)
    nx, ny = -ty, tx
    inv_step = 1.0 / n.field_step
    total = 0.0
    for p in range(panels):
        middle = s_from + (2 * p + 1) * half
        for q in range(n.gauss_count[rule]):
            s = middle + half * n.gauss_x[rule, q]
            for spot in range(len(n.apart)):
                vx = s * tx - h * nx + n.apart[spot, 0]
                vy = s * ty - h * ny + n.apart[spot, 1]
                ux, uy = abs(vx) * inv_step, abs(vy) * inv_step
                i, j = np.uintp(ux), np.uintp(uy)
                y0, y1, y2, y3, y4, y5, y6, y7 = _weights(uy - j)
                # A stencil's corner is margin + 1 − order/2 = 1 beyond (i, j). One sum per column and component.
                i += np.uintp(1)
                j += np.uintp(1)
                a0 = a1 = a2 = a3 = a4 = a5 = a6 = a7 = 0.0
                b0 = b1 = b2 = b3 = b4 = b5 = b6 = b7 = 0.0
                for w in _weights(ux - np.uintp(ux)):
                    row = field[0, i, j : j + np.uintp(8)]
                    a0, a1, a2, a3 = a0 + w * row[0], a1 + w * row[1], a2 + w * row[2], a3 + w * row[3]
                    a4, a5, a6, a7 = a4 + w * row[4], a5 + w * row[5], a6 + w * row[6], a7 + w * row[7]
                    row = field[1, i, j : j + np.uintp(8)]
                    b0, b1, b2, b3 = b0 + w * row[0], b1 + w * row[1], b2 + w * row[2], b3 + w * row[3]
                    b4, b5, b6, b7 = b4 + w * row[4], b5 + w * row[5], b6 + w * row[6], b7 + w * row[7]
                    i += np.uintp(1)
                sum_x = (a0 * y0 + a1 * y1 + a2 * y2 + a3 * y3) + (a4 * y4 + a5 * y5 + a6 * y6 + a7 * y7)
                sum_y = (b0 * y0 + b1 * y1 + b2 * y2 + b3 * y3) + (b4 * y4 + b5 * y5 + b6 * y6 + b7 * y7)
                if vx < 0.0:
                    sum_x = -sum_x
                if vy < 0.0:
                    sum_y = -sum_y
                total -= n.gauss_w[rule, q] * (sum_x * nx + sum_y * ny)
    return total * half / len(n.apart)


@nb.njit(cache=True)
def _rings_of_end(h: float, s: float, tx: float, ty: float, weights: F64, tables: Tables, n: Numbers) -> float:
    """Rings of the half line from s ≥ 0 on, going in direction (tx, ty)."""
    if math.hypot(h, s) >= n.quiet_end:
        return 0.0
    return ring_tail(h, s, tx, ty, weights, tables.blur, tables.rings, n.turns, n.near)


@nb.njit(cache=True)
def _rings_of_line(h: float, tx: float, ty: float, weights: F64, tables: Tables, n: Numbers) -> float:
    """Rings of an infinite line; none within ``reach``, where its response has them."""
    if not n.reach <= abs(h) < n.quiet_line:
        return 0.0
    ahead = ring_tail(h, 0.0, tx, ty, weights, tables.blur, tables.rings, n.turns, n.near)
    return ahead - ring_tail(-h, 0.0, -tx, -ty, weights, tables.blur, tables.rings, n.turns, n.near)


@nb.njit(cache=True)
def _rings_of_part(
    h: float, s1: float, s2: float, tx: float, ty: float, weights: F64, tables: Tables, n: Numbers
) -> float:
    """Rings of the part s1 < s2 of an edge, every point of it beyond ``near``.

    A half line going the other way sees the photosite on its other side, and runs against the edge: twice a sign.
    """
    if s1 >= 0.0:
        return _rings_of_end(h, s1, tx, ty, weights, tables, n) - _rings_of_end(h, s2, tx, ty, weights, tables, n)
    if s2 <= 0.0:
        return _rings_of_end(-h, -s1, -tx, -ty, weights, tables, n) - _rings_of_end(
            -h, -s2, -tx, -ty, weights, tables, n
        )
    return (
        _rings_of_line(h, tx, ty, weights, tables, n)
        + _rings_of_end(-h, -s1, -tx, -ty, weights, tables, n)
        - _rings_of_end(h, s2, tx, ty, weights, tables, n)
    )


@nb.njit(cache=True, inline="always")
def line_at(h: float, e: int, channel: int, edges: Edges, tables: Tables, n: Numbers) -> float:
    """Contribution of one edge's line to a photosite at signed distance h, half of it taken away; without rings."""
    pair = edges.pair[e]
    a = abs(h)
    if a >= n.reach:
        total: float = weigh(far_line(h, across(moments_of(e, edges, n))), tables.far[pair, channel])
        return total
    u = a / n.response_step
    cell = int(u)
    t = u - cell
    c = tables.response[edges.response[e], pair, channel, cell]
    value: float = c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))))
    return value if h >= 0.0 else -value


@nb.njit(cache=True)
def edge_at(x: float, y: float, e: int, channel: int, edges: Edges, tables: Tables, n: Numbers) -> float:
    """Contribution of one edge to one photosite, by whichever of the ways is exact enough and cheap; without rings."""
    tx, ty = edges.tx[e], edges.ty[e]
    dx, dy = edges.x[e] - x, edges.y[e] - y
    h = dx * ty - dy * tx
    s1 = dx * tx + dy * ty
    s2 = s1 + edges.length[e]
    pair = edges.pair[e]
    far = tables.far[pair, channel]
    moments = moments_of(e, edges, n)
    r1, r2 = math.hypot(h, s1), math.hypot(h, s2)
    beside = s1 < 0.0 < s2
    sees_line = beside and edges.response[e] >= 0 and abs(h) < n.reach
    if not sees_line and min(r1, r2) >= n.near and (not beside or abs(h) >= n.near):
        return weigh(far_edge(h, s1, s2, moments), far)
    field = tables.field[pair, channel]
    cut = math.sqrt(max(n.near * n.near - h * h, 0.0))
    low, high = max(s1, -cut), min(s2, cut)
    total = 0.0
    if not sees_line or (r1 < n.near and r2 < n.near and s2 - s1 < 2.0 * cut - (s2 - s1)):
        if high > low:
            total = _flux(h, low, high, tx, ty, field, n)
            if s1 < low:
                total += weigh(far_edge(h, s1, low, moments), far)
            if s2 > high:
                total += weigh(far_edge(h, high, s2, moments), far)
        return total
    total = line_at(h, e, channel, edges, tables, n)
    for side in range(2):
        s = -s1 if side == 0 else s2
        if s < cut:
            if side == 0:
                total -= _flux(h, -cut, -s, tx, ty, field, n)
            else:
                total -= _flux(h, s, cut, tx, ty, field, n)
            s = cut
        if s < math.inf:
            total -= weigh(far_tail(h, s, mirrored(moments) if side == 0 else moments), far)
    return total


@nb.njit(cache=True)
def rings_of_line_at(h: float, e: int, channel: int, edges: Edges, tables: Tables, n: Numbers) -> float:
    """Rings that the far form in ``line_at`` leaves out."""
    weights = tables.ring_weights[edges.pair[e], channel]
    return _rings_of_line(h, edges.tx[e], edges.ty[e], weights, tables, n)


@nb.njit(cache=True)
def rings_at(x: float, y: float, e: int, channel: int, edges: Edges, tables: Tables, n: Numbers) -> float:
    """Rings that the far forms in ``edge_at`` leave out (kept apart: few plans have any, and it is the inner loop)."""
    tx, ty = edges.tx[e], edges.ty[e]
    dx, dy = edges.x[e] - x, edges.y[e] - y
    h = dx * ty - dy * tx
    s1 = dx * tx + dy * ty
    s2 = s1 + edges.length[e]
    weights = tables.ring_weights[edges.pair[e], channel]
    cut = math.sqrt(max(n.near * n.near - h * h, 0.0))
    if -cut < s1 and s2 < cut and s2 - s1 < cut:
        return 0.0
    if s1 < 0.0 < s2 and edges.response[e] >= 0 and abs(h) < n.reach:
        behind = _rings_of_end(-h, max(-s1, cut), -tx, -ty, weights, tables, n)
        return behind - _rings_of_end(h, max(s2, cut), tx, ty, weights, tables, n)
    if s1 >= cut or s2 <= -cut or cut == 0.0:
        return _rings_of_part(h, s1, s2, tx, ty, weights, tables, n)
    total = 0.0
    if s1 < -cut:
        total += _rings_of_part(h, s1, -cut, tx, ty, weights, tables, n)
    if s2 > cut:
        total += _rings_of_part(h, cut, s2, tx, ty, weights, tables, n)
    return total


@nb.njit(cache=True, parallel=True)
def add_rings_in_zones(
    x0: float,
    y0: float,
    zones: F64,
    first: I64,
    picked: I64,
    channel: U8,
    image: F64,
    edges: Edges,
    tables: Tables,
    long: Numbers,
    short: Numbers,
) -> None:
    """Add the rings that some edges send from far away to the photosites of zones, each edge's once.

    x0, y0 : of the image's first photosite;  zones: (n, 3) x, y and radius
    first, picked : where the edges of each zone begin (n + 1,), and they
    long, short : how far rings are there already (``near``, ``reach``) and how far they are wanted (``quiet_end``,
                  ``quiet_line``), for edges with a response and without
    """
    rows, cols = image.shape
    for r in nb.prange(rows):
        y = y0 + r
        left, right = cols, 0
        for zone in range(len(zones)):
            half2 = zones[zone, 2] ** 2 - (y - zones[zone, 1]) ** 2
            if half2 >= 0.0:
                middle, half = zones[zone, 0] - x0, math.sqrt(half2) + 1.0  # wider than rounding; each is asked below
                left = min(left, max(0, math.ceil(middle - half)))
                right = max(right, min(cols, math.floor(middle + half) + 1))
        if left >= right:
            continue
        added_at = np.full(edges.x.size, -1, np.int64)
        for c in range(left, right):
            x = x0 + c
            for zone in range(len(zones)):
                if (x - zones[zone, 0]) ** 2 + (y - zones[zone, 1]) ** 2 > zones[zone, 2] ** 2:
                    continue
                for e in picked[first[zone] : first[zone + 1]]:
                    if added_at[e] == c:
                        continue
                    added_at[e] = c
                    image[r, c] += rings_at(
                        x, y, e, channel[r, c], edges, tables, long if edges.response[e] >= 0 else short
                    )
