"""Cfa: which photosite sees which channel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import numpy as np
from annotated_types import Ge, Le

from camsim.core.annotations import Called
from camsim.core.arrays import U8
from camsim.core.tiled import Tiled
from camsim.core.typed import Several, Whole, check, refusal, validate
from camsim.core.words import brief
from camsim.errors import InvalidValueError, UnknownNameError

_FIRST = "RGB"

BAYER = ("RGGB", "BGGR", "GRBG", "GBRG")

PATTERNS: Mapping[str, tuple[str, ...]] = {
    # Fujifilm's 6 × 6, in the phase that LibRaw calls its first.
    "x-trans": ("GBGGRG", "RGRBGB", "GBGGRG", "GRGGBG", "BGBRGR", "GRGGBG"),
    # Kodak's TrueSense: half of the photosites are panchromatic.
    "rgbw": ("WBWG", "BWGW", "WGWR", "GWRW"),
    # Huawei's phones of 2019: yellow where Bayer has green.
    "ryyb": ("RY", "YB"),
    # Complementary colours of early digital cameras.
    "cygm": ("CY", "GM"),
    "mono": ("Y",),
}
"""Named arrays."""


GREENS: Mapping[str, str] = {"Gr": "G", "Gb": "g"}
"""Letters of the two greens of a Bayer array, in rows with red and in rows with blue."""


def filters_of(channels: Sequence[str]) -> tuple[str, ...]:
    """Return the colours of filters: a lower-case letter is a second channel with the same filter as the capital.

    >>> filters_of(("R", "G", "B", "g"))
    ('R', 'G', 'B')
    """
    return tuple(dict.fromkeys(letter.upper() for letter in channels))


@dataclass(frozen=True, slots=True)
class Cfa:
    """A colour filter array: a rectangle of letters repeated over the sensor, from photosite (0, 0).

    pattern : one string of letters per row. G and g are two channels of one filter colour with separate curves, such as
              the greens in rows with red (Gr) and with blue (Gb): files and previews treat both as green

    >>> Cfa.bayer("GBRG").pattern
    ('GB', 'RG')
    >>> Cfa.bayer("GBRG").channels
    ('R', 'G', 'B')
    >>> Cfa.bayer("RGGB").channel_index(2, 4, origin=(0, 1))
    array([[1, 0, 1, 0],
           [2, 1, 2, 1]], dtype=uint8)
    """

    pattern: Annotated[Several[str], Called("a list of rows such as ('RG', 'GB')", "Cfa.bayer('RGGB') makes one")]

    if TYPE_CHECKING:

        def __init__(self, pattern: Several[str]) -> None: ...

    __repr__ = brief

    def __post_init__(self) -> None:
        validate(self)
        if not self.pattern or not self.pattern[0]:
            raise refusal(self, "pattern", "is empty; give one text of letters per row, such as ('RG', 'GB')")
        widths = sorted({len(row) for row in self.pattern})
        if len(widths) > 1:
            raise refusal(self, "pattern", f"rows of {widths} letters; all rows of a pattern are equally long")
        strange = sorted({c for row in self.pattern for c in row if not (c.isascii() and c.isalpha())})
        if strange:
            raise refusal(self, "pattern", f"{', '.join(map(repr, strange))}; only letters A to Z name channels")

    @classmethod
    def bayer(cls, pattern: str = "RGGB") -> Cfa:
        """Return a Bayer array from the letters of (0,0) (0,1) (1,0) (1,1)."""
        if pattern not in BAYER:
            raise InvalidValueError(f"must be one of {', '.join(BAYER)}, not {pattern!r}", key="pattern", stage="Cfa")
        return cls((pattern[:2], pattern[2:]))

    @classmethod
    def quad_bayer(cls, pattern: str = "RGGB", group: Whole = 2) -> Cfa:
        """Return a Bayer array whose every letter is a square of ``group`` × ``group`` photosites.

        >>> Cfa.quad_bayer("RGGB").pattern
        ('RRGG', 'RRGG', 'GGBB', 'GGBB')
        """
        check(group, Annotated[int, Ge(2), Le(16)], "group", "Cfa")
        return cls(tuple("".join(c * group for c in row) for row in cls.bayer(pattern).pattern for _ in range(group)))

    @classmethod
    def named(cls, name: str) -> Cfa:
        """Return a named array: x-trans, rgbw, ryyb, cygm, mono."""
        if check(name, str, "name", "Cfa") not in PATTERNS:
            raise UnknownNameError("cfa", name, PATTERNS, key="name", stage="Cfa")
        return cls(PATTERNS[name])

    @classmethod
    def mono(cls) -> Cfa:
        """Return the array of a sensor without colour filters: one channel, Y."""
        return cls.named("mono")

    def greens_apart(self) -> Cfa:
        """Return the array with g in place of G in rows with blue and no red, which makes the greens two channels.

        >>> Cfa.bayer("GRBG").greens_apart().pattern
        ('GR', 'Bg')
        """
        return Cfa(tuple(row.replace("G", "g") if "B" in row and "R" not in row else row for row in self.pattern))

    @property
    def period(self) -> tuple[int, int]:
        """(rows, cols) after which the pattern repeats."""
        return len(self.pattern), len(self.pattern[0])

    @property
    def channels(self) -> tuple[str, ...]:
        """The letters, each once: R, G, B first, then the others in reading order."""
        letters = list(dict.fromkeys("".join(self.pattern)))
        return tuple(sorted(letters, key=lambda c: _FIRST.index(c) if c in _FIRST else len(_FIRST)))

    def channel_index(self, rows: int, cols: int, origin: tuple[int, int] = (0, 0)) -> U8:
        """Return (rows, cols) indices into ``channels`` of the window that begins at photosite ``origin``."""
        return self.tiled_index(rows, cols, origin)[:]

    def tiled_index(self, rows: int, cols: int, origin: tuple[int, int] = (0, 0)) -> Tiled:
        """Return ``channel_index`` as a tiled array, which is expanded on demand."""
        channels = self.channels
        codes = np.array([[channels.index(c) for c in row] for row in self.window_pattern(origin)], dtype=np.uint8)
        return Tiled(codes, (rows, cols))

    def window_pattern(self, origin: tuple[int, int]) -> tuple[str, ...]:
        """Return the pattern of a window that starts at photosite ``origin``: its (0,0) (0,1) ….

        >>> Cfa.bayer("RGGB").window_pattern((1, 0))
        ('GB', 'RG')
        """
        rows, cols = self.period
        return tuple(
            "".join(self.pattern[(r + origin[0]) % rows][(c + origin[1]) % cols] for c in range(cols))
            for r in range(rows)
        )
