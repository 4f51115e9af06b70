"""One band of the difference: its tiles, transformed with the transfers that stand for all places of a box."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt
import scipy

from camsim.arrays import F64, I64, U8
from camsim.kernels import shared
from camsim.rendering.across.bands import Band
from camsim.rendering.across.kernels import AFTER, BEFORE, Polar, Sets, add_terms, fold, on_lattice
from camsim.rendering.across.places import COARSE, Basis, Box, Places, angles_of
from camsim.rendering.across.transfers import GHOSTS, Transfers, with_ghosts
from camsim.rendering.edges import Edges
from camsim.rendering.fourier.blocks import Block, Tile
from camsim.rendering.fourier.inverse import filled, inverse
from camsim.rendering.fourier.lens import footprint_transfer, frequencies
from camsim.rendering.fourier.nearby import MANY, Nearby, regions_of
from camsim.rendering.job import Job

Mask: TypeAlias = npt.NDArray[np.bool_]

TOGETHER = 4  # tiles
ROWS = 16  # of a block: fewer are no work for a thread of its own


class Whole(Protocol):
    """The image that a band is of."""

    @property
    def job(self) -> Job: ...  # noqa: D102
    @property
    def between(self) -> float: ...  # noqa: D102
    @property
    def transfers(self) -> Transfers: ...  # noqa: D102
    @property
    def angles(self) -> int: ...  # noqa: D102
    @property
    def signals(self) -> tuple[F64, I64, F64]: ...  # noqa: D102
    @property
    def contrast(self) -> F64: ...  # noqa: D102


class Part(NamedTuple):
    """Photosites of the window that are one tile."""

    row: int
    col: int
    rows: int
    cols: int

    @property
    def where(self) -> tuple[slice, slice]:
        """Where it is in an image."""
        return slice(self.row, self.row + self.rows), slice(self.col, self.col + self.cols)


@dataclass(frozen=True, kw_only=True, eq=False)
class BandImage:
    """What one band adds."""

    image: Whole
    band: Band

    @functools.cached_property
    def _nearby(self) -> Nearby:
        """The scene, in steps of the band."""
        edges, step = self.image.job.edges, self.band.step
        return Nearby(edges=Edges(start=edges.start / step, end=edges.end / step, left=edges.left, right=edges.right))

    @functools.cached_property
    def _places(self) -> tuple[Places, float]:
        """What compares places, and the spacing of the frequencies that it does so at."""
        band, transfers, job = self.band, self.image.transfers, self.image.job
        count = min(transfers.harmonics.shape[2], math.ceil(band.cut / transfers.step) + 1)
        times = max(1, count // COARSE)
        index = np.arange(times // 2 + 1, count, times)
        frequency = transfers.step * index
        angle = math.pi * np.arange(angles_of(transfers.most)) / angles_of(transfers.most)
        per_um = frequency[:, None] / job.grid.pitch_um
        passes = np.abs(job.system.footprint_otf(per_um * np.cos(angle), per_um * np.sin(angle)))
        heard = passes * (band.window(frequency) * transfers.step * times / (math.pi * frequency))[:, None]
        sets = len(self.image.signals[1])
        return Places(
            transfers=transfers,
            heard=np.broadcast_to(heard, (sets, *heard.shape)),
            index=index,
            allowed=0.5 * self.image.between,
        ), transfers.step * times

    @functools.cached_property
    def boxes(self) -> list[Box]:
        """The boxes that have places in common."""
        grid, size = self.image.job.grid, self.band.side * self.band.group
        x0, y0 = grid.first_centre
        cuts = [cut(count, max(1, round(count / size))) for count in (grid.rows, grid.cols)]
        return [
            Box(top, left, bottom - top, right - left, (x0 * grid.pitch_um, y0 * grid.pitch_um), grid.pitch_um)
            for top, bottom in pairwise(cuts[0])
            for left, right in pairwise(cuts[1])
        ]

    @functools.cached_property
    def counts(self) -> tuple[int, int]:
        """Places along x and y of a box."""
        boxes = sorted(self.boxes, key=lambda box: float(np.hypot(*box.places_um(np.zeros(1), np.zeros(1))[0])))
        some = [boxes[0], boxes[len(boxes) // 2], boxes[-1]]
        return self._places[0].counts(list(dict.fromkeys(some)))

    def _parts(self, box: Box) -> Iterator[Part]:
        """Yield a box's tiles, each no larger than the band's side."""
        cuts = [cut(count, -(-count // self.band.side)) for count in (box.rows, box.cols)]
        for top, bottom in pairwise(cuts[0]):
            for left, right in pairwise(cuts[1]):
                yield Part(box.row + top, box.col + left, bottom - top, right - left)

    def add_box(self, box: Box, channel: U8, image: F64) -> None:
        """Add what the photosites of a box see."""
        (x0, y0), band, seen = self.image.job.grid.first_centre, self.band, []
        for part in self._parts(box):
            tile = band.tile(part.rows, part.cols)
            first = (x0 + part.col) / band.step - band.before, (y0 + part.row) / band.step - band.before
            edges = self._nearby.seen(tile, first)
            if len(edges):
                seen.append((part, tile, edges))
        if not seen:
            return
        places, spacing = self._places
        basis = places.basis(box, self.counts, spacing)
        if basis.cuts.size:
            fields = _Fields(whole=self.image, band=band, basis=basis)
            for some in groups(seen, TOGETHER):
                self._add_tiles(some, box, fields, channel, image)

    def _add_tiles(
        self, seen: list[tuple[Part, Tile, Edges]], box: Box, fields: _Fields, channel: U8, image: F64
    ) -> None:
        """Add some tiles of a box, whose transfers are read once for all of them."""
        _, of_set, taken = self.image.signals
        job, basis, step, tiles = self.image.job, fields.basis, self.band.step, []
        for part, tile, edges in seen:
            spectra, regions = regions_of(edges, tile, 0.0, job.tolerance)
            present = np.unique(channel[part.where])
            index = np.full(int(job.signals.scale.size), -1)
            index[present] = np.arange(present.size)
            # Transfers hold the contrast already.
            contrast = np.where(self.image.contrast == 0.0, 1.0, self.image.contrast)
            shares = np.ascontiguousarray(taken[spectra - 1]) / contrast
            total = np.zeros((present.size, basis.cuts.size, tile.sums[0], 2, tile.sums[1]))
            tiles.append((present, regions, Sets(shares, index[of_set], step * basis.cuts), total))
        for blocks in zip(*(regions.blocks() for _, regions, _, _ in tiles), strict=True):
            for (_, tile, _), (_, _, sets, total), (block, scene) in zip(seen, tiles, blocks, strict=True):
                add = functools.partial(add_terms, total, scene, fields.on_block(block, tile), sets, block.place(tile))
                shared(total.shape[2], add, least=ROWS)
        for (part, tile, _), (present, _, _, total) in zip(seen, tiles, strict=True):
            rows = part.row - box.row + np.arange(float(part.rows))
            cols = part.col - box.col + np.arange(float(part.cols))
            into = image[part.where]
            for own, letter in zip(total, present, strict=True):
                here = channel[part.where] == letter
                for every in lattices(here) if step == 1 else (WHOLE,):
                    weights = basis.weights(box, rows[every[0]], cols[every[1]])
                    found = np.zeros(weights.shape[1:])
                    # Term by term: beyond its box a place's weight grows as a polynomial of its degree.
                    for weight, term in zip(weights, seen_through(own, tile, every), strict=True):
                        found += weight * (term if step == 1 else filled(term, step, part.rows, part.cols))
                    into[every][here[every]] += found[here[every]]


WHOLE = (slice(None), slice(None))


def lattices(here: Mask) -> list[tuple[slice, slice]]:
    """Return rows and columns that hold all photosites of a channel: every second one where half have none."""
    quarters = [(slice(a, None, 2), slice(b, None, 2)) for a in (0, 1) for b in (0, 1)]
    own = [every for every in quarters if here[every].any()]
    return own if len(own) <= 2 else [WHOLE]


def seen_through(own: F64, tile: Tile, every: tuple[slice, slice]) -> F64:
    """Return photosites (terms, rows, cols) of a tile, or some, from frequencies (terms, rows, 2, columns)."""
    if every == WHOLE:
        return inverse(own[:, :, 0] + 1j * own[:, :, 1], tile)
    (px, py), at = tile.periods, (every[1].start, every[0].start)
    rows, cols = (len(range(*part.indices(count))) for part, count in zip(every, (tile.rows, tile.cols), strict=True))
    fewer = dataclasses.replace(tile, rows=rows, cols=cols, periods=(px // 2, py // 2), cut=2.0 * tile.cut)
    folded = np.zeros((len(own), *fewer.sums, 2))
    shared(len(own), functools.partial(fold, own, tile.periods, at, folded))
    return inverse(folded.view(complex)[..., 0], fewer)


def cut(count: int, pieces: int) -> list[int]:
    """Return where pieces of about one size begin, and the end."""
    cuts: list[int] = np.linspace(0, count, pieces + 1).round().astype(int).tolist()
    return cuts


def groups(seen: list[tuple[Part, Tile, Edges]], most: int) -> Iterator[list[tuple[Part, Tile, Edges]]]:
    """Yield tiles that are transformed the same way, edge by edge or from nodes along them, at most so many at once."""
    for spread in (False, True):
        own = [each for each in seen if (len(each[2]) > MANY) == spread]
        for first in range(0, len(own), most):
            yield own[first : first + most]


@dataclass(frozen=True, kw_only=True, eq=False)
class _Fields:
    """A basis's transfers on the lattice of a band's tiles, kept."""

    whole: Whole
    band: Band
    basis: Basis

    @functools.cached_property
    def polar(self) -> Polar:
        """The transfers over |f| and angle."""
        transfers, angles, basis = self.whole.transfers, self.whole.angles, self.basis
        count = transfers.harmonics.shape[2]
        rows = np.minimum(np.ceil(basis.cuts / transfers.step).astype(int) + 1, count)
        terms, sets, most = len(basis.cuts), transfers.harmonics.shape[1], transfers.most
        values = np.zeros((BEFORE + int(rows.max()) + AFTER, angles + BEFORE + AFTER, terms, sets, 2))
        used = np.flatnonzero(np.abs(basis.made_of).max(axis=(0, 2)) > 0.0)
        for q in range(terms):
            stop = min(max(int(rows[q]) + AFTER, GHOSTS.shape[1]), count)
            spectrum = np.zeros((sets, stop, 2 * angles), complex)
            own = np.einsum("km,ksfm->sfm", basis.made_of[q, used], transfers.harmonics[used, :, :stop])
            spectrum[..., : most + 1], spectrum[..., -most:] = own[..., most:], own[..., :most]
            around = scipy.fft.ifft(spectrum, axis=-1, norm="forward", workers=-1)
            half = np.concatenate([around[..., -BEFORE:], around[..., : angles + AFTER]], axis=-1)
            moved = np.moveaxis(with_ghosts(half), 0, -1)[: len(values)]
            values[: moved.shape[0], :, q, :, 0], values[: moved.shape[0], :, q, :, 1] = moved.real, moved.imag
        active = sets * (rows[:, None] > np.arange(int(rows.max()))).sum(axis=0)
        return Polar(values.reshape(*values.shape[:2], -1), 1.0 / transfers.step, active)

    @functools.cached_property
    def _kept(self) -> dict[Block, F64]:
        return {}

    def on_block(self, block: Block, tile: Tile) -> F64:
        """Return transfers (terms · sets, count_j, 2, count_i) with OLPF, photosite and the band's window."""
        if block not in self._kept:
            job, step = self.whole.job, self.band.step
            foot = footprint_transfer(job.system, block, tile, step * job.grid.pitch_um)
            across, down, both = (part.view(complex)[..., 0] for part in foot)
            fx, fy = frequencies(block, tile, 1.0)
            more = across * down[:, None] * (both if both.size else 1.0) * self.band.window(np.hypot(fx, fy) / step)
            out = np.zeros((self.polar.values.shape[2] // 2, block.count_j, 2, block.count_i))
            pairs = np.ascontiguousarray(more).view(np.float64).reshape(*more.shape, 2)
            polar = self.polar._replace(per_frequency=self.polar.per_frequency / step)
            shared(block.count_j, functools.partial(on_lattice, block.place(tile), polar, pairs, out), least=ROWS)
            self._kept[block] = out
        return self._kept[block]
