"""Circles tangent to edges, at whose centres their ringing may add up in phase."""

from __future__ import annotations

import numpy as np

from camsim.core.arrays import F64, I64, kinds_of
from camsim.core.kernels import kernel
from camsim.rendering.edges import Edges
from camsim.rendering.focus import ZONE, normals
from camsim.rendering.grid import Grid

NEARLY_PARALLEL = 1e-11  # sine of the angle between edges below which they define no circle
ALIKE = 16  # largest period, in edges, of a repeated pattern such as a wheel's spokes
FAR_APART = 1e-6  # least relative area of the triangle of three normals: below it, the circle is rounding
AGAIN = 1e-6  # relative difference below which a circle repeats the previous one
SAME_CIRCLE = 0.125  # difference in λN below which circles count as one
SAME_CENTRE = 0.5  # λN: size of the cells within which centres count as one
NEXT = 0.3  # λN: least difference of radii between circles whose ringing may be in phase


def circles(edges: Edges, *, grid: Grid, nearest: float, blur: float) -> tuple[F64, F64]:
    """Return centres (n, 2) and radii (n,) of circles of radius ``nearest`` or more that are tangent to edges.

    edges : in chains; only circles whose zone about the centre reaches the grid are returned, each once
    blur  : the shortest λN, pitches

    Three edges define a circle: three successive ones, or corresponding ones in three successive parts of a repeated
    pattern, such as dashes about a point or a wheel's teeth.
    """
    found = [_in_a_row(edges, grid, nearest), _in_a_pattern(edges, grid, nearest)]
    centre, radius = (np.concatenate([part[k] for part in found]) for k in (0, 1))
    step = SAME_CIRCLE * blur
    _, place = kinds_of(np.round(centre[:, 0] / step) + 1j * np.round(centre[:, 1] / step))
    _, which = kinds_of(place + 1j * np.round(radius / step))
    first = np.unique(which, return_index=True)[1]
    return centre[first], radius[first]


def _in_a_row(edges: Edges, grid: Grid, nearest: float) -> tuple[F64, F64]:
    """Return circles tangent to successive edges of a chain.

    Every three successive edges are tangent to one circle. If the direction turns by α and β at the ends of the middle
    one, its length is ρ·(tan α/2 + tan β/2). For a round outline every three edges give the same circle.
    """
    first, middle, last = edges.threes
    normal, length = normals(edges), edges.length
    alpha, beta = _half_tangent(normal[first], normal[middle]), _half_tangent(normal[middle], normal[last])
    turns = np.minimum(np.abs(alpha), np.abs(beta)) > 0.5 * NEARLY_PARALLEL
    both = alpha + beta
    regular = turns & (np.abs(both) > NEARLY_PARALLEL)
    middle, alpha, both = middle[regular], alpha[regular], both[regular]
    signed = length[middle] / both
    seen = np.abs(signed) >= nearest
    middle, alpha, signed = middle[seen], alpha[seen], signed[seen]
    n = normal[middle]
    along = np.stack([n[:, 1], -n[:, 0]], axis=1)
    centre = edges.start[middle] + signed[:, None] * (n + alpha[:, None] * along)
    radius = np.abs(signed)
    seen = _outside(centre, grid) <= ZONE * radius
    return centre[seen], radius[seen]


def _half_tangent(before: F64, after: F64) -> F64:
    """Return the tangents (n,) of half the angles by which normals turn from one edge to the next."""
    sine = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    cosine = before[:, 0] * after[:, 0] + before[:, 1] * after[:, 1]
    tangent: F64 = sine / np.maximum(1.0 + cosine, np.finfo(float).tiny)
    return tangent


