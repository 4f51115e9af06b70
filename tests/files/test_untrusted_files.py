"""Files from strangers through every command: one sentence and exit 2, little memory, and nothing of theirs is run."""

import io
import json
import struct
import sys
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import camsim
from camsim.camera.camera import Camera
from camsim.camera.description import describe
from camsim.config.from_record import capture_from_record
from camsim.errors import CamsimError, InputError
from camsim.files import exr_reader, jpeg_reader, save, tiff_reader
from camsim.files.limits import MOST_RATIO, MOST_UNPACKED_BYTES, refuse_bomb
from camsim.files.reading import read_file
from camsim.measure import read_picture
from tests.tables import rows

BENCH = Path(__file__).parents[2] / "bench"
SLOW_MACHINE_S = float("inf")


@pytest.fixture(scope="module")
def fuzz() -> Iterator[ModuleType]:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(BENCH))
        import fuzz_readers

        yield fuzz_readers
    for name in ("fuzz_readers", "mutations", "crafted_files"):
        sys.modules.pop(name, None)


@pytest.fixture(scope="module")
def whole(fuzz: ModuleType, tmp_path_factory: pytest.TempPathFactory) -> Any:
    return fuzz.samples(tmp_path_factory.mktemp("whole"))


def test_mutated_files_give_a_sentence(tmp_path: Path, fuzz: ModuleType, whole: Any) -> None:
    """The same as bench/fuzz_readers.py, which does twenty thousand."""
    tally = fuzz.fuzz(60, 5, whole, tmp_path, slowest_s=SLOW_MACHINE_S)
    assert not tally.wrong
    assert tally.ends.total() == 5 * 60
    for what in ("info", "info --full", "info --json", "measure", "recapture"):
        assert tally.ends[f"{what}: refused"] > 15, what
        assert tally.ends[f"{what}: done"] > 2, what


def test_crafted_files_are_refused(tmp_path: Path, fuzz: ModuleType, whole: Any) -> None:
    wrong, commands = fuzz.crafted_are_refused(whole, tmp_path, slowest_s=SLOW_MACHINE_S)
    assert not wrong
    assert commands > 200
    assert not (tmp_path / "proof").exists()


def mosaic_with(tmp_path: Path, fuzz: ModuleType, make_frame: Any, **changes: Any) -> Path:
    """Write a TIFF whose record is changed, its checksum mended."""
    import mutations

    save(make_frame(), tmp_path / "a.tiff")
    record = {"camsim": "frame/1", **read_file(tmp_path / "a.tiff").record.as_dict(), **changes}
    content = mutations.with_record((tmp_path / "a.tiff").read_bytes(), ".tiff", mutations.signed(record))
    (tmp_path / "b.tiff").write_bytes(content)
    return tmp_path / "b.tiff"


@pytest.mark.parametrize(("changes", "message"), rows("wrong-contents.txt", "records"))
def test_a_record_is_judged_before_it_is_used(
    tmp_path: Path, fuzz: ModuleType, make_frame: Any, changes: str, message: str
) -> None:
    path = mosaic_with(tmp_path, fuzz, make_frame, **eval(changes))
    for read in (read_file, read_picture):
        with pytest.raises(InputError, match=rf"^cannot read '{path}': [^\n]*{message}"):
            read(path)


@pytest.mark.parametrize(("change", "message"), rows("wrong-contents.txt", "cameras in records"))
def test_a_parameter_of_another_type_is_refused(change: str, message: str) -> None:
    tree = json.loads(json.dumps(describe(Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0)))))
    with pytest.raises(InputError, match=message):
        capture_from_record({"camera": {**tree, **eval(change)}})


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e300])
def test_pictures_of_no_numbers_are_refused(tmp_path: Path, bad: float) -> None:
    image = np.full((100, 120), 0.5)
    image[50, 60] = bad
    np.save(tmp_path / "a.npy", image)
    with pytest.raises(CamsimError, match="holds values that are no numbers"):
        camsim_measure(tmp_path / "a.npy")


def camsim_measure(path: Path) -> Any:
    from camsim.measure import measure_mtf

    return measure_mtf(read_picture(path))


@pytest.mark.parametrize("shape", [(1, 200_000), (200_000, 1), (40, 60_000), (5, 5), (31, 31)])
def test_pictures_of_any_shape_take_little_work(tmp_path: Path, shape: tuple[int, int]) -> None:
    np.save(tmp_path / "a.npy", np.random.default_rng(1).integers(0, 4000, shape).astype(np.uint16))
    with pytest.raises(CamsimError, match=r"no measurable slanted edge|repeat every"):
        camsim_measure(tmp_path / "a.npy")


def png_that_says(rows: int, cols: int) -> bytes:
    """Return a PNG of one byte a pixel with none in it."""
    chunks = ((b"IHDR", struct.pack(">2I5B", cols, rows, 8, 0, 0, 0, 0)), (b"IDAT", zlib.compress(b"")), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I4s", len(body), kind) + body + struct.pack(">I", zlib.crc32(kind + body))
        for kind, body in chunks
    )


