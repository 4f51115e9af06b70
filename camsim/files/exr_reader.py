"""An untrusted OpenEXR file: its header, the required end of its last chunk, and its pixels.

The library trusts a header and allocates the memory; so the header is checked first.
"""

from __future__ import annotations

import contextlib
import os
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from camsim.errors import InputError, in_brief
from camsim.files.limits import refuse_bomb
from camsim.files.which_image import split_channel

MAGIC = struct.pack("<i", 20000630)

_LONGEST_NAME = 255
_MOST_ATTRIBUTES = 4096
_MOST_PARTS = 64
_MOST_CHANNELS = 4096
_LARGEST_COORDINATE = 1 << 30
_LONGEST_HEADER = 1 << 20
_ROWS_PER_CHUNK = {0: 1, 2: 1, 3: 16}
"""By the format's code of the compression: none, one row by ZIP, 16 rows by ZIP."""

_MOST_ROWS_PER_CHUNK = 256
"""Most rows per chunk of any compression."""

_DEEP, _SEVERAL_PARTS = 0x800, 0x1000
_BYTES_OF_SAMPLE = {0: 4, 1: 2, 2: 4}
"""By the format's code: integer, half, float."""


@dataclass(frozen=True, slots=True)
class Header:
    """Attributes by name, as type and bytes, and the offset of the table of chunks after them."""

    attributes: Mapping[str, tuple[str, bytes]]
    chunk_table: int

    def text(self, name: str) -> str | None:
        """Return a string attribute; None if absent or of another type."""
        kind, value = self.attributes.get(name, ("", b""))
        return value.decode("utf-8", "replace") if kind == "string" else None

    def primaries(self) -> tuple[float, ...]:
        """Return x and y of red, green, blue and white; empty if not stated."""
        kind, value = self.attributes.get("chromaticities", ("", b""))
        return struct.unpack("<8f", value) if kind == "chromaticities" and len(value) == 32 else ()

    def size(self) -> tuple[int, int]:
        """Return rows and columns."""
        kind, value = self.attributes.get("dataWindow", ("", b""))
        if kind != "box2i" or len(value) != 16:
            raise InputError("its header has no dataWindow")
        left, top, right, bottom = struct.unpack("<4i", value)
        if right < left or bottom < top:
            raise InputError("its dataWindow is empty")
        if max(-left, -top, right, bottom) > _LARGEST_COORDINATE:
            raise InputError(f"its dataWindow reaches from {left}, {top} to {right}, {bottom}, which no image does")
        return bottom - top + 1, right - left + 1


def read_header(file: BinaryIO, size: int, most: int) -> Header:
    """Read the attributes of a file of one part; raises InputError over ``most`` bytes of them."""
    file.seek(8)
    return _attributes(file, size, most)


def read_layers(path: Path, file: BinaryIO, size: int) -> Mapping[str, Mapping[str, npt.NDArray[Any]]]:
    """Return all channels, (rows, cols) each, by layer and name.

    Layers of the first part keep their names, and channels without a layer have the empty one: single-part programs see
    only these. Layers of other parts are prefixed by the part's name.
    """
    file.seek(0)
    begin = file.read(8).ljust(8, b"\0")
    if not begin.startswith(MAGIC):
        raise InputError("it is no OpenEXR")
    (flags,) = struct.unpack_from("<I", begin, 4)
    if flags & _DEEP:
        raise InputError("it is a deep image, with several samples in a pixel, which cannot be measured")
    headers = [_attributes(file, size, _LONGEST_HEADER)]
    while flags & _SEVERAL_PARTS and (following := _attributes(file, size, _LONGEST_HEADER)).attributes:
        headers.append(following)
        if len(headers) > _MOST_PARTS:
            raise InputError(f"it has more than {_MOST_PARTS} parts")
    refuse_bomb(sum(_image_bytes(header, size) for header in headers), size)
    import OpenEXR

    try:
        with _without_its_words():
            parts = [
                (part.name() if index else "", {name: np.asarray(each.pixels) for name, each in part.channels.items()})
                for index, part in enumerate(OpenEXR.File(str(path), separate_channels=True).parts)
            ]
    except (RuntimeError, ValueError, IndexError, OverflowError) as error:  # errors of C++ as translated by pybind11
        raise InputError(f"it is cut short or damaged ({in_brief(error)})") from None
    layers: dict[str, dict[str, npt.NDArray[Any]]] = {}
    for part, channels in parts:
        of_part: dict[str, dict[str, npt.NDArray[Any]]] = {}
        for name, pixels in channels.items():
            layer, channel = split_channel(name)
            whole = layer if layer == part else ".".join(filter(None, (part, layer)))
            of_part.setdefault(whole, {})[channel] = pixels
        if twice := layers.keys() & of_part.keys():
            raise InputError(f"two of its layers are called {min(twice)[:40]!r}")
        layers |= of_part
    return layers


