"""What a file of ours says about itself: format, size, product and the record of what was computed.

Files come from anywhere. Every byte may be wrong, so nothing is believed: offsets are looked at before they are
followed, texts have a longest length, and the record has a checksum of its own.
"""

from __future__ import annotations

import json
import os
import zipfile
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO
from xml.parsers import expat

import numpy as np

from camsim.errors import InputError
from camsim.files import exr_reader, png_reader, tiff_reader
from camsim.files.describe import RECORD_FORMAT, canonical, checksum
from camsim.files.npz import RECORD_NAME

XMP_NAMESPACE = "urn:camsim:frame/1/"
"""XML namespace of our own properties in XMP."""

_ANY_NAMESPACE = b"urn:camsim:"

LONGEST_RECORD = 16 << 20
"""Bytes of JSON. A scene file has at most as many; parsed, they take some twenty times as much memory."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Held:
    """What one file holds.

    form       : "DNG", "OpenEXR", "TIFF", "PNG" or "NPZ"
    suffix     : of such files, with its dot
    rows, cols : of the image
    size_bytes : of the file
    product    : which of the frame's products it is
    has_truth  : whether the truth is in it
    compressed : whether it is a DNG of lossless JPEG
    record     : the figures that explain its numbers, and ``description``: all stages with all parameters
    """

    path: Path
    form: str
    suffix: str
    rows: int
    cols: int
    size_bytes: int
    product: str
    has_truth: bool
    compressed: bool
    record: Mapping[str, Any]

    @property
    def description(self) -> Mapping[str, Any]:
        """All stages with all parameters, as :func:`camsim.revive.revive` takes them."""
        described: Mapping[str, Any] = self.record["description"]
        return described


@dataclass(frozen=True, slots=True)
class _Found:
    form: str
    suffix: str
    rows: int
    cols: int
    text: str | None
    has_truth: bool = False
    compressed: bool = False


def read_file(path: str | os.PathLike[str]) -> Held:
    """Read what a DNG, EXR, TIFF, PNG or NPZ of ours says about itself; the image is left alone.

    Raises InputError, in one sentence, for what is no such file, was cut short or has been changed.
    """
    shown = Path(path)
    try:
        if not shown.is_file():
            raise InputError("there is no such file" if not shown.exists() else "it is not a file")
        with shown.open("rb") as file:
            size = os.fstat(file.fileno()).st_size
            found = _reader(file.read(8))(file, size)
        record = parse_record(found.text)
    except InputError as error:
        raise InputError(f"cannot read {str(path)!r}: {error}") from None
    except OSError as error:
        raise InputError(f"cannot read {str(path)!r}: {error.strerror or error}") from error
    except ValueError as error:  # a name with a zero in it
        raise InputError(f"cannot read {str(path)!r}: {error}") from error
    return Held(
        path=shown,
        form=found.form,
        suffix=found.suffix,
        rows=found.rows,
        cols=found.cols,
        size_bytes=size,
        product=str(record["product"]),
        has_truth=found.has_truth or record["product"] == "truth",
        compressed=found.compressed,
        record=record,
    )


def parse_record(text: str | None) -> Mapping[str, Any]:
    """Return the record that a text holds, its checksum looked at."""
    if text is None:
        raise InputError("it was not written by camsim: it does not say what was computed")
    if len(text) > LONGEST_RECORD:
        raise InputError(f"its record has more than {LONGEST_RECORD >> 20} MiB")
    try:
        record = json.loads(text, parse_constant=_no_number)
    except (ValueError, RecursionError):
        raise InputError("its record is damaged: it is no JSON") from None
    if not isinstance(record, dict) or "camsim" not in record:
        raise InputError("it was not written by camsim: its text is another program's")
    if record["camsim"] != RECORD_FORMAT:
        said = str(record["camsim"])[:40]
        raise InputError(
            f"its record has the format {said!r} and this version of camsim reads {RECORD_FORMAT!r}; "
            f"use the version that wrote it ({str(record.get('software', 'unknown'))[:40]})"
        )
    sum_said = record.pop("sha256", None)
    if sum_said != checksum(canonical(record)) or not isinstance(record.get("description"), dict):
        raise InputError("its record is damaged: it does not fit its checksum")
    return record


def _reader(begin: bytes) -> Callable[[BinaryIO, int], _Found]:
    if begin.startswith(b"II*\0"):
        return _tiff
    if begin.startswith(exr_reader.MAGIC):
        return _exr
    if begin.startswith(png_reader.MAGIC):
        return _png
    if begin.startswith(b"PK\x03\x04"):
        return _npz
    raise InputError("it is no DNG, OpenEXR, TIFF, PNG or NPZ of camsim")


def _tiff(file: BinaryIO, size: int) -> _Found:
    directory = tiff_reader.read_directory(file, size)
    is_dng = tiff_reader.DNG_VERSION in directory.entries
    rows, cols = directory.number(tiff_reader.IMAGE_LENGTH), directory.number(tiff_reader.IMAGE_WIDTH)
    directory.refuse_truncated()
    if is_dng:
        text = _record_in_xmp(directory.bytes_of(tiff_reader.XMP, 2 * LONGEST_RECORD))
        compressed = directory.number(tiff_reader.COMPRESSION) == tiff_reader.LOSSLESS_JPEG
        return _Found("DNG", ".dng", rows, cols, text, compressed=compressed)
    words = directory.bytes_of(tiff_reader.IMAGE_DESCRIPTION, LONGEST_RECORD).rstrip(b"\0")
    return _Found("TIFF", ".tiff", rows, cols, words.decode("ascii", "replace") if words[:1] == b"{" else None)


def _exr(file: BinaryIO, size: int) -> _Found:
    header = exr_reader.read_header(file, size, 2 * LONGEST_RECORD)
    rows, cols = header.size()
    text = header.text("camsim:record")
    # Only of our own files is it known how they end.
    if text is not None and (end := exr_reader.end_of_chunks(file, header)) != size:
        where = f"its image ends at byte {end}" if end else "its image is not whole"
        raise InputError(f"it is cut short or damaged: it has {size} bytes and {where}")
    return _Found("OpenEXR", ".exr", rows, cols, text)


def _png(file: BinaryIO, size: int) -> _Found:
    rows, cols, text = png_reader.read_png(file, size, LONGEST_RECORD)
    return _Found("PNG", ".png", rows, cols, text)


def _npz(file: BinaryIO, size: int) -> _Found:
    try:
        with zipfile.ZipFile(file) as archive:
            names = archive.namelist()
            if RECORD_NAME not in names:
                return _Found("NPZ", ".npz", 0, 0, None)
            with archive.open(RECORD_NAME) as member:
                words = member.read(LONGEST_RECORD + 1)
            with archive.open("mosaic.npy") as member:
                version = np.lib.format.read_magic(member)
                shape, _, _ = np.lib.format.read_array_header_1_0(member)
    except (zipfile.BadZipFile, zlib.error, KeyError, NotImplementedError, RuntimeError, EOFError) as error:
        raise InputError(f"it is cut short or damaged ({error})") from None
    except ValueError:
        raise InputError("its mosaic is no array of numpy's") from None
    if version != (1, 0) or len(shape) != 2:
        raise InputError("its mosaic is no array of ours")
    return _Found("NPZ", ".npz", shape[0], shape[1], words.decode("ascii", "replace"), "truth.npy" in names)


def _record_in_xmp(xmp: bytes) -> str | None:
    """Return the text of our property, wherever in the XMP it is; another program may have rearranged it."""
    letters: list[str] = []
    inside = False
    name = f"{XMP_NAMESPACE} Record"

    def start(element: str, attributes: Mapping[str, str]) -> None:
        nonlocal inside
        inside = element == name
        if name in attributes:
            letters.append(attributes[name])

    def end(_: str) -> None:
        nonlocal inside
        inside = False

    def text(found: str) -> None:
        if inside:
            letters.append(found)

    def doctype(*_: object) -> None:
        raise InputError("its XMP declares a document type, which XMP never does")

    parser = expat.ParserCreate(namespace_separator=" ")
    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.CharacterDataHandler = text
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(xmp.rstrip(b"\0"), True)
    except expat.ExpatError as error:
        if not letters and XMP_NAMESPACE.encode() not in xmp:
            return None
        raise InputError(f"its XMP is damaged ({error})") from None
    if not letters and _ANY_NAMESPACE in xmp and XMP_NAMESPACE.encode() not in xmp:
        raise InputError(
            "its record has another format than this version of camsim reads; use the version that wrote it"
        )
    return "".join(letters) or None


def _no_number(word: str) -> float:
    raise ValueError(f"{word} is no number")
