"""One band of the difference: its tiles, transformed with the transfers that stand for all places of a box."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from camsim.arrays import F64, U8
from camsim.kept import cached_property
from camsim.kernels import shared
from camsim.rendering.aberrated.kernels import mark
from camsim.rendering.aberrated.windows import windows
from camsim.rendering.across.bands import Band
from camsim.rendering.across.beside import Beside, repeats
from camsim.rendering.across.chords import chords_of
from camsim.rendering.across.hardest import asked
from camsim.rendering.across.line_kernels import Pieces
from camsim.rendering.across.on_tiles import Fields, Passed, polar_of
from camsim.rendering.across.pieces import pieces_of
from camsim.rendering.across.places import COARSE, Basis, Box, Places, angles_of
from camsim.rendering.across.tile_sums import Part, Summed, groups
from camsim.rendering.across.whole import Whole
from camsim.rendering.edges import Edges
from camsim.rendering.fourier.nearby import Nearby
from camsim.rendering.fourier.tile import Tile
from camsim.rendering.grid import Grid

TOGETHER = 4  # tiles
GRAIN = 2  # photosites of a map of what sees more than lines
LONG, LARGE = 6.0, 8.0  # reaches: pieces of outlines, and the least window that is worth it
WORTH = 0.9  # of the least price so far: what is worth it
SIDES = (2.2, 3.5, 5.0)  # reaches: of tiles about what sees more than lines
SPARSE = 2  # times as large a box then, at the most: as many tiles as its transfers are worth
COMPLEX, KEPT = 16.0, 3e7  # bytes; numbers of a box that are kept for its next tiles at the most
TILES, PRODUCTS = 9.0, 0.4  # a box takes as long for a frequency as so many points of a tile, and a tile, for its own


@dataclass(frozen=True, kw_only=True, eq=False)
class BandImage:
    """What one band adds.

    nearby : the scene of tiles, in steps of the band
    pieces : of outlines that photosites see as lines
    marked : the photosites that see more than lines; None: all of them
    tiles  : about how many windows hold these
    """

    image: Whole
    band: Band
    nearby: Nearby
    pieces: Pieces
    marked: U8 | None
    tiles: int

    @cached_property
    def _places(self) -> Places:
        """What compares places."""
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
            every=times,
            allowed=0.5 * self.image.between,
        )

    @cached_property
    def _passed(self) -> Passed:
        """What all boxes' transfers are multiplied by."""
        job, band = self.image.job, self.band
        keep = self._points <= KEPT
        return Passed(system=job.system, band=band, pitch_um=job.grid.pitch_um, keep=keep)

    @property
    def _tile(self) -> Tile:
        """The largest tile."""
        side = min(self.band.side, self.band.box)
        return self.band.tile(side, side)

    @property
    def _points(self) -> float:
        """Its frequencies, and those that blocks have beside the band."""
        return 2.0 * self._tile.points

    @cached_property
    def boxes(self) -> list[Box]:
        """The boxes that have places in common."""
        window, size = Box.window(self.image.job.grid), self.band.box
        cuts = [cut(count, max(1, round(count / size))) for count in (window.rows, window.cols)]
        return [
            window._replace(row=top, col=left, rows=bottom - top, cols=right - left)
            for top, bottom in pairwise(cuts[0])
            for left, right in pairwise(cuts[1])
        ]

    @cached_property
    def _some(self) -> list[Box]:
        """The boxes that are asked."""
        return asked(
            self.boxes,
            far=lambda box: float(np.hypot(*box.places_um(np.zeros(1), np.zeros(1))[0])),
            change=lambda box: float(np.ptp(np.interp(box.radii_um, *self.image.changes))),
        )

    @cached_property
    def counts(self) -> tuple[int, int] | None:
        """Places along x and y of a box; None: it is too large for any number of them."""
        return self._places.counts(self._some)

    @cached_property
    def beside(self) -> tuple[int, int] | None:
        """Places along a piece of an outline, and along either side of what is heard across it; None: too many."""
        window = Box.window(self.image.job.grid)
        # Where patterns turn most, where they hardly do, and where they change most along the radius.
        corners = [(row, col) for row in (0, window.rows) for col in (0, window.cols)]
        along, across = (
            self._places.counts(
                [window._replace(row=row, col=col, rows=n, cols=n) for row, col in [*corners, self._changing(n)]]
            )
            for n in (math.ceil(LONG * self.band.reach), math.ceil(2.0 * self.band.reach))
        )
        return None if along is None or across is None else (max(along), max(across))

    def _changing(self, size: int) -> tuple[int, int]:
        """Return row and column of a box over which wavefronts change most, towards the farthest corner."""
        grid, (radius, change) = self.image.job.grid, self.image.changes
        half = 0.5 * size * grid.pitch_um
        gained = np.interp(radius + half, radius, change) - np.interp(radius - half, radius, change)
        first = np.array(grid.first_centre)
        last = first + np.array([grid.cols - 1, grid.rows - 1])
        far = np.where(np.abs(first) > np.abs(last), first, last)
        place = far * float(radius[int(np.argmax(gained))]) / max(float(np.hypot(*far)) * grid.pitch_um, 1e-300)
        col, row = (place - first - 0.5 * (size - 1)).round().astype(int).tolist()
        return row, col

    def halved(self) -> BandImage:
        """Return the same in boxes of half the side, and in tiles that are no larger."""
        grid = self.image.job.grid
        box = max(1, min(self.band.box, max(grid.rows, grid.cols)) // 2)
        band = dataclasses.replace(self.band, box=box)
        if box < band.side:
            band = band.with_side(box)
        return dataclasses.replace(self, band=band, tiles=_tiles(grid, band, self.marked))

    def _basis(self, box: Box) -> Basis:
        assert self.counts is not None
        return self._shown[box] if box in self._shown else self._places.basis(box, self.counts)

    @cached_property
    def _shown(self) -> dict[Box, Basis]:
        """The bases of some boxes."""
        assert self.counts is not None
        return {box: self._places.basis(box, self.counts) for box in self._some}

    @property
    def _ends(self) -> float:
        """Where all terms of some boxes end, cycles/pitch: boxes with one lattice look up once what they share."""
        return max((float(basis.cuts.max(initial=0.0)) for basis in self._shown.values()), default=0.0)

    @cached_property
    def box_bytes(self) -> float:
        """What a box holds while it is transformed: its transfers, the same on its tiles' lattice, and tiles' sums."""
        transfers, band = self.image.transfers, self.band
        terms, sets = max(basis.cuts.size for basis in self._shown.values()), len(self.image.signals[1])
        _, _, frequencies, harmonics = transfers.harmonics.shape
        rows = min(frequencies, math.ceil(self._ends / transfers.step) + 1)
        tiles, lattice = min(TOGETHER, math.ceil(band.box / band.side) ** 2), math.prod(self._tile.sums)
        kept = max(self._points, lattice) if self._points * sets * terms <= KEPT else lattice
        on_it = sets * kept + (tiles + 1) * self.image.job.signals.scale.size * lattice
        taken: float = COMPLEX * terms * (sets * rows * (harmonics + self.image.angles) + on_it)
        return taken

    def prepared(self) -> None:
        """Make what all boxes have in common, before threads ask for it at once."""
        _ = self._shown, self._passed, self.nearby.outlines

    def _parts(self, box: Box) -> Iterator[Part]:
        """Yield a box's tiles, each no larger than the band's side."""
        if self.marked is not None:
            left = self.marked[box.row : box.row + box.rows, box.col : box.col + box.cols].copy()
            for window in windows(left, GRAIN, self.band.side):
                own = left[window.row : window.row + window.rows, window.col : window.col + window.cols]
                mine = own != 0
                own[:] = 0  # other windows' patches may lie in this one
                yield Part(box.row + window.row, box.col + window.col, window.rows, window.cols, mine)
            return
        cuts = [cut(count, -(-count // self.band.side)) for count in (box.rows, box.cols)]
        for top, bottom in pairwise(cuts[0]):
            for left_col, right in pairwise(cuts[1]):
                mine = np.ones((bottom - top, right - left_col), bool)
                yield Part(box.row + top, box.col + left_col, bottom - top, right - left_col, mine)

    def add_lines(self, channel: U8, image: F64) -> None:
        """Add what photosites see of lines that see nothing else."""
        if self.marked is None or not len(self.pieces.frame):
            return
        whole, band, grid = self.image, self.band, self.image.job.grid
        assert self.beside is not None
        _, of_set, taken = whole.signals
        shares = np.concatenate([np.zeros((1, len(of_set))), taken]) / np.where(
            whole.contrast == 0.0, 1.0, whole.contrast
        )
        beside = Beside(
            system=whole.job.system,
            transfers=whole.transfers,
            angles=whole.angles,
            band=band,
            pitch_um=grid.pitch_um,
            counts=self.beside,
            shares=shares,
            channel=of_set,
        )
        beside.add(self.pieces, grid.first_centre, channel, self.marked, image)

    def add_box(self, box: Box, channel: U8, image: F64) -> None:
        """Add what the photosites of a box see."""
        (x0, y0), band, seen = self.image.job.grid.first_centre, self.band, []
        for part in self._parts(box):
            tile = band.tile(part.rows, part.cols)
            first = (x0 + part.col) / band.step - band.before, (y0 + part.row) / band.step - band.before
            edges = self.nearby.seen(tile, first)
            if len(edges):
                seen.append((part, tile, edges))
        if not seen:
            return
        basis = self._basis(box)
        if basis.cuts.size:
            # Where none of its terms goes on nothing is transformed.
            cut = min(band.cut, max(self._ends, float(basis.cuts[0]))) * band.step
            seen = [(part, dataclasses.replace(tile, cut=cut), edges) for part, tile, edges in seen]
            polar = polar_of(self.image.transfers, basis, self.image.angles)
            each = list(groups(seen, TOGETHER))
            # What memory does not hold is made again for the next tiles.
            keep = len(each) > 1 and self._points * (polar.values.shape[2] // 2) <= KEPT
            fields = Fields(band=band, basis=basis, polar=polar, passed=self._passed, keep=keep)
            for some in each:
                Summed(image=self.image, box=box, fields=fields, seen=some).add(channel, image)


def band_image(whole: Whole, band: Band) -> BandImage:
    """Return the image of a band, in the tiles that are cheapest: about all, or about what sees more than lines."""
    grid = whole.job.grid
    low = np.array(grid.first_centre)
    high = low + np.array([grid.cols - 1, grid.rows - 1])
    edges, step = whole.job.edges, band.step
    few = chords_of(edges, whole.listened.apart(band.low, band.high)).edges
    nearby = Nearby(edges=Edges(start=few.start / step, end=few.end / step, left=few.left, right=few.right))
    small = max(grid.rows, grid.cols) < LARGE * band.reach
    if step > 1 or small or repeats(band, whole.transfers.step):
        edges = edges.some(np.zeros(len(edges), bool))
    allowed = whole.listened.bent(band.low, band.high) if len(edges) else np.zeros(3)
    pieces, marks = pieces_of(edges, low, high, band.reach, LONG * band.reach, allowed)
    tiles = _tiles(grid, band, None)
    plain = best = BandImage(image=whole, band=band, nearby=nearby, pieces=pieces, marked=None, tiles=tiles)
    if len(pieces.frame):
        marked = np.zeros((grid.rows, grid.cols), np.uint8)
        shared(grid.rows, lambda first, end: mark(grid.first_centre, marks, band.reach, marked, first, end))
        least = band.period**2 * tiles
        for times in SIDES:
            other = band.with_side(math.ceil(times * band.reach))
            count = _tiles(grid, other, marked)
            price = other.period**2 * count
            if price < WORTH * least:
                points = other.tile(other.side, other.side).points
                together = TILES * points / (PRODUCTS * points + other.period**2)
                box = math.ceil(math.sqrt(together * grid.rows * grid.cols / max(count, 1)))
                least, other = price, dataclasses.replace(other, box=max(other.side, min(SPARSE * band.box, box)))
                best = dataclasses.replace(best, band=other, marked=marked, tiles=count)
    if best.marked is not None and best.beside is None:
        best = plain
    while best.counts is None:  # where patterns change quickly; over one photosite they do not
        best = best.halved()
    return best


def _tiles(grid: Grid, band: Band, marked: U8 | None) -> int:
    """Return about how many windows hold all photosites, or those that are marked."""
    if marked is not None:
        return len(windows(marked, GRAIN, band.side))
    return math.ceil(grid.rows / band.side) * math.ceil(grid.cols / band.side)


def cut(count: int, pieces: int) -> list[int]:
    """Return where pieces of about one size begin, and the end."""
    cuts: list[int] = np.linspace(0, count, pieces + 1).round().astype(int).tolist()
    return cuts
