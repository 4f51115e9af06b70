"""Random telegraph noise."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.core.typed import Fraction, NonNegative, Number, validate
from camsim.sensor import streams
from camsim.sensor.stage import Context, ElectronicStage
from camsim.sensor.streams import BLOCK_ROWS


@dataclass(frozen=True, slots=True, kw_only=True)
class TelegraphNoise(ElectronicStage):
    """Random telegraph noise: in each frame a trap adds or subtracts half its amplitude, equally likely.

    fraction    : share of photosites that have one, drawn from the sensor's serial number
    amplitude_e : mean distance between up and down, electrons, exponentially distributed

    Frames are further apart than the time constant of the trap: states in two frames are independent.

    >>> round(TelegraphNoise(fraction=0.02, amplitude_e=10.0).dark_noise_e(1.0), 6)
    1.0
    """

    name: ClassVar = "telegraph_noise"
    stream: ClassVar = 13, 14
    temporal: ClassVar = True

    fraction: Fraction
    amplitude_e: NonNegative

    if TYPE_CHECKING:

        def __init__(self, *, fraction: Number, amplitude_e: Number) -> None: ...

    def __post_init__(self) -> None:
        validate(self)

    def apply(self, electrons: F64, context: Context) -> F64:
        """Add to, or subtract from, each photosite with a trap half of the trap's amplitude."""
        row, col, amplitude_e = self.within((electrons.shape[0], electrons.shape[1]), context)
        up = context.generator(self.stream[1]).random(len(row)) < 0.5
        moved = electrons.copy()
        moved[row, col] += np.where(up, 0.5, -0.5) * amplitude_e
        return moved

    def within(self, shape: tuple[int, int], context: Context) -> tuple[I64, I64, F64]:
        """Return rows, columns and amplitudes (electrons) of the photosites with a trap within a context."""
        (first_row, first_col), cols = context.first, context.frame_cols
        found = []
        for block in range(first_row // BLOCK_ROWS, (first_row + shape[0] - 1) // BLOCK_ROWS + 1):
            rng = streams.generator(context.serial, self.stream[0], block=block)
            count = int(rng.binomial(BLOCK_ROWS * cols, self.fraction))
            index = rng.choice(BLOCK_ROWS * cols, count, replace=False)
            amplitude_e = rng.exponential(1.0, count) * self.amplitude_e
            found.append(
                np.stack([block * BLOCK_ROWS + index // cols - first_row, index % cols - first_col, amplitude_e])
            )
        row, col, amplitude_e = np.concatenate(found, axis=1)
        inside = (row >= 0) & (row < shape[0]) & (col >= 0) & (col < shape[1])
        return row[inside].astype(np.int64), col[inside].astype(np.int64), amplitude_e[inside]

    def dark_noise_e(self, electrons_per_dn: float) -> float:
        """Return the standard deviation over all photosites: the root of a quarter of the mean square amplitude."""
        return math.sqrt(0.5 * self.fraction) * self.amplitude_e
