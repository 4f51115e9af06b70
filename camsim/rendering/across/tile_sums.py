"""Tiles of a box: transforms of their edges times the box's transfers, back to photosites, and weighed there."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.kernels import shared
from camsim.rendering.across.kernels import Sets, add_terms
from camsim.rendering.across.on_tiles import ROWS, Fields, Mask, lattices, seen_through
from camsim.rendering.across.places import Box
from camsim.rendering.edges import Edges
from camsim.rendering.fourier.inverse import filled
from camsim.rendering.fourier.nearby import MANY, regions_of
from camsim.rendering.fourier.tile import Tile
from camsim.rendering.job import Job


class Signals(Protocol):
    """The image that tiles are of."""

    @property
    def job(self) -> Job: ...  # noqa: D102
    @property
    def signals(self) -> tuple[F64, I64, F64]: ...  # noqa: D102
    @property
    def contrast(self) -> F64: ...  # noqa: D102


class Part(NamedTuple):
    """Photosites of the window that are one tile; mine: which of them it is for."""

    row: int
    col: int
    rows: int
    cols: int
    mine: Mask

    @property
    def where(self) -> tuple[slice, slice]:
        """Where it is in an image."""
        return slice(self.row, self.row + self.rows), slice(self.col, self.col + self.cols)


@dataclass(frozen=True, kw_only=True, eq=False)
class Summed:
    """Some tiles of a box on one lattice, whose transfers are read once for all of them.

    seen : each with its lattice, and the edges about it
    """

    image: Signals
    box: Box
    fields: Fields
    seen: list[tuple[Part, Tile, Edges]]

    def add(self, channel: U8, image: F64) -> None:
        """Add what their photosites see."""
        _, of_set, taken = self.image.signals
        job, basis, band = self.image.job, self.fields.basis, self.fields.band
        each = [regions_of(edges, tile, job.tolerance) for _, tile, edges in self.seen]
        present = np.unique(np.concatenate([np.unique(channel[part.where][part.mine]) for part, _, _ in self.seen]))
        index = np.full(int(job.signals.scale.size), -1)
        index[present] = np.arange(present.size)
        most = max(spectra.size for spectra, _ in each)
        weights = np.zeros((len(each), most, of_set.size))
        for own, (spectra, _) in zip(weights, each, strict=True):
            # Transfers hold the contrast already.
            own[: spectra.size] = taken[spectra - 1] / np.where(self.image.contrast == 0.0, 1.0, self.image.contrast)
        sets, tile = Sets(weights, index[of_set], band.step * basis.cuts), self.seen[0][1]
        total = np.zeros((len(each), present.size, tile.sums[0], 2, basis.cuts.size, tile.sums[1]))
        for blocks in zip(*(regions.blocks() for _, regions in each), strict=True):
            block = blocks[0][0]
            scenes = np.zeros((len(each), most, block.count_j, 2, block.count_i))
            for scene, (_, own) in zip(scenes, blocks, strict=True):
                scene[: len(own.transforms)] = own.transforms
            add = functools.partial(
                add_terms, total, scenes, self.fields.on_block(block, tile), sets, block.place(tile)
            )
            shared(tile.sums[0], add, least=ROWS)
        for (part, own_tile, _), of_tile in zip(self.seen, total, strict=True):
            for own, letter in zip(of_tile, present, strict=True):
                here = part.mine & (channel[part.where] == letter)
                if here.any():
                    self._add_terms(part, own_tile, own, here, image[part.where])

    def _add_terms(self, part: Part, tile: Tile, own: F64, here: Mask, into: F64) -> None:
        """Add a tile's terms, as frequencies (rows, 2, terms, columns), to some photosites of an image."""
        box, basis, band = self.box, self.fields.basis, self.fields.band
        first_row, first_col = float(part.row - box.row), float(part.col - box.col)
        rows, cols = first_row + np.arange(float(part.rows)), first_col + np.arange(float(part.cols))
        if band.step == 1:
            for every in lattices(here):
                found = basis.weighed(box, rows[every[0]], cols[every[1]], seen_through(own, tile, every))
                into[every][here[every]] += found[here[every]]
            return
        coarse, images = seen_through(own, tile), []
        if basis.bends_less(box, 2.0 * math.pi * band.cut):
            y, x = (band.step * (np.arange(float(count)) - band.before) for count in coarse.shape[1:])
            images.append(basis.weighed(box, first_row + y, first_col + x, coarse))
        for every in lattices(here):
            if images:
                found = filled(images[0], band.filling, part.rows, part.cols, every)
            else:
                # Term by term: beyond its box a place's weight grows as a polynomial of its degree.
                each = np.stack([filled(term, band.filling, part.rows, part.cols, every) for term in coarse])
                found = basis.weighed(box, rows[every[0]], cols[every[1]], each)
            into[every][here[every]] += found[here[every]]


def groups(seen: list[tuple[Part, Tile, Edges]], most: int) -> Iterator[list[tuple[Part, Tile, Edges]]]:
    """Yield tiles that are transformed the same way, edge by edge or from nodes along them, at most so many at once."""
    for spread in (False, True):
        own = [each for each in seen if (len(each[2]) > MANY) == spread]
        for first in range(0, len(own), most):
            yield own[first : first + most]
