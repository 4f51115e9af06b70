"""Pictures behind a system: the near part of the pattern by transforms, tile by tile, the rest on a coarse lattice.

The pattern is tapered as in the Fourier engine, from 1 at ``inner`` to 0 at ``outer``. Where all lies nearer than
``inner`` that is all. Of a larger picture the rest of the pattern, (1 − taper) × pattern, is smooth but for its rings,
which a field hears only by what it has at the cut-off frequency: they are averaged over, and what is left is folded
with the picture on a coarse lattice (far.py). So no light is left out, however far away it comes from.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, U8
from camsim.kept import cached_property
from camsim.optics import OpticalSystem
from camsim.optics.protocols import KnowsEnergy, KnowsTail, Round
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.edges import Edges
from camsim.rendering.engine import MEMORY_LIMIT_BYTES, Cost
from camsim.rendering.fast_length import fast_length
from camsim.rendering.fields.aligned import Aligned
from camsim.rendering.fields.cost import Prices, pattern_rows, quickest, too_large, unknown_reach, windows
from camsim.rendering.fields.far import Beyond
from camsim.rendering.fields.layer import Layer, reach_of
from camsim.rendering.fields.light import Lattice, Samples
from camsim.rendering.fields.points import PointLayer
from camsim.rendering.fields.quiet import Reach, for_pictures, parted, quiet_distance
from camsim.rendering.fields.samples import parts_of, samples_of
from camsim.rendering.fields.scenery import Fields
from camsim.rendering.fourier.image import FourierImage
from camsim.rendering.fourier.lens_curves import LensCurves
from camsim.rendering.fourier.spread import Kernel
from camsim.rendering.fourier.task import check_tolerance, spreading_precision
from camsim.rendering.fourier.tile import Tile
from camsim.repeated import Channels

TILE_SIDES = (1 << 14, 2048, 1024, 512, 256, 128)  # photosites along a tile, the largest that keeps within the memory
_ROW_BYTES = 16.0  # of a photosite in a row of tiles: what is there, and the light from far away
MOST_FREQUENCIES = 4.0  # of a lattice of its own, for each sample and each frequency of the band


@dataclass(frozen=True, kw_only=True, eq=False)
class FieldImage:
    """Layers behind a system.

    layers        : pictures, placed, in pitches
    density       : (planes, channels, j) what each plane of each layer gives each channel at each wavelength
    wavelength_nm : (j,)
    tolerance     : largest error, in the unit of ``density``
    rings_until   : a difference's pattern is taken as far, pitches, as its rings are heard in step
    """

    layers: Sequence[Layer | PointLayer]
    density: F64
    wavelength_nm: F64
    system: OpticalSystem
    pitch_um: float
    tolerance: float
    rings_until: float = 0.0
    memory_limit_bytes: float = MEMORY_LIMIT_BYTES

    def rendered(
        self, origin: tuple[float, float], channel: U8, progress: Callable[[float], None] = lambda done: None
    ) -> F64:
        """Render every photosite in its own channel, what the layers add to the background.

        origin  : x, y of the first photosite's centre, pitches
        channel : (..., rows, cols) index of each photosite's channel
        """
        image, row = np.zeros(channel.shape), 0
        for band in self.bands(origin, channel, progress):
            if band.shape == image.shape:
                return band
            image[..., row : row + band.shape[-2], :] = band
            row += band.shape[-2]
        return image

    def bands(
        self, origin: tuple[float, float], channel: Channels, progress: Callable[[float], None] = lambda done: None
    ) -> Iterator[F64]:
        """Yield the same from the top, a row of tiles at a time."""
        check_tolerance(self.tolerance)
        shape = channel.shape[-2], channel.shape[-1]
        reach, side, cost = self._planned(origin, shape)
        if cost.memory_bytes > self.memory_limit_bytes:
            why = unknown_reach(self.system, self._extent(origin, shape))
            raise too_large(cost.memory_bytes, self.memory_limit_bytes, why)
        parts = windows(shape, side)
        shells = self._beyond(reach).shells(origin, shape) if reach.far else []
        for done, (row, col, rows, cols) in enumerate(parts):
            if col == 0:
                here = channel[..., row : row + rows, :]
                band = np.zeros(here.shape)
            part = (..., slice(col, col + cols))
            at = origin[0] + col, origin[1] + row
            low, high, tile = self._tile(at, (rows, cols), reach)
            band[part] += self._window(at, low, high, tile, reach, here[part])
            progress((done + 1) / len(parts))
            if col + cols == shape[1]:
                for shell in shells:
                    shell.add(row, here, band)
                yield band

    def _window(self, at: tuple[float, float], low: F64, high: F64, tile: Tile, reach: Reach, channel: U8) -> F64:
        """Return what a window's photosites see within the reach: lattices along their rows, then the rest."""
        image = np.zeros(channel.shape)
        kernel = self._kernel
        fields, rows = (0, 1) if kernel.round else (self._prices.fields(tile), pattern_rows(kernel, tile))
        plan = reach.sizes(tile, self.density.shape[0], self.density.shape[1], fields, rows)
        rest: dict[int, Samples] = {}
        for k, layer in enumerate(self.layers):
            along = self._is_aligned(layer, tile)
            samples = samples_of(layer, low, high, cut=tile.cut, allowed=self._precision, origin=at, aligned=along)
            if samples is None:
                continue
            if samples.lattice is not None:
                image += self._aligned(k, samples.lattice, tile).image(channel)
            if samples.strengths.size or samples.corrections.size:
                rest[k] = samples
        if rest:
            scenery = Fields(tile=tile, plan=plan, samples=[*rest.values()], precision=self._precision)
            optics = self._optics([*rest])
            image += optics.tile_image(tile, plan, scenery, channel, optics.contrast)
        return image

    def expected(self, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[Cost, float]:
        """Return what rows and columns from ``origin`` on are expected to take, and the number of frequencies."""
        reach, side, cost = self._planned(origin, shape)
        return cost, sum(tile.points for _, tile, _ in self._tiles(origin, shape, side, reach))

    def sight(self, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[float, float]:
        """Return how far the pattern reaches, and how far apart a window's photosites and the pictures may lie."""
        return self._kernel.reach, float(np.hypot(*self._extent(origin, shape)))

    def reach(self, origin: tuple[float, float], shape: tuple[int, int]) -> Reach:
        """Return how the pattern is parted for a window."""
        if (origin, shape) in self._reaches:
            return self._reaches[origin, shape]
        quiet: Callable[[float], float] | None = None
        budget, lens = ErrorBudget(self.tolerance), self.system.lens
        if self._kernel.round and isinstance(lens, KnowsEnergy) and not self.system.more:
            quiet = functools.partial(
                quiet_distance, self.layers, self.system, self.wavelength_nm, self.density, self.pitch_um,
                self._kernel, self._footprint, allowed=0.5 * budget.allowed("reach"),
            )  # fmt: skip
        hem = budget.allowed("hem" if isinstance(lens, KnowsTail) else "taper")
        self._reaches[origin, shape] = parted(self._kernel, self._extent(origin, shape), shape, hem, quiet)
        return self._reaches[origin, shape]

    @cached_property
    def _reaches(self) -> dict[tuple[tuple[float, float], tuple[int, int]], Reach]:
        return {}

    @cached_property
    def _precision(self) -> float:
        return spreading_precision(self.tolerance)

    @cached_property
    def _kernel(self) -> Kernel:
        kernel = self._optics(range(len(self.layers))).kernel
        budget = ErrorBudget(self.tolerance)
        return for_pictures(kernel, self.system, self.wavelength_nm, self.pitch_um, budget, self.rings_until)

    def _optics(self, layers: Sequence[int]) -> FourierImage:
        """Return what multiplies some layers' planes by lens and photosite: they stand for regions on no background.

        One for the same layers: windows of one size share transfers.
        """
        if (key := tuple(layers)) in self._of_layers:
            return self._of_layers[key]
        first = np.cumsum([0, *(layer.planes for layer in self.layers)])
        planes = np.concatenate([np.arange(first[k], first[k + 1]) for k in layers])
        nothing, none = np.zeros((1, *self.density.shape[1:])), np.empty(0, np.int64)
        self._of_layers[key] = FourierImage(
            edges=Edges(start=np.empty((0, 2)), end=np.empty((0, 2)), left=none, right=none),
            density=np.concatenate([nothing, self.density[planes]]),
            base=np.zeros(self.density.shape[1]),
            wavelength_nm=self.wavelength_nm,
            system=self.system,
            pitch_um=self.pitch_um,
            tolerance=self.tolerance,
        )
        return self._of_layers[key]

    @cached_property
    def _of_layers(self) -> dict[tuple[int, ...], FourierImage]:
        return {}

    def _is_aligned(self, layer: Layer | PointLayer, tile: Tile) -> bool:
        """Whether a layer's samples lie along the photosites' rows, and not too closely for a lattice of their own."""
        frequencies = tile.periods[0] * tile.periods[1] / self._step(layer) ** 2
        points = layer.shape[0] * layer.shape[1] * parts_of(layer, self._kernel.cutoff) ** 2 + tile.points
        return self._kernel.round and layer.upright and bool(frequencies <= MOST_FREQUENCIES * points)

    def _aligned(self, number: int, lattice: Lattice, tile: Tile) -> Aligned:
        first = sum(layer.planes for layer in self.layers[:number])
        density = self.density[first : first + self.layers[number].planes]
        return Aligned(
            lattice=lattice, tile=tile, kernel=self._kernel,
            density=density if self.system.chromatic else density.sum(axis=2, keepdims=True),
            curves=self._curves, system=self.system, pitch_um=self.pitch_um,
            tolerance=self.tolerance, precision=self._precision,
        )  # fmt: skip

    @cached_property
    def _curves(self) -> LensCurves:
        """What gives a round lens to lattices: windows of one size share it."""
        assert isinstance(self.system.lens, Round)
        wavelength_nm = self.wavelength_nm if self.system.chromatic else self.wavelength_nm[:1]
        return LensCurves(self.system.lens, wavelength_nm, self.pitch_um, self._kernel)

    @cached_property
    def _footprint(self) -> float:
        """How far OLPF and photosite reach, pitches."""
        return float(self._optics(range(len(self.layers))).footprint.max())

    def _extent(self, origin: tuple[float, float], shape: tuple[int, int]) -> F64:
        """Return how far along x and y a photosite and a seen part of a picture may lie apart."""
        corners = np.concatenate([layer.corners for layer in self.layers]) - np.array(origin)
        size = np.array([shape[1] - 1.0, shape[0] - 1.0])
        apart: F64 = np.maximum(np.maximum(corners.max(axis=0), size - corners.min(axis=0)), 0.0) + self._footprint
        return apart

    def _tile(self, origin: tuple[float, float], shape: tuple[int, int], reach: Reach) -> tuple[F64, F64, Tile]:
        """Return the box whose samples matter to a window, from its first photosite, and the window as a tile."""
        size = np.array([shape[1] - 1.0, shape[0] - 1.0])
        beyond = np.array(reach.outer) + self._footprint
        corners = np.concatenate([layer.corners for layer in self.layers]) - np.array(origin)
        low = np.maximum(-beyond, corners.min(axis=0))
        high = np.minimum(size + beyond, corners.max(axis=0))
        wide = 3.0 * max(reach_of(layer.degree, self._step(layer)) for layer in self.layers)
        extent = np.maximum(np.maximum(high, size - low), 0.0) + wide
        if not self._kernel.round and min(reach.inner) == self._kernel.reach:
            extent = size + beyond + wide  # wherever a window lies: those of one size share transfers
        periods = [fast_length(math.ceil(value), real=True) for value in extent + beyond]
        cut = self._kernel.cutoff + reach.band
        tile = Tile(
            row=0, col=0, rows=shape[0], cols=shape[1], inner=reach.inner, outer=reach.outer,
            periods=(max(periods[0], 2), max(periods[1], 2)), cut=cut,
            low=(float(low[0]), float(low[1])), high=(float(high[0]), float(high[1])), sharpness=reach.sharpness,
        )  # fmt: skip
        return low, high, tile

    def _step(self, layer: Layer | PointLayer) -> float:
        """Return the distance of a layer's samples once they are refined."""
        return layer.step / parts_of(layer, self._kernel.cutoff)

    @cached_property
    def _prices(self) -> Prices:
        planes, channels, wavelengths = self.density.shape
        return Prices(
            layers=self.layers,
            steps=[self._step(layer) for layer in self.layers],
            kernel=self._kernel,
            shape=(planes, channels, wavelengths),
            memory_limit_bytes=self.memory_limit_bytes,
        )

    def _planned(self, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[Reach, int, Cost]:
        """Return how the pattern is parted, the side of tiles, and what they take: priced once, to be rendered."""
        if (origin, shape) in self._plans:
            return self._plans[origin, shape]
        reach = self.reach(origin, shape)
        sides = [side for side in TILE_SIDES if side == TILE_SIDES[0] or side < max(shape)]
        each = [(side, self._prices.of(self._tiles(origin, shape, side, reach))) for side in sides]
        rows = {side: _ROW_BYTES * min(side, shape[0]) * shape[1] for side in sides}
        side, own = quickest(each, rows, self.memory_limit_bytes)
        cost = Cost(seconds=own.seconds, memory_bytes=own.held_bytes + rows[side])
        self._plans[origin, shape] = reach, side, cost
        return self._plans[origin, shape]

    @cached_property
    def _plans(self) -> dict[tuple[tuple[float, float], tuple[int, int]], tuple[Reach, int, Cost]]:
        return {}

    def _tiles(
        self, origin: tuple[float, float], shape: tuple[int, int], side: int, reach: Reach
    ) -> Iterator[tuple[tuple[F64, F64], Tile, list[bool]]]:
        """Yield each window's box of samples, its tile, and which layers are lattices there."""
        for row, col, rows, cols in windows(shape, side):
            low, high, tile = self._tile((origin[0] + col, origin[1] + row), (rows, cols), reach)
            yield (low, high), tile, [self._is_aligned(layer, tile) for layer in self.layers]

    def _beyond(self, reach: Reach) -> Beyond:
        return Beyond(
            layers=self.layers,
            density=self.density,
            wavelength_nm=self.wavelength_nm,
            system=self.system,
            pitch_um=self.pitch_um,
            inner=reach.inner[0],
            outer=reach.outer[0],
            sharpness=reach.sharpness,
            light=self._kernel.light(reach.inner[0]) / ErrorBudget(self.tolerance).allowed("reach"),
        )
