"""1/f noise of rows."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from annotated_types import Ge, Le

from camsim.core.arrays import F64
from camsim.core.typed import NonNegative, Number, validate
from camsim.sensor.stage import Context, ElectronicStage


@dataclass(frozen=True, slots=True)
class FlickerRows(ElectronicStage):
    """1/f noise of the supply, seen as bands: row offsets whose power falls with frequency.

    sigma_e  : standard deviation of a row over many frames, electrons; within one it is less (0.97 of it if pink)
    exponent : power ~ 1/frequency^exponent, 0..2; 1 is pink

    >>> FlickerRows(sigma_e=1.0, exponent=1.0)
    FlickerRows(sigma_e=1.0, exponent=1.0)
    """

    name: ClassVar = "flicker_rows"
    stream: ClassVar = 11
    temporal: ClassVar = True

    sigma_e: NonNegative
    exponent: Annotated[float, Ge(0), Le(2)] = 1.0

    if TYPE_CHECKING:

        def __init__(self, sigma_e: Number, exponent: Number = 1.0) -> None: ...

    def __post_init__(self) -> None:
        validate(self)

    def offsets_e(self, rows: int, rng: np.random.Generator) -> F64:
        """Return (rows,) offsets of one frame, mean 0.

        White normals are shaped in the frequency domain of twice the frame (so that the last and first rows are not
        wrapped together) from one cycle per 2·rows up to Nyquist, and scaled to the expected variance.
        """
        frequency = np.fft.rfftfreq(2 * rows)
        amplitude = np.zeros_like(frequency)
        amplitude[1:] = frequency[1:] ** (-0.5 * self.exponent)
        # Each frequency except Nyquist represents two of the full transform.
        power = (2.0 * np.sum(amplitude[1:-1] ** 2) + amplitude[-1] ** 2) / (2 * rows)
        white = np.fft.rfft(rng.standard_normal(2 * rows))
        shaped = np.fft.irfft(white * (amplitude / math.sqrt(power)), n=2 * rows)
        offsets: F64 = self.sigma_e * shaped[:rows]
        return offsets

    def over(self, context: Context) -> ElectronicStage:
        """Draw the offsets of all the window's rows at once, as they are correlated."""
        return _Offsets(self.offsets_e(context.rows_in_all, context.frame_generator(self.stream)))

    def apply(self, electrons: F64, context: Context) -> F64:
        """Add the offsets of these rows."""
        return self.over(context).apply(electrons, context)

    def draws(self, shape: tuple[int, int], context: Context) -> int:
        """Return two normals for each row."""
        return 2 * shape[0]

    def dark_noise_e(self, electrons_per_dn: float) -> float:
        """Return the standard deviation of the noise, electrons."""
        return self.sigma_e


@dataclass(frozen=True, slots=True, eq=False)
class _Offsets(ElectronicStage):
    """The offsets (rows,) of a window's rows, electrons."""

    name: ClassVar = FlickerRows.name

    rows_e: F64

    def apply(self, electrons: F64, context: Context) -> F64:
        before = context.rows_before
        return electrons + self.rows_e[before : before + len(electrons), None]
