"""Fixed-pattern offsets of columns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from camsim.core.arrays import F32, F64
from camsim.core.typed import NonNegative, Number, validate
from camsim.sensor import streams
from camsim.sensor.stage import Context, ElectronicStage


@dataclass(frozen=True, slots=True)
class ColumnNoise(ElectronicStage):
    """Every column has a fixed offset, that of its amplifier, normal around 0 over the columns.

    sigma_e : standard deviation, electrons

    >>> ColumnNoise(0.5).dark_noise_e(2.0)
    0.0
    """

    name: ClassVar = "column_noise"
    stream: ClassVar = 8

    sigma_e: NonNegative

    if TYPE_CHECKING:

        def __init__(self, sigma_e: Number) -> None: ...

    def __post_init__(self) -> None:
        validate(self)

    def over(self, context: Context) -> ElectronicStage:
        """Draw the numbers of all the frame's columns."""
        return _Offsets(self.sigma_e, column_normals(context.serial, context.frame_cols))

    def apply(self, electrons: F64, context: Context) -> F64:
        """Add to each column (the second axis) its offset."""
        return self.over(context).apply(electrons, context)

    def draws(self, shape: tuple[int, int], context: Context) -> int:
        """Return one normal for each column of the frame."""
        return context.frame_cols


def column_normals(serial: int, frame_cols: int) -> F32:
    """Return (frame_cols,) standard normals that belong to the sensor's columns."""
    return streams.generator(serial, ColumnNoise.stream, block=0).standard_normal(frame_cols, dtype=np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class _Offsets(ElectronicStage):
    """Standard normals (cols,) of the frame's columns, and their standard deviation."""

    name: ClassVar = ColumnNoise.name

    sigma_e: float
    normals: F32

    def apply(self, electrons: F64, context: Context) -> F64:
        first = context.first[1]
        return electrons + self.sigma_e * self.normals[first : first + electrons.shape[1]].astype(np.float64)
