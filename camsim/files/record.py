"""The record of a file, validated before use: size, depth, checksum, names and types."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from camsim.camera.frame import check_products
from camsim.core.arrays import I64
from camsim.core.typed import hints, validate
from camsim.errors import CamsimError, InputError, InvalidValueError
from camsim.files.describe import RECORD_FORMAT, checksum
from camsim.sensor.adc import full_codes
from camsim.sensor.companding import are_points

LONGEST_RECORD = 16 << 20
"""Most bytes of JSON, as for a scene file."""

_LARGEST_CODE = 65_535
"""Largest code of 16 bits, the most of a converter."""

_MOST_LISTS, _MOST_VALUES = 1 << 19, 1 << 21
"""Half a million corners. Parsed, lists and numbers take twenty times the memory of their text."""

_DEEPEST = 64
_MOST_DIGITS = 20
_CHECKSUM = re.compile(r',"sha256":"([0-9a-f]{64})"')
_PROGRAM = re.compile(r'"camsim":"([^"\\]{1,40})"')
_SOFTWARE = re.compile(r'"software":"([^"\\]{1,40})"')


@dataclass(frozen=True, slots=True, kw_only=True)
class Record:
    """Description of a computation and of its values; see ``camsim.files.describe.record``."""

    software: str
    product: str
    camera: str
    channels: tuple[str, ...]
    cfa_pattern: tuple[str, ...]
    black_level_dn: int
    black_offsets_dn: tuple[tuple[int, ...], ...]
    white_level_dn: int
    electrons_per_dn: float
    seed: int
    error_estimate: float | None
    description_sha256: str
    description: Mapping[str, Any]

    def __post_init__(self) -> None:
        validate(self)
        check_products((self.product,))
        if not self.channels or not self.cfa_pattern or len({len(row) for row in (*self.cfa_pattern, "")} - {0}) != 1:
            raise InvalidValueError("give one letter for each filter, in rows of one length", key="cfa_pattern")
        if len({len(row) for row in (*self.black_offsets_dn, ())} - {0}) != 1:
            raise InvalidValueError("give rows of one length", key="black_offsets_dn")
        codes = self.black_level_dn, self.white_level_dn, *(offset for row in self.black_offsets_dn for offset in row)
        if max(map(abs, codes)) > _LARGEST_CODE:
            raise InvalidValueError(f"codes end at {_LARGEST_CODE}", key="white_level_dn")
        _ = self.companding
        if self.white_level_dn <= self.black_level_dn or self.electrons_per_dn <= 0.0:
            raise InvalidValueError("must be above black_level_dn, and electrons_per_dn above 0", key="white_level_dn")

    @property
    def companding(self) -> tuple[tuple[int, int], ...]:
        """The points of ``Frame.companding``; empty without it."""
        points = self._adc.get("companding") or ()
        if points and not are_points(points):
            raise InvalidValueError("must be points whose data numbers and codes increase", key="companding")
        return tuple((dn, code) for dn, code in points)

    @property
    def white_levels_dn(self) -> I64:
        """Codes at which photosites are full, one for each of ``black_offsets_dn``."""
        return full_codes(self.white_level_dn, self.black_offsets_dn, (1 << self._bits) - 1)

    @property
    def _adc(self) -> Mapping[str, Any]:
        """The converter in the description."""
        camera = self.description.get("camera")
        adc = camera.get("adc") if isinstance(camera, Mapping) else None
        return adc if isinstance(adc, Mapping) else {}

    @property
    def _bits(self) -> int:
        """Bits of the converter; if not stated, enough for white."""
        bits = self._adc.get("bit_depth")
        return bits if isinstance(bits, int) and 1 <= bits <= 16 else self.white_level_dn.bit_length()

    @property
    def size(self) -> tuple[int, int] | None:
        """Rows and columns of the picture; None if the description does not state them."""
        stated = self.description.get("region") or self.description.get("camera")
        rows, cols = (stated.get(side) if isinstance(stated, Mapping) else None for side in ("rows", "cols"))
        return (rows, cols) if isinstance(rows, int) and isinstance(cols, int) else None

    def check_size(self, rows: int, cols: int) -> None:
        """Raise InputError if the picture has not these rows and columns, as its position would be unknown."""
        if self.size not in (None, (rows, cols)):
            described = " × ".join(map(str, self.size or ()))
            raise InputError(
                f"its record describes {described} photosites and its image has {rows} × {cols}: another program cut "
                "or scaled it and kept the record; give the file that camsim wrote, or save the image without it"
            )

    def as_dict(self) -> dict[str, Any]:
        """Return the record as it was written."""
        return {field.name: getattr(self, field.name) for field in fields(self)}


def is_record(text: str) -> bool:
    """Whether a text is a camsim record of any version, complete or not."""
    return _PROGRAM.search(text) is not None or _CHECKSUM.search(text) is not None


def parse_record(text: str | None) -> Record:
    """Return the record in a text; raises InputError if invalid or changed."""
    if text is None:
        raise InputError("it was not written by camsim: it does not say what was computed")
    if len(text) > LONGEST_RECORD:
        raise InputError(f"its record has more than {LONGEST_RECORD >> 20} MiB")
    if text.count("[") + text.count("{") > _MOST_LISTS or text.count(",") > _MOST_VALUES:
        raise InputError(f"its record has more than {_MOST_LISTS} lists and tables, or {_MOST_VALUES} values")
    try:
        said = json.loads(text, parse_constant=_no_number, parse_float=_finite, parse_int=_whole)
    except (ValueError, RecursionError):
        raise InputError("its record is damaged: it is no JSON") from None
    if not isinstance(said, dict) or "camsim" not in said:
        raise InputError("it was not written by camsim: its text is another program's")
    if said.pop("camsim") != RECORD_FORMAT:
        raise InputError(_other_format(text))
    # The text equals the written one byte for byte, apart from the added checksum.
    found = list(_CHECKSUM.finditer(text))
    whole = found and text[: found[-1].start()] + text[found[-1].end() :]
    if not whole or not text.isascii() or said.pop("sha256", None) != checksum(whole):
        raise InputError("its record is damaged: it does not fit its checksum")
    _refuse_deep(said)
    return _record(said)


def _record(said: dict[str, Any]) -> Record:
    kinds = hints(Record)
    if unknown := [name for name in said if name not in kinds]:
        raise InputError(f"its record has a part {ascii(unknown[0])[:40]} that camsim never writes")
    if missing := [name for name in kinds if name not in said]:
        raise InputError(f"its record lacks {missing[0]!r}")
    try:
        return Record(**said)
    except CamsimError as error:
        raise InputError(f"its record cannot be: {error}") from None


def _other_format(text: str) -> str:
    format_, software = (pattern.search(text) for pattern in (_PROGRAM, _SOFTWARE))
    return (
        f"its record has the format {format_[1] if format_ else 'unknown'!r} and this version of camsim reads "
        f"{RECORD_FORMAT!r}; use the version that wrote it ({software[1] if software else 'unknown'})"
    )


def _refuse_deep(tree: Any) -> None:
    """Raise InputError if a tree is nested more deeply than any scene."""
    level = [tree]
    for _ in range(_DEEPEST):
        level = [
            part
            for holder in level
            for part in (holder.values() if isinstance(holder, dict) else holder)
            if isinstance(part, (dict, list))
        ]
        if not level:
            return
    raise InputError(f"its record is nested more than {_DEEPEST} deep")


def _finite(word: str) -> float:
    value = float(word)
    if not math.isfinite(value):
        raise ValueError(f"{word} is too large")
    return value


def _whole(word: str) -> int:
    if len(word) > _MOST_DIGITS:
        raise ValueError(f"a number of {len(word)} digits")
    return int(word)


def _no_number(word: str) -> float:
    raise ValueError(f"{word} is no number")
