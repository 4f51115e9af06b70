"""Camera makers' raw files: what LibRaw says of them, code by code, and what our own reader says of the same DNG."""

import json
import sys
from pathlib import Path

import imagecodecs
import numpy as np
import pytest
import rawpy
from edges import gaussian_edge, gaussian_limit
from maker_files import X_TRANS, Tags, fuji_raw, mosaic_tags, tiff_raw

from camsim.errors import InputError
from camsim.measure import Picture, Roi, measure_mtf, read_picture

CODES = np.random.default_rng(1).integers(600, 4000, (160, 240)).astype(np.uint16)
LEAST_BYTES = 76_000

MAKERS = {
    "nef": ("NIKON CORPORATION", "NIKON D3", "<"),
    "nrw": ("NIKON CORPORATION", "NIKON D3", ">"),
    "arw": ("SONY", "ILCE-7M3", "<"),
    "pef": ("PENTAX", "PENTAX K-5", ">"),
    "srw": ("SAMSUNG", "NX300", "<"),
    "rwl": ("LEICA", "D-LUX 5", "<"),
    "3fr": ("Hasselblad", "Hasselblad H3D", "<"),
    "mos": ("Leaf", "Leaf Aptus 22", "<"),
    "mef": ("Mamiya", "ZD", "<"),
    "iiq": ("Phase One", "P65+", "<"),
    "dcr": ("Kodak", "DCS Pro 14N", ">"),
    "erf": ("EPSON", "R-D1", ">"),
    "raf": ("FUJIFILM", "X-T1", ""),
    "rw2": ("Panasonic", "DMC-LX3", "<"),
}


def written(path: Path) -> None:
    make, model, order = MAKERS[path.suffix[1:]]
    if path.suffix == ".raf":
        fuji_raw(path, CODES)
    elif path.suffix == ".rw2":
        # Panasonic's own tags: sizes and borders; codes stand in the upper bits.
        tags: Tags = {
            1: ("U", b"0300"), 2: ("H", 240), 3: ("H", 160), 4: ("H", 0), 5: ("H", 0), 6: ("H", 160), 7: ("H", 240),
            8: ("H", 1), 9: ("H", 1), 10: ("H", 12), 11: ("H", 1), 23: ("H", 400), 28: ("H", 128), 29: ("H", 128),
            30: ("H", 128),
        }  # fmt: skip
        data = (CODES << 4).astype("<u2").tobytes()
        tiff_raw(path, data, tags, make=make, model=model, magic=b"IIU\0", below=False)
    elif path.suffix == ".erf":
        data = imagecodecs.packints_encode(CODES, 12)
        tiff_raw(path, data, mosaic_tags(CODES, 12), make=make, model=model, magic=b"MM\0*")
    else:
        magic = b"II*\0" if order == "<" else b"MM\0*"
        data = CODES.astype(order + "u2").tobytes()
        tiff_raw(path, data, mosaic_tags(CODES, 16), make=make, model=model, magic=magic)


def mosaic(picture: Picture) -> np.ndarray:
    codes = np.zeros(picture.shape, np.int64)
    for plane in picture.planes:
        codes[plane.first[0] :: plane.step[0], plane.first[1] :: plane.step[1]] = plane.samples
    return codes


