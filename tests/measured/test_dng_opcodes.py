"""Opcode lists of DNGs: pixels mean what the specification makes of them. Each list is written here, byte by byte."""

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from maker_files import Tags, mosaic_tags, tiff_raw

from camsim.errors import InputError
from camsim.measure import Picture, read_picture

ROWS, COLS, BLACK, WHITE = 40, 60, 100, 4100
CODES = np.random.default_rng(3).integers(150, 3000, (ROWS, COLS)).astype(np.uint16)
DNG: Tags = {254: ("I", 1), 50706: ("B", bytes((1, 4, 0, 0)))}


def operation(code: int, body: bytes, *, optional: bool = False) -> bytes:
    return struct.pack(">I4BII", code, 1, 3, 0, 0, int(optional), len(body)) + body


def area(top: int = 0, left: int = 0, down: int = 1, across: int = 1) -> bytes:
    return struct.pack(">8I", top, left, ROWS, COLS, 0, 1, down, across)


def written(path: Path, *operations: bytes, number: int = 51009, codes: np.ndarray = CODES, **more: Any) -> Path:
    listed = struct.pack(">I", len(operations)) + b"".join(operations)
    tags: Tags = {
        **mosaic_tags(codes, 16), 50714: ("I", BLACK), 50717: ("I", WHITE), number: ("U", listed),
        **more.get("tags", {}),
    }  # fmt: skip
    tiff_raw(path, codes.astype("<u2").tobytes(), tags, make="Acme", model="One", first=DNG)
    return path


def light(picture: Picture) -> np.ndarray:
    """Samples from black to white, rebuilt."""
    out = np.full(picture.shape, np.nan)
    for plane in picture.planes:
        one = (plane.samples.astype(np.float64) - plane.black) / (plane.white - plane.black)
        out[plane.first[0] :: plane.step[0], plane.first[1] :: plane.step[1]] = one
    return out


LINEAR = (CODES.astype(np.float64) - BLACK) / (WHITE - BLACK)


def test_a_polynomial_makes_light_of_roots(tmp_path: Path) -> None:
    body = area() + struct.pack(">I3d", 2, 0.0, 0.25, 0.75)
    found = light(read_picture(written(tmp_path / "a.dng", operation(8, body))))
    assert found == pytest.approx(0.25 * LINEAR + 0.75 * LINEAR**2, abs=1e-12)


