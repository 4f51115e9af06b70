"""Noise of the reset."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from camsim.core.arrays import F64
from camsim.core.typed import Celsius, NonNegative, Number, check, validate
from camsim.sensor.stage import Context, ElectronicStage, add_normals


@dataclass(frozen=True, slots=True)
class ResetNoise(ElectronicStage):
    """kTC noise of the reset of a capacitor, normal; absent with correlated double sampling.

    sigma_e : standard deviation, electrons

    >>> ResetNoise(20.0).dark_noise_e(2.7)
    20.0
    """

    name: ClassVar = "reset_noise"
    stream: ClassVar = 6
    temporal: ClassVar = True

    sigma_e: NonNegative

    if TYPE_CHECKING:

        def __init__(self, sigma_e: Number) -> None: ...

    def __post_init__(self) -> None:
        validate(self)

    @classmethod
    def of_capacitance(cls, capacitance_ff: Number, temperature_c: Number = 25.0) -> ResetNoise:
        """Return the noise of a capacitance, √(kTC)/q, with Boltzmann's k and the elementary charge q of the SI.

        >>> round(ResetNoise.of_capacitance(1.6).sigma_e, 1)
        16.0
        """
        check(capacitance_ff, NonNegative, "capacitance_ff", cls.__name__)
        check(temperature_c, Celsius, "temperature_c", cls.__name__)
        energy_j = 1.380649e-23 * (temperature_c + 273.15)
        return cls(math.sqrt(energy_j * capacitance_ff * 1e-15) / 1.602176634e-19)

    def apply(self, electrons: F64, context: Context) -> F64:
        """Add normal noise."""
        normals = context.generator(self.stream).standard_normal(electrons.shape, dtype=np.float32)
        return add_normals(electrons, self.sigma_e, normals)

    def draws(self, shape: tuple[int, int], context: Context) -> int:
        """Return one normal for each photosite."""
        return shape[0] * shape[1]

    def dark_noise_e(self, electrons_per_dn: float) -> float:
        """Return the standard deviation of the noise, electrons."""
        return self.sigma_e
