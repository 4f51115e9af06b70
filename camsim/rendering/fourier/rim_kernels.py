"""What far edges give photosites by the smooth light of a pupil's rim."""

from __future__ import annotations

import math
from typing import NamedTuple

from camsim.arrays import F64, I64
from camsim.kernels import kernel
from camsim.quadrature import gauss_legendre

STEP_RAD, PANELS, HEM_PANELS = 0.12, 16.0, 8.0  # of a panel: in angle; of 1/r as far as the taper; and within it
PAD = 24  # cells of a spline beyond either end of 1/r: what lies beyond those is heard 0.43 times as much a cell
_X, _W = gauss_legendre(10)


class Gained(NamedTuple):
    """∫(1 − taper)·light·r dr from a photosite outwards, by direction and by 1/r: coefficients of quintic B-splines.

    splines : (pairs, directions, PAD + cells + 1 + PAD), directions even ones from x on
    most    : the largest 1/r, per pitch, at cell number ``PAD + cells``;  inner, outer: of the taper, pitches
    """

    splines: F64
    most: float
    inner: float
    outer: float


@kernel()
def panel_of(inner: float, outer: float) -> float:
    """Return the most of 1/r that a panel goes along, about a taper."""
    return min(1.0 / (PANELS * inner), (1.0 / inner - 1.0 / outer) / HEM_PANELS)


@kernel(allocates=True)
def add_rim(
    gained: Gained, start: F64, end: F64, pair: I64, places: F64, weight: float, image: F64, begin: int, stop: int
) -> None:
    """Add what edges give photosites (n,) by some of their places (n, m, 2), each of the same weight.

    A region's light is ∮ of what is gained from the photosite to the outline, over the angle that this sweeps.
    """
    for k in range(begin, stop):
        total = 0.0
        for place in range(places.shape[1]):
            for e in range(len(start)):
                ax, ay = start[e, 0] - places[k, place, 0], start[e, 1] - places[k, place, 1]
                bx, by = end[e, 0] - places[k, place, 0], end[e, 1] - places[k, place, 1]
                low, high = _within(ax, ay, bx, by, gained.inner)
                if low >= high:
                    total += _swept(gained, gained.splines[pair[e]], ax, ay, bx, by)
                    continue
                if low > 0.0:
                    total += _swept(gained, gained.splines[pair[e]], ax, ay, ax + low * (bx - ax), ay + low * (by - ay))
                if high < 1.0:
                    total += _swept(
                        gained, gained.splines[pair[e]], ax + high * (bx - ax), ay + high * (by - ay), bx, by
                    )
        image[k] += weight * total


@kernel()
def _within(ax: float, ay: float, bx: float, by: float, half: float) -> tuple[float, float]:
    """Return at which shares of its way a line enters the square of so much to either side, and leaves it."""
    low, high = 0.0, 1.0
    for a, b in ((ax, bx), (ay, by)):
        along = b - a
        if along == 0.0:
            if abs(a) > half:
                return 1.0, 0.0
            continue
        one, two = (-half - a) / along, (half - a) / along
        low, high = max(low, min(one, two)), min(high, max(one, two))
    return low, high


@kernel(allocates=True)
def _swept(gained: Gained, spline: F64, ax: float, ay: float, bx: float, by: float) -> float:
    """Return ∫ of what is gained over the angle between two places, along the line from one to the other."""
    ex, ey = bx - ax, by - ay
    length = math.hypot(ex, ey)
    if length == 0.0:
        return 0.0
    ex, ey = ex / length, ey / length
    across, along = ax * ey - ay * ex, ax * ex + ay * ey  # the foot lies at (ey, −ex)·across
    distance = abs(across)
    if distance == 0.0:
        return 0.0
    # From the foot on by angles: tan is the way along over the distance, 1/r the cosine over it.
    first, last = math.atan2(along, distance), math.atan2(along + length, distance)
    if first >= last:
        return 0.0  # all but edge on, where cosines are nothing but rounding
    near = 1.0 if first <= 0.0 <= last else max(math.cos(first), math.cos(last))
    step = panel_of(gained.inner, gained.outer)
    changed = min((2.0 * near - math.cos(first) - math.cos(last)) / distance, 2.0 * gained.most)  # there and back
    panels = math.ceil((last - first) / STEP_RAD + changed / step)
    foot = math.atan2(-ex * across, ey * across)
    way = 1.0 if across > 0.0 else -1.0  # counter-clockwise where the photosite lies to the left
    half, total = 0.5 * (last - first) / panels, 0.0
    for panel in range(panels):
        for q in range(len(_X)):
            angle = first + half * (2.0 * panel + 1.0 + _X[q])
            total += _W[q] * _looked_up(gained, spline, math.cos(angle) / distance, foot + way * angle)
    return way * half * total


@kernel(forceinline=True)
def _quintic(t: float) -> tuple[float, float, float, float, float, float]:
    """Return the six quintic B-splines about a place, a share ``t`` of a cell beyond the third one's middle."""
    s = 1.0 - t
    t2, s2 = t * t, s * s
    return (
        s2 * s2 * s / 120.0,
        (26.0 + t * (-50.0 + t * (20.0 + t * (20.0 + t * (-20.0 + 5.0 * t))))) / 120.0,
        (66.0 + t2 * (-60.0 + t2 * (30.0 - 10.0 * t))) / 120.0,
        (66.0 + s2 * (-60.0 + s2 * (30.0 - 10.0 * s))) / 120.0,
        (26.0 + s * (-50.0 + s * (20.0 + s * (20.0 + s * (-20.0 + 5.0 * s))))) / 120.0,
        t2 * t2 * t / 120.0,
    )


@kernel(forceinline=True)
def _looked_up(gained: Gained, spline: F64, over_r: float, angle_rad: float) -> float:
    """Return what is gained at 1/r, in a direction of the scene: light from there falls the opposite way."""
    directions, columns = spline.shape
    u = min(over_r / gained.most, 1.0) * (columns - 1 - 2 * PAD) + PAD
    v = (angle_rad / math.tau + 0.5) * directions
    i, j = math.floor(u), math.floor(v)
    across, round_about = _quintic(u - i), _quintic(v - j)
    total = 0.0
    for b in range(6):
        row = (j + b - 2) % directions
        own = 0.0
        for a in range(6):
            own += across[a] * spline[row, i + a - 2]
        total += round_about[b] * own
    return total
