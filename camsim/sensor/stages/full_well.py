"""Full well."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from camsim.core.arrays import F64
from camsim.core.typed import Number, Positive, validate
from camsim.sensor.stage import Context, ElectronicStage, Phase


@dataclass(frozen=True, slots=True)
class FullWell(ElectronicStage):
    """The largest number of electrons that a photosite holds.

    capacity_e : electrons, above 0

    >>> FullWell(10700.0)
    FullWell(capacity_e=10700.0)
    """

    name: ClassVar = "full_well"
    phases: ClassVar = (Phase.WELL,)
    without_noise: ClassVar = True

    capacity_e: Positive

    if TYPE_CHECKING:

        def __init__(self, capacity_e: Number) -> None: ...

    def __post_init__(self) -> None:
        validate(self)

    def apply(self, electrons: F64, context: Context) -> F64:
        """Clip the charge at the capacity."""
        held: F64 = np.minimum(electrons, self.capacity_e)
        return held
