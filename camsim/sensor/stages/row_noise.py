"""Temporal offsets of rows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from camsim.core.arrays import F64
from camsim.core.typed import NonNegative, Number, validate
from camsim.sensor.stage import Context, ElectronicStage


@dataclass(frozen=True, slots=True)
class RowNoise(ElectronicStage):
    """Every row of every frame has a random offset, normal around 0, independent of other rows.

    sigma_e : standard deviation, electrons

    >>> RowNoise(0.3)
    RowNoise(sigma_e=0.3)
    """

    name: ClassVar = "row_noise"
    stream: ClassVar = 7
    temporal: ClassVar = True

    sigma_e: NonNegative

    if TYPE_CHECKING:

        def __init__(self, sigma_e: Number) -> None: ...

    def __post_init__(self) -> None:
        validate(self)

    def apply(self, electrons: F64, context: Context) -> F64:
        """Add one number to each row (the first axis)."""
        return electrons + self.sigma_e * context.generator(self.stream).standard_normal((len(electrons), 1))

    def draws(self, shape: tuple[int, int], context: Context) -> int:
        """Return one normal for each row."""
        return shape[0]

    def dark_noise_e(self, electrons_per_dn: float) -> float:
        """Return the standard deviation of the noise, electrons."""
        return self.sigma_e
