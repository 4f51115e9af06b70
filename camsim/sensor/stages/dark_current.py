"""Dark current."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

from annotated_types import Ge, Le

from camsim.core.arrays import F64
from camsim.core.typed import Celsius, Fraction, NonNegative, Number, check, validate
from camsim.sensor.stage import Context, ElectronicStage, Phase, gains


@dataclass(frozen=True, slots=True)
class DarkCurrent(ElectronicStage):
    """Mean charge that gathers without light; its shot noise is drawn with that of the light.

    e_per_s       : electrons per second and photosite, the mean over all photosites
    nonuniformity : standard deviation over photosites (DCNU), a fraction of the mean; log-normal above 0.25
    at_c          : temperature at which ``e_per_s`` holds, °C
    doubling_c    : warming that doubles it, °C

    >>> DarkCurrent(2.0, at_c=25.0, doubling_c=7.0)
    DarkCurrent(e_per_s=2.0, nonuniformity=0.0, at_c=25.0, doubling_c=7.0)
    """

    name: ClassVar = "dark_current"
    phases: ClassVar = (Phase.CHARGE,)
    stream: ClassVar = 5

    e_per_s: NonNegative
    nonuniformity: Fraction = 0.0
    at_c: Celsius = 25.0
    doubling_c: Annotated[float, Ge(1), Le(1000)] = 7.0

    if TYPE_CHECKING:

        def __init__(
            self, e_per_s: Number, nonuniformity: Number = 0.0, at_c: Number = 25.0, doubling_c: Number = 7.0
        ) -> None: ...

    def __post_init__(self) -> None:
        validate(self)

    def warming(self, temperature_c: float | None) -> float:
        """Return the current at a temperature, relative to ``e_per_s``; a temperature of None is ``at_c``.

        >>> DarkCurrent(1.0, at_c=20.0, doubling_c=6.0).warming(32.0)
        4.0
        """
        if temperature_c is None:
            return 1.0
        check(temperature_c, Celsius, "temperature_c", "Exposure")
        # No sensor is hotter than this; the power of two stays finite.
        factor: float = 2.0 ** min((temperature_c - self.at_c) / self.doubling_c, 500.0)
        return factor

    def apply(self, electrons: F64, context: Context) -> F64:
        """Add e_per_s · time to the mean charge, times each photosite's relative current."""
        dark_e = self.e_per_s * context.time_s * self.warming(context.temperature_c)
        if not self.nonuniformity:
            return electrons + dark_e
        return electrons + dark_e * gains(self.nonuniformity, context.normals(self.stream, electrons.shape))

    def draws(self, shape: tuple[int, int], context: Context) -> int:
        """Return the number of normals that are drawn for the pattern; a uniform current has none."""
        return context.normals_drawn(shape[0]) if self.nonuniformity else 0
