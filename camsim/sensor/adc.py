"""Adc: electrons to data numbers."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from annotated_types import Ge, Le
from numpy.typing import ArrayLike, NDArray

from camsim.core.annotations import Called
from camsim.core.arrays import F64, I64, U16
from camsim.core.typed import Index, Iso, Number, Positive, Several, Whole, refusal, validate
from camsim.core.words import brief
from camsim.sensor.companding import LARGEST, are_points, data_numbers, encoding, steps_dn


def full_codes(white_level_dn: int, offsets_dn: ArrayLike, largest_dn: int) -> I64:
    """Return the codes at which photosites with these black offsets are full: offsets move white as they move black.

    >>> full_codes(4000, [[0, -12], [5, 200]], 4095).tolist()
    [[4000, 3988], [4005, 4095]]
    """
    codes: I64 = np.minimum(white_level_dn + np.asarray(offsets_dn), largest_dn)
    return codes


@dataclass(frozen=True, slots=True, kw_only=True)
class Adc:
    """A converter that rounds to the nearest data number and clips at both ends.

    bit_depth        : 1..16
    black_level_dn   : data number of zero electrons; data numbers equal codes unless companded
    electrons_per_dn : at ``base_iso``; falls in proportion to the ISO setting
    base_iso         : ISO at which ``electrons_per_dn`` holds
    black_offsets_dn : a rectangle of integers, tiled over the full frame and added to the black level, as in sensors
                       that read several photosites at once; they include 0 or both signs
    gain_at_iso      : (ISO, electrons per data number) of other settings, by increasing ISO, where the gain is not
                       proportional to ISO; electrons_per_dn · iso is interpolated linearly in log iso, ``base_iso``
                       included
    code_step_dn     : distance between codes, as for 12 bits stored in 16; the largest code is the last one in range
    companding       : (data number, code) points, increasing from data number 0 to the largest one distinguished: the
                       stored code of each data number, piecewise linear; empty: not companded

    >>> adc = Adc(bit_depth=12, black_level_dn=128, electrons_per_dn=10.0, base_iso=200.0)
    >>> adc.quantise(np.array([-1e9, 0.0, 14.0, 16.0, 1e9]), iso=200.0)
    array([   0,  128,  129,  130, 4095], dtype=uint16)
    >>> adc.quantise(np.array([14.0]), iso=400.0)
    array([131], dtype=uint16)
    """

    bit_depth: Annotated[int, Ge(1), Le(16)]
    black_level_dn: Index
    electrons_per_dn: Positive
    base_iso: Positive
    black_offsets_dn: Several[Several[int]] = ((0,),)
    gain_at_iso: Annotated[Several[tuple[Iso, Positive]], Called("a list of (ISO, electrons per data number)")] = (
        dataclasses.field(default=(), metadata={"described": "if any"})
    )
    code_step_dn: Annotated[float, Ge(1), Le(32768)] = dataclasses.field(default=1.0, metadata={"described": "if any"})
    companding: Annotated[Several[tuple[Index, Index]], Called("a list of (data number, code)")] = dataclasses.field(
        default=(), metadata={"described": "if any"}
    )

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            bit_depth: Whole,
            black_level_dn: Whole,
            electrons_per_dn: Number,
            base_iso: Number,
            black_offsets_dn: Several[Several[Whole]] = ((0,),),
            gain_at_iso: Several[tuple[Number, Number]] = (),
            code_step_dn: Number = 1.0,
            companding: Several[tuple[Whole, Whole]] = (),
        ) -> None: ...

    __repr__ = brief

    def __post_init__(self) -> None:
        validate(self)
        if self.companding:
            self._validate_companding()
        if self.black_level_dn >= self.largest_dn:
            most = f"{self.largest_dn - 1}, below the largest code of {self.bit_depth} bits"
            raise refusal(self, "black_level_dn", f"must be at most {most}, not {self.black_level_dn}")
        offsets = [offset for row in self.black_offsets_dn for offset in row]
        if not offsets or len({len(row) for row in self.black_offsets_dn}) > 1:
            raise refusal(self, "black_offsets_dn", "give rows of equal length, such as [[0, 2], [1, -1]]")
        if not all(0 <= self.black_level_dn + offset < self.largest_dn for offset in offsets):
            lead = f"{min(offsets)}..{max(offsets)} lead from a black level of {self.black_level_dn}"
            raise refusal(self, "black_offsets_dn", f"{lead} beyond 0..{self.largest_dn - 1}")
        # Black..white refers to a photosite without an offset: an offset that no photosite has defines no white.
        if common := max(min(offsets), 0) + min(max(offsets), 0):
            side = "above" if common > 0 else "below"
            way_out = f"give black_level_dn {self.black_level_dn + common}, and offsets that are less by {common}"
            raise refusal(self, "black_offsets_dn", f"all lie {side} 0, and no photosite has black there; {way_out}")
        settings = [iso for iso, _ in self.gain_at_iso]
        if any(after <= before for before, after in pairwise(settings)):
            raise refusal(self, "gain_at_iso", f"ISO {', '.join(f'{iso:g}' for iso in settings)}; must increase")
        if self.base_iso in settings:
            way_out = "its gain is electrons_per_dn; leave it out here"
            raise refusal(self, "gain_at_iso", f"has ISO {self.base_iso:g}, which is base_iso: {way_out}")

    def _validate_companding(self) -> None:
        if not are_points(self.companding):
            message = f"must be two points or more, data numbers and codes both increasing, {LARGEST} at most"
            raise refusal(self, "companding", message)
        first, last, most = self.companding[0][0], self.companding[-1][0], (1 << self.bit_depth) - 1
        if first != 0 or last > most:
            there = f"goes from data number {first} to {last}"
            raise refusal(self, "companding", f"{there}; give points from 0 to {most}, the largest, or less")
        if self.black_offsets_dn != ((0,),):
            raise refusal(self, "companding", "given together with black_offsets_dn; leave one of the two out")

    @property
    def largest_dn(self) -> int:
        """The largest data number: 2^bits − 1, the last multiple of the code step, or the last companding point."""
        if self.companding:
            return self.companding[-1][0]
        return round(math.floor(((1 << self.bit_depth) - 1) / self.code_step_dn + 1e-6) * self.code_step_dn)

    def electrons_per_dn_at(self, iso: float) -> float:
        """Return electrons per data number at an ISO setting.

        >>> adc = Adc(
        ...     bit_depth=12, black_level_dn=9, electrons_per_dn=4.0, base_iso=100.0, gain_at_iso=[(400.0, 1.1)]
        ... )
        >>> [round(adc.electrons_per_dn_at(iso), 9) for iso in (50.0, 100.0, 200.0, 400.0, 800.0)]
        [8.0, 4.0, 2.1, 1.1, 0.55]
        """
        if not self.gain_at_iso:
            return self.electrons_per_dn * self.base_iso / iso
        known, electrons = zip(*sorted([(self.base_iso, self.electrons_per_dn), *self.gain_at_iso]), strict=True)
        products = [at * each for at, each in zip(known, electrons, strict=True)]
        return float(np.interp(math.log(iso), np.log(known), products)) / iso

    def window_black_offsets_dn(self, origin: tuple[int, int]) -> tuple[tuple[int, ...], ...]:
        """Return the tile of offsets that starts at photosite ``origin`` of the full frame.

        >>> adc = Adc(
        ...     bit_depth=12, black_level_dn=9, electrons_per_dn=1.0, base_iso=100.0, black_offsets_dn=((0, 1), (2, 3))
        ... )
        >>> adc.window_black_offsets_dn((1, 0)), adc.quantise(np.zeros((2, 3)), iso=100.0).tolist()
        (((2, 3), (0, 1)), [[9, 10, 9], [11, 12, 11]])
        """
        offsets = np.roll(np.array(self.black_offsets_dn), (-origin[0], -origin[1]), axis=(0, 1))
        return tuple(tuple(int(offset) for offset in row) for row in offsets)

    def offsets_dn(self, shape: tuple[int, int], origin: tuple[int, int]) -> I64:
        """Return the black offset (rows, cols) of every photosite of a window at ``origin`` in the full frame."""
        offsets = np.array(self.window_black_offsets_dn(origin))
        tiles = -(-shape[0] // offsets.shape[0]), -(-shape[1] // offsets.shape[1])
        return np.tile(offsets, tiles)[: shape[0], : shape[1]]

    def white_level_dn(self, iso: float, full_well_e: float | None = None) -> int:
        """Return the data number at which the signal clips, by the full well or by the largest code.

        At least one above black, so that black..white is never empty.

        >>> adc = Adc(bit_depth=12, black_level_dn=128, electrons_per_dn=10.0, base_iso=200.0)
        >>> adc.white_level_dn(200.0, full_well_e=30_000.0), adc.white_level_dn(200.0, full_well_e=40_000.0)
        (3128, 4095)
        """
        if full_well_e is None:
            return self.largest_dn
        # Rounded as codes are, black included: half a code goes to the even one.
        full_dn = self.black_level_dn + full_well_e / self.electrons_per_dn_at(iso)
        code_dn = round(min(full_dn, float(self.largest_dn)) / self.code_step_dn) * self.code_step_dn
        white_dn = max(self.black_level_dn + 1, round(code_dn))
        # With companding, the data number that the code of full photosites decodes to.
        return int(self.data_numbers(self._stored(np.array(white_dn))))

    def saturation_e(self, iso: float, full_well_e: float | None = None) -> float:
        """Return the electrons from black to white at an ISO setting."""
        return (self.white_level_dn(iso, full_well_e) - self.black_level_dn) * self.electrons_per_dn_at(iso)

    def quantise(self, electrons: F64, *, iso: float, origin: tuple[int, int] = (0, 0)) -> U16:
        """Return the codes of ``electrons`` (any shape): rounded, then clipped to 0..2^bits − 1.

        origin : (row, col) in the full frame of the first photosite; only black offsets depend on it
        """
        electrons = np.asarray(electrons, dtype=np.float64)
        codes = np.empty(electrons.shape, dtype=np.uint16)
        # In pieces: saves a floating-point copy of a large frame.
        source, target = np.atleast_1d(electrons), np.atleast_1d(codes)
        step = max(1, (1 << 18) * len(source) // max(1, source.size))
        for start in range(0, len(source), step):
            dn = source[start : start + step] / self.electrons_per_dn_at(iso)
            dn += self.black_level_dn
            if self.black_offsets_dn != ((0,),):
                dn += self.offsets_dn((dn.shape[0], dn.shape[1]), (origin[0] + start, origin[1]))
            if np.isnan(dn.min(initial=0.0)):
                raise ValueError("electrons hold NaN, which has no code")
            if self.code_step_dn != 1.0:
                dn = np.rint(dn / self.code_step_dn) * self.code_step_dn
            np.rint(dn, out=dn)
            np.clip(dn, 0.0, self.largest_dn, out=dn)
            target[start : start + step] = self._stored(dn)
        return codes

    def _stored(self, dn: NDArray[Any]) -> NDArray[Any]:
        """Return the stored codes of integer data numbers."""
        return encoding(tuple(self.companding))[dn.astype(np.int64)] if self.companding else dn

    def data_numbers(self, codes: U16) -> U16:
        """Return the data numbers of codes; without companding they are equal."""
        return data_numbers(tuple(self.companding), codes)

    def electrons(self, codes: U16, *, iso: float, origin: tuple[int, int] = (0, 0)) -> F64:
        """Return the electrons (rows, cols) of codes; ``origin``: as of ``quantise``."""
        signal_dn = self.data_numbers(codes).astype(np.float64) - self.black_level_dn
        signal_dn -= self.offsets_dn((codes.shape[0], codes.shape[1]), origin)
        electrons: F64 = signal_dn * self.electrons_per_dn_at(iso)
        return electrons

    def step_dn(self, dn: F64) -> F64:
        """Return the distance between neighbouring codes about data numbers (any shape)."""
        steps: F64 = np.maximum(steps_dn(tuple(self.companding), dn), self.code_step_dn)
        return steps
