"""TIFF's many layouts as another program writes them, read back number for number."""

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tifffile

from camsim.errors import InputError
from camsim.files.tiff_image import read_image
from camsim.files.tiff_reader import read_directory

KINDS = ("uint8", "uint16", "uint32", "int16", "float16", "float32", "float64")


def read(path: Path) -> np.ndarray[Any, Any]:
    with path.open("rb") as file:
        return read_image(read_directory(file, path.stat().st_size))


def numbers(kind: str, shape: tuple[int, ...]) -> np.ndarray[Any, Any]:
    drawn = np.random.default_rng(7).uniform(0, 255, shape)
    return (np.rint(drawn) if np.dtype(kind).kind in "ui" else drawn).astype(kind)


@pytest.mark.parametrize("kind", KINDS)
def test_every_layout_comes_back(tmp_path: Path, kind: str) -> None:
    packings: list[dict[str, Any]] = [
        {},
        {"compression": "zlib"},
        {"compression": "zlib", "predictor": True},
        {"compression": "lzw"},
        {"compression": "packbits"},
    ]
    pieces: list[dict[str, Any]] = [{}, {"rowsperstrip": 7}, {"tile": (16, 32)}]
    headers = itertools.cycle((("<", False), (">", False), ("<", True), (">", True)))  # 4 and 45 share no factor
    shapes = ((37, 45), (37, 45, 3), (3, 37, 45))
    for (shape, packing, piece), (order, big) in zip(
        itertools.product(shapes, packings, pieces), headers, strict=False
    ):
        image = numbers(kind, shape)
        how = {"photometric": "rgb", "planarconfig": "separate" if shape[0] == 3 else "contig"}
        with tifffile.TiffWriter(tmp_path / "a.tiff", byteorder=order, bigtiff=big) as tiff:
            tiff.write(image, metadata=None, **(how if len(shape) == 3 else {}), **packing, **piece)
        expected = np.moveaxis(image, 0, -1) if shape[0] == 3 else image
        got = read(tmp_path / "a.tiff")
        assert got.dtype == expected.dtype
        np.testing.assert_array_equal(got, expected, err_msg=f"{order} {big} {shape} {packing} {piece}")


@pytest.mark.parametrize("bits", [10, 12, 14])
@pytest.mark.parametrize("cols", [8, 13])
def test_packed_bits(tmp_path: Path, bits: int, cols: int) -> None:
    """Bits are counted one by one here: the highest first, every row from a byte of its own."""
    image = np.random.default_rng(3).integers(0, 1 << bits, (5, cols)).astype(np.uint16)
    rows = ["".join(format(value, f"0{bits}b") for value in row) for row in image]
    packed = b"".join(int(row.ljust(-(-len(row) // 8) * 8, "0"), 2).to_bytes(-(-len(row) // 8)) for row in rows)
    tifffile.imwrite(tmp_path / "a.tiff", np.zeros((5, len(packed) // 5), np.uint8), metadata=None)
    data = bytearray((tmp_path / "a.tiff").read_bytes())
    with tifffile.TiffFile(tmp_path / "a.tiff") as tiff:
        tags = {tag.code: tag for tag in tiff.pages.first.tags}
        at = tags[273].value[0]
        data[at : at + len(packed)] = packed
        for code, value in ((256, cols), (258, bits)):
            offset = tags[code].offset + 8
            data[offset : offset + 2] = value.to_bytes(2, "little")
    (tmp_path / "a.tiff").write_bytes(data)
    np.testing.assert_array_equal(read(tmp_path / "a.tiff"), image)


@pytest.mark.parametrize(
    ("how", "message"),
    [
        ({"photometric": "miniswhite"}, "photometric interpretation 0"),
        ({"photometric": "palette", "colormap": np.zeros((3, 256), np.uint16)}, "photometric interpretation 3"),
        ({"compression": "lzma"}, "compression 34925"),
    ],
)
def test_what_is_no_light_is_refused(tmp_path: Path, how: dict[str, Any], message: str) -> None:
    tifffile.imwrite(tmp_path / "a.tiff", numbers("uint8", (9, 9)), metadata=None, **how)
    with pytest.raises(InputError, match=message):
        read(tmp_path / "a.tiff")