def test_a_table_maps_sixteen_bits(tmp_path: Path) -> None:
    table = (np.arange(65536) ** 2 // 65535).astype(">u2")
    found = light(
        read_picture(written(tmp_path / "a.dng", operation(7, area() + struct.pack(">I", 65536) + table.tobytes())))
    )
    assert found == pytest.approx(LINEAR**2, abs=3e-5)


@pytest.mark.parametrize("optional", [False, True])
def test_a_gain_map_of_one_colour_multiplies_its_photosites(optional: bool, tmp_path: Path) -> None:
    """Shading of red, 3 × 2 points from rim to rim of the image; straight between them."""
    gains = np.array([[1.0, 2.0], [1.5, 1.0], [3.0, 1.0]], ">f4")
    head = struct.pack(">2I4dI", 3, 2, 0.5, 1.0, 0.0, 0.0, 1)
    path = written(tmp_path / "a.dng", operation(9, area(0, 0, 2, 2) + head + gains.tobytes(), optional=optional))
    found = light(read_picture(path))
    expected = LINEAR.copy()
    for row in range(0, ROWS, 2):
        for col in range(0, COLS, 2):
            v, h = (row + 0.5) / ROWS, (col + 0.5) / COLS
            columns = [np.interp(v, [0.0, 0.5, 1.0], gains[:, k]) for k in (0, 1)]
            expected[row, col] *= np.interp(h, [0.0, 1.0], columns)
    assert found == pytest.approx(np.minimum(expected, 1.0), abs=1e-6)
    # Noise is measured in codes: a gain of each photosite's own leaves them.
    assert np.array_equal(light(read_picture(path, stored=True)), LINEAR)
    assert read_picture(path).noted.operations == ("OpcodeList2 GainMap: applied",)


def test_full_photosites_stay_full_and_dark_ones_dark(tmp_path: Path) -> None:
    codes = CODES.copy()
    codes[0, 0], codes[1, 1] = 4100, 0
    half = area() + struct.pack(">I", ROWS) + np.full(ROWS, 0.5, ">f4").tobytes()
    picture = read_picture(written(tmp_path / "a.dng", operation(12, half), codes=codes))
    red = next(plane for plane in picture.planes if plane.name == "R")
    blue = next(plane for plane in picture.planes if plane.name == "B")
    assert red.samples[0, 0] == red.white == 1.0
    assert blue.samples[0, 0] == blue.lowest == pytest.approx(-BLACK / (WHITE - BLACK))
    assert light(picture)[3:] == pytest.approx(0.5 * LINEAR[3:])


@pytest.mark.parametrize(("code", "axis"), [(10, 0), (11, 1), (12, 0), (13, 1)])
def test_rows_and_columns_are_moved_and_scaled(code: int, axis: int, tmp_path: Path) -> None:
    each = np.random.default_rng(code).uniform(0.9, 1.1, CODES.shape[axis]).astype(">f4") - (1.0 if code < 12 else 0.0)
    each = each.astype(">f4")
    body = area() + struct.pack(">I", each.size) + each.tobytes()
    found = light(read_picture(written(tmp_path / "a.dng", operation(code, body))))
    line = each.astype(np.float64)[:, None] if axis == 0 else each.astype(np.float64)
    assert found == pytest.approx(np.minimum(LINEAR + line if code < 12 else LINEAR * line, 1.0), abs=1e-9)


def test_vignetting_is_undone(tmp_path: Path) -> None:
    terms = (0.3, 0.1, 0.0, 0.0, 0.05)
    found = light(read_picture(written(tmp_path / "a.dng", operation(3, struct.pack(">7d", *terms, 0.5, 0.5)))))
    y, x = np.mgrid[0:ROWS, 0:COLS] + 0.5
    r = np.hypot(x - COLS / 2, y - ROWS / 2) / np.hypot(COLS / 2, ROWS / 2)
    gain = 1.0 + 0.3 * r**2 + 0.1 * r**4 + 0.05 * r**10
    assert found == pytest.approx(np.minimum(LINEAR * gain, 1.0), abs=1e-12)


def test_bad_photosites_become_their_neighbours_mean(tmp_path: Path) -> None:
    codes = np.full((ROWS, COLS), 1000, np.uint16)
    codes[0::2, 0::2] = 2000
    codes[10, 20], codes[4, 6], codes[20:22, 30:32] = 4000, 4000, 4000
    points = struct.pack(">3I2I2I4I", 1, 2, 1, 10, 20, 4, 6, 20, 30, 22, 32)
    path = written(tmp_path / "a.dng", operation(5, points), number=51008, codes=codes)
    found = light(read_picture(path)) * (WHITE - BLACK) + BLACK
    mended = np.full((ROWS, COLS), 1000.0)
    mended[0::2, 0::2] = 2000.0
    assert found == pytest.approx(mended)
    constant = written(tmp_path / "b.dng", operation(4, struct.pack(">2I", 4000, 1)), number=51008, codes=codes)
    assert light(read_picture(constant)) * (WHITE - BLACK) + BLACK == pytest.approx(mended)
    # Noise is measured on what is stored.
    assert np.array_equal(np.rint(light(read_picture(path, stored=True)) * (WHITE - BLACK) + BLACK), codes)


def test_curves_are_refused_where_codes_are_wanted_and_damaged_lists_always(tmp_path: Path) -> None:
    curve = area() + struct.pack(">I3d", 2, 0.0, 0.0, 1.0)
    with pytest.raises(InputError, match="OpcodeList2 asks for MapPolynomial, which changes what its samples mean"):
        read_picture(written(tmp_path / "a.dng", operation(8, curve)), stored=True)
    for code, body in (
        (8, curve[:-8]),
        (9, area() + b"1234"),
        (10, area() + struct.pack(">I", 3) + bytes(12)),
        (3, b""),
    ):
        with pytest.raises(InputError, match=r"OpcodeList2 has a .* that is cut short or damaged"):
            read_picture(written(tmp_path / "a.dng", operation(code, body)))
    with pytest.raises(InputError, match="its OpcodeList2 is cut short"):
        read_picture(written(tmp_path / "a.dng", operation(8, curve)[:-1]))


def test_fractional_blacks_of_columns_leave_codes_where_noise_is_measured(tmp_path: Path) -> None:
    """Black levels by column in 32nds: light is told by all of it, and codes stay whole."""
    blacks = np.random.default_rng(8).integers(-96, 96, COLS) / 32.0
    parts = [part for value in blacks for part in (round(value * 32), 32)]
    packed = struct.pack(f"<{len(parts)}i", *parts)
    path = written(tmp_path / "a.dng", tags={50715: ("U", packed)})
    # Type 10, SRATIONAL: maker_files writes bytes, so that the entry is put right here.
    raw = bytearray(path.read_bytes())
    at = raw.index(struct.pack("<HHI", 50715, 7, len(packed)))
    raw[at : at + 8] = struct.pack("<HHI", 50715, 10, COLS)
    path.write_bytes(bytes(raw))
    picture = read_picture(path)
    found = np.zeros(CODES.shape)
    for plane in picture.planes:
        found[plane.first[0] :: plane.step[0], plane.first[1] :: plane.step[1]] = plane.samples - plane.black
    assert found == pytest.approx(CODES - BLACK - blacks[None, :])
    whole = read_picture(path, stored=True)
    assert all(plane.samples.dtype.kind == "i" for plane in whole.planes)
    for plane in whole.planes:
        one = CODES - np.rint(blacks)[None, :]
        assert np.array_equal(plane.samples, one[plane.first[0] :: plane.step[0], plane.first[1] :: plane.step[1]])
