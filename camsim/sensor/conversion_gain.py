"""Dual conversion gain: a photosite with two capacitors, and which one is in use at an ISO setting."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from camsim.typed import NonNegative, Number, Positive, judge, refusal


@dataclass(frozen=True, slots=True, kw_only=True)
class DualGain:
    """High conversion gain from an ISO setting on: a smaller full well and less read noise.

    from_iso     : the lowest setting that uses it
    capacity_e   : full well in this mode, electrons; None: as in the other
    read_noise_e : standard deviation in this mode, electrons; None: as in the other

    ``Adc.electrons_per_dn`` goes on in proportion to ISO: makers calibrate their settings across the switch.

    >>> DualGain(from_iso=800.0, capacity_e=8000.0, read_noise_e=1.2)
    DualGain(from_iso=800.0, capacity_e=8000.0, read_noise_e=1.2)
    """

    from_iso: Positive
    capacity_e: Positive | None = None
    read_noise_e: NonNegative | None = None

    if TYPE_CHECKING:

        def __init__(
            self, *, from_iso: Number, capacity_e: Number | None = None, read_noise_e: Number | None = None
        ) -> None: ...

    def __post_init__(self) -> None:
        judge(self)
        if self.capacity_e is None and self.read_noise_e is None:
            message = "neither full well nor read noise is given for this mode, which then is the other's; give one"
            raise refusal(self, "from_iso", message)
