"""Tiles of a window, and places in each whose patterns stand for all that lie between.

A pattern is a smooth function of the place, so is the image at a fixed scene: between Chebyshev places it is
interpolated. What that loses of any scene of contrast 1 is at most half of what the interpolated pattern and the right
one differ by, all over: ½·∫|ΔP|. So the patterns' own Chebyshev series along x and y through the hardest tiles say how
many places it takes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from camsim.arrays import F64
from camsim.errors import UnsupportedError
from camsim.kept import cached_property
from camsim.kernels import shared
from camsim.optics.protocols import Placed, Varies
from camsim.products import product
from camsim.quadrature import GOLDEN
from camsim.rendering.across.hardest import asked
from camsim.rendering.grid import Grid

SERIES = 12  # terms of a pattern's series
ALONG = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32)  # tiles along the longer side
SMALLEST, SINGLY = 8, 64  # photosites along a tile; so many may each be one
PLACE_SECONDS, PHOTOSITE_SECONDS = 0.1, 1e-7  # of one place's image: its pattern, and each photosite
ACROSS = (32, 64, 128, 256)  # samples across the pupil
TURN = 0.25  # waves between neighbouring samples
ROUNDING = 1e-11  # of all light: series fall no further
STEADY = 0.9  # from term to term: what falls less is not followed
LOOKED_AT = 25  # places along either side of a window at which wavefronts are compared
# There, of the pupil: in steps of the golden section, as sin mθ is nothing on even ones, each for as much of its area.
_ANGLE, _RADIUS = 2.0 * math.pi * GOLDEN * np.arange(24), np.sqrt((np.arange(24) + 0.5) / 24)
ASKED = _RADIUS * np.cos(_ANGLE), _RADIUS * np.sin(_ANGLE)
AT_ONCE = 4  # patterns, on threads of their own
TAKEN = 1 << 13  # samples of patterns whose series are made at a time: what stays in a cache
PADDED = 4  # times the pupil: samples of a pattern, λN/4 apart


class Tile(NamedTuple):
    """Rows and columns of a window."""

    row: int
    col: int
    rows: int
    cols: int

    def grid(self, grid: Grid) -> Grid:
        """Return the tile as a window of the frame."""
        row, col = grid.origin
        frame = grid.frame or (grid.rows, grid.cols)
        return Grid(
            rows=self.rows,
            cols=self.cols,
            pitch_um=grid.pitch_um,
            origin=(row + self.row, col + self.col),
            frame=frame,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Lattice:
    """Tiles, and how many places along x and y each has.

    bound : on what interpolation loses, of full contrast
    """

    tiles: tuple[Tile, ...]
    counts: tuple[int, int]
    bound: float

    @property
    def gain(self) -> float:
        """By how much errors of the places' images may grow when they are combined: Lebesgue's constants."""
        return lebesgue(self.counts[0]) * lebesgue(self.counts[1])

    def places_um(self, tile: Tile, grid: Grid) -> Iterator[tuple[int, int, float, float]]:
        """Yield the places of a tile: number along x, along y, and x and y."""
        axes = axes_um(tile, grid)
        across, down = (a.mean() + 0.5 * np.ptp(a) * nodes(n) for a, n in zip(axes, self.counts, strict=True))
        for j, y_um in enumerate(down):
            for i, x_um in enumerate(across):
                yield i, j, float(x_um), float(y_um)

    def weights(self, tile: Tile) -> tuple[F64, F64]:
        """Return weights (cols, places along x) and (rows, places along y) of a tile's photosites."""

        def along(count: int, size: int) -> F64:
            return cardinal(count, np.linspace(-1.0, 1.0, size) if size > 1 else np.zeros(1))

        return along(self.counts[0], tile.cols), along(self.counts[1], tile.rows)


def nodes(count: int) -> F64:
    """Return Chebyshev's nodes on −1 … 1."""
    places: F64 = -np.cos(math.pi * (np.arange(count) + 0.5) / count)
    return places


def cardinal(count: int, places: F64) -> F64:
    """Return (places, nodes) values of the polynomials that are 1 at one of Chebyshev's nodes and 0 at the others."""
    # Places may lie beyond −1 … 1.
    at_nodes, at_places = (np.polynomial.chebyshev.chebvander(x, count - 1) for x in (nodes(count), places))
    at_places[:, 0] *= 0.5
    values: F64 = 2.0 / count * np.einsum("pd,nd->pn", at_places, at_nodes)
    return values


