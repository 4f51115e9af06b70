"""Noise of the read-out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from camsim.arrays import F64
from camsim.sensor.stage import Context, ElectronicStage, add_normals
from camsim.typed import NonNegative, Number, judge


@dataclass(frozen=True, slots=True)
class ReadNoise(ElectronicStage):
    """Normal noise of the read-out, referred to electrons.

    sigma_e : standard deviation, electrons

    >>> ReadNoise(2.4).dark_noise_e(2.7)
    2.4
    """

    name: ClassVar = "read_noise"
    stream: ClassVar = 3
    temporal: ClassVar = True

    sigma_e: NonNegative

    if TYPE_CHECKING:

        def __init__(self, sigma_e: Number) -> None: ...

    def __post_init__(self) -> None:
        judge(self)

    def apply(self, electrons: F64, context: Context) -> F64:
        """Add normal noise; charge may come out below zero."""
        normals = context.generator(self.stream).standard_normal(electrons.shape, dtype=np.float32)
        return add_normals(electrons, self.sigma_e, normals)

    def draws(self, shape: tuple[int, int], context: Context) -> int:
        """Return one normal for each photosite."""
        return shape[0] * shape[1]

    def dark_noise_e(self, electrons_per_dn: float) -> float:
        """Return its standard deviation."""
        return self.sigma_e
