"""Files read back by ourselves: what they say, and what is said of those that are not whole or not ours."""

import contextlib
import json
import re
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
import rawpy
import tifffile
from PIL import Image

import camsim
from camsim.camera.camera import Camera
from camsim.camera.description import describe
from camsim.camera.frame import Frame
from camsim.config.from_record import stages_from_record
from camsim.errors import CamsimError, InputError
from camsim.files import save
from camsim.files.describe import canonical, checksum
from camsim.files.reading import read_file
from camsim.files.record import parse_record
from camsim.measure import read_picture
from tests.files.conftest import MakeFrame
from tests.tables import rows

KINDS = [
    ("a.dng", "mosaic", "DNG"),
    ("a.exr", "truth", "OpenEXR"),
    ("a.exr", "electrons", "OpenEXR"),
    ("a.exr", "spectral", "OpenEXR"),
    ("a.tiff", "mosaic", "TIFF"),
    ("a.tif", "mosaic", "TIFF"),
    ("a.png", "preview", "PNG"),
    ("a.png", "mosaic", "PNG"),
    ("a.dng", "truth", "DNG"),
    ("a.tiff", "truth", "TIFF"),
    ("a.npz", "frame", "NPZ"),
]


@pytest.mark.parametrize(("name", "product", "form"), KINDS)
def test_a_file_says_what_it_is(tmp_path: Path, frame: Frame, name: str, product: str, form: str) -> None:
    save(frame, tmp_path / name, product=product)
    held = read_file(tmp_path / name)
    assert (held.form, held.product, held.rows, held.cols) == (form, product, 48, 66)
    assert held.size_bytes == (tmp_path / name).stat().st_size
    assert held.description == frame.description
    assert held.fits
    assert held.record.seed == frame.seed
    assert held.has_truth == (product in ("truth", "frame"))
    assert held.record.error_estimate == (4.5e-7 if product == "truth" else 3.2e-7)


def test_white_moves_with_black_as_far_as_the_converter_goes(tmp_path: Path) -> None:
    """Of 12 bits: the record's white of 628 has 10, and 1128 was read as 1023. By hand: 128 + 20 000 / 40 + 500."""
    sets = ["sensor.charge.full_well_e=20000", "exposure.iso=50", "sensor.readout.black_offsets_dn=[[0, 500]]"]
    frame = camsim.capture("flat-field", overrides=[*sets, "region={rows: 2, cols: 2}", "render.tolerance=1e-2"])
    for name in ("a.tiff", "a.npz"):
        save(frame, tmp_path / name)
        record = read_file(tmp_path / name).record
        assert record.white_levels_dn.tolist() == frame.white_levels_dn.tolist() == [[628, 1128]]


def test_a_dng_that_another_program_gave_a_preview_has_the_size_of_its_raw_image(tmp_path: Path, frame: Frame) -> None:
    save(frame, tmp_path / "a.dng")
    with tifffile.TiffFile(tmp_path / "a.dng") as tiff:
        tags, codes = tiff.pages[0].tags, tiff.asarray()
        said = [(number, "B", tags[number].count, bytes(tags[number].value), True) for number in (700, 50706)]
    with tifffile.TiffWriter(tmp_path / "b.dng") as tiff:
        small = np.zeros((16, 22, 3), np.uint8)
        tiff.write(small, subfiletype=1, subifds=1, photometric="rgb", extratags=said, metadata=None)
        tiff.write(codes, subfiletype=0, photometric=32803, metadata=None)
    held = read_file(tmp_path / "b.dng")
    assert (held.rows, held.cols, held.fits) == (48, 66, True)


def test_every_byte_cut_off_is_noticed(tmp_path: Path, frame: Frame) -> None:
    for name, product, _ in KINDS:
        save(frame, tmp_path / name, product=product, force=True)
        whole = (tmp_path / name).read_bytes()
        for keep in (*range(40), *range(40, len(whole), 997), len(whole) - 1):
            (tmp_path / f"cut{name}").write_bytes(whole[:keep])
            with pytest.raises(InputError, match=r"^cannot read '.*': [^\n]+$"):
                read_file(tmp_path / f"cut{name}")


