"""What photosites do to their neighbours: crosstalk and blooming; and the photosites that are broken."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from camsim.arrays import F64, I64
from camsim.errors import InvalidValueError
from camsim.sensor.cfa import Cfa
from camsim.sensor.checked import check_number
from camsim.sensor.streams import BLOCK_ROWS, Stream, generator

Places: TypeAlias = tuple[I64, I64]


@dataclass(frozen=True, slots=True)
class Crosstalk:
    """Light and charge that end in a neighbour, on the mean.

    kernel : 3 × 3 fractions; kernel[1 + i][1 + j] of a photosite's charge ends in the photosite i rows below and
             j columns to the right of it. Together at most 1 (what is missing is lost).

    >>> one = np.zeros((5, 5))
    >>> one[2, 2] = 100.0
    >>> Crosstalk(((0, 0, 0), (0, 0.9, 0.1), (0, 0, 0))).apply(one)[1]
    array([ 0., 90., 10.])
    """

    kernel: tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]

    def __post_init__(self) -> None:
        kernel: object = tuple(tuple(float(f) for f in row) for row in self.kernel)
        object.__setattr__(self, "kernel", kernel)
        if len(self.kernel) != 3 or any(len(row) != 3 for row in self.kernel):
            raise InvalidValueError("crosstalk: kernel must be 3 rows of 3 fractions")
        for fraction in (f for row in self.kernel for f in row):
            check_number("crosstalk", "kernel", fraction, largest=1.0)
        total = math.fsum(f for row in self.kernel for f in row)
        if total > 1.0 + 1e-9:
            raise InvalidValueError(
                f"crosstalk: kernel adds up to {total:.6g}; a photosite cannot give away more than it gets, at most 1"
            )

    def apply(self, electrons: F64) -> F64:
        """Return (rows, cols) mean charge of (rows + 2, cols + 2): the window with one photosite more all round."""
        rows, cols = electrons.shape[0] - 2, electrons.shape[1] - 2
        mixed = np.zeros((rows, cols))
        for i, row in enumerate(self.kernel):
            for j, fraction in enumerate(row):
                if fraction:
                    # What comes from above left was sent to below right.
                    mixed += fraction * electrons[2 - i : 2 - i + rows, 2 - j : 2 - j + cols]
        return mixed

    def mixing(self, cfa: Cfa) -> F64:
        """Return (channels, channels): what a photosite of a channel gets of its own and of the others, on flat light.

        The mean over all photosites of the channel: a lopsided kernel tells the greens of two rows apart.

        >>> Crosstalk(((0, 0.01, 0), (0.01, 0.96, 0.01), (0, 0.01, 0))).mixing(Cfa.bayer("RGGB")).round(2).tolist()
        [[0.96, 0.04, 0.0], [0.02, 0.96, 0.02], [0.0, 0.04, 0.96]]
        """
        mixing: F64 = np.einsum("ij,kijc->kc", np.array(self.kernel), _senders(cfa))
        return mixing

    def seen_by(self, channel: int, planes: F64, cfa: Cfa) -> F64:
        """Return (rows, cols) mean charge that a photosite of ``channel`` would collect at every place.

        Its neighbours are those that such a photosite has in the array, on the average of its places there.

        planes : (channels, rows + 2, cols + 2) mean charge that each channel's filter lets through
        """
        rows, cols = planes.shape[1] - 2, planes.shape[2] - 2
        seen = np.zeros((rows, cols))
        for (i, j, sender), share in np.ndenumerate(_senders(cfa)[channel]):
            if share * self.kernel[i][j]:
                seen += share * self.kernel[i][j] * planes[sender, 2 - i : 2 - i + rows, 2 - j : 2 - j + cols]
        return seen


def _senders(cfa: Cfa) -> F64:
    """Return (channels, 3, 3, channels): how often what reaches a channel's photosites by kernel[i][j] is of which."""
    index, count = cfa.channel_index(*cfa.period), len(cfa.channels)
    shares = np.empty((count, 3, 3, count))
    for i, j in np.ndindex(3, 3):
        sent = np.roll(index, (i - 1, j - 1), axis=(0, 1))
        for channel in range(count):
            shares[channel, i, j] = np.bincount(sent[index == channel], minlength=count)
    shares /= shares.sum(axis=-1, keepdims=True)
    return shares


