"""Photo-response non-uniformity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from camsim.core.arrays import F64
from camsim.core.typed import Fraction, Number, validate
from camsim.sensor.stage import Context, ElectronicStage, Phase, gains


@dataclass(frozen=True, slots=True)
class Prnu(ElectronicStage):
    """Photo-response non-uniformity: every photosite has a different gain, normal around 1 (log-normal above 0.25).

    fraction : standard deviation of the gain, 0..1

    >>> Prnu(0.006)
    Prnu(fraction=0.006)
    """

    name: ClassVar = "prnu"
    phases: ClassVar = (Phase.LIGHT,)
    stream: ClassVar = 1

    fraction: Fraction

    if TYPE_CHECKING:

        def __init__(self, fraction: Number) -> None: ...

    def __post_init__(self) -> None:
        validate(self)

    def apply(self, electrons: F64, context: Context) -> F64:
        """Multiply the mean charge by each photosite's gain."""
        lit = gains(self.fraction, context.normals(self.stream, electrons.shape))
        lit *= electrons
        return lit

    def draws(self, shape: tuple[int, int], context: Context) -> int:
        """Return the number of normals that are drawn for the pattern."""
        return context.normals_drawn(shape[0])
