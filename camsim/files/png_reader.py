"""Untrusted PNG: checksums of all chunks, texts, and pixels."""

from __future__ import annotations

import io
import struct
import zlib
from dataclasses import dataclass, replace
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from camsim.errors import InputError, in_brief
from camsim.files.limits import refuse_bomb
from camsim.files.primaries import other_than_srgb

MAGIC = b"\x89PNG\r\n\x1a\n"

_PALETTE = 3
_CHANNELS = {0: 1, 2: 3, _PALETTE: 1, 4: 2, 6: 4}
_BITS = {0: (1, 2, 4, 8, 16), 2: (8, 16), _PALETTE: (1, 2, 4, 8), 4: (8, 16), 6: (8, 16)}
"""By the format's colour type: grey, RGB, palette, grey and RGB with alpha."""

_MOST_CHUNKS = 1 << 16
_LONGEST_OTHER = 64
_GAMMA_UNIT = 1e-5
_SRGB_CODES = b"\x01\x0d"  # primaries of BT.709, sRGB's curve


@dataclass(frozen=True, slots=True)
class Header:
    """Metadata before the pixels of a PNG.

    text     : camsim's, None if absent
    gamma    : exponent of the pixels' encoding, 1 if not stated
    coloured : whether a colour space is named;  profile: the ICC profile;  space: a space other than sRGB, in words
    see_through : whether one colour is transparent;  exif: EXIF data
    image    : offset and length of the chunks passed to Pillow: header and pixels
    """

    rows: int
    cols: int
    bits: int
    colour: int
    text: str | None
    gamma: float
    coloured: bool
    image: tuple[tuple[int, int], ...]
    profile: bytes = b""
    space: str = ""
    see_through: bool = False
    exif: bytes = b""


def read_header(file: BinaryIO, size: int, most: int) -> Header:
    """Check every chunk; raises InputError for damaged or missing ones.

    most : the longest text, unpacked, in bytes
    """
    file.seek(0)
    if file.read(len(MAGIC)) != MAGIC:
        raise InputError("it is no PNG")
    head: bytes | None = None
    text, gamma, coloured, profile = None, 1.0, False, b""
    code_points, primaries, see_through, exif = b"", b"", False, b""
    image: list[tuple[int, int]] = []
    for _ in range(_MOST_CHUNKS):
        at = file.tell()
        length, kind = struct.unpack(">I4s", file.read(8).ljust(8, b"\0"))
        if at + 8 > size or kind == b"\0\0\0\0":
            raise InputError(f"it is cut short: it has {size} bytes and no end")
        if at + length + 12 > size:
            raise InputError(f"it is cut short: it has {size} bytes and ends within its chunk {kind!r}")
        if kind == b"IEND":
            space = _space(code_points, b"" if coloured else primaries)
            header = _header(head, text, gamma, coloured, image)
            return replace(header, profile=profile, space=space, see_through=see_through, exif=exif)
        see_through |= kind == b"tRNS"
        if kind not in (b"IHDR", b"IDAT", b"zTXt", b"gAMA", b"sRGB", b"iCCP", b"cICP", b"cHRM", b"eXIf"):
            file.seek(length + 4, 1)
            continue
        content = _checked(file, kind, length, most if kind in (b"zTXt", b"iCCP", b"eXIf") else _LONGEST_OTHER)
        if kind == b"IHDR":
            if head is not None:
                raise InputError("it has two headers (IHDR), and which of them counts nobody can say")
            head = content
        if kind in (b"IHDR", b"IDAT"):
            image.append((at, length + 12))
        elif kind == b"gAMA" and length == 4:
            gamma = struct.unpack(">I", content)[0] * _GAMMA_UNIT
        elif kind == b"cICP":
            code_points = content
        elif kind == b"cHRM":
            primaries = content
        elif kind == b"eXIf":
            exif = content
        elif kind in (b"sRGB", b"iCCP"):
            coloured = True
            profile = _profile(content, most) if kind == b"iCCP" else profile
        elif content.startswith(b"camsim\0\0"):
            text = _unpacked(content[8:], most)
    raise InputError(f"it has more than {_MOST_CHUNKS} chunks")


