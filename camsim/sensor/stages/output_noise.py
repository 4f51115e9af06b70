"""Noise after the gain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from camsim.core.arrays import F64
from camsim.core.typed import NonNegative, Number, validate
from camsim.sensor.stage import Context, ElectronicStage, add_normals


@dataclass(frozen=True, slots=True)
class OutputNoise(ElectronicStage):
    """Normal noise that comes in after the gain: the same in data numbers at every ISO.

    sigma_dn : standard deviation, data numbers

    >>> OutputNoise(0.5).dark_noise_e(2.5)
    1.25
    """

    name: ClassVar = "output_noise"
    stream: ClassVar = 9
    temporal: ClassVar = True

    sigma_dn: NonNegative

    if TYPE_CHECKING:

        def __init__(self, sigma_dn: Number) -> None: ...

    def __post_init__(self) -> None:
        validate(self)

    def apply(self, electrons: F64, context: Context) -> F64:
        """Add normal noise, converted to electrons."""
        normals = context.generator(self.stream).standard_normal(electrons.shape, dtype=np.float32)
        return add_normals(electrons, self.dark_noise_e(context.electrons_per_dn), normals)

    def draws(self, shape: tuple[int, int], context: Context) -> int:
        """Return one normal for each photosite."""
        return shape[0] * shape[1]

    def dark_noise_e(self, electrons_per_dn: float) -> float:
        """Return the standard deviation of the noise in electrons."""
        return self.sigma_dn * electrons_per_dn
