"""Photosites to check: where each method is at its limit. A pure function of the inputs."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from camsim.core.arrays import F64, I64, kinds_of, picked
from camsim.numerics.quadrature import GOLDEN
from camsim.rendering.direct.records import Outlines
from camsim.rendering.engine import Marks
from camsim.rendering.grid import Grid
from camsim.rendering.waves.image import tiles

MOST = 256  # photosites, however long the rendering takes
SHARE_OF_TIME, SECONDS = 0.04, 2e-3  # time of the check: over that of the rendering, and at least
PLACE_SECONDS = 6e-5  # to select a photosite


def how_many(photosites: int, *, render_seconds: float, check_seconds: float, fewest: int) -> int:
    """Return how many photosites are checked, from the expected seconds of the rendering and of one photosite."""
    seconds = max(SHARE_OF_TIME * render_seconds, SECONDS)
    return min(photosites, MOST, max(fewest, int(seconds / (check_seconds + PLACE_SECONDS))))


def hardest_photosites(outlines: Outlines, more: F64, grid: Grid, marks: Marks, *, count: int) -> tuple[I64, I64]:
    """Return rows and columns of ``count`` photosites to check (all of a smaller grid), none twice.

    more : (n, 2) places of pictures, gradients and points, the most difficult first

    The places take turns: a corner; next to the end of a part, from just beyond the near radius to past the cutoff
    radius of the end; next to the middle of a part, within the table of the edge response, at its end or beyond;
    a corner of a tile just far enough from a corner of the scene to be interpolated, or a corner of the frame; the
    centre of a round part, where its ringing adds up, or where one leaves the frame and an engine's sides grow; one of
    ``more``; and quasi-random places.
    """
    photosites = grid.rows * grid.cols
    count = min(count, photosites)
    first, size = np.array(grid.first_centre), np.array([grid.cols, grid.rows])
    borders = first + np.array([(col, row) for row, col, _, _ in tiles((grid.rows, grid.cols))][1:]).reshape(-1, 2)
    more = np.concatenate([more, borders])
    # The end of a part; of an arc a place at most a third of a turn away.
    ends = outlines.at(0.0), outlines.at(np.minimum(1.0, math.tau / 3.0 / np.maximum(outlines.turn_rad, 1e-9)))
    bent = picked(outlines, outlines.turn_rad != 0.0)
    middles = (_middles(bent, grid), _leaving(bent, grid)) if len(bent.x) else ()
    spots: dict[tuple[int, int], None] = {}
    for turn in range(2 * count):
        if len(spots) >= count:
            break
        places = [more[turn : turn + 1]]
        if len(outlines.x):
            places.append(_hard_points(ends, middles, marks, grid, turn))
        one = np.clip(np.round(np.concatenate(places) - first), 0, size - 1).astype(int)
        spots |= dict.fromkeys((row, col) for col, row in one.tolist())
    place = 0.0
    while len(spots) < count:
        place = (place + GOLDEN) % 1.0
        spots.setdefault(divmod(int(place * photosites), grid.cols), None)
    chosen = np.array(list(spots)[:count])
    return chosen[:, 0], chosen[:, 1]


def _middles(bent: Outlines, grid: Grid) -> F64:
    """Return the centres (n, 2) of round parts in a frame, where ringing adds up, by decreasing total angle."""
    found, index = kinds_of(np.round(bent.x + 1j * bent.y, 9))
    turn_rad = np.bincount(index, np.abs(bent.turn_rad), found.size)
    places = found.view(np.float64).reshape(-1, 2)
    low = np.array(grid.first_centre) - 0.5
    seen = np.all((places >= low) & (places <= low + np.array([grid.cols, grid.rows])), axis=1)
    best: F64 = places[seen][np.argsort(-turn_rad[seen], kind="stable")]
    return best


def _normal(along: F64) -> F64:
    """Return the unit vector to the left of a vector; an arbitrary one for zero, as of an arc shorter than rounding."""
    length = float(np.hypot(*along))
    return np.array([-along[1], along[0]]) / length if length else np.array([0.0, 1.0])


def _leaving(bent: Outlines, grid: Grid) -> F64:
    """Return where round parts cross the frame's border (n, 2)."""
    low = np.array(grid.first_centre) - 0.5
    high, found = low + np.array([grid.cols, grid.rows]), [np.empty((0, 2))]
    for axis, border in ((0, low[0]), (0, high[0]), (1, low[1]), (1, high[1])):
        some = picked(bent, np.abs(border - (bent.x, bent.y)[axis]) < bent.dx)
        middle = np.stack([some.x, some.y], axis=1)
        along = border - middle[:, axis]
        for side in (1.0, -1.0):
            place = middle.copy()
            place[:, axis] = border
            place[:, 1 - axis] += side * np.sqrt((some.dx - along) * (some.dx + along))
            out = place - middle
            gone = np.sign(some.turn_rad) * (np.arctan2(out[:, 1], out[:, 0]) - some.from_rad) % math.tau
            on = (gone <= np.abs(some.turn_rad)) & np.all((place >= low - 1e-9) & (place <= high + 1e-9), axis=1)
            found.append(place[on])
    return np.concatenate(found)


