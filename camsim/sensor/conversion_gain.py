"""Dual conversion gain: a photosite with two capacitors, chosen by ISO setting or both read after one exposure."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from camsim.core.arrays import F64
from camsim.core.typed import NonNegative, Number, Positive, refusal, validate
from camsim.sensor.adc import Adc
from camsim.sensor.companding import LARGEST

ReadOut: TypeAlias = Literal["merged", "low", "high"]

_MERGED_TO = 0.9
"""Share of the high gain's black..white up to which it is used: above, its noise would be clipped at white."""

_MERGED_BITS = 16


@dataclass(frozen=True, slots=True, kw_only=True)
class DualGain:
    """High conversion gain: a smaller full well and less read noise, from an ISO setting on, or in each exposure.

    from_iso     : the lowest setting that uses it; ``Adc.electrons_per_dn`` stays proportional to ISO there, as makers
                   calibrate their settings across the switch
    capacity_e   : full well in this mode, electrons; None: as at low gain
    read_noise_e : standard deviation in this mode, electrons; None: as at low gain
    electrons_per_dn : instead of ``from_iso``, at the base ISO: each exposure is read at both gains, with independent
                       read-out noise
    read         : the recorded image, "low", "high" or "merged": in 16 bits, the high-gain one up to 90 % of its white,
                   the low-gain one above. None: merged if there are two

    >>> DualGain(from_iso=800.0, capacity_e=8000.0, read_noise_e=1.2).read is None
    True
    >>> DualGain(electrons_per_dn=0.5, read_noise_e=1.2).read
    'merged'
    """

    from_iso: Positive | None = None
    capacity_e: Positive | None = None
    read_noise_e: NonNegative | None = None
    electrons_per_dn: Positive | None = dataclasses.field(default=None, metadata={"described": "if any"})
    read: ReadOut | None = dataclasses.field(default=None, metadata={"described": "if any"})

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            from_iso: Number | None = None,
            capacity_e: Number | None = None,
            read_noise_e: Number | None = None,
            electrons_per_dn: Number | None = None,
            read: ReadOut | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        if (self.from_iso is None) == (self.electrons_per_dn is None):
            message = "give one of from_iso, and electrons_per_dn of a sensor that reads both gains of each exposure"
            raise refusal(self, "from_iso", message)
        if self.from_iso is not None:
            if self.capacity_e is None and self.read_noise_e is None:
                message = "neither full well nor read noise is given for this mode, which then is the other's; give one"
                raise refusal(self, "from_iso", message)
            if self.read is not None:
                raise refusal(self, "read", "does nothing without electrons_per_dn: there is one image; leave it out")
        elif self.read is None:
            object.__setattr__(self, "read", "merged")

    def has_low_noise_at(self, iso: float) -> bool:
        """Whether dark photosites have the read noise of high gain at an ISO setting."""
        return self.read != "low" if self.from_iso is None else iso >= self.from_iso

    def is_small_at(self, iso: float) -> bool:
        """Whether white is set by the full well of high gain at an ISO setting."""
        return self.read == "high" if self.from_iso is None else iso >= self.from_iso

    def converter(self, adc: Adc) -> Adc:
        """Return the converter of the recorded codes; ``adc``: that of low gain."""
        if self.electrons_per_dn is None or self.read == "low":
            return adc
        ratio = self.electrons_per_dn / adc.electrons_per_dn
        bits = adc.bit_depth
        if self.read == "merged":
            bits = _MERGED_BITS
            # The largest data number of the low gain fits.
            room_dn = LARGEST - adc.black_level_dn - max(max(row) for row in adc.black_offsets_dn)
            ratio = max(ratio, (adc.largest_dn - adc.black_level_dn) / room_dn)
        return dataclasses.replace(
            adc,
            bit_depth=bits,
            electrons_per_dn=ratio * adc.electrons_per_dn,
            gain_at_iso=tuple((iso, ratio * electrons) for iso, electrons in adc.gain_at_iso),
        )


def merged_e(low_e: F64, high_e: F64, high_white_e: float) -> F64:
    """Return (rows, cols) electrons of the high-gain read-out, and of the low-gain one where that is nearly full."""
    electrons: F64 = np.where(high_e < _MERGED_TO * high_white_e, high_e, low_e)
    return electrons
