"""Metadata of a camsim file: format, size, product and record.

Files are untrusted: every byte may be wrong. Offsets are checked before use, texts have a maximal length, and the
record has a checksum.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO
from xml.parsers import expat

import numpy as np
import numpy.typing as npt

from camsim.errors import InputError, in_brief
from camsim.files import exr_reader, npz_reader, png_reader, tiff_reader
from camsim.files.describe import XMP_NAMESPACE
from camsim.files.npz import RECORD_NAME
from camsim.files.record import LONGEST_RECORD, Record, is_record, parse_record
from camsim.files.tiff_image import read_image

_ANY_NAMESPACE = b"urn:camsim:"


@dataclass(frozen=True, slots=True, kw_only=True)
class Held:
    """Metadata of a file.

    form       : "DNG", "OpenEXR", "TIFF", "PNG" or "NPZ"
    suffix     : file suffix of this format, with its dot
    rows, cols : size of the image
    size_bytes : size of the file
    has_truth  : whether it contains the truth
    compressed : whether it is a DNG of lossless JPEG
    record     : the figures that explain its numbers, and ``description``: all stages with all parameters
    """

    path: Path
    form: str
    suffix: str
    rows: int
    cols: int
    size_bytes: int
    has_truth: bool
    compressed: bool
    record: Record

    @property
    def fits(self) -> bool:
        """Whether the image has the rows and columns that its record states, if it states any."""
        return self.record.size in (None, (self.rows, self.cols))

    @property
    def product(self) -> str:
        """The product of the frame that the file holds."""
        return self.record.product

    @property
    def description(self) -> Mapping[str, Any]:
        """All stages with all parameters, as used by :mod:`camsim.config.from_record`."""
        return self.record.description


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
    """Read the metadata of a DNG, EXR, TIFF, PNG or NPZ of camsim, without the image.

    Raises InputError for other, truncated or changed files.
    """
    with opened(path) as (file, size):
        reader = _reader(file)
        if reader is None:
            raise InputError("it is no DNG, OpenEXR, TIFF, PNG or NPZ of camsim")
        found = reader(file, size)
        record = parse_record(found.text)
    return Held(
        path=Path(path),
        form=found.form,
        suffix=found.suffix,
        rows=found.rows,
        cols=found.cols,
        size_bytes=size,
        has_truth=found.has_truth or record.product == "truth",
        compressed=found.compressed,
        record=record,
    )


def read_arrays(held: Held) -> dict[str, npt.NDArray[Any]]:
    """Return the arrays of a file read by ``read_file``, by name; an unnamed image is ``codes``."""
    with opened(held.path) as (file, size):
        if held.form == "NPZ":
            with npz_reader.opened(file, size) as archive:
                return {name: archive.array(name) for name in archive.arrays}
        if held.form == "OpenEXR":
            layers = exr_reader.read_layers(held.path, file, size)
            return {f"{layer}.{name}".lstrip("."): plane for layer in layers for name, plane in layers[layer].items()}
        if held.form == "PNG":
            return {"codes": png_reader.read_pixels(file, size, png_reader.read_header(file, size, LONGEST_RECORD))}
        first = tiff_reader.read_directory(file, size)
        return {"codes": read_image(_main_image(file, size, first) if held.form == "DNG" else first)}


def is_altered(held: Held) -> bool:
    """Whether a DNG's codes do not match the identifier in the file; false for other files."""
    if held.form != "DNG":
        return False
    with opened(held.path) as (file, size):
        first = tiff_reader.read_directory(file, size)
        written, text = first.bytes_of(tiff_reader.RAW_DATA_UNIQUE_ID, 16), _dng_text(first) or ""
    codes = np.ascontiguousarray(read_arrays(held)["codes"], "<u2")
    return hashlib.blake2b(codes.tobytes() + text.encode("ascii"), digest_size=16).digest() != written


def read_record(file: BinaryIO, size: int) -> Record | None:
    """Return the record of an open file; None for files of other programs.

    Raises InputError if a camsim file is damaged.
    """
    reader = _reader(file)
    text = reader(file, size).text if reader is not None else None
    return None if text is None or not is_record(text) else parse_record(text)