def _hard_points(ends: tuple[F64, F64], middles: Sequence[F64], marks: Marks, grid: Grid, turn: int) -> F64:
    """Return four difficult points (4, 2), pitches; turns step through the parts by the golden ratio.

    middles : centres of round parts, and where they leave the frame
    """
    part = _part(turn, len(ends[0]))
    a, b = ends[0][part], ends[1][part]
    normal = _normal(b - a) * (1.0 if turn % 2 else -1.0)
    x0, y0 = grid.first_centre
    fraction = (turn * GOLDEN) % 1.0
    width, height = grid.cols - 1, grid.rows - 1
    fourth = np.array([x0 + fraction * width, y0 + (fraction * math.e * 7.0) % 1.0 * height])
    if turn % 4 == 0:
        corner = _tile_corner(ends[0], marks, grid, turn)
        fourth = np.array([x0 + (turn % 2) * width, y0 + (turn // 2 % 2) * height]) if corner is None else corner
    elif turn % 4 < 3 and (some := [one for one in middles if len(one)]):
        one = some[(turn + 1) % len(some)]
        fourth = one[turn // 4 % len(one)]
    distance = (0.97 * marks.reach, 0.3, 1.03 * marks.reach, 0.5 * marks.reach)[turn % 4]
    near_middle = a + (0.45 + 0.09 * (turn % 5)) * (b - a) + distance * normal
    # Beyond the near radius wherever photosites lie; later turns reach the cutoff radius of the end.
    off = math.ceil(1.02 * marks.near) + fraction * max(0.0, 1.1 * marks.quiet - marks.near)
    return np.array([a, a + off * normal, near_middle, fourth])


def _part(turn: int, parts: int) -> int:
    return int((turn * GOLDEN) % 1.0 * parts)


def _tile_corner(start: F64, marks: Marks, grid: Grid, turn: int) -> F64 | None:
    """Return a corner of a tile just far enough from a corner of the scene to be interpolated; None outside the frame.

    start : (n, 2) corners of the scene;  turn: steps through them and through tiles to all four sides
    """
    first = np.array(grid.first_centre)
    picked = start[_part(turn, len(start))] - (first - 0.5)
    tile, (side, axis) = np.floor(picked / marks.leaf) * marks.leaf, divmod(turn // 4 % 4, 2)
    far = marks.apart if side else -marks.apart
    tile[axis] = np.ceil((picked[axis] + far) / marks.leaf) * marks.leaf - (0 if side else 1)
    return first + tile if np.all((tile >= 0) & (tile < [grid.cols, grid.rows])) else None
