"""A lens that changes over the frame as a plan: images with the patterns of a tile's places, weighed per photosite.

    I(x) = Σ_n L_n(x)·(P_n ∗ scene)(x)

The scene is mapped by the distortion before any of it (bending.py). Each photosite gathers with the pattern of its own
place; the check recomputes photosites with just that.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.optics.protocols import Varies
from camsim.rendering.across.decided import bent_sides
from camsim.rendering.across.lattice import Lattice, Tile
from camsim.rendering.auto import BY_EDGES, FOURIER
from camsim.rendering.budget import PLACES_PART
from camsim.rendering.engine import Cost, Decision, Engine, Marks, Plan, Progress, one_by_one, share
from camsim.rendering.flat import FlatPlan
from camsim.rendering.job import Job
from camsim.rendering.work import Work
from camsim.repeated import Channels

FEWEST = 6  # photosites checked, each with a pattern of its own
PLANNED_SECONDS = 0.02  # a place, besides what its image takes


@dataclass(frozen=True, kw_only=True, eq=False)
class AcrossPlan:
    """Tiles and their places.

    job     : of the whole window, behind the lens of the axis
    lens    : what it is at every place
    method  : of the places' images: "boundary" or "fourier"
    """

    job: Job
    lens: Varies
    lattice: Lattice
    method: str

    def placed(self, tile: Tile, x_um: float, y_um: float) -> Plan:
        """Return the plan of a tile's image with the pattern of one place."""
        job = self.job.behind(self.lens.at(x_um, y_um))
        job = dataclasses.replace(
            job, grid=tile.grid(self.job.grid), tolerance=PLACES_PART * self.job.tolerance / self.lattice.gain
        )
        if not len(job.edges):
            return FlatPlan(job=job)
        engine: Engine = BY_EDGES if self.method == "boundary" else FOURIER
        return engine.plan(job)

    @functools.cached_property
    def _sample(self) -> Plan:
        """The plan of the middle tile's first place, for what all have in common."""
        tile = self.lattice.tiles[len(self.lattice.tiles) // 2]
        _, _, x_um, y_um = next(self.lattice.places_um(tile, self.job.grid))
        return self.placed(tile, x_um, y_um)

    @property
    def marks(self) -> Marks:
        """Those of one place."""
        return self._sample.marks

    @property
    def fewest(self) -> int:
        """How many photosites are checked whatever it takes."""
        return FEWEST

    @property
    def wavelengths(self) -> int:
        """Number of wavelength nodes at one place."""
        return self._sample.wavelengths

    @property
    def images_made(self) -> int:
        """How many images of a tile are made."""
        return len(self.lattice.tiles) * self.lattice.counts[0] * self.lattice.counts[1]

    @property
    def cost(self) -> Cost:
        """What all places take if the middle tile's are like the others."""
        each = self.each
        return Cost(seconds=self.images_made * (PLANNED_SECONDS + each.seconds), memory_bytes=each.memory_bytes)

    @functools.cached_property
    def each(self) -> Cost:
        """What one place's image takes."""
        return self._sample.cost

    def work(self, images: int) -> Work:
        """Count what is done: each photosite once for every place of its tile."""
        grid, places = self.job.grid, self.lattice.counts[0] * self.lattice.counts[1]
        return Work(
            edges=len(self.job.edges),
            channels=images,
            photosites=images * places * grid.rows * grid.cols,
            wavelength_nodes=self.wavelengths,
        )

    def decisions(self) -> Iterator[Decision]:
        """Yield tiles and places, what distortion makes of edges, and what one image takes."""
        across, down = self.lattice.counts
        tiles = self.lattice.tiles
        size = f"{tiles[0].rows} × {tiles[0].cols} photosites"
        yield Decision(
            topic="field",
            decision=f"{len(tiles)} tile{'s' if len(tiles) > 1 else ''} of {size}, "
            f"patterns of {across} × {down} places in each",
            reason=f"what lies between is interpolated to {self.lattice.bound:.1g} of the light",
        )
        yield from bent_sides(self.job)
        yield from self._sample.decisions()

    def of(self, job: Job) -> AcrossPlan:
        """Return the same tiles and places for other edges."""
        return dataclasses.replace(self, job=job)

    def bands(self, channel: Channels, progress: Progress) -> Iterator[F64]:
        """Yield the image, one row of tiles after the other."""
        tiles, cols = self.lattice.tiles, channel.shape[1]
        for number, tile in enumerate(tiles):
            if tile.col == 0:
                band = np.empty((tile.rows, cols))
            own = channel[tile.row : tile.row + tile.rows, tile.col : tile.col + tile.cols]
            band[:, tile.col : tile.col + tile.cols] = self._tile(
                tile, own, functools.partial(share, progress, number, len(tiles))
            )
            if tile.col + tile.cols == cols:
                yield band

    def _tile(self, tile: Tile, channel: U8, progress: Progress) -> F64:
        across, down = self.lattice.weights(tile)
        count, total = across.shape[1] * down.shape[1], np.zeros(channel.shape)
        for number, (i, j, x_um, y_um) in enumerate(self.lattice.places_um(tile, self.job.grid)):
            plan, row = self.placed(tile, x_um, y_um), 0
            for band in plan.bands(channel, functools.partial(share, progress, number, count)):
                rows = slice(row, row + len(band))
                total[rows] += band * (down[rows, j, None] * across[:, i])
                row += len(band)
        return total

    def images(self, channels: U8, progress: Progress) -> Iterator[Iterator[F64]]:
        """Yield the bands of several images in turn."""
        return one_by_one(self, channels, progress)

    def standard_error(self, rows: I64, cols: I64) -> float | None:
        """Return None: no chance."""
        return None