def lebesgue(count: int) -> float:
    """Return the most that interpolation from so many of Chebyshev's nodes multiplies errors by.

    >>> [round(lebesgue(n), 2) for n in (1, 2, 3)]
    [1.0, 1.41, 1.67]
    """
    return float(np.abs(cardinal(count, np.linspace(-1.0, 1.0, 201))).sum(axis=1).max())


def axes_um(tile: Tile, grid: Grid) -> tuple[F64, F64]:
    """Return x and y of the tile's columns and rows, µm."""
    x0, y0 = tile.grid(grid).first_centre
    across = (x0 + np.arange(tile.cols, dtype=np.float64)) * grid.pitch_um
    down = (y0 + np.arange(tile.rows, dtype=np.float64)) * grid.pitch_um
    return across, down


def lattice_for(lens: Varies, grid: Grid, wavelength_nm: float, allowed: float) -> Lattice:
    """Return the tiles and places that keep below what is allowed and take least.

    wavelength_nm : the shortest that matters
    """
    best: tuple[float, Lattice] | None = None
    changes, count = _Changes(lens=lens, grid=grid, wavelength_nm=wavelength_nm), grid.rows * grid.cols
    singly, followed = count * (PLACE_SECONDS + PHOTOSITE_SECONDS), count <= SINGLY
    for along in ALONG:
        tiles = _tiles(grid, along)
        each = PLACE_SECONDS * len(tiles) + PHOTOSITE_SECONDS * count  # of a place in every tile
        ends, found = _counted(tiles, changes, allowed, singly / each)
        followed = followed or ends
        if found is not None:
            places = math.prod(found.counts)
            seconds = places * each
            if best is not None and seconds >= best[0]:
                break
            best = seconds, found
            if places == 1:
                return found
        if max(tiles[0].rows, tiles[0].cols) <= SMALLEST:
            break
    if singly < best[0] if best is not None else followed:
        return one_by_one(grid)
    if best is None:
        raise UnsupportedError(
            f"its pattern changes too quickly over the frame: {SERIES} places along {SMALLEST} photosites do not "
            f"follow it; give it fewer waves, ask for less, or render no more than {SINGLY} photosites at a time",
            key="lens",
        )
    return best[1]


def one_by_one(grid: Grid) -> Lattice:
    """Return a lattice of every photosite by itself, with the pattern of its own place."""
    return Lattice(tiles=_tiles(grid, max(grid.rows, grid.cols)), counts=(1, 1), bound=0.0)


