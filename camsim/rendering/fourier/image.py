"""The exact Fourier engine: any lens, any photosite (docs/mathematics.md has its error model).

The transform of the regions is known exactly, edge by edge. Times the transfer of every stage, added up over the
aliases of the photosites' lattice, and one inverse transform per channel: that is the image, with a kernel tapered to
0 before the period could wrap it round (plan.py).
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np

from camsim.arrays import F64, U8
from camsim.kept import cached_property
from camsim.kernels import ahead, shared
from camsim.optics import OpticalSystem
from camsim.optics.protocols import KnowsTail, Round
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.edges import Edges
from camsim.rendering.engine import MEMORY_LIMIT_BYTES, OF_LIMIT, Cost, too_much
from camsim.rendering.fourier.apart import parts_of
from camsim.rendering.fourier.blocks import Block
from camsim.rendering.fourier.clamped import clamped
from camsim.rendering.fourier.density import Density
from camsim.rendering.fourier.joint import joint_stages
from camsim.rendering.fourier.kernels import SceneBlock, add_fields, add_round
from camsim.rendering.fourier.lens import Fields, Footprints, passing
from camsim.rendering.fourier.lens_curves import LensCurves
from camsim.rendering.fourier.lens_fields import LensFields
from camsim.rendering.fourier.loudness import Loudness
from camsim.rendering.fourier.photosites import Collected, collected
from camsim.rendering.fourier.plan import Sizes, plan_sizes, rank
from camsim.rendering.fourier.regions import Regions
from camsim.rendering.fourier.shells import Shell
from camsim.rendering.fourier.spread import Kernel, kernel_of, with_band
from camsim.rendering.fourier.task import Task, check_tolerance, spectra_of_edge
from camsim.rendering.fourier.tile import Tile
from camsim.rendering.fourier.together import Part, Sum
from camsim.rendering.hearing import Hearing
from camsim.rendering.spectral import fewer, kinds

OF_WAVELENGTHS = 1e-3  # of what these may leave: what mixtures of spectra may be wrong by
WORTH = 0.8  # of the time that mixtures take, what the spectra themselves may: they hold more

Alike: TypeAlias = tuple[F64, F64]  # how much of each of few spectra there is in every one, and what those few give


class Scenery(Protocol):
    """What is transformed on a tile."""

    def blocks(self) -> Iterator[tuple[Block, SceneBlock]]:
        """Yield the band block by block, with 4π²|k|² times the transform of everything that has a spectrum."""
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class FourierImage:
    """Regions behind a system, to be rendered by transforms.

    edges         : pitches; the regions they bound are closed
    density       : (spectra, channels, j) what each spectrum gives each channel at each wavelength
    base          : (channels,) the background
    wavelength_nm : (j,)
    tolerance     : largest error, in the unit of ``density``;  memory_limit_bytes: what the plan keeps below if it can
    shell         : part of a pattern, by distance; None: all of it;  islands: how many of these edges are one of
    whole         : of which this is a shell, or an island;  undivided: it has none, as long as it fits the memory
    rings_until   : a difference's pattern is taken as far, see ``Job``
    over_rectangle : a round pattern is taken over a rectangle, not as a curve
    hearing       : what tells which sides are heard far off;  quiet: from where on rings are within their shares
    """

    edges: Edges
    density: F64
    base: F64
    wavelength_nm: F64
    system: OpticalSystem
    pitch_um: float
    tolerance: float
    memory_limit_bytes: float = MEMORY_LIMIT_BYTES
    rings_until: float = 0.0
    shell: Shell | None = None
    hearing: Hearing = Loudness.of
    quiet: Callable[[], float] | None = None
    whole: FourierImage | None = None
    islands: int = 1
    undivided: bool = False
    over_rectangle: bool = False

    def rendered(
        self, origin: tuple[float, float], channel: U8, progress: Callable[[float], None] = lambda done: None
    ) -> F64:
        """Render every photosite in its own channel.

        origin   : x, y of the first photosite's centre, pitches
        channel  : (..., rows, cols) index of each photosite's channel; several images share all but their last sum
        progress : told the fraction done

        Raises InvalidValueError for a tolerance out of range, or where it would take more memory than the limit.
        """
        check_tolerance(self.tolerance)
        image = self.base[channel]
        if not len(self.edges) or not np.any(self.density[1:] != self.density[0]):
            progress(1.0)
            return image
        shape = (channel.shape[-2], channel.shape[-1])
        if parts := self.parts(origin, shape):
            return image + Sum(parts=parts).rendered(origin, channel, progress)
        plan, (shares, contrast) = self._planned(origin, shape)
        if plan.memory_bytes > (most_bytes := OF_LIMIT * self.memory_limit_bytes):
            raise too_much("fourier", plan.memory_bytes, most_bytes)

        def tiled(tile: Tile) -> tuple[Tile, F64 | None]:
            seen = clamped(self.edges, tile.low, tile.high, (origin[0] + tile.col, origin[1] + tile.row))
            regions = Regions.of(seen, tile, plan, shares, self.tolerance / self.kernel.carries)
            if not regions.seen:
                return tile, None  # all that could be seen lies elsewhere
            return tile, self.tile_image(tile, plan, regions, channel[tile.part], contrast)

        for done, (tile, values) in enumerate(ahead(tiled, plan.tiles, plan.at_once), start=1):
            if values is not None:
                image[tile.part] += values
            progress(done / len(plan.tiles))
        if self.islands > 1:
            self.__dict__.pop("_fields", None)  # its transfers, before the next one's are made
        return image

    def expected(self, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[Cost, float]:
        """Return what rows and columns from ``origin`` on are expected to take, and the number of frequencies."""
        if not len(self.edges):
            return Cost(seconds=0.0, memory_bytes=8.0 * shape[0] * shape[1]), 0.0
        if parts := self.parts(origin, shape):
            return Sum(parts=parts).expected(origin, shape)
        return self.at_once(origin, shape)

    def at_once(self, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[Cost, float]:
        """Return the same without parts."""
        plan, _ = self._planned(origin, shape)
        return Cost(seconds=plan.seconds, memory_bytes=plan.memory_bytes), sum(tile.points for tile in plan.tiles)

    def parts(self, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[Part, ...]:
        """Return parts by distance or by place, where they take less than all at once; else none."""
        if self.shell is not None:
            return ()
        if (origin, shape) not in self._apart:
            self._apart[origin, shape] = parts_of(self, origin, shape)
        return self._apart[origin, shape]

    def shell_of(self, shell: Shell) -> FourierImage:
        """Return a part of the pattern, by distance."""
        return dataclasses.replace(self, base=np.zeros_like(self.base), shell=shell, whole=self)

    def island_of(self, edges: Edges, islands: int) -> FourierImage:
        """Return a part of the scene, one of so many."""
        return dataclasses.replace(self, base=np.zeros_like(self.base), edges=edges, islands=islands, whole=self)

    @cached_property
    def _apart(self) -> dict[tuple[tuple[float, float], tuple[int, int]], tuple[Part, ...]]:
        return {}

    @cached_property
    def lit(self) -> tuple[F64, F64]:
        """Wavelengths and densities that are told apart: one where the system treats all alike."""
        if self.system.chromatic:
            return self.wavelength_nm, self.density
        return self.wavelength_nm[:1], self.density.sum(axis=2, keepdims=True)

    @cached_property
    def contrast(self) -> F64:
        """What every spectrum gives against the background's: (spectra, channels, j)."""
        against: F64 = self.lit[1][1:] - self.lit[1][0]
        return against

    @cached_property
    def _kinds(self) -> tuple[F64, F64]:
        return kinds(self.contrast) if self.whole is None else self.whole._kinds

    @cached_property
    def _ways(self) -> tuple[Alike, ...]:
        """The spectra, greys together; and again as mixtures of fewer, if they are, each then part of most edges."""
        if self.whole is not None:
            return self.whole._ways
        off = OF_WAVELENGTHS * ErrorBudget(self.tolerance).allowed("wavelengths") / self.contrast.shape[2]
        plain, few = self._kinds, fewer(*self._kinds, off)
        return (plain,) if few[1] is plain[1] else (plain, few)

    @cached_property
    def kernel(self) -> Kernel:
        """What the plan has to know of the lens."""
        if self.whole is not None:
            known = self.whole.kernel
            return dataclasses.replace(known, tapers=self.islands) if self.shell is None else self.shell.kernel(known)
        known = kernel_of(self.system, self.lit[0], self.pitch_um, self.tolerance, over_rectangle=self.over_rectangle)
        if known.round and known.tapered and not isinstance(self.system.lens, KnowsTail):  # its transfer is overlaps
            known = with_band(known, self.system, self.lit[0], *self._kinds, self.tolerance)
        return dataclasses.replace(known, reach=max(known.reach, self.rings_until))

    @cached_property
    def footprint(self) -> F64:
        """How far a photosite sees along x and along y, pitches."""
        extent_um: F64 = np.abs(self.system.spots_um()).max(axis=0) + self.system.photosite.half_extent_um
        return extent_um / self.pitch_um

    @cached_property
    def _plans(self) -> dict[tuple[tuple[float, float], tuple[int, int]], tuple[Sizes, Alike]]:
        return {}

    @cached_property
    def _density(self) -> Density:
        """Where the edges are; all shells are asked for the same."""
        return Density.of(self.edges) if self.shell is None or self.whole is None else self.whole._density

    def _planned(self, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[Sizes, Alike]:
        """Return tiles and settings, and the spectra as transformed: chosen once, to be priced and rendered."""
        known = self._plans.get((origin, shape))
        if known is None:
            ways = [(self._plan(np.array(origin), shape, alike), alike) for alike in self._ways]
            sooner = rank(ways[0][0], self.memory_limit_bytes) < (False, WORTH * ways[-1][0].seconds)
            known = self._plans[origin, shape] = ways[0 if sooner else -1]
        return known

    def _plan(self, origin: F64, shape: tuple[int, int], alike: Alike) -> Sizes:
        """Choose tiles and settings."""
        shares, contrast = alike
        spectra, channels, wavelengths = contrast.shape
        return plan_sizes(
            Task(
                kernel=self.kernel,
                shape=shape,
                low=self._density.low - origin,
                high=self._density.high - origin,
                footprint=self.footprint,
                joint=bool(joint_stages(self.system)),
                edges=len(self.edges),
                density=self._density,
                origin=origin,
                spectra=spectra,
                spectra_of_edge=spectra_of_edge(self.edges, shares),
                channels=channels,
                wavelengths=wavelengths,
                tolerance=self.tolerance,
                memory_limit_bytes=self.memory_limit_bytes,
            )
        )

    def tile_image(self, tile: Tile, plan: Sizes, regions: Scenery, channel: U8, contrast: F64) -> F64:
        """Return a tile's image less the background; contrast (spectra, channels, j) of the regions against that."""
        image = np.empty(channel.shape)
        present = np.array([k for k in range(contrast.shape[1]) if (channel == k).any()])
        for some in np.split(present, range(plan.channels, present.size, plan.channels)):
            found = collected(tile, some.size)
            self._collect(found, tile, plan, regions, contrast[:, some])
            for k, values in zip(some, found.images(), strict=True):
                np.copyto(image, values, where=channel == k)
        return image

    def _collect(self, found: Collected, tile: Tile, plan: Sizes, regions: Scenery, contrast: F64) -> None:
        """Add up the image's transform block by block; contrast: (spectra, channels, j) against the background."""
        if self.kernel.round:
            curves = self._curves.of(tile, contrast)
            for block, scene in regions.blocks():
                total, place = found.room(block)
                more = scene, self._footprints.on(block, tile), curves, place
                shared(total.shape[1], functools.partial(add_round, total, *more))
                found.take(block, total)
            return
        for fields, weights in self._fields.of(tile, plan, contrast):
            self._collect_fields(found, tile, regions, fields, weights)
            del fields  # or these transfers would stay until the next are made

    def _collect_fields(self, found: Collected, tile: Tile, regions: Scenery, fields: Fields, weights: F64) -> None:
        for block, scene, values in passing(fields, regions.blocks()):
            total, place = found.room(block)
            more = scene, self._footprints.on(block, tile), values, weights, place
            shared(total.shape[1], functools.partial(add_fields, total, *more))
            found.take(block, total)

    @cached_property
    def _footprints(self) -> Footprints:
        return Footprints(self.system, self.pitch_um)

    @cached_property
    def _curves(self) -> LensCurves:
        """What gives a round lens, or its shell, on a block."""
        assert isinstance(self.system.lens, Round)
        pattern = self.system.lens if self.shell is None else self.shell.of(self.system.lens, self.pitch_um)
        return LensCurves(pattern, self.lit[0], self.pitch_um, self.kernel)

    @cached_property
    def _fields(self) -> LensFields:
        """What gives a lens that is not round on a block."""
        return LensFields(self.system, self.lit[0], self.pitch_um, self.kernel, self.tolerance)
