"""A lens that changes over the frame as a plan: images with the patterns of a tile's places, weighed per photosite.

    I(x) = Σ_n L_n(x)·(P_n ∗ scene)(x)

The scene is mapped by the distortion before any of it (bending.py). Each photosite gathers with the pattern of its own
place; the check recomputes photosites with just that.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.kept import cached_property
from camsim.kernels import ahead
from camsim.optics.protocols import Varies
from camsim.rendering.across.decided import bent_sides
from camsim.rendering.across.lattice import Lattice, Tile
from camsim.rendering.auto import BY_EDGES, FOURIER
from camsim.rendering.budget import PLACES_PART
from camsim.rendering.engine import MEMORY_LIMIT_BYTES, Cost, Decision, Marks, Plan, Progress, one_by_one
from camsim.rendering.flat import FlatPlan
from camsim.rendering.job import Job
from camsim.rendering.work import Work
from camsim.repeated import Channels

if TYPE_CHECKING:
    from camsim.rendering.fourier.engine import FourierPlan

FEWEST = 6  # photosites checked, each with a pattern of its own
AT_ONCE = 4  # images, on threads of their own
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
        job = self._job(tile, x_um, y_um)
        if not len(job.edges):
            return FlatPlan(job=job)
        return BY_EDGES.plan(job) if self.method == "boundary" else FOURIER.plan_like(job, self._by_transforms)

    def _job(self, tile: Tile, x_um: float, y_um: float) -> Job:
        """Return a tile as it is seen with the pattern of one place."""
        job = self.job.behind(self.lens.at(x_um, y_um))
        tolerance = PLACES_PART * self.job.tolerance / self.lattice.gain
        return dataclasses.replace(job, grid=tile.grid(self.job.grid), tolerance=tolerance)

    @cached_property
    def _first(self) -> Job:
        """The middle tile's, at its first place."""
        tile = self.lattice.tiles[len(self.lattice.tiles) // 2]
        _, _, x_um, y_um = next(self.lattice.places_um(tile, self.job.grid))
        return self._job(tile, x_um, y_um)

    @cached_property
    def _by_transforms(self) -> FourierPlan:
        """Its plan by fourier, whose ways are taken for all places."""
        return FOURIER.plan(self._first)

    @cached_property
    def _sample(self) -> Plan:
        """Its plan, for what all have in common."""
        if not len(self._first.edges):
            return FlatPlan(job=self._first)
        return BY_EDGES.plan(self._first) if self.method == "boundary" else self._by_transforms

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
        from camsim.rendering.aberrated.engine import AberratedPlan  # which no other plan needs

        each, sample = self.each, self._sample
        once = sample.kept_seconds if isinstance(sample, AberratedPlan) else 0.0
        seconds = once + self.images_made * (PLANNED_SECONDS + each.seconds - once)
        return Cost(seconds=seconds, memory_bytes=each.memory_bytes)

    @cached_property
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
        cols, places = channel.shape[1], self.lattice.counts[0] * self.lattice.counts[1]
        for number, (tile, i, j, image) in enumerate(ahead(self._image, self._images(channel), self._at_once)):
            here = slice(tile.col, tile.col + tile.cols)
            if number % places == 0:
                across, down = self.lattice.weights(tile)
                if tile.col == 0:
                    band = np.zeros((tile.rows, cols))
            band[:, here] += image * (down[:, j, None] * across[:, i])
            progress((number + 1) / self.images_made)
            if tile.col + tile.cols == cols and number % places == places - 1:
                yield band

    def _images(self, channel: Channels) -> Iterator[tuple[Tile, int, int, float, float, U8]]:
        """Yield the images to make: a tile, its place, and the photosites' channels."""
        for tile in self.lattice.tiles:
            own = channel[tile.row : tile.row + tile.rows, tile.col : tile.col + tile.cols]
            for i, j, x_um, y_um in self.lattice.places_um(tile, self.job.grid):
                yield tile, i, j, x_um, y_um, own

    def _image(self, what: tuple[Tile, int, int, float, float, U8]) -> tuple[Tile, int, int, F64]:
        """Return a tile's image with the pattern of one place."""
        tile, i, j, x_um, y_um, channel = what
        bands = self.placed(tile, x_um, y_um).bands(channel, lambda done: None)
        return tile, i, j, np.concatenate(list(bands))

    @property
    def _at_once(self) -> int:
        """How many images fit in memory at a time, on threads of their own."""
        return max(1, min(AT_ONCE, int(MEMORY_LIMIT_BYTES / max(self.each.memory_bytes, 1.0))))

    def images(self, channels: U8, progress: Progress) -> Iterator[Iterator[F64]]:
        """Yield the bands of several images in turn."""
        return one_by_one(self, channels, progress)

    def standard_error(self, rows: I64, cols: I64) -> float | None:
        """Return None: no chance."""
        return None