@pytest.mark.parametrize(("content", "message"), rows("wrong-contents.txt", "images"))
def test_what_is_no_image_of_ours(tmp_path: Path, content: str, message: str) -> None:
    path = tmp_path / "a.dng"
    path.write_bytes(eval(content))
    with pytest.raises(InputError) as caught:
        read_file(path)
    assert str(caught.value) == f"cannot read '{path}': {message}"


def test_images_of_other_programs(tmp_path: Path) -> None:
    import OpenEXR

    tifffile.imwrite(tmp_path / "a.tiff", np.zeros((4, 4), np.uint16), description="mine")
    Image.new("L", (4, 4)).save(tmp_path / "a.png")
    pixels = {"Y": np.zeros((4, 4), np.float32)}
    header = {"compression": OpenEXR.PIZ_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, pixels).write(str(tmp_path / "a.exr"))
    for name in ("a.tiff", "a.png", "a.exr"):
        with pytest.raises(InputError, match="it was not written by camsim: it"):
            read_file(tmp_path / name)


def test_names_that_are_no_files(tmp_path: Path) -> None:
    for name, message in (
        ("gone.dng", "there is no such file"),
        (".", "it is not a file"),
        ("a" * 300, "File name too long"),
    ):
        with pytest.raises(InputError, match=message):
            read_file(f"{tmp_path}/{name}")


def test_a_changed_record_is_not_believed(tmp_path: Path, frame: Frame) -> None:
    for name, product, _ in KINDS:
        if name.endswith(("png", "npz")):  # these formats have checksums of their own
            continue
        save(frame, tmp_path / name, product=product, force=True)
        whole = (tmp_path / name).read_bytes()
        assert b"4023" in whole
        (tmp_path / name).write_bytes(whole.replace(b"4023", b"4032"))
        for read in (read_file, read_picture) if name == "a.tiff" else (read_file,):
            with pytest.raises(InputError, match="its record is damaged: it does not fit its checksum"):
                read(tmp_path / name)


def record_with(frame: Frame, tmp_path: Path, **changes: object) -> str:
    save(frame, tmp_path / "a.tiff", force=True)
    said = {"camsim": "frame/1", **read_file(tmp_path / "a.tiff").record.as_dict(), **changes}
    return canonical({**said, "sha256": checksum(canonical(said))})


def test_another_version_of_the_format_is_named(tmp_path: Path, frame: Frame) -> None:
    text = record_with(frame, tmp_path, camsim="frame/7", software="camsim 3.1")
    with pytest.raises(InputError) as caught:
        parse_record(text)
    assert str(caught.value) == (
        "its record has the format 'frame/7' and this version of camsim reads 'frame/1'; "
        "use the version that wrote it (camsim 3.1)"
    )


@pytest.mark.parametrize(
    "text", ["{", "[" * 100_000, '{"camsim":NaN}', "9" * 5000, '{"a":1}', "[]", "null", '{"camsim":[]}', "{}"]
)
def test_records_that_are_none(text: str) -> None:
    with pytest.raises(InputError):
        parse_record(text)


def test_xmp_with_entities_is_refused(tmp_path: Path, frame: Frame) -> None:
    save(frame, tmp_path / "a.dng")
    whole = (tmp_path / "a.dng").read_bytes()
    at = whole.index(b"<?xpacket begin")
    bomb = b'<!DOCTYPE a [<!ENTITY b "bbbbbbbb"><!ENTITY c "&b;&b;&b;&b;">]><a>&c;</a>'
    (tmp_path / "a.dng").write_bytes(whole[:at] + bomb + whole[at + len(bomb) :])
    with pytest.raises(InputError, match="its XMP declares a document type"):
        read_file(tmp_path / "a.dng")


