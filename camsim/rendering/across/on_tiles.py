"""Boxes' transfers on the lattice of a band's tiles, and tiles from frequencies back to photosites."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
import scipy

from camsim.arrays import C128, F64
from camsim.kept import cached_property
from camsim.kernels import shared
from camsim.optics import OpticalSystem
from camsim.rendering.across.bands import Band
from camsim.rendering.across.ghosts import GHOSTS
from camsim.rendering.across.kernels import AFTER, BEFORE, Polar, fold, on_lattice
from camsim.rendering.across.places import Basis
from camsim.rendering.across.transfers import Transfers
from camsim.rendering.fourier.blocks import Block
from camsim.rendering.fourier.inverse import WHOLE, inverse
from camsim.rendering.fourier.lens import footprint_transfer, frequencies
from camsim.rendering.fourier.tile import Tile

Mask: TypeAlias = npt.NDArray[np.bool_]

ROWS = 16  # of a block: fewer are no work for a thread of its own
TOGETHER = 8  # frequencies whose circles are transformed at a time: what stays in a cache


@dataclass(frozen=True, kw_only=True, eq=False)
class Passed:
    """OLPF, photosite and a band's window on the lattice of its tiles, which all boxes have in common.

    keep : them for the next tiles
    """

    system: OpticalSystem
    band: Band
    pitch_um: float
    keep: bool

    @cached_property
    def _kept(self) -> dict[Block, F64]:
        return {}

    def on(self, block: Block, tile: Tile) -> F64:
        """Return them on a block (count_j, count_i, 2)."""
        return of_block(self._kept, block, functools.partial(self._made, block, tile), keep=self.keep)

    def _made(self, block: Block, tile: Tile) -> F64:
        step = self.band.step
        foot = footprint_transfer(self.system, block, tile, step * self.pitch_um)
        across, down, both = (part.view(complex)[..., 0] for part in foot)
        fx, fy = frequencies(block, tile, 1.0)
        more = across * down[:, None] * (both if both.size else 1.0) * self.band.window(np.hypot(fx, fy) / step)
        return np.ascontiguousarray(more).view(np.float64).reshape(*more.shape, 2)


def polar_of(transfers: Transfers, basis: Basis, angles: int) -> Polar:
    """Return a basis's transfers over |f| and so many angles of half a circle."""
    count = transfers.harmonics.shape[2]
    rows = np.minimum(np.ceil(basis.cuts / transfers.step).astype(int) + 1, count)
    terms, sets, most = len(basis.cuts), transfers.harmonics.shape[1], transfers.most
    values = np.zeros((BEFORE + int(rows.max()) + AFTER, angles + BEFORE + AFTER, terms, sets, 2))
    stop = min(max(int(rows.max()) + AFTER, GHOSTS.shape[1]), count)
    by_harmonic, around = transfers.made(basis.made_of, stop), values.view(complex)[..., 0]

    def half(first: int, end: int) -> C128:
        """Return half a circle and what look-ups take beside it (|f|, angles, terms, sets)."""
        own = by_harmonic[..., first:end].transpose(3, 0, 2, 1)
        spectrum = np.zeros((len(own), 2 * angles, terms, sets), complex)
        spectrum[:, : most + 1], spectrum[:, -most:] = own[:, most:], own[:, :most]
        circle = scipy.fft.ifft(spectrum, axis=1, norm="forward", overwrite_x=True)
        return np.concatenate([circle[:, -BEFORE:], circle[:, : angles + AFTER]], axis=1)

    def work(first: int, end: int) -> None:
        for low in range(first, end, TOGETHER):
            high = min(low + TOGETHER, end)
            around[BEFORE + low : BEFORE + high] = half(low, high)

    shared(min(stop, len(around) - BEFORE), work, least=TOGETHER)
    around[:BEFORE] = np.einsum("gk,k...->g...", GHOSTS, half(0, GHOSTS.shape[1]))
    active = sets * (rows[:, None] > np.arange(int(rows.max()))).sum(axis=0)
    return Polar(values.reshape(*values.shape[:2], -1), 1.0 / transfers.step, active)


@dataclass(frozen=True, kw_only=True, eq=False)
class Fields:
    """A basis's transfers on the lattice of a band's tiles.

    keep : them for the next tiles
    """

    band: Band
    basis: Basis
    polar: Polar
    passed: Passed
    keep: bool

    @cached_property
    def _kept(self) -> dict[Block, F64]:
        return {}

    def on_block(self, block: Block, tile: Tile) -> F64:
        """Return transfers (count_j, sets, 2, terms, tile's columns) with OLPF, photosite and the band's window."""
        return of_block(self._kept, block, functools.partial(self._made, block, tile), keep=self.keep)

    def _made(self, block: Block, tile: Tile) -> F64:
        step, pairs = self.band.step, self.passed.on(block, tile)
        terms = self.basis.cuts.size
        out = np.zeros((block.count_j, self.polar.values.shape[2] // (2 * terms), 2, terms, tile.sums[1]))
        polar = self.polar._replace(per_frequency=self.polar.per_frequency / step)
        shared(block.count_j, functools.partial(on_lattice, block.place(tile), polar, pairs, out), least=ROWS)
        return out


def of_block(kept: dict[Block, F64], block: Block, make: Callable[[], F64], *, keep: bool) -> F64:
    """Return what was kept of a block, or make it."""
    if block in kept:
        return kept[block]
    made = make()
    if keep:
        kept[block] = made
    return made


def lattices(here: Mask) -> list[tuple[slice, slice]]:
    """Return rows and columns that hold all photosites of a channel: every second one where half have none."""
    quarters = [(slice(a, None, 2), slice(b, None, 2)) for a in (0, 1) for b in (0, 1)]
    own = [every for every in quarters if here[every].any()]
    return own if len(own) <= 2 else [WHOLE]


def seen_through(own: F64, tile: Tile, every: tuple[slice, slice] = WHOLE) -> F64:
    """Return photosites (terms, rows, cols) of a tile, or some, from frequencies (rows, 2, terms, columns)."""
    if every == WHOLE:
        return inverse(np.moveaxis(own[:, 0] + 1j * own[:, 1], 1, 0), tile)
    (px, py), at = tile.periods, (every[1].start, every[0].start)
    rows, cols = (len(range(*part.indices(count))) for part, count in zip(every, (tile.rows, tile.cols), strict=True))
    fewer = dataclasses.replace(tile, rows=rows, cols=cols, periods=(px // 2, py // 2), cut=2.0 * tile.cut)
    terms = own.shape[2]
    folded = np.zeros((terms, *fewer.sums, 2))
    shared(terms, functools.partial(fold, own, tile.periods, at, folded))
    return inverse(folded.view(complex)[..., 0], fewer)
