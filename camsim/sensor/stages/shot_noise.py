"""Shot noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from camsim.core.arrays import F64
from camsim.sensor.stage import Context, ElectronicStage, Phase

# numpy's Poisson takes means up to about 9.2e18. No photosite holds even a billionth of that.
_LARGEST_MEAN_E = 1e18


@dataclass(frozen=True, slots=True)
class ShotNoise(ElectronicStage):
    """Photons and dark electrons arrive one by one: a Poisson count of the mean charge.

    >>> ShotNoise().phases
    (<Phase.COUNT: 4>,)
    """

    name: ClassVar = "shot_noise"
    phases: ClassVar = (Phase.COUNT,)
    stream: ClassVar = 2
    temporal: ClassVar = True

    def apply(self, electrons: F64, context: Context) -> F64:
        """Replace mean charge by a Poisson count (above 1e13 rounding affects its standard deviation).

        A negative mean (possible within the tolerance of a rendering) counts as zero.
        """
        rng = context.generator(self.stream)
        return rng.poisson(np.clip(electrons, 0.0, _LARGEST_MEAN_E)).astype(np.float64, copy=False)

    def draws(self, shape: tuple[int, int], context: Context) -> int:
        """Return one count for each photosite."""
        return shape[0] * shape[1]