@pytest.mark.parametrize("suffix", MAKERS)
def test_a_makers_file_is_read_as_libraw_reads_it(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"a.{suffix}"
    written(path)
    picture = read_picture(path)
    with rawpy.imread(str(path)) as raw:
        left, top = raw.sizes.left_margin, raw.sizes.top_margin
        visible = CODES[top : top + raw.sizes.height, left : left + raw.sizes.width]
        assert np.array_equal(mosaic(picture), visible)
        colors, black = raw.raw_colors_visible, raw.black_level_per_channel
        for plane in picture.planes:
            here = colors[plane.first[0] :: plane.step[0], plane.first[1] :: plane.step[1]]
            assert {chr(raw.color_desc[color]) for color in np.unique(here)} == {plane.name[0]}
            assert {black[color] for color in np.unique(here)} == {plane.black}
            assert plane.white == raw.white_level
    noted = picture.noted
    assert noted is not None
    make, model, _ = MAKERS[suffix]
    assert noted.camera == (model if model.startswith(make) else f"{make} {model}")
    assert (noted.iso, noted.time_s, noted.f_number, noted.focal_length_mm) == (400.0, 0.008, 5.6, 50.0)
    if suffix == "raf":
        assert {plane.step for plane in picture.planes} == {(6, 6)}
        assert "".join(sorted(plane.name for plane in picture.planes)) == "".join(sorted("".join(X_TRANS)))


def test_info_says_what_the_camera_noted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from camsim.cli.info import json_of_file, text_of_file

    fuji_raw(tmp_path / "a.raf", CODES)
    tree = json.loads(json_of_file(str(tmp_path / "a.raf")))
    assert (tree["camera"], tree["iso"], tree["filters"]) == ("FUJIFILM X-T1", 400.0, list(X_TRANS))
    assert "as LibRaw unpacks them" in text_of_file(str(tmp_path / "a.raf"))


def test_edges_of_a_makers_file_are_measured(tmp_path: Path) -> None:
    codes = np.rint(200.0 + 12_000.0 * gaussian_edge(160, 160, 5, 0.8)).astype(np.uint16)
    tiff_raw(tmp_path / "a.arw", codes.astype("<u2").tobytes(), mosaic_tags(codes, 16), make="SONY", model="ILCE-7M3")
    for edge in measure_mtf(read_picture(tmp_path / "a.arw"), rois=[Roi(10, 40, 140, 76)]).edges:
        assert edge.figures.mtf50_cycles_per_pixel == pytest.approx(gaussian_limit(0.5, 0.8), rel=1e-3)


@pytest.mark.parametrize("suffix", ["nef", "raf"])
def test_what_is_no_raw_file_is_one_sentence(suffix: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    whole, part = tmp_path / f"a.{suffix}", tmp_path / f"b.{suffix}"
    written(whole)
    data = whole.read_bytes()
    for some in (b"", b"no raw file " * 99, data[:90], data[:3000], data[: len(data) // 2], data[: LEAST_BYTES // 2]):
        part.write_bytes(some)
        with pytest.raises(InputError, match=r"LibRaw does not read it \(.*\): it is damaged, cut short") as caught:
            read_picture(part)
        assert "\n" not in str(caught.value)
    assert capfd.readouterr().err == ""  # LibRaw prints what it finds


def test_a_size_that_no_file_has_takes_no_memory(tmp_path: Path) -> None:
    huge = np.lib.stride_tricks.as_strided(CODES, (60_000, 60_000), (0, 0))
    data = CODES.astype("<u2").tobytes()
    tiff_raw(tmp_path / "a.nef", data, mosaic_tags(huge, 16), make="NIKON CORPORATION", model="NIKON D3")
    with pytest.raises(InputError, match=r"its image takes 7200 MB unpacked, from \d+ bytes"):
        read_picture(tmp_path / "a.nef")


DNG: Tags = {254: ("I", 1), 50706: ("B", bytes((1, 4, 0, 0)))}
"""Of the first directory, which is a smaller picture's."""


@pytest.mark.parametrize("storing", ["plain", "12 bits", "lossless JPEG"])
def test_both_readers_of_a_dng_agree(storing: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bits = 12 if storing == "12 bits" else 16
    compression = 7 if storing == "lossless JPEG" else 1
    data = {
        "plain": CODES.astype("<u2").tobytes(),
        "12 bits": imagecodecs.packints_encode(CODES, 12),
        "lossless JPEG": imagecodecs.ljpeg_encode(CODES, bitspersample=16),
    }[storing]
    black = (100.0, 200.0, 300.0, 400.0)
    tags = {**mosaic_tags(CODES, bits, compression), 50713: ("H", (2, 2)), 50714: ("R", black), 50717: ("I", 4000)}
    path = tmp_path / "a.dng"
    tiff_raw(path, data, tags, make="Acme", model="One", first=DNG)
    one = read_picture(path)
    assert np.array_equal(mosaic(one), CODES)
    assert [plane.black for plane in one.planes] == list(black)
    with rawpy.imread(str(path)) as raw:
        assert np.array_equal(raw.raw_image, CODES)
        assert raw.white_level == 4000
        assert raw.black_level_per_channel == [100, 200, 400, 300]  # the second green is LibRaw's last
    if storing == "lossless JPEG":
        monkeypatch.setitem(sys.modules, "imagecodecs", None)
        assert np.array_equal(mosaic(read_picture(path)), CODES)


def test_rows_and_columns_in_fields_are_put_in_turn(tmp_path: Path) -> None:
    fields = np.concatenate([CODES[0::2], CODES[1::2]])
    fields = np.concatenate([fields[:, 0::3], fields[:, 1::3], fields[:, 2::3]], axis=1)
    tags = {**mosaic_tags(CODES, 16), 50975: ("I", 2), 52547: ("I", 3)}
    tiff_raw(tmp_path / "a.dng", fields.astype("<u2").tobytes(), tags, make="Acme", model="One", first=DNG)
    assert np.array_equal(mosaic(read_picture(tmp_path / "a.dng")), CODES)


@pytest.mark.parametrize(
    ("number", "code", "flags", "refused"),
    [(51009, 1, 0, "WarpRectilinear"), (51009, 6, 0, "TrimBounds"), (51008, 7, 0, "MapTable"), (51008, 9, 1, ""),
     (51009, 1, 1, ""), (51022, 1, 0, ""), (51009, 99, 0, "operation 99")],
)  # fmt: skip
def test_operations_that_are_not_applied_are_named(
    number: int, code: int, flags: int, refused: str, tmp_path: Path
) -> None:
    listed = b"".join(value.to_bytes(4) for value in (1, code, 0x01030000, flags, 8)) + bytes(8)
    tags = {**mosaic_tags(CODES, 16), number: ("U", listed)}
    data = CODES.astype("<u2").tobytes()
    tiff_raw(tmp_path / "a.dng", data, tags, make="Acme", model="One", first=DNG)
    if not refused:
        assert np.array_equal(mosaic(read_picture(tmp_path / "a.dng")), CODES)
        return
    with pytest.raises(InputError, match=rf"OpcodeList[12] asks for {refused}, which changes what its samples mean"):
        read_picture(tmp_path / "a.dng")


def test_two_samples_of_each_photosite_are_refused(tmp_path: Path) -> None:
    tags = {**mosaic_tags(CODES, 16), 256: ("I", 120), 258: ("H", (16, 16)), 277: ("H", 2)}
    data = CODES.astype("<u2").tobytes()
    tiff_raw(tmp_path / "a.dng", data, tags, make="Acme", model="One", first=DNG)
    with pytest.raises(InputError, match="2 samples of each photosite of its mosaic"):
        read_picture(tmp_path / "a.dng")