@contextlib.contextmanager
def opened(path: str | os.PathLike[str]) -> Iterator[tuple[BinaryIO, int]]:
    """Open a file; yield it with its size, and name it in errors."""
    try:
        if not Path(path).is_file():
            raise InputError("there is no such file" if not Path(path).exists() else "it is not a file")
        with Path(path).open("rb") as file:
            yield file, os.fstat(file.fileno()).st_size
    except InputError as error:
        raise InputError(f"cannot read {str(path)!r}: {error}") from None
    except OSError as error:
        raise InputError(f"cannot read {str(path)!r}: {error.strerror or error}") from error


def _reader(file: BinaryIO) -> Callable[[BinaryIO, int], _Found] | None:
    """Return the reader for a file's magic number; None for a format without a record."""
    file.seek(0)
    begin = file.read(8)
    readers = {exr_reader.MAGIC: _exr, png_reader.MAGIC: _png, npz_reader.MAGIC: _npz}
    readers |= dict.fromkeys(tiff_reader.MAGICS, _tiff)
    return next((reader for magic, reader in readers.items() if begin.startswith(magic)), None)


def _tiff(file: BinaryIO, size: int) -> _Found:
    directory = tiff_reader.read_directory(file, size)
    is_dng = tiff_reader.DNG_VERSION in directory.entries
    text = (_dng_text if is_dng else _tiff_text)(directory)
    main = _main_image(file, size, directory) if is_dng else directory
    rows, cols = main.number(tiff_reader.IMAGE_LENGTH), main.number(tiff_reader.IMAGE_WIDTH)
    if text is not None:
        # Foreign tags may be arbitrary, camsim's must be complete.
        directory.refuse_truncated()
    if not is_dng:
        return _Found("TIFF", ".tiff", rows, cols, text)
    compressed = main.number(tiff_reader.COMPRESSION) == tiff_reader.LOSSLESS_JPEG
    return _Found("DNG", ".dng", rows, cols, text, compressed=compressed)


def _main_image(file: BinaryIO, size: int, first: tiff_reader.Directory) -> tiff_reader.Directory:
    """Return the directory of a DNG's main image: another program may have put a preview before it."""
    if first.number(tiff_reader.SUBFILE_TYPE, 0) == 0:
        return first
    every = tiff_reader.read_directories(file, size)
    return next((each for each in every if each.number(tiff_reader.SUBFILE_TYPE, 0) == 0), first)


def _dng_text(directory: tiff_reader.Directory) -> str | None:
    return _record_in_xmp(directory.bytes_of(tiff_reader.XMP, 2 * LONGEST_RECORD))


def _tiff_text(directory: tiff_reader.Directory) -> str | None:
    words = directory.bytes_of(tiff_reader.IMAGE_DESCRIPTION, LONGEST_RECORD).rstrip(b"\0")
    return words.decode("ascii", "replace") if words[:1] == b"{" else None


def _exr(file: BinaryIO, size: int) -> _Found:
    header = exr_reader.read_header(file, size, 2 * LONGEST_RECORD)
    rows, cols = header.size()
    text = header.text("camsim:record")
    # The end is known only for camsim's files.
    if text is not None and (end := exr_reader.end_of_chunks(file, header)) != size:
        where = f"its image ends at byte {end}" if end else "its image is not whole"
        raise InputError(f"it is cut short or damaged: it has {size} bytes and {where}")
    return _Found("OpenEXR", ".exr", rows, cols, text)


def _png(file: BinaryIO, size: int) -> _Found:
    header = png_reader.read_header(file, size, LONGEST_RECORD)
    return _Found("PNG", ".png", header.rows, header.cols, header.text)


def _npz(file: BinaryIO, size: int) -> _Found:
    with npz_reader.opened(file, size) as archive:
        text = archive.text(RECORD_NAME, LONGEST_RECORD)
        if text is None:
            return _Found("NPZ", ".npz", 0, 0, None)
        shape = archive.header("mosaic").shape
        if len(shape) != 2:
            raise InputError(f"its mosaic has the shape {shape}, and (rows, cols) is needed")
        return _Found("NPZ", ".npz", shape[0], shape[1], text, "truth" in archive.arrays)


def _record_in_xmp(xmp: bytes) -> str | None:
    """Return the text of camsim's property anywhere in the XMP, which another program may have rearranged."""
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
        raise InputError(f"its XMP is damaged ({in_brief(error)})") from None
    if not letters and _ANY_NAMESPACE in xmp and XMP_NAMESPACE.encode() not in xmp:
        raise InputError(
            "its record has another format than this version of camsim reads; use the version that wrote it"
        )
    return "".join(letters) or None
