"""Dark-signal non-uniformity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from camsim.core.arrays import F64
from camsim.core.typed import NonNegative, Number, validate
from camsim.sensor.stage import Context, ElectronicStage, add_normals


@dataclass(frozen=True, slots=True)
class Dsnu(ElectronicStage):
    """Dark-signal non-uniformity: every photosite has a different offset, normal around 0.

    sigma_e : standard deviation of the offset, electrons

    >>> Dsnu(0.6)
    Dsnu(sigma_e=0.6)
    """

    name: ClassVar = "dsnu"
    stream: ClassVar = 4

    sigma_e: NonNegative

    if TYPE_CHECKING:

        def __init__(self, sigma_e: Number) -> None: ...

    def __post_init__(self) -> None:
        validate(self)

    def apply(self, electrons: F64, context: Context) -> F64:
        """Add each photosite's offset."""
        return add_normals(electrons, self.sigma_e, context.normals(self.stream, electrons.shape))

    def draws(self, shape: tuple[int, int], context: Context) -> int:
        """Return the number of normals that are drawn for the pattern."""
        return context.normals_drawn(shape[0])
