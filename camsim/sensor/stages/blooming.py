"""Blooming."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from camsim.core.arrays import F64
from camsim.core.typed import Fraction, Number, validate
from camsim.errors import InvalidValueError
from camsim.sensor.stage import Context, ElectronicStage, Phase
from camsim.sensor.stages.full_well import FullWell


@dataclass(frozen=True, slots=True)
class Blooming(ElectronicStage):
    """Charge above the full well that runs up and down its column, as in a CCD without drains.

    spill : fraction of the excess that moves on, half of it upwards; the rest is drained. 0..1

    Charge that leaves the window is lost, and none comes in from outside.

    >>> Blooming(spill=0.8)
    Blooming(spill=0.8)
    """

    name: ClassVar = "blooming"
    phases: ClassVar = (Phase.WELL,)
    without_noise: ClassVar = True
    whole_window: ClassVar = True

    spill: Fraction = 1.0

    if TYPE_CHECKING:

        def __init__(self, spill: Number = 1.0) -> None: ...

    def __post_init__(self) -> None:
        validate(self)

    def lacks(self, others: Sequence[ElectronicStage]) -> str:
        """Return a message if the camera has no full well, above which charge blooms."""
        there = any(isinstance(stage, FullWell) for stage in others)
        return "" if there else "there is no full_well that charge could spill over; give one"

    def apply(self, electrons: F64, context: Context) -> F64:
        """Spill charge above the sensor's full well along the columns of the whole window."""
        well = context.other(FullWell)
        if well is None:
            raise InvalidValueError(self.lacks(()), key=self.name)
        return self.spilt(electrons, capacity_e=well.capacity_e)

    def spilt(self, electrons: F64, *, capacity_e: float) -> F64:
        """Return the charge of a whole window (rows, cols) after blooming, at most ``capacity_e``.

        >>> Blooming().spilt(np.array([[0.0], [150.0], [30.0]]), capacity_e=100.0).ravel()
        array([ 25., 100.,  55.])
        """
        held = np.minimum(electrons, capacity_e)
        running = (0.5 * self.spill) * (electrons - held)
        if not running.any():
            return held
        for order in (range(len(held)), range(len(held) - 1, -1, -1)):
            carried = np.zeros(held.shape[1])
            for row in order:
                taken = np.minimum(carried, capacity_e - held[row])
                held[row] += taken
                carried += running[row] - taken
        return held