@dataclass(frozen=True, slots=True)
class Blooming:
    """Charge above the full well that runs up and down its column, as in a CCD without drains.

    spill : the fraction of it that runs on, half of it upwards; the rest is drained. 0..1

    Charge that leaves the window is lost, and none comes in from outside.
    """

    spill: float = 1.0

    def __post_init__(self) -> None:
        check_number("blooming", "spill", self.spill, largest=1.0)

    def apply(self, electrons: F64, *, capacity_e: float) -> F64:
        """Return the charge of a whole window (rows, cols), nowhere above ``capacity_e``.

        >>> Blooming().apply(np.array([[0.0], [150.0], [30.0]]), capacity_e=100.0).ravel()
        array([ 25., 100.,  55.])
        """
        held = np.minimum(electrons, capacity_e)
        running = (0.5 * self.spill) * (electrons - held)
        if not running.any():
            return held
        for order in (range(len(held)), range(len(held) - 1, -1, -1)):
            carried = np.zeros(held.shape[1])
            for row in order:
                taken = np.minimum(carried, capacity_e - held[row])
                held[row] += taken
                carried += running[row] - taken
        return held


@dataclass(frozen=True, slots=True, kw_only=True)
class Defects:
    """Hot photosites (with a dark current of their own) and dead ones (blind), by share and by list.

    hot_fraction  : share of all photosites that are hot, drawn from the sensor's serial number
    hot_e_per_s   : their mean dark current; it is distributed exponentially
    dead_fraction : share that sees no light
    hot           : (row, col, e_per_s) of the full frame, besides those drawn
    dead          : (row, col) of the full frame, besides those drawn
    """

    hot_fraction: float = 0.0
    hot_e_per_s: float = 0.0
    dead_fraction: float = 0.0
    hot: tuple[tuple[int, int, float], ...] = ()
    dead: tuple[tuple[int, int], ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "hot", tuple((int(r), int(c), float(e)) for r, c, e in self.hot))
        object.__setattr__(self, "dead", tuple((int(r), int(c)) for r, c in self.dead))
        check_number("defects", "hot_fraction", self.hot_fraction, largest=1.0)
        check_number("defects", "dead_fraction", self.dead_fraction, largest=1.0)
        check_number("defects", "hot_e_per_s", self.hot_e_per_s)
        if self.hot_fraction + self.dead_fraction > 1.0:
            raise InvalidValueError("defects: hot_fraction and dead_fraction are more than 1 together")
        for row, col, e_per_s in self.hot:
            check_number("defects", f"hot e_per_s of ({row}, {col})", e_per_s)
        for row, col in (*((r, c) for r, c, _ in self.hot), *self.dead):
            if row < 0 or col < 0:
                raise InvalidValueError(f"defects: photosite ({row}, {col}); rows and columns count from 0")

    def within(
        self, *, serial: int, shape: tuple[int, int], origin: tuple[int, int], frame_cols: int
    ) -> tuple[Places, F64, Places]:
        """Return the hot photosites of a window, their currents in e⁻/s, and the dead ones: rows and columns in it.

        serial     : of the sensor, which says where they are
        origin     : (row, col) of the window's first photosite in the full frame
        frame_cols : width of the full frame
        """
        hot = [np.array(self.hot, dtype=np.float64).reshape(-1, 3)]
        dead = [np.array(self.dead, dtype=np.int64).reshape(-1, 2)]
        if self.hot_fraction or self.dead_fraction:
            for block in range(max(origin[0], 0) // BLOCK_ROWS, (origin[0] + shape[0] - 1) // BLOCK_ROWS + 1):
                drawn_hot, drawn_dead = self._drawn(serial, block, frame_cols)
                hot.append(drawn_hot)
                dead.append(drawn_dead)
        all_hot, all_dead = np.concatenate(hot), np.concatenate(dead)
        hot_places, current = _inside(all_hot[:, :2].astype(np.int64), shape, origin), all_hot[:, 2]
        dead_places = _inside(all_dead, shape, origin)
        return hot_places[1], current[hot_places[0]], dead_places[1]

    def _drawn(self, serial: int, block: int, frame_cols: int) -> tuple[F64, I64]:
        """Return (row, col, e_per_s) and (row, col) of a block of rows: how many, then where, then how hot."""
        rng = generator(serial, Stream.DEFECTS, block=block)
        photosites = BLOCK_ROWS * frame_cols
        hot_count = int(rng.binomial(photosites, self.hot_fraction))
        dead_count = min(int(rng.binomial(photosites, self.dead_fraction)), photosites - hot_count)
        index = rng.choice(photosites, hot_count + dead_count, replace=False)
        places = np.stack([block * BLOCK_ROWS + index // frame_cols, index % frame_cols], axis=1)
        current = rng.exponential(1.0, hot_count) * self.hot_e_per_s
        return np.column_stack([places[:hot_count], current]), places[hot_count:]


def _inside(places: I64, shape: tuple[int, int], origin: tuple[int, int]) -> tuple[npt.NDArray[np.bool_], Places]:
    """Return which places of the full frame lie in a window, and where in it."""
    row, col = places[:, 0] - origin[0], places[:, 1] - origin[1]
    inside = (row >= 0) & (row < shape[0]) & (col >= 0) & (col < shape[1])
    return inside, (row[inside], col[inside])
