"""What far edges give a photosite by the spikes of a pupil with straight sides."""

from __future__ import annotations

from typing import NamedTuple

from camsim.arrays import F64, I64, U8
from camsim.kernels import kernel
from camsim.quadrature import gauss_legendre

GRAZES = 0.01  # of how far the taper begins from there, or its width: a spike's own along an edge, which then is felt
NEAR = 0.5  # of the distance from the crossing or from the photosite: the longest panel
HEM_PART = 0.2  # of the taper: the longest panel within it
_X, _W = gauss_legendre(6)


class Far(NamedTuple):
    """Edges seen from the first photosite, pitches."""

    start: F64
    end: F64
    pair: I64


class Profiles(NamedTuple):
    """The light across spikes, each summed over wavelengths for every pair of spectra and channel.

    running : (sides, pairs, channels, cells, 6) from −half to half of all, as quintics
    tail    : (sides, pairs, channels, 2) half of all; and what is missing of it, times the distance
    first, step : (sides,) where the cells begin, and their width, pitches;  middle, width: of the spike
    """

    running: F64
    tail: F64
    first: F64
    step: F64
    middle: F64
    width: F64


class Side(NamedTuple):
    """The same of one side, pair and channel."""

    cells: F64  # (cells, 6)
    tail: F64  # (2,)
    first: float
    step: float
    middle: float
    width: float


class Ways(NamedTuple):
    """Both ways of every side's spike, in turn.

    along, across : (ways, 2) unit vectors, the second as the side's profile runs
    moved  : (ways,) from how far along its light falls, pitches
    sign   : (ways,) 1 where across is a quarter turn from along, else −1
    gained : (ways, cells, 6) ∫(1 − taper)/(s − moved)² ds from ``begin`` on, as quintics;  begin, step: of its cells
    whole  : (ways,) all that is gained, to infinity
    """

    along: F64
    across: F64
    moved: F64
    sign: F64
    gained: F64
    begin: F64
    step: F64
    whole: F64


@kernel(forceinline=True)
def _quintic(c: F64, t: float) -> float:
    value: float = c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))))
    return value


@kernel()
def _gained(s: float, ways: Ways, way: int) -> float:
    u = (s - ways.begin[way]) / ways.step[way]
    if u <= 0.0:
        return 0.0
    cells = ways.gained.shape[1]
    if u >= cells:
        all_but: float = ways.whole[way] - 1.0 / (s - ways.moved[way])
        return all_but
    gained: float = _quintic(ways.gained[way, int(u)], u - int(u))
    return gained


@kernel()
def _density(s: float, ways: Ways, way: int) -> float:
    """Return (1 − taper)/(s − moved)²."""
    u = (s - ways.begin[way]) / ways.step[way]
    if u <= 0.0:
        return 0.0
    if u >= ways.gained.shape[1]:
        bare: float = 1.0 / (s - ways.moved[way]) ** 2
        return bare
    c, t = ways.gained[way, int(u)], u - int(u)
    slope: float = c[1] + t * (2.0 * c[2] + t * (3.0 * c[3] + t * (4.0 * c[4] + t * 5.0 * c[5])))
    density: float = slope / ways.step[way]
    return density


@kernel()
def _running(t: float, side: Side) -> float:
    """Return what lies across a spike up to a place, less half of all."""
    u = (t - side.first) / side.step
    if 0.0 <= u < len(side.cells):
        inside: float = _quintic(side.cells[int(u)], u - int(u))
        return inside
    away = t - side.middle
    value: float = (side.tail[0] if away > 0.0 else -side.tail[0]) - side.tail[1] / away
    return value


@kernel()
def _grazed(s1: float, t1: float, s2: float, t2: float, ways: Ways, way: int, side: Side) -> float:
    """Integrate along an edge that runs beside a spike: by parts, with panels that close in on the crossing."""
    slope = (s2 - s1) / (t2 - t1)
    total: float = _gained(s2, ways, way) * _running(t2, side)
    total -= _gained(s1, ways, way) * _running(t1, side)
    crossing, finest = s1 + (side.middle - t1) * slope, NEAR * side.width * abs(slope)
    hem = ways.begin[way], ways.begin[way] + ways.step[way] * ways.gained.shape[1]
    low, high = max(min(s1, s2), ways.begin[way]), max(s1, s2)
    part = 0.0
    while low < high:
        # By half of how far the crossing is, and the photosite; within the taper by a part of it.
        reach = min(max(finest, NEAR * abs(low - crossing)), NEAR * low)
        if low < hem[1]:
            reach = min(reach, HEM_PART * (hem[1] - hem[0]))
        stop = min(high, low + reach)
        half = 0.5 * (stop - low)
        for q in range(_X.size):
            s = low + half * (1.0 + _X[q])
            t = side.middle + (s - crossing) / slope
            part += half * _W[q] * _density(s, ways, way) * _running(t, side)
        low = stop
    return total - part if s2 >= s1 else total + part


@kernel(error_model="numpy")
def add_spikes(
    begin: int, stop: int, far: Far, profiles: Profiles, ways: Ways, origin: F64, channel: U8, image: F64
) -> None:
    """Add to photosites (images, rows, cols), counted row by row, what edges give them; each in its own channel."""
    cols = image.shape[2]
    rows = image.shape[1]
    for job in range(begin, stop):
        picture, place = job // (rows * cols), job % (rows * cols)
        row, col = place // cols, place % cols
        x, y, own = origin[0] + col, origin[1] + row, channel[picture, row, col]
        total = 0.0
        for e in range(len(far.pair)):
            ax, ay = x - far.start[e, 0], y - far.start[e, 1]
            bx, by = x - far.end[e, 0], y - far.end[e, 1]
            for way in range(len(ways.sign)):
                dx, dy = ways.along[way, 0], ways.along[way, 1]
                s1, s2 = ax * dx + ay * dy, bx * dx + by * dy
                if s1 <= ways.begin[way] and s2 <= ways.begin[way]:
                    continue
                t1 = ax * ways.across[way, 0] + ay * ways.across[way, 1]
                t2 = bx * ways.across[way, 0] + by * ways.across[way, 1]
                if t1 == t2:
                    continue
                k = way // 2
                side = Side(
                    profiles.running[k, far.pair[e], own],
                    profiles.tail[k, far.pair[e], own],
                    profiles.first[k],
                    profiles.step[k],
                    profiles.middle[k],
                    profiles.width[k],
                )
                nearest = min(max(side.middle, min(t1, t2)), max(t1, t2))
                slope = (s2 - s1) / (t2 - t1)
                s = s1 + (nearest - t1) * slope
                hem = ways.step[way] * ways.gained.shape[1]
                changes = abs(slope) * side.width > GRAZES * max(abs(s - ways.begin[way]), hem)
                if changes and side.width > GRAZES * abs(nearest - side.middle):
                    part = _grazed(s1, t1, s2, t2, ways, way, side)
                else:
                    part = (_running(t2, side) - _running(t1, side)) * _gained(s, ways, way)
                total += ways.sign[way] * part
        image[picture, row, col] += total
