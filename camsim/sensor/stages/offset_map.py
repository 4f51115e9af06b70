"""Measured offsets of photosites."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeAlias

import numpy as np

from camsim.core.arrays import F32, F64
from camsim.core.number_kinds import array_of
from camsim.core.typed import refusal, validate
from camsim.sensor.stage import Context, ElectronicStage

OffsetUnit: TypeAlias = Literal["dn", "electrons"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OffsetMap(ElectronicStage):
    """A fixed offset of each photosite, such as the mean of many darks shows it.

    offsets : (rows, cols), added to the signal; tiled if the sensor has more photosites
    unit    : "dn": after the gain, equal data numbers at every ISO setting; "electrons": before the gain
    source  : the file or folder that they came from;  sha256: hash of the offsets

    >>> OffsetMap(offsets=np.zeros((4, 6)), unit="electrons").shape
    (4, 6)
    """

    name: ClassVar = "offset_map"

    offsets: Any = field(repr=False)
    unit: OffsetUnit
    source: str = ""
    sha256: str = field(default="", init=False)

    if TYPE_CHECKING:

        def __init__(self, *, offsets: Any, unit: OffsetUnit, source: str = "") -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        keep_pattern(self, "offsets", "rows, cols")

    def __eq__(self, other: object) -> bool:
        return isinstance(other, OffsetMap) and (self.sha256, self.unit) == (other.sha256, other.unit)

    def __hash__(self) -> int:
        return hash((self.sha256, self.unit))

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the map."""
        rows, cols = self.offsets.shape
        return rows, cols

    def spread_e(self, electrons_per_dn: float) -> float:
        """Return the standard deviation of the offsets, electrons."""
        spread = float(self.offsets.std(dtype=np.float64))
        return spread * electrons_per_dn if self.unit == "dn" else spread

    def apply(self, electrons: F64, context: Context) -> F64:
        """Add each photosite's offset."""
        offsets = pattern_at(self.offsets, context.first, electrons.shape)
        if self.unit == "dn":
            offsets *= context.electrons_per_dn
        offsets += electrons
        return offsets


def keep_pattern(stage: ElectronicStage, field_name: str, axes: str) -> None:
    """Store a stage's per-photosite array in single precision, read-only, and its SHA-256 in ``sha256``.

    axes : names, such as "rows, cols"

    Raises InvalidValueError unless these are finite numbers along such axes.
    """
    given = array_of(getattr(stage, field_name), field_name, type(stage).__name__)
    if given.ndim != len(axes.split(",")) or given.dtype.kind not in "fiu" or not given.size:
        raise refusal(stage, field_name, f"must be numbers ({axes}), not {given.dtype} of shape {given.shape}")
    stored = np.array(given, np.float32, order="C")
    if not np.isfinite(stored).all():
        raise refusal(stage, field_name, "must be finite")
    stored.flags.writeable = False
    stated = hashlib.sha256(f"{stored.shape}".encode())
    stated.update(stored.data)
    object.__setattr__(stage, field_name, stored)
    object.__setattr__(stage, "sha256", stated.hexdigest())


def pattern_at(pattern: F32, first: tuple[int, int], shape: tuple[int, ...]) -> F64:
    """Return the part of a pattern (rows, cols), tiled over the frame, that begins at photosite ``first``."""
    row, col = (
        (start + np.arange(count)) % size for start, count, size in zip(first, shape, pattern.shape, strict=True)
    )
    part: F64 = pattern[np.ix_(row, col)].astype(np.float64)
    return part
