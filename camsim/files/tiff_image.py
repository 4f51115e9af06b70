"""The image of one directory of a TIFF or DNG: every size is checked against the file before allocation."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from camsim.errors import InputError, in_brief
from camsim.files.jpeg_reader import frame_header
from camsim.files.limits import refuse_bomb
from camsim.files.tiff_reader import COMPRESSION, IMAGE_LENGTH, IMAGE_WIDTH, TILE_OFFSETS, Directory

_BITS_PER_SAMPLE, _PHOTOMETRIC, _FILL_ORDER, _SAMPLES_PER_PIXEL, _ROWS_PER_STRIP = 258, 262, 266, 277, 278
_PLANAR, _PREDICTOR, _TILE_WIDTH, _TILE_LENGTH, _SAMPLE_FORMAT = 284, 317, 322, 323, 339

_NONE, _LZW, _JPEG, _DEFLATE, _PACKBITS = 1, 5, 7, (8, 32946), 32773
GREY, RGB, MOSAIC, LINEAR_RAW = 1, 2, 32803, 34892
_PHOTOMETRICS = (GREY, RGB, MOSAIC, LINEAR_RAW)

_KINDS = {1: "u", 2: "i", 3: "f"}
_WHOLE_BITS = {"u": (8, 16, 32), "i": (8, 16, 32), "f": (16, 32, 64)}
_MOST_SAMPLES = 64
_MOST_PIECES = 1 << 17
_WAY_OUT = "convert it to an uncompressed 16-bit file (Adobe's DNG converter does)"


class NotReadError(InputError):
    """Raised for an image that is stored in a way that camsim does not read."""


@dataclass(frozen=True, slots=True)
class _Layout:
    """Layout of samples in strips or tiles.

    dtype : of a sample in memory;  bits, order: of a stored one
    planes, samples : planar and interleaved samples of a pixel; one of the two is 1
    piece : rows and columns of a strip or tile
    """

    rows: int
    cols: int
    planes: int
    samples: int
    dtype: np.dtype[Any]
    bits: int
    order: Literal["<", ">"]
    compression: int
    predictor: int
    piece: tuple[int, int]
    tiled: bool

    @property
    def grid(self) -> tuple[int, int]:
        """Number of pieces down and across."""
        return -(-self.rows // self.piece[0]), -(-self.cols // self.piece[1])


def photometric(directory: Directory) -> int:
    """Return the photometric interpretation, by TIFF's number."""
    return directory.number(_PHOTOMETRIC, GREY)


def bits_per_sample(directory: Directory) -> int:
    """Return the bits of a stored sample; they are the same in all channels."""
    bits = set(directory.numbers(_BITS_PER_SAMPLE) or (1,))
    if len(bits) != 1:
        raise InputError(f"its samples have {', '.join(map(str, sorted(bits)[:4]))} bits; one number is read for all")
    return bits.pop()


def read_image(directory: Directory) -> npt.NDArray[Any]:
    """Return the samples, (rows, cols) or (rows, cols, samples)."""
    layout = _layout(directory)
    offsets, counts = directory.pieces()
    down, across = layout.grid
    if len(offsets) != layout.planes * down * across or len(offsets) > _MOST_PIECES:
        raise InputError(
            f"it says {layout.planes * down * across} strips or tiles and lists {len(offsets)}; "
            f"{_MOST_PIECES} are the most that are read"
        )
    image = np.empty((layout.planes, layout.rows, layout.cols, layout.samples), layout.dtype)
    for index, (at, count) in enumerate(zip(offsets, counts, strict=True)):
        plane, place = divmod(index, down * across)
        top, left = (k * size for k, size in zip(divmod(place, across), layout.piece, strict=True))
        # A strip ends with the image, a tile may extend beyond it.
        height = layout.piece[0] if layout.tiled else min(layout.piece[0], layout.rows - top)
        directory.file.seek(at)
        piece = _piece(directory.file.read(count), (height, layout.piece[1], layout.samples), layout)
        here = image[plane, top : top + height, left : left + layout.piece[1]]
        here[...] = piece[: here.shape[0], : here.shape[1]]
    if layout.planes > 1:
        return np.moveaxis(image[..., 0], 0, -1)
    return image[0, :, :, 0] if layout.samples == 1 else image[0]