def tiff_that_says(rows: int, cols: int) -> bytes:
    """Return a TIFF of one byte a pixel, packed by zlib, with none in it."""
    said = {256: cols, 257: rows, 258: 8, 259: 8, 262: 1, 273: 8, 277: 1, 278: rows, 279: 8}
    entries = b"".join(struct.pack("<2H2I", number, 4, 1, value) for number, value in said.items())
    return b"II*\0" + struct.pack("<I", 16) + bytes(8) + struct.pack("<H", len(said)) + entries + bytes(4)


@pytest.mark.parametrize(("name", "content"), [("a.png", png_that_says), ("a.tiff", tiff_that_says)])
@pytest.mark.parametrize(("rows", "cols"), [(1 << 11, 1 << 17), (1 << 17, 1 << 11)])
def test_as_much_as_is_said_to_be_believed_is(tmp_path: Path, name: str, content: Any, rows: int, cols: int) -> None:
    assert rows * cols == MOST_UNPACKED_BYTES
    for more, message in ((0, "damaged|cut short|holds"), (1, f"more than {MOST_UNPACKED_BYTES >> 20} MiB")):
        (tmp_path / name).write_bytes(content(rows + more, cols))
        with pytest.raises(InputError, match=message):
            read_picture(tmp_path / name)


def test_a_large_file_is_believed_sixteenfold() -> None:
    refuse_bomb(MOST_RATIO << 30, 1 << 30)
    with pytest.raises(InputError, match="and 16 times the file are refused"):
        refuse_bomb((MOST_RATIO << 30) + 1, 1 << 30)


def test_tiles_of_an_exr_count_whole() -> None:
    """Ten rows of a thousand columns in tiles of 32 rows and 64 columns: two channels of half, one of float."""
    kinds = ((b"B", 1), (b"G", 1), (b"R", 2))
    channels = b"".join(name + b"\0" + struct.pack("<4i", kind, 0, 1, 1) for name, kind in kinds) + b"\0"
    window = ("box2i", struct.pack("<4i", 0, 0, 999, 9))
    stated = {"dataWindow": window, "channels": ("chlist", channels)}
    assert exr_reader._image_bytes(exr_reader.Header(stated, 0), 9999) == 10 * 1000 * (2 + 2 + 4)
    for across, down, pixels in ((64, 32, 32 * 1000), (2000, 5, 10 * 2000)):
        tiled = {**stated, "tiles": ("tiledesc", struct.pack("<2IB", across, down, 0))}
        assert exr_reader._image_bytes(exr_reader.Header(tiled, 0), 9999) == pixels * (2 + 2 + 4)


def test_every_byte_cut_off_the_beginnings_of_a_jpeg_and_a_tiff_is_noticed() -> None:
    jpeg = b"\xff\xd8\xff\xe0\0\4ab\xff\xc0\0\x0b\x08" + struct.pack(">2H", 40, 30) + b"\1\1\x11\0"
    header = jpeg_reader.frame_header(jpeg)
    assert (header.bits, header.rows, header.cols, header.components) == (8, 40, 30, 1)
    for keep in range(18):
        with pytest.raises(InputError, match="no frame begins in it"):
            jpeg_reader.frame_header(jpeg[:keep])
    entries = struct.pack("<2H2I2H2I", 256, 4, 1, 9, 257, 4, 1, 7)
    tiff = b"II*\0" + struct.pack("<IH", 8, 2) + entries
    assert tiff_reader.read_directory(io.BytesIO(tiff), len(tiff)).number(257) == 7
    for keep in range(8, len(tiff)):
        with pytest.raises(InputError, match="its directory is not within"):
            tiff_reader.read_directory(io.BytesIO(tiff[:keep]), keep)


@pytest.mark.parametrize(("length", "message"), [(None, ""), (1 << 30, "its directory has 1073741824 bytes")])
def test_an_archive_that_ends_as_those_beyond_4_gib_do(
    tmp_path: Path, make_frame: Any, length: int | None, message: str
) -> None:
    """Where its directory lies and how long it is stand in a record of their own then."""
    save(make_frame(), tmp_path / "a.npz")
    whole = (tmp_path / "a.npz").read_bytes()
    with zipfile.ZipFile(io.BytesIO(whole)) as archive:
        count, start = len(archive.namelist()), archive.start_dir
    one = len(whole) - 22 - start
    large = struct.pack("<4sQ2H2I4Q", b"PK\6\6", 44, 45, 45, 0, 0, count, count, length or one, start)
    where = struct.pack("<4sIQI", b"PK\6\7", 0, start + one, 1)
    end = struct.pack("<4s4H2IH", b"PK\5\6", 0, 0, 0xFFFF, 0xFFFF, 0xFFFFFFFF, 0xFFFFFFFF, 0)
    (tmp_path / "a.npz").write_bytes(whole[:-22] + large + where + end)
    if length is None:
        assert read_file(tmp_path / "a.npz").product == "frame"
    else:
        with pytest.raises(InputError, match=message):
            read_file(tmp_path / "a.npz")
