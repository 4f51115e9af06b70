"""The image of a DNG, written row by row while it is computed: one uncompressed strip, or tiles of lossless JPEG.

Lossless JPEG is that of ITU-T T.81 process 14 with predictor 1, as the DNG specification asks; a mosaic's columns are
dealt out to two components, so that a photosite is predicted from the one of its own filter.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any, BinaryIO, Protocol

import numpy as np

from camsim.core.arrays import U16
from camsim.errors import OutputError
from camsim.files.tiff_ifd import HEADER_BYTES, Tag, header, long, refuse_over_4_gib, short

_UNCOMPRESSED, _LOSSLESS_JPEG = 1, 7
_TILE_ROWS = 128
_TILE_COLS_STEP = 16
"""TIFF 6.0: a tile's width is a multiple of it."""

_PREDICT_LEFT = 1
_BITS = 16


class Pixels(Protocol):
    """Protocol of an encoding of rows of codes as bytes."""

    def encoded(self, codes: U16) -> Iterator[memoryview | bytes]:
        """Yield the bytes of complete pieces; remaining rows are buffered."""
        ...

    def rest(self) -> Iterator[memoryview | bytes]:
        """Yield the bytes of buffered rows."""
        ...

    def tags(self, offsets: list[int], sizes: list[int], rows: int) -> tuple[Tag, ...]:
        """Return the tags for offsets, sizes and encoding of the pieces."""
        ...


class Image:
    """The image part of a file being written, after the header."""

    def __init__(self, file: BinaryIO, pixels: Pixels) -> None:
        self._file, self._pixels = file, pixels
        self._identity = hashlib.blake2b(digest_size=16)
        self._offsets: list[int] = []
        self._sizes: list[int] = []
        self._rows = 0
        self._end = HEADER_BYTES
        file.write(header(0))

    def take(self, codes: U16) -> None:
        """Write the next rows, (m, cols) or (m, cols, samples)."""
        codes = np.ascontiguousarray(codes, dtype="<u2")
        self._identity.update(codes.data.cast("B"))
        self._rows += len(codes)
        self._write(self._pixels.encoded(codes))

    def finish(self, text: str, directories: Callable[[tuple[Tag, ...], bytes, int], tuple[bytes, int]]) -> None:
        """Write everything after the image.

        text        : identifies the image together with its codes
        directories : from the tags of the image, its 16-byte identity and the offset to the bytes of the directories
                      and the offset of the main one
        """
        self._write(self._pixels.rest())
        # TIFF requires directories at even offsets.
        self._file.write(bytes(self._end % 2))
        at = self._end + self._end % 2
        self._identity.update(text.encode("ascii"))
        tags = self._pixels.tags(self._offsets, self._sizes, self._rows)
        content, main_at = directories(tags, self._identity.digest(), at)
        self._file.write(content)
        self._file.seek(0)
        self._file.write(header(main_at))

    def _write(self, pieces: Iterator[memoryview | bytes]) -> None:
        for piece in pieces:
            size = len(piece)
            refuse_over_4_gib(self._end + size)
            self._file.write(piece)
            self._offsets.append(self._end)
            self._sizes.append(size)
            self._end += size


class Strip:
    """Uncompressed codes in a single strip."""

    def encoded(self, codes: U16) -> Iterator[memoryview]:
        """Yield the rows' bytes."""
        yield codes.data.cast("B")

    def rest(self) -> Iterator[memoryview]:
        """Yield nothing: no rows are buffered."""
        yield from ()

    def tags(self, offsets: list[int], sizes: list[int], rows: int) -> tuple[Tag, ...]:
        """Return the tags of one strip: its pieces follow one another."""
        return (
            short(259, _UNCOMPRESSED),
            long(273, offsets[0]),  # StripOffsets
            long(278, rows),  # RowsPerStrip
            long(279, sum(sizes)),  # StripByteCounts
        )


class LosslessTiles:
    """Tiles in two columns, each a separate lossless JPEG.

    components : number of components of a mosaic's columns: 2, or 1 without filters, as LibRaw and dcraw expect
    """

    def __init__(self, cols: int, *, components: int) -> None:
        self._encode, self._components = lossless_encoder(), components
        # More than half the image: dcraw and LibRaw break the rows of a tile wider than the image where the image ends,
        # and LibRaw takes tiles of exactly half its width for another layout.
        self._cols = (cols // (2 * _TILE_COLS_STEP) + 1) * _TILE_COLS_STEP
        self._waiting: list[U16] = []

    def encoded(self, codes: U16) -> Iterator[bytes]:
        """Yield the tiles of complete tile rows."""
        self._waiting.append(codes)
        whole = sum(map(len, self._waiting)) // _TILE_ROWS * _TILE_ROWS
        if whole:
            rows = np.concatenate(self._waiting)
            self._waiting = [rows[whole:].copy()]
            yield from self._tiles(rows[:whole])

    def rest(self) -> Iterator[bytes]:
        """Yield the last tiles, padded with their last rows."""
        rows = np.concatenate(self._waiting)
        if len(rows):
            yield from self._tiles(rows)

    def tags(self, offsets: list[int], sizes: list[int], rows: int) -> tuple[Tag, ...]:
        """Return the tags of the tiles."""
        return (
            short(259, _LOSSLESS_JPEG),
            long(322, self._cols),  # TileWidth
            long(323, _TILE_ROWS),  # TileLength
            long(324, *offsets),  # TileOffsets
            long(325, *sizes),  # TileByteCounts
        )

    def _tiles(self, rows: U16) -> Iterator[bytes]:
        """Yield the tiles from left to right and from the top; the encoder releases the GIL, so threads help."""
        parts = [
            rows[first : first + _TILE_ROWS, left : left + self._cols]
            for first in range(0, len(rows), _TILE_ROWS)
            for left in range(0, rows.shape[1], self._cols)
        ]
        with ThreadPoolExecutor() as pool:
            yield from pool.map(self._tile, parts)

    def _tile(self, codes: U16) -> bytes:
        right, below = self._cols - codes.shape[1], _TILE_ROWS - len(codes)
        edges = ((0, below), (0, right), (0, 0))[: codes.ndim]
        whole = np.pad(codes, edges, mode="edge") if right or below else np.ascontiguousarray(codes)
        return self._encode(whole if whole.ndim == 3 else whole.reshape(_TILE_ROWS, -1, self._components))


def lossless_encoder() -> Callable[[U16], bytes]:
    """Return the encoder of (rows, cols, components); raises OutputError if its library is not installed."""
    try:
        import imagecodecs
    except ImportError:
        raise OutputError(
            "lossless JPEG needs the package imagecodecs: python -m pip install 'camsim-spectral[compress]'; "
            "or leave compression out"
        ) from None

    def encode(codes: U16) -> bytes:
        components: dict[str, Any] = {"colorspace": "rgb", "outcolorspace": "rgb"} if codes.shape[2] == 3 else {}
        return bytes(
            imagecodecs.jpeg8_encode(codes, lossless=True, predictor=_PREDICT_LEFT, bitspersample=_BITS, **components)
        )

    return encode
