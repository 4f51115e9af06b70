"""Optical low-pass filters: birefringent plates that split every ray."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar, TypeAlias

import numpy as np

from camsim.core.annotations import Called
from camsim.core.arrays import F64
from camsim.core.typed import Number, Positive, check, validate
from camsim.numerics.rotations import cosine_and_sine

Split: TypeAlias = Annotated[Positive, Called("a number above 0", "without a split leave the filter out")]


class _Plates:
    """Mixin of filters with ``splits_um`` and ``rotate_deg``. It has no fields."""

    __slots__ = ()

    rotate_deg: float

    @property
    @abstractmethod
    def splits_um(self) -> tuple[float, float]:
        """The distances between neighbouring spots along x and y before rotation, µm."""

    @property
    def separable(self) -> bool:
        """Whether the transfer is a product of one function of fx and one of fy."""
        return (self.rotate_deg / 90.0).is_integer()

    def spots_um(self) -> F64:
        """Return the offsets (n, 2) of the spots as x, y in µm; each carries the same light."""
        along_x, along_y = ([-0.5 * split, 0.5 * split] if split else [0.0] for split in self.splits_um)
        spots = np.array([[x, y] for y in along_y for x in along_x])
        c, s = cosine_and_sine(self.rotate_deg)
        turned: F64 = spots @ np.array([[c, s], [-s, c]])
        return turned

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer function cos(π·d·fx)·cos(π·d·fy), fx and fy along the splits; first zero at 1/(2d) along each."""
        c, s = cosine_and_sine(self.rotate_deg)
        fx, fy = np.asarray(fx_per_um), np.asarray(fy_per_um)
        fu, fv = fx * c + fy * s, fy * c - fx * s
        otf: F64 = np.cos(np.pi * self.splits_um[0] * fu) * np.cos(np.pi * self.splits_um[1] * fv)
        return otf


@dataclass(frozen=True, slots=True, kw_only=True)
class FourSpotOlpf(_Plates):
    """Equal spots on the corners of a rectangle: two crossed plates.

    split_um   : the full distance between two neighbouring spots along x, µm (never half of it)
    split_y_um : the full distance along y; None: as along x
    rotate_deg : rotation of the spots, clockwise as displayed

    >>> FourSpotOlpf(split_um=4.0).spots_um()
    array([[-2., -2.],
           [ 2., -2.],
           [-2.,  2.],
           [ 2.,  2.]])
    """

    place: ClassVar[str] = "olpf"

    split_um: Split
    split_y_um: Split | None = None
    rotate_deg: float = 0.0

    if TYPE_CHECKING:

        def __init__(self, *, split_um: Number, split_y_um: Number | None = None, rotate_deg: Number = 0.0) -> None: ...

    def __post_init__(self) -> None:
        validate(self)

    @classmethod
    def from_pitches(
        cls, *, pitch_um: Number, split_pitches: Number, split_y_pitches: Number | None = None, rotate_deg: Number = 0.0
    ) -> FourSpotOlpf:
        """Return the filter with splits given in pitches."""
        split_um = _in_um(cls, "split_pitches", split_pitches, pitch_um)
        along_y_um = None if split_y_pitches is None else _in_um(cls, "split_y_pitches", split_y_pitches, pitch_um)
        return cls(split_um=split_um, split_y_um=along_y_um, rotate_deg=rotate_deg)

    @property
    def splits_um(self) -> tuple[float, float]:
        """The distances between neighbouring spots along x and y before rotation, µm."""
        return self.split_um, self.split_um if self.split_y_um is None else self.split_y_um


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoSpotOlpf(_Plates):
    """Two equal spots: one plate.

    split_um   : the full distance between the spots, µm
    rotate_deg : rotation from a horizontal split, clockwise as displayed; 90: a vertical split

    >>> TwoSpotOlpf(split_um=4.0).spots_um()
    array([[-2.,  0.],
           [ 2.,  0.]])
    """

    place: ClassVar[str] = "olpf"

    split_um: Split
    rotate_deg: float = 0.0

    if TYPE_CHECKING:

        def __init__(self, *, split_um: Number, rotate_deg: Number = 0.0) -> None: ...

    def __post_init__(self) -> None:
        validate(self)

    @classmethod
    def from_pitches(cls, *, pitch_um: Number, split_pitches: Number, rotate_deg: Number = 0.0) -> TwoSpotOlpf:
        """Return the filter with a split given in pitches."""
        return cls(split_um=_in_um(cls, "split_pitches", split_pitches, pitch_um), rotate_deg=rotate_deg)

    @property
    def splits_um(self) -> tuple[float, float]:
        """The distances between neighbouring spots along x and y before rotation, µm."""
        return self.split_um, 0.0


def _in_um(kind: type, name: str, pitches: Number, pitch_um: Number) -> float:
    split: float = check(pitches, Split, name, kind.__name__)
    return split * float(check(pitch_um, Positive, "pitch_um", kind.__name__))