@contextlib.contextmanager
def _without_its_words() -> Iterator[None]:
    """Silence the library, which writes errors directly to the process's stderr in addition to raising them."""
    try:
        saved = os.dup(2)
    except OSError:  # there is no stderr
        yield
        return
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 2)
        os.close(nowhere)
        yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)


def _image_bytes(header: Header, size: int) -> int:
    """Return the bytes of the pixels of a part, after checking its header."""
    rows, cols = header.size()
    if 8 * (rows // _MOST_ROWS_PER_CHUNK) > size:
        raise InputError(f"it says {rows} rows and has {size} bytes, too few for the table of its chunks")
    kind, tiles = header.attributes.get("tiles", ("", b""))
    if kind == "tiledesc" and len(tiles) == 9:
        # A tile is unpacked entirely, even if little of it is image.
        across, down = struct.unpack_from("<2I", tiles)
        rows, cols = max(rows, down), max(cols, across)
    return rows * cols * sum(_sample_bytes(header))


def _sample_bytes(header: Header) -> list[int]:
    """Return the bytes of a sample of each channel."""
    kind, value = header.attributes.get("channels", ("", b""))
    if kind != "chlist":
        raise InputError("its header has no channels")
    found: list[int] = []
    at = 0
    while at < len(value) and value[at]:
        end = value.find(b"\0", at)
        if end < 0 or end + 17 > len(value) or len(found) >= _MOST_CHANNELS:
            raise InputError("the list of its channels is damaged")
        sample, _, x_step, y_step = struct.unpack_from("<4i", value, end + 1)
        if sample not in _BYTES_OF_SAMPLE or (x_step, y_step) != (1, 1):
            raise InputError(
                f"its channel {value[at:end].decode('latin-1')[:40]!r} has samples of kind {sample}, every {y_step} "
                f"rows and {x_step} columns; all pixels are needed, as half or float"
            )
        found.append(_BYTES_OF_SAMPLE[sample])
        at = end + 17
    if not found:
        raise InputError("it has no channels")
    return found


def _attributes(file: BinaryIO, size: int, most: int) -> Header:
    attributes: dict[str, tuple[str, bytes]] = {}
    for _ in range(_MOST_ATTRIBUTES):
        name = _name(file)
        if not name:
            return Header(attributes, file.tell())
        kind = _name(file)
        (length,) = struct.unpack("<i", file.read(4).ljust(4, b"\xff"))
        if not 0 <= length <= most:
            raise InputError(f"its attribute {name!r} has {length} bytes, which camsim never writes")
        value = file.read(length)
        if len(value) < length:
            raise InputError(f"it is cut short: it has {size} bytes and ends within its header")
        attributes[name] = kind, value
        most -= length
    raise InputError("its header has no end")


def end_of_chunks(file: BinaryIO, header: Header) -> int:
    """Return where the file must end by its table of chunks; 0 if the table is incomplete."""
    rows, _ = header.size()
    kind, compression = header.attributes.get("compression", ("", b""))
    rows_per_chunk = _ROWS_PER_CHUNK.get(compression[0]) if kind == "compression" and compression else None
    if rows_per_chunk is None:
        raise InputError("it has a compression that camsim never writes")
    file.seek(header.chunk_table + 8 * ((rows - 1) // rows_per_chunk))
    (last,) = struct.unpack("<Q", file.read(8).ljust(8, b"\0"))
    if not 0 < last < 1 << 62:
        return 0
    file.seek(last + 4)
    (length,) = struct.unpack("<i", file.read(4).ljust(4, b"\xff"))
    return last + 8 + length if length > 0 else 0


def _name(file: BinaryIO) -> str:
    letters = bytearray()
    while (letter := file.read(1)) not in (b"\0", b""):
        letters += letter
        if len(letters) > _LONGEST_NAME:
            raise InputError("its header holds a name that never ends")
    return letters.decode("latin-1")