def read_pixels(file: BinaryIO, size: int, header: Header) -> npt.NDArray[Any]:
    """Return the pixels, (rows, cols) or (rows, cols, channels), of 8 or 16 bits; fewer bits fill 8."""
    if header.colour == _PALETTE:
        raise InputError("it is an image of a colour palette, which cannot be measured")
    if header.see_through:
        raise InputError("one of its colours is transparent (tRNS), and nobody knows what is behind; flatten it first")
    channels = _CHANNELS[header.colour]
    if header.bits == 16 and channels > 1:
        return _deep_channels(file, size, header)
    refuse_bomb(header.rows * header.cols * channels * max(1, header.bits // 8), size)
    from PIL import PngImagePlugin

    chunks = bytearray(MAGIC)
    for at, length in header.image:
        file.seek(at)
        chunks += file.read(length)
    chunks += struct.pack(">I4sI", 0, b"IEND", zlib.crc32(b"IEND"))
    try:
        # Only chunks for the pixels are passed to Pillow, and not to Image.open, whose limits are process-wide.
        with PngImagePlugin.PngImageFile(io.BytesIO(chunks)) as opened:
            image = np.asarray(opened)
    except (OSError, SyntaxError, ValueError) as error:
        raise InputError(f"its pixels are damaged ({in_brief(error)})") from None
    if image.dtype == np.bool_:
        return image.astype(np.uint8) * np.uint8(255)
    # Pillow's 16-bit grey may come with 32 bits.
    return image.astype(np.uint16) if header.bits == 16 else image


def _deep_channels(file: BinaryIO, size: int, header: Header) -> npt.NDArray[Any]:
    """Return the pixels of 16-bit colours, or grey with alpha, (rows, cols, channels): Pillow makes 8 bits of them."""
    try:
        import imagecodecs
    except ImportError:
        raise InputError(
            "it has 16 bits a colour, which needs the package imagecodecs: python -m pip install "
            "'camsim-spectral[compress]'; or save it as TIFF"
        ) from None
    refuse_bomb(header.rows * header.cols * _CHANNELS[header.colour] * 2, size)
    file.seek(0)
    try:
        return np.asarray(imagecodecs.png_decode(file.read(size)))
    except (RuntimeError, ValueError) as error:
        raise InputError(f"its pixels are damaged ({in_brief(error)})") from None


def _space(code_points: bytes, primaries: bytes) -> str:
    """Return a text on the colour space of chunks cICP (ITU-T H.273) or cHRM; empty for sRGB or none."""
    if code_points and code_points[:2] != _SRGB_CODES:
        return f"cICP {' '.join(map(str, code_points[:4]))}"
    x_y = [value * 1e-5 for value in struct.unpack(">8I", primaries)] if len(primaries) == 32 else []
    return other_than_srgb([*x_y[2:], *x_y[:2]], "cHRM")


def _profile(content: bytes, most: int) -> bytes:
    """Return the ICC profile of a chunk: a name, 0, the method, and the packed profile."""
    _, _, packed = content.partition(b"\0")
    try:
        return zlib.decompressobj().decompress(packed[1:], most)
    except zlib.error:
        return b"damaged"


def _header(head: bytes | None, text: str | None, gamma: float, coloured: bool, image: list[tuple[int, int]]) -> Header:
    if head is None or len(head) != 13:
        raise InputError("its header (IHDR) is missing or has not 13 bytes")
    cols, rows, bits, colour = struct.unpack(">2I2B", head[:10])
    if not rows or not cols or bits not in _BITS.get(colour, ()):
        raise InputError(f"its header says {rows} × {cols} pixels of {bits} bits and colour type {colour}")
    return Header(rows, cols, bits, colour, text, gamma, coloured, tuple(image))


def _checked(file: BinaryIO, kind: bytes, length: int, most: int) -> bytes:
    """Return the first ``most`` bytes of a chunk after verifying its checksum; none for pixels."""
    content, checksum, left = b"", zlib.crc32(kind), length
    while left:
        some = file.read(min(1 << 20, left))
        if not some:
            raise InputError(f"it is cut short within its chunk {kind!r}")
        checksum = zlib.crc32(some, checksum)
        content += some[: max(0, most - len(content))]
        left -= len(some)
    if file.read(4) != struct.pack(">I", checksum):
        raise InputError(f"its chunk {kind!r} is damaged (its checksum does not fit)")
    return content


def _unpacked(packed: bytes, most: int) -> str:
    try:
        return zlib.decompressobj().decompress(packed, most).decode("latin-1")
    except zlib.error as error:
        raise InputError(f"its text is damaged ({in_brief(error)})") from None