def _tiles(grid: Grid, along: int) -> tuple[Tile, ...]:
    """Return tiles that are about square, so many along the longer side."""
    side = max(grid.rows, grid.cols) / along
    cuts = [
        np.linspace(0, size, max(1, min(size, round(size / side))) + 1).round().astype(int).tolist()
        for size in (grid.rows, grid.cols)
    ]
    return tuple(
        Tile(top, left, bottom - top, right - left)
        for top, bottom in zip(cuts[0][:-1], cuts[0][1:], strict=True)
        for left, right in zip(cuts[1][:-1], cuts[1][1:], strict=True)
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Changes:
    """Where in a window a lens's wavefront changes."""

    lens: Varies
    grid: Grid
    wavelength_nm: float

    def _waves(self, places_um: F64) -> F64:
        """Return wavefronts (n, k) at places (n, 2), but for what they all have of a constant."""
        waves = np.stack([self.lens.at(x, y).waves(*ASKED, self.wavelength_nm) for x, y in places_um.tolist()])
        return np.asarray(waves - waves.mean(axis=1, keepdims=True))

    @cached_property
    def _all_over(self) -> tuple[F64, F64]:
        """Places of the window, and their wavefronts."""
        across, down = axes_um(Tile(0, 0, self.grid.rows, self.grid.cols), self.grid)
        x, y = (np.linspace(axis[0], axis[-1], min(LOOKED_AT, axis.size)) for axis in (across, down))
        places: F64 = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        return places, self._waves(places)

    def over(self, tile: Tile) -> tuple[float, list[float]]:
        """Return how far wavefronts of a tile lie from their mean, and where one lies the farthest."""
        (across, down), (places, waves) = axes_um(tile, self.grid), self._all_over
        own = np.array([(x, y) for x in (across[0], across.mean(), across[-1]) for y in (down[0], down[-1])])
        inside = ((places >= own.min(axis=0)) & (places <= own.max(axis=0))).all(axis=1)
        places = np.concatenate([own, places[inside]])
        waves = np.concatenate([self._waves(own), waves[inside]])
        off = np.abs(waves - waves.mean(axis=0)).max(axis=1)
        return float(off.max()), places[int(np.argmax(off))].tolist()


def _counted(tiles: tuple[Tile, ...], changes: _Changes, allowed: float, most: float) -> tuple[bool, Lattice | None]:
    """Return whether the series end, and the fewest places that keep below what is allowed.

    most : places of a tile; as soon as it is sure to have more it is not looked for how many
    """
    lens, wavelength_nm, lost = changes.lens, changes.wavelength_nm, np.zeros((2, SERIES))

    def far(tile: Tile) -> float:
        across, down = axes_um(tile, changes.grid)
        return math.hypot(across.mean(), down.mean())

    for tile in asked(tiles, far=far, change=lambda tile: changes.over(tile)[0]):
        axes = axes_um(tile, changes.grid)
        middle = [float(axis.mean()) for axis in axes]
        # Along x and y through the middle, and through where the wavefront is another than elsewhere.
        for through in (middle, changes.over(tile)[1]):
            for k, axis in enumerate(axes):
                line = list(middle)
                line[1 - k] = through[1 - k]
                lost[k] = np.maximum(lost[k], _lost(lens, line, k, 0.5 * float(np.ptp(axis)), wavelength_nm))
                # Whatever the other tiles are like.
                if lost[k][-1] > 0.5 * allowed:
                    return False, None
                if math.prod(np.sum(lost > 0.5 * allowed, axis=1) + 1.0) > most:
                    return True, None
    counts: list[int] = []
    for k in range(2):
        share = 0.5 * allowed / (1.0 if k == 0 else lebesgue(counts[0]))
        enough = np.flatnonzero(lost[k] <= share)
        if not enough.size:
            return False, None
        counts.append(int(enough[0]) + 1)
    bound = float(lost[0][counts[0] - 1] + lebesgue(counts[0]) * lost[1][counts[1] - 1])
    return True, Lattice(tiles=tiles, counts=(counts[0], counts[1]), bound=bound)


def _lost(lens: Varies, middle_um: list[float], axis: int, half_um: float, wavelength_nm: float) -> F64:
    """Return what interpolation along an axis from 1, 2 … SERIES places loses: twice what its series has beyond."""
    if half_um == 0.0:
        return np.zeros(SERIES)
    place, lenses = list(middle_um), []
    for node in nodes(SERIES):
        place[axis] = middle_um[axis] + half_um * float(node)
        lenses.append(lens.at(*place))
    patterns = _patterns(lenses, wavelength_nm)
    degree = np.arange(SERIES)
    cosines = np.cos(np.multiply.outer(degree, np.arccos(nodes(SERIES)))) * 2.0 / SERIES
    cosines[0] *= 0.5
    flat, series = patterns.reshape(SERIES, -1), np.zeros(SERIES)
    for first in range(0, flat.shape[1], TAKEN):
        series += 0.5 * np.abs(product(cosines, flat[:, first : first + TAKEN])).sum(axis=1)
    series[series < ROUNDING] = 0.0
    # The last terms tell how it goes on, every second of which may be 0; what does not fall is no series.
    last, before = series[-2:].max(), series[-4:-2].max()
    ratio = math.sqrt(last / max(before, 1e-300)) if last > 0.0 else 0.0
    rest = last * ratio / (1.0 - ratio) if ratio < STEADY else math.inf
    lost: F64 = 2.0 * (np.cumsum(series[::-1])[::-1] - series + rest)
    return lost


def _patterns(lenses: list[Placed], wavelength_nm: float) -> F64:
    """Return patterns (n, y, x) of light 1 in all, on one lattice."""
    for samples in ACROSS:
        axis = (2.0 * np.arange(samples) + 1.0) / samples - 1.0
        x, y = np.meshgrid(axis, axis)
        inside = np.hypot(x, y) <= 1.0
        waves = [np.where(inside, lens.waves(x, y, wavelength_nm), 0.0) for lens in (lenses[0], lenses[-1])]
        steps = [np.abs(np.diff(w, axis=k))[np.diff(inside.astype(int), axis=k) == 0] for w in waves for k in (0, 1)]
        if max(float(step.max()) for step in steps) <= TURN:
            break
    size = PADDED * samples
    out = np.empty((len(lenses), size, size))

    def work(first: int, end: int) -> None:
        for own, lens in zip(out[first:end], lenses[first:end], strict=True):
            amplitude = np.where(inside, np.exp(2j * np.pi * lens.waves(x, y, wavelength_nm)), 0.0)
            # Rows beyond the pupil are nothing, and need not be transformed.
            lines = scipy.fft.fft(amplitude, size, axis=1)
            power = np.abs(scipy.fft.fft(lines, size, axis=0, overwrite_x=True)) ** 2
            own[:] = power / power.sum()

    shared(len(lenses), work, most=AT_ONCE)
    return out