def _layout(directory: Directory) -> _Layout:
    """Validate the layout of an image in its directory."""
    rows, cols = directory.number(IMAGE_LENGTH), directory.number(IMAGE_WIDTH)
    samples = directory.number(_SAMPLES_PER_PIXEL, 1)
    bits = bits_per_sample(directory)
    form = set(directory.numbers(_SAMPLE_FORMAT) or (1,))
    kind = _KINDS.get(form.pop()) if len(form) == 1 else None
    compression, means = directory.number(COMPRESSION, _NONE), photometric(directory)
    if not rows or not cols or not 1 <= samples <= _MOST_SAMPLES:
        raise InputError(f"it says {rows} × {cols} pixels of {samples} samples")
    if means not in _PHOTOMETRICS:
        raise InputError(
            f"its samples mean something else than light (photometric interpretation {means}); "
            "grey, RGB, a filter mosaic or linear raw is needed"
        )
    packed = kind == "u" and compression == _NONE and 8 < bits < 16
    if kind is None or not (bits in _WHOLE_BITS[kind] or packed or (compression == _JPEG and 8 < bits < 16)):
        raise NotReadError(f"its samples have {bits} bits, which is not read; {_WAY_OUT}")
    if directory.number(_FILL_ORDER, 1) != 1:
        raise NotReadError(f"its bits are stored in reverse; {_WAY_OUT}")
    tiled = TILE_OFFSETS in directory.entries
    piece = (
        (directory.number(_TILE_LENGTH), directory.number(_TILE_WIDTH))
        if tiled
        else (min(rows, directory.number(_ROWS_PER_STRIP, rows)), cols)
    )
    if not all(piece):
        raise InputError(f"its strips or tiles have {piece[0]} × {piece[1]} pixels")
    apart = directory.number(_PLANAR, 1) == 2 and samples > 1
    layout = _Layout(
        rows=rows,
        cols=cols,
        planes=samples if apart else 1,
        samples=1 if apart else samples,
        dtype=np.dtype(f"{kind}{-(-bits // 8) if not 8 < bits < 16 else 2}"),
        bits=bits,
        order=directory.form.order,
        compression=compression,
        predictor=directory.number(_PREDICTOR, 1) if compression not in (_NONE, _JPEG) else 1,
        piece=piece,
        tiled=tiled,
    )
    itemsize = layout.dtype.itemsize
    if compression == _NONE and rows * (cols * samples * bits // 8) > directory.size:
        raise InputError(
            f"it is cut short: it has {directory.size} bytes and its image of {rows} × {cols} pixels needs "
            f"{rows * (cols * samples * bits // 8)}"
        )
    # One tile may be larger than the image.
    pixels = max(rows * cols * layout.planes, piece[0] * piece[1])
    refuse_bomb(pixels * layout.samples * itemsize, directory.size)
    return layout


def _piece(data: bytes, shape: tuple[int, int, int], layout: _Layout) -> npt.NDArray[Any]:
    """Return one strip or tile; raises unless it has the required number of bytes."""
    if layout.compression == _JPEG:
        return _from_jpeg(data, shape, layout)
    rows, cols, samples = shape
    row_bytes = -(-cols * samples * layout.bits // 8)
    raw = _unpacked(data, rows * row_bytes, layout.compression)
    if len(raw) < rows * row_bytes:
        raise InputError(f"a strip or tile holds {len(raw)} bytes where {rows * row_bytes} belong")
    lines = np.frombuffer(raw, np.uint8, rows * row_bytes).reshape(rows, row_bytes)
    if 8 < layout.bits < 16:
        return _from_bits(lines, cols * samples, layout.bits).reshape(shape)
    if layout.predictor == 3:
        return _from_float_differences(lines, shape, layout.dtype)
    values = lines.view(layout.dtype.newbyteorder(layout.order)).reshape(shape).astype(layout.dtype, copy=False)
    if layout.predictor == 2:
        summed: npt.NDArray[Any] = np.cumsum(values, axis=1, dtype=layout.dtype)
        return summed
    if layout.predictor != 1:
        raise NotReadError(f"its samples are predicted in a way that is not read ({layout.predictor}); {_WAY_OUT}")
    return values


def _unpacked(data: bytes, needed: int, compression: int) -> bytes:
    """Return the first ``needed`` bytes of a strip or tile, without unpacking many more."""
    if compression == _NONE:
        return data
    try:
        if compression in _DEFLATE:
            return zlib.decompressobj().decompress(data, needed)
        if compression == _PACKBITS:
            return _from_packbits(data, needed)
        if compression == _LZW:
            return bytes(_imagecodecs("LZW").lzw_decode(data, out=needed))
    except (zlib.error, RuntimeError, ValueError) as error:  # RuntimeError: imagecodecs' own
        raise InputError(f"a strip or tile is damaged ({in_brief(error)})") from None
    raise NotReadError(f"its image is stored as TIFF's compression {compression}, which is not read; {_WAY_OUT}")


def _from_packbits(data: bytes, needed: int) -> bytes:
    """Undo TIFF 6.0's PackBits: a count, then that many bytes or one to repeat."""
    out, at = bytearray(), 0
    while len(out) < needed and at + 1 < len(data):
        count = data[at]
        if count < 128:
            out += data[at + 1 : at + 2 + count]
            at += 2 + count
        else:
            out += data[at + 1 : at + 2] * (257 - count if count > 128 else 0)
            at += 2 if count > 128 else 1
    return bytes(out)


def _from_bits(lines: npt.NDArray[np.uint8], count: int, bits: int) -> npt.NDArray[np.uint16]:
    """Return samples of 9 to 15 bits, packed without gaps from the highest bit on; each row begins with a byte."""
    values = np.empty((len(lines), count), np.uint16)
    place = 1 << np.arange(bits - 1, -1, -1, dtype=np.uint32)
    for row, line in enumerate(lines):
        values[row] = np.unpackbits(line)[: count * bits].reshape(count, bits) @ place
    return values


def _from_float_differences(
    lines: npt.NDArray[np.uint8], shape: tuple[int, int, int], dtype: np.dtype[Any]
) -> npt.NDArray[Any]:
    """Undo Adobe's predictor 3: bytes grouped by rank from the highest, as differences."""
    rows, cols, samples = shape
    if dtype.kind != "f":
        raise NotReadError(f"whole numbers are predicted as if they were floating-point ones; {_WAY_OUT}")
    apart = np.cumsum(lines.reshape(rows, -1, samples), axis=1, dtype=np.uint8)
    bytes_of = apart.reshape(rows, dtype.itemsize, cols * samples).transpose(0, 2, 1)
    return np.ascontiguousarray(bytes_of).view(dtype.newbyteorder(">")).reshape(shape).astype(dtype)


def _from_jpeg(data: bytes, shape: tuple[int, int, int], layout: _Layout) -> npt.NDArray[Any]:
    """Return a strip or tile of JPEG; its header must match the layout."""
    frame = frame_header(data)
    belongs = shape[0] * shape[1] * shape[2]
    if frame.rows * frame.cols * frame.components != belongs:
        raise InputError(
            f"a tile of JPEG says {frame.rows} × {frame.cols} pixels of {frame.components} samples, and "
            f"{shape[0]} × {shape[1]} of {shape[2]} belong there"
        )
    codecs = _imagecodecs("JPEG")
    try:
        pixels: npt.NDArray[Any] = codecs.jpeg8_decode(data)
    except (RuntimeError, ValueError) as error:  # RuntimeError: imagecodecs' own
        raise InputError(
            f"a tile of JPEG is damaged, or of a kind that is not read ({in_brief(error)}); {_WAY_OUT}"
        ) from None
    if pixels.size != belongs or pixels.dtype.kind != "u":
        raise InputError(f"a tile of JPEG holds {pixels.size} samples where {belongs} belong")
    return pixels.reshape(shape)


def _imagecodecs(what: str) -> Any:
    try:
        import imagecodecs
    except ImportError:
        raise NotReadError(
            f"its image is stored as {what}; {_WAY_OUT}, or: python -m pip install imagecodecs"
        ) from None
    return imagecodecs
