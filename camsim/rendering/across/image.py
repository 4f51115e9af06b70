"""What differs from the perfect lens, all over the frame: its two bands, tile by tile, by Fourier transforms."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy

from camsim.arrays import F64, I64, U8
from camsim.kernels import shared
from camsim.optics.placed import Revolves
from camsim.rendering.across.bands import SIGMA, SMOOTH_CUT, Band, band_of, far_reach, near_reach
from camsim.rendering.across.kernels import AFTER, BEFORE, Polar, Sets, add_terms, on_lattice
from camsim.rendering.across.places import COARSE, Basis, Box, Places, angles_of
from camsim.rendering.across.transfers import SIX, Transfers, fused_transfers, with_ghosts
from camsim.rendering.edges import Edges
from camsim.rendering.engine import Progress
from camsim.rendering.fast_length import fast_length
from camsim.rendering.fourier.blocks import Block, Tile
from camsim.rendering.fourier.inverse import inverse
from camsim.rendering.fourier.lens import footprint_transfer, frequencies
from camsim.rendering.fourier.nearby import MANY, Nearby, regions_of
from camsim.rendering.job import Job
from camsim.rendering.spectral import multiples

GROUPS = {"near": 4, "far": 1}  # tiles along a side that have places in common
EACH = 0.25  # of the transfers' share: what each of their approximations may leave
HARDEST = 3  # boxes on which places are counted
TOGETHER = 4  # tiles
ROWS = 16  # of a block: fewer are no work for a thread of its own


@dataclass(frozen=True, kw_only=True, eq=False)
class DifferenceImage:
    """The difference behind a lens of revolution; the job's tolerance is its part.

    between : what places that are interpolated may leave
    """

    job: Job
    lens: Revolves
    between: float

    @functools.cached_property
    def signals(self) -> tuple[F64, I64, F64]:
        """Weights (sets, wavelengths) of transfers, each one's channel, and what spectra but the background's take.

        Spectra that are multiples of one another in a channel have one transfer.
        """
        density = self.job.signals.density
        contrast = density[1:] - density[0]
        weights, channel, taken = [], [], []
        for k in range(contrast.shape[1]):
            which, times = multiples(contrast[:, k])
            for own in np.unique(which):
                weights.append(contrast[own, k])
                channel.append(k)
                taken.append(np.where(which == own, times, 0.0))
        return np.array(weights), np.array(channel), np.array(taken).T

    @functools.cached_property
    def contrast(self) -> F64:
        """The most that two sides of an edge differ by, of each set."""
        taken = np.concatenate([np.zeros((1, len(self.signals[1]))), self.signals[2]])
        most: F64 = np.abs(taken[self.job.sides[:, 0]] - taken[self.job.sides[:, 1]]).max(axis=0)
        return most

    @functools.cached_property
    def radii_um(self) -> tuple[float, float]:
        """Where in the frame the window lies."""
        grid = self.job.grid
        low = np.array(grid.first_centre) * grid.pitch_um
        high = low + np.array([grid.cols - 1, grid.rows - 1]) * grid.pitch_um
        nearest = np.maximum(np.maximum(low, -high), 0.0)
        return float(np.hypot(*nearest)), float(np.hypot(*np.maximum(np.abs(low), np.abs(high))))

    def _heard(self, frequency: F64) -> F64:
        """Return how much of a transfer's error a line shows at frequencies in cycles/pitch, about."""
        return 1.0 / np.square(np.maximum(math.pi * frequency, 1.0))

    @functools.cached_property
    def transfers(self) -> Transfers:
        """The lens along its radius."""
        job, (weights, _, _) = self.job, self.signals
        return fused_transfers(
            self.lens,
            job.signals.wavelength_nm,
            weights * self.contrast[:, None],
            pitch_um=job.grid.pitch_um,
            radii_um=self.radii_um,
            allowed=EACH * job.budget.allowed("transfers"),
            heard=self._heard,
        )

    @functools.cached_property
    def bands(self) -> tuple[Band, Band]:
        """The near one and the far one."""
        job, (weights, _, _), (low, high) = self.job, self.signals, self.radii_um
        extent = job.footprint.extent if job.footprint is not None else 0.0
        shape = job.grid.rows, job.grid.cols
        near = extent + near_reach(self.transfers, np.ones(len(weights)), job.edges, job.budget.allowed("near cut"))
        far = extent + far_reach(
            self.lens,
            job.system,
            job.signals.wavelength_nm,
            weights * self.contrast[:, None],
            radii_um=(low, high),
            pitch_um=job.grid.pitch_um,
            edges=job.edges,
            allowed=job.budget.allowed("far cut"),
        )
        cut = self.transfers.step * (self.transfers.harmonics.shape[2] - 1)
        return band_of("near", near, job.span, shape, cut, GROUPS["near"]), band_of(
            "far", far, job.span, shape, min(cut, SMOOTH_CUT * SIGMA), GROUPS["far"]
        )

    @functools.cached_property
    def angles(self) -> int:
        """Points of half a circle from which a six-point look-up keeps its share."""
        transfers, allowed = self.transfers, EACH * self.job.budget.allowed("transfers")
        frequency = transfers.step * np.arange(float(transfers.harmonics.shape[2]))
        size = (np.abs(transfers.harmonics).max(axis=(0, 1)) * self._heard(frequency)[:, None]).max(axis=0)
        m = np.abs(np.arange(-transfers.most, transfers.most + 1))
        count = transfers.most + 1
        while True:
            count = fast_length(count + 1)
            if float(np.sum(size * np.minimum(SIX * (math.pi * m / count) ** 6, 2.0))) <= allowed:
                return count

    def _places(self, band: Band) -> tuple[Places, float]:
        """Return what compares places in a band, and the spacing of the frequencies that it does so at."""
        transfers, job = self.transfers, self.job
        count = min(transfers.harmonics.shape[2], math.ceil(band.cut / transfers.step) + 1)
        times = max(1, count // COARSE)
        index = np.arange(times // 2 + 1, count, times)
        frequency = transfers.step * index
        angle = math.pi * np.arange(angles_of(transfers.most)) / angles_of(transfers.most)
        per_um = frequency[:, None] / job.grid.pitch_um
        passes = np.abs(job.system.footprint_otf(per_um * np.cos(angle), per_um * np.sin(angle)))
        heard = passes * (band.window(frequency) * transfers.step * times / (math.pi * frequency))[:, None]
        sets = len(self.signals[1])
        allowed = 0.5 * self.between
        return Places(
            transfers=transfers, heard=np.broadcast_to(heard, (sets, *heard.shape)), index=index, allowed=allowed
        ), transfers.step * times

    def _box(self, row: int, col: int, rows: int, cols: int) -> Box:
        grid = self.job.grid
        x0, y0 = grid.first_centre
        return Box(row, col, rows, cols, (x0 * grid.pitch_um, y0 * grid.pitch_um), grid.pitch_um)

    def boxes(self, band: Band) -> list[Box]:
        """Return the boxes that have places in common."""
        grid, size = self.job.grid, band.side * band.group
        cuts = [
            np.linspace(0, count, max(1, round(count / size)) + 1).round().astype(int).tolist()
            for count in (grid.rows, grid.cols)
        ]
        return [
            self._box(top, left, bottom - top, right - left)
            for top, bottom in zip(cuts[0][:-1], cuts[0][1:], strict=True)
            for left, right in zip(cuts[1][:-1], cuts[1][1:], strict=True)
        ]

    @functools.cached_property
    def counts(self) -> dict[str, tuple[int, int]]:
        """Places along x and y of a box of each band."""
        found = {}
        for band in self.bands:
            boxes = sorted(
                self.boxes(band), key=lambda box: float(np.hypot(*box.places_um(np.zeros(1), np.zeros(1))[0]))
            )
            some = [boxes[0], boxes[len(boxes) // 2], boxes[-1]]
            found[band.name] = self._places(band)[0].counts(list(dict.fromkeys(some)))
        return found

    def rendered(self, channel: U8, progress: Progress) -> F64:
        """Return the image, each photosite in its own channel."""
        image = np.zeros(channel.shape)
        nearby = Nearby(edges=self.job.edges)
        work = [(band, box) for band in self.bands for box in self.boxes(band)]
        for done, (band, box) in enumerate(work):
            self._add_box(band, box, nearby, channel, image)
            progress((done + 1) / len(work))
        return image

    def _tiles(self, band: Band, box: Box) -> Iterator[Tile]:
        """Yield a box's tiles, each no larger than the band's side."""
        cuts = [
            np.linspace(0, count, -(-count // band.side) + 1).round().astype(int).tolist()
            for count in (box.rows, box.cols)
        ]
        for top, bottom in zip(cuts[0][:-1], cuts[0][1:], strict=True):
            for left, right in zip(cuts[1][:-1], cuts[1][1:], strict=True):
                yield band.tile(box.row + top, box.col + left, bottom - top, right - left)

    def _add_box(self, band: Band, box: Box, nearby: Nearby, channel: U8, image: F64) -> None:
        x0, y0 = self.job.grid.first_centre
        seen = [(tile, nearby.seen(tile, (x0 + tile.col, y0 + tile.row))) for tile in self._tiles(band, box)]
        seen = [(tile, edges) for tile, edges in seen if len(edges)]
        if not seen:
            return
        places, spacing = self._places(band)
        basis = places.basis(box, self.counts[band.name], spacing)
        if not basis.cuts.size:
            return
        fields = _Fields(image=self, band=band, basis=basis)
        weights = basis.weights(box)
        for some in groups(seen, TOGETHER):
            self._add_tiles(some, box, fields, weights, channel, image)

    def _add_tiles(
        self, seen: list[tuple[Tile, Edges]], box: Box, fields: _Fields, weights: F64, channel: U8, image: F64
    ) -> None:
        """Add some tiles of a box, whose transfers are read once for all of them."""
        _, of_set, taken = self.signals
        cuts, tiles = fields.basis.cuts, []
        for tile, edges in seen:
            part = slice(tile.row, tile.row + tile.rows), slice(tile.col, tile.col + tile.cols)
            spectra, regions = regions_of(edges, tile, 0.0, self.job.tolerance)
            present = np.unique(channel[part])
            index = np.full(int(self.job.signals.scale.size), -1)
            index[present] = np.arange(present.size)
            # Transfers hold the contrast already.
            shares = np.ascontiguousarray(taken[spectra - 1]) / np.where(self.contrast == 0.0, 1.0, self.contrast)
            total = np.zeros((present.size, cuts.size, tile.sums[0], 2, tile.sums[1]))
            tiles.append((part, present, regions, Sets(shares, index[of_set], cuts), total))
        for blocks in zip(*(regions.blocks() for _, _, regions, _, _ in tiles), strict=True):
            for (tile, _), (_, _, _, sets, total), (block, scene) in zip(seen, tiles, blocks, strict=True):
                add = functools.partial(add_terms, total, scene, fields.on_block(block, tile), sets, block.place(tile))
                shared(total.shape[2], add, least=ROWS)
        for (tile, _), (part, present, _, _, total) in zip(seen, tiles, strict=True):
            mine = slice(tile.row - box.row, tile.row - box.row + tile.rows)
            across = slice(tile.col - box.col, tile.col - box.col + tile.cols)
            for k, letter in enumerate(present):
                here = channel[part] == letter
                for q in range(cuts.size):
                    term = inverse(total[k, q, :, 0] + 1j * total[k, q, :, 1], tile)
                    image[part][here] += (weights[q, mine, across] * term)[here]


def groups(seen: list[tuple[Tile, Edges]], most: int) -> Iterator[list[tuple[Tile, Edges]]]:
    """Yield tiles that are transformed the same way, edge by edge or from nodes along them, at most so many at once."""
    for spread in (False, True):
        own = [each for each in seen if (len(each[1]) > MANY) == spread]
        for first in range(0, len(own), most):
            yield own[first : first + most]


@dataclass(frozen=True, kw_only=True, eq=False)
class _Fields:
    """A basis's transfers on the lattice of a band's tiles, kept."""

    image: DifferenceImage
    band: Band
    basis: Basis

    @functools.cached_property
    def polar(self) -> Polar:
        """The transfers over |f| and angle."""
        transfers, angles, basis = self.image.transfers, self.image.angles, self.basis
        count = transfers.harmonics.shape[2]
        rows = np.minimum(np.ceil(basis.cuts / transfers.step).astype(int) + 1, count)
        terms, sets, most = len(basis.cuts), transfers.harmonics.shape[1], transfers.most
        values = np.zeros((BEFORE + int(rows.max()) + AFTER, angles + BEFORE + AFTER, terms, sets, 2))
        used = np.flatnonzero(np.abs(basis.made_of).max(axis=(0, 2)) > 0.0)
        for q in range(terms):
            stop = min(int(rows[q]) + AFTER, count)
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
            job = self.image.job
            foot = footprint_transfer(job.system, block, tile, job.grid.pitch_um)
            across, down, both = (part.view(complex)[..., 0] for part in foot)
            fx, fy = frequencies(block, tile, 1.0)
            more = across * down[:, None] * (both if both.size else 1.0) * self.band.window(np.hypot(fx, fy))
            out = np.zeros((self.polar.values.shape[2] // 2, block.count_j, 2, block.count_i))
            pairs = np.ascontiguousarray(more).view(np.float64).reshape(*more.shape, 2)
            shared(block.count_j, functools.partial(on_lattice, block.place(tile), self.polar, pairs, out), least=ROWS)
            self._kept[block] = out
        return self._kept[block]