def _in_a_pattern(edges: Edges, grid: Grid, nearest: float) -> tuple[F64, F64]:
    """Return circles tangent to three edges at equal steps in their order, each with a foot point on the edge."""
    low = np.array(grid.first_centre)
    high = low + np.array([grid.cols - 1.0, grid.rows - 1.0])
    normal = normals(edges)
    offset = np.einsum("nx,nx->n", normal, edges.start)
    room = 256
    while True:
        found = np.empty((room, 3))
        count = _touched(edges.start, edges.along, edges.length, normal, offset, low, high, nearest, found)
        if count <= room:
            return found[:count, :2], found[:count, 2]
        room = count


@kernel()
def _touched(
    start: F64, along: F64, length: F64, normal: F64, offset: F64, low: F64, high: F64, nearest: float, found: F64
) -> int:
    """Write centres and radii of circles up to the array's size; return the number of all circles.

    A line n·x = h is a radius r from a centre c if n·c = h ± r, with the same sign for corresponding edges. A circle
    that repeats from edge to edge, as for a round outline, is written once.
    """
    count, edges = 0, length.size
    last_x, last_y, last_radius = 0.0, 0.0, 0.0
    for one in range(edges - 4):
        for step in range(2, min(ALIKE, (edges - 1 - one) // 2) + 1):
            two, three = one + step, one + 2 * step
            ax, ay = normal[two, 0] - normal[one, 0], normal[two, 1] - normal[one, 1]
            bx, by = normal[three, 0] - normal[two, 0], normal[three, 1] - normal[two, 1]
            area = ax * by - ay * bx
            if abs(area) <= FAR_APART * (ax * ax + ay * ay + bx * bx + by * by):
                continue
            a, b = offset[two] - offset[one], offset[three] - offset[two]
            x, y = (a * by - b * ay) / area, (ax * b - bx * a) / area
            radius = abs(normal[one, 0] * x + normal[one, 1] * y - offset[one])
            if radius < nearest:
                continue
            off_x = max(0.0, low[0] - x, x - high[0])
            off_y = max(0.0, low[1] - y, y - high[1])
            if off_x * off_x + off_y * off_y > (ZONE * radius) ** 2:
                continue
            facing = True
            for edge in (one, two, three):
                foot = along[edge, 0] * (x - start[edge, 0]) + along[edge, 1] * (y - start[edge, 1])
                if foot < 0.0 or foot > length[edge]:
                    facing = False
            known = max(abs(last_x - x), abs(last_y - y), abs(last_radius - radius)) <= AGAIN * radius
            if known or not facing:
                continue
            last_x, last_y, last_radius = x, y, radius
            if count < found.shape[0]:
                found[count, 0], found[count, 1], found[count, 2] = x, y, radius
            count += 1
    return count


def in_step(centre: F64, radius: F64, share: F64, blur: float) -> tuple[F64, I64]:
    """Return the shares (n,) of circles including those of larger concentric ones, and the centre (n,) of each.

    The ringing of all of them may be in phase; that of a larger circle counts less, since it falls as 1/r².
    """
    cell = np.floor(centre / (SAME_CENTRE * blur) + 0.137)  # an offset, since scenes have round coordinates
    _, whose = kinds_of(cell[:, 0] + 1j * cell[:, 1])
    order = np.lexsort((-radius, whose))
    r, each = radius[order], whose[order]
    first = np.append(True, each[1:] != each[:-1])
    apart = first | np.append(True, r[:-1] - r[1:] > NEXT * blur)
    strength = np.where(apart, share[order] / r**2, 0.0)
    total = np.cumsum(strength)
    before = (total - strength)[first][np.cumsum(first) - 1]
    summed = np.empty_like(share)
    summed[order] = np.maximum((total - before) * r**2, share[order])
    return summed, whose


def _outside(points: F64, grid: Grid) -> F64:
    """Return the distances (n,) of points outside the rectangle of the grid's photosite centres."""
    low = np.array(grid.first_centre)
    high = low + np.array([grid.cols - 1, grid.rows - 1])
    gap = np.maximum(np.maximum(low - points, points - high), 0.0)
    distance: F64 = np.hypot(gap[:, 0], gap[:, 1])
    return distance
