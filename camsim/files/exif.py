"""EXIF 2.32 metadata of a photograph: a TIFF without an image, possibly damaged."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import TypeVar

from camsim.errors import InputError
from camsim.files.tiff_reader import Directory, read_directory

_PREFIX = b"Exif\0\0"
_CAMERAS, _INTEROPERABILITY, _INDEX = 34665, 40965, 1
_ADOBES = b"R03"
_TIME, _SENSITIVITY, _SENSITIVITY_INDEX, _MOST_SENSITIVE = 33434, 34855, 34866, 65535
"""PhotographicSensitivity has 16 bits: larger values are in RecommendedExposureIndex."""

T = TypeVar("T")


def in_exif(exif: bytes, read: Callable[[Directory], T], otherwise: T) -> T:
    """Return what ``read`` finds in a block of EXIF; ``otherwise`` if damaged, which must not refuse a picture."""
    block = exif.removeprefix(_PREFIX)
    try:
        return read(read_directory(io.BytesIO(block), len(block)))
    except InputError:
        return otherwise


def colours_noted(directory: Directory) -> str:
    """Return the stated colour space if it is not sRGB: the optional one of DCF, often given without a profile."""
    try:
        notes = directory.below(_CAMERAS)
        rules = None if notes is None else notes.below(_INTEROPERABILITY)
        adobes = rules is not None and rules.bytes_of(_INDEX, 8).rstrip(b"\0") == _ADOBES
    except InputError:
        return ""
    return "Adobe RGB, by EXIF" if adobes else ""


def setting_noted(directory: Directory) -> tuple[float | None, float | None]:
    """Return the ISO setting and the exposure time, s, of EXIF; None if unreadable."""
    try:
        notes = directory.below(_CAMERAS)
        if notes is None:
            return None, None
        iso, time_s = notes.values(_SENSITIVITY)[:1], notes.values(_TIME)[:1]
        if iso == (_MOST_SENSITIVE,):
            iso = notes.values(_SENSITIVITY_INDEX)[:1] or iso
    except InputError:
        return None, None
    return iso[0] if iso else None, time_s[0] if time_s else None