def test_damaged_xmp_is_a_fault_only_where_a_record_was_begun(tmp_path: Path, frame: Frame) -> None:
    """Pictures of other cameras are measured whatever their XMP says; of ours no record is lost without a word."""
    save(frame, tmp_path / "a.dng")
    whole = (tmp_path / "a.dng").read_bytes()
    first, last = (mark.start() for mark in re.finditer(rb"<\?xpacket", whole))
    for xmp, read, message in (
        (b'<x xmlns:tiff="http://ns.adobe.com/tiff/1.0/"><tiff:Make>Other', True, "it was not written by camsim"),
        (whole[first : whole.index(b"Record")], False, "its XMP is damaged"),
        (whole[first : whole.index(b"Record") + 99], False, "its XMP is damaged"),
    ):
        (tmp_path / "b.dng").write_bytes(whole[:first] + xmp.ljust(last - first) + whole[last:])
        with pytest.raises(InputError, match=message):
            read_file(tmp_path / "b.dng")
        with contextlib.nullcontext() if read else pytest.raises(InputError, match=message):
            read_picture(tmp_path / "b.dng")


def test_a_bomb_of_zeros_in_a_png_stays_small(tmp_path: Path, frame: Frame) -> None:
    save(frame, tmp_path / "a.png")
    whole = (tmp_path / "a.png").read_bytes()
    body = b"zTXtcamsim\0\0" + zlib.compress(bytes(1 << 28), 9)
    chunk = struct.pack(">I", len(body) - 4) + body + struct.pack(">I", zlib.crc32(body))
    (tmp_path / "a.png").write_bytes(whole[:33] + chunk + whole[33:])
    # The second text, ours, is the one that counts.
    assert read_file(tmp_path / "a.png").product == "preview"
    (tmp_path / "a.png").write_bytes(whole[:33] + chunk + whole[-12:])
    with pytest.raises(InputError, match="record"):
        read_file(tmp_path / "a.png")


def test_forged_descriptions_give_a_sentence() -> None:
    """Trees whose checksum would fit: each value in turn exchanged for one that cannot be, or could be."""
    camera = Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0))
    scene = camsim.Scene(background=0.5, shapes=[camsim.Disc(radius_um=3.0, reflectance=0.1)])
    text = json.dumps(describe({"camera": camera, "scene": scene}))
    places: list[tuple[object, ...]] = []

    def walk(tree: object, path: tuple[object, ...]) -> None:
        if len(path) < 5:
            places.append(path)
            for key, value in tree.items() if isinstance(tree, dict) else ():
                walk(value, (*path, key))

    walk(json.loads(text), ())
    refused = 0
    for path in places[1:]:
        for value in (None, -1, 1e300, "x", [], [[]], {}, {"kind": "Path"}, {"kind": ["Airy"]}, {"kind": "Airy"}):
            tree = json.loads(text)
            at = tree
            for key in path[:-1]:
                at = at[key]
            at[path[-1]] = value
            try:
                stages_from_record(tree)
            except CamsimError as error:
                refused += "\n" not in str(error)
    assert refused > len(places)


def test_every_shipped_camera_comes_back_whole() -> None:
    from camsim.config import library

    for name in library.shipped("sensor"):
        camera = Camera.from_yaml(name, lens=camsim.Airy(f_number=5.6))
        assert describe(stages_from_record(json.loads(json.dumps(describe(camera))))) == describe(camera)


def test_rawpy_still_reads_a_dng_with_its_record(tmp_path: Path, make_frame: MakeFrame) -> None:
    frame = make_frame(description={"long": ["x" * 1000] * 1000})
    save(frame, tmp_path / "a.dng")
    assert read_file(tmp_path / "a.dng").description == frame.description
    with rawpy.imread(str(tmp_path / "a.dng")) as raw:
        np.testing.assert_array_equal(raw.raw_image, frame.mosaic)


@pytest.mark.parametrize(
    ("said", "becomes"), [(b"&quot;frame/1&quot;", b"&quot;frame/9&quot;"), (b"frame/1", b"frame/9")]
)
def test_a_dng_from_another_version_of_the_format(tmp_path: Path, frame: Frame, said: bytes, becomes: bytes) -> None:
    save(frame, tmp_path / "a.dng")
    (tmp_path / "b.dng").write_bytes((tmp_path / "a.dng").read_bytes().replace(said, becomes))
    with pytest.raises(InputError, match=r"format.*reads.*; use the version that wrote it"):
        read_file(tmp_path / "b.dng")
