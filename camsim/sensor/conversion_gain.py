"""Dual conversion gain: a photosite with two capacitors, and which one is in use at an ISO setting."""

from __future__ import annotations

import math
from dataclasses import dataclass

from camsim.errors import InvalidValueError
from camsim.sensor.checked import check_number, check_positive


@dataclass(frozen=True, slots=True, kw_only=True)
class DualGain:
    """The high conversion gain: from an ISO setting on, less charge fits and reading it is quieter.

    from_iso     : the lowest setting that uses it
    capacity_e   : full well in this mode, electrons; None: as in the other
    read_noise_e : standard deviation in this mode, electrons; None: as in the other

    ``Adc.electrons_per_dn`` goes on in proportion to ISO: makers calibrate their settings across the switch.
    """

    from_iso: float
    capacity_e: float | None = None
    read_noise_e: float | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.from_iso) and self.from_iso > 0.0):
            raise InvalidValueError(f"{self.from_iso}; must be above 0 and finite", key="from_iso", stage="DualGain")
        if self.capacity_e is not None:
            check_positive("DualGain", "capacity_e", self.capacity_e)
        if self.read_noise_e is not None:
            check_number("DualGain", "read_noise_e", self.read_noise_e)
