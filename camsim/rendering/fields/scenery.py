"""Layers on one tile, transformed block by block, as the Fourier engine takes scenes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from camsim.arrays import C128, F64
from camsim.rendering.fields.light import Samples
from camsim.rendering.fourier.blocks import Block, Strip, strips
from camsim.rendering.fourier.kernels import SceneBlock
from camsim.rendering.fourier.plan import Sizes
from camsim.rendering.fourier.regions import phases_of, sums_of_waves
from camsim.rendering.fourier.tile import Tile


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Fields:
    """What lies about a tile; ``precision`` of the non-uniform transforms, relative."""

    tile: Tile
    plan: Sizes
    samples: Sequence[Samples]
    precision: float

    @property
    def areas(self) -> F64:
        """The light (planes,) of every plane."""
        return np.concatenate([s.strengths.sum(axis=1) + s.corrections.sum(axis=1) for s in self.samples])

    def blocks(self) -> Iterator[tuple[Block, SceneBlock]]:
        """Yield the band block by block, with 4π²|k|² times the transform of each plane."""
        areas = self.areas
        for strip in strips(self.tile, self.plan.strip_points):
            whole = [values for samples in self.samples for values in self._transformed(strip, samples)]
            for block in strip.blocks(self.tile, self.plan.block_points):
                transforms = np.empty((areas.size, block.count_j, 2, block.count_i))
                for own, values in zip(transforms, whole, strict=True):
                    part = strip.part(values, block)
                    own[:, 0], own[:, 1] = part.real, part.imag
                yield block, SceneBlock(transforms, areas)

    def _transformed(self, strip: Strip, samples: Samples) -> Iterator[C128]:
        px, py = self.tile.periods
        kx = np.arange(strip.count_i) / px
        ky = ((strip.first_j + np.arange(strip.count_j)) / py)[:, None]
        scale = 4.0 * np.pi**2 * (kx * kx + ky * ky)
        spline = np.ones((1, 1))
        for across, down in samples.axes:
            # Along the rows of photosites one of the two is no function of the other's frequencies.
            along = samples.step * (
                across * kx + down * ky if across and down else across * kx if across else down * ky
            )
            spline = spline * np.sinc(along) ** (samples.degree + 1)
        spline = spline * scale
        for strengths, corrections in zip(samples.strengths, samples.corrections, strict=True):
            values = spline * self._sums(strip, samples.places, strengths)
            if corrections.size:
                values += scale * self._sums(strip, samples.points, corrections)
            yield values

    def _sums(self, strip: Strip, places: F64, strengths: F64) -> C128:
        return sums_of_waves(strip, self.tile, phases_of(places, self.tile), strengths.astype(complex), self.precision)
