"""Shot noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from camsim.core.arrays import F64
from camsim.core.kernels.counts import fill_counts
from camsim.sensor.stage import Context, ElectronicStage, Phase


@dataclass(frozen=True, slots=True)
class ShotNoise(ElectronicStage):
    """Shot noise of photons and dark electrons, which arrive one by one: a Poisson count of the mean charge.

    >>> ShotNoise().phases
    (<Phase.COUNT: 4>,)
    """

    name: ClassVar = "shot_noise"
    phases: ClassVar = (Phase.COUNT,)
    stream: ClassVar = 2
    temporal: ClassVar = True

    def apply(self, electrons: F64, context: Context) -> F64:
        """Replace mean charge by a Poisson count, made from one normal number so that it increases with the mean.

        A negative mean (possible within the tolerance of a rendering) counts as zero.
        """
        normals = context.generator(self.stream).standard_normal(electrons.size)
        counts = np.empty(electrons.shape)
        fill_counts(counts.reshape(-1), np.ravel(electrons), normals)
        return counts

    def draws(self, shape: tuple[int, int], context: Context) -> int:
        """Return one count for each photosite."""
        return shape[0] * shape[1]
