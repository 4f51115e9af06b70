"""EXR, TIFF, PNG and NPY read back by other people's libraries; every format byte for byte the same twice."""

import dataclasses
import json
import time
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
import tifffile
from PIL import Image

from camsim.camera.frame import Frame
from camsim.files import SUFFIXES, save
from camsim.files.planes import write_planes
from camsim.files.preview import develop
from tests.files.conftest import MakeFrame

EVERYTHING = [(suffix, product) for suffix, form in SUFFIXES.items() for product in form.writers]


def exr_planes(path: Path) -> dict[str, np.ndarray]:
    file = OpenEXR.File(str(path), separate_channels=True)
    return {name: channel.pixels for name, channel in file.channels().items()}


def test_a_tiff_of_four_channels_is_one_page_of_four_samples(tmp_path: Path, frame: Frame) -> None:
    truth = np.random.default_rng(1).random((48, 66, 4), dtype=np.float32)
    save(dataclasses.replace(frame, channels=("R", "G", "B", "W"), truth=truth), tmp_path / "a.tiff", product="truth")
    with tifffile.TiffFile(tmp_path / "a.tiff") as file:
        (page,) = file.pages
        assert (page.shape, page.planarconfig) == ((48, 66, 4), 1)
        np.testing.assert_array_equal(page.asarray(), truth)


def test_exr_truth_is_exact(tmp_path: Path, frame: Frame) -> None:
    save(frame, tmp_path / "a.exr")
    planes = exr_planes(tmp_path / "a.exr")
    assert set(planes) == {"R", "G", "B"}
    assert frame.truth is not None
    for index, name in enumerate("RGB"):
        assert planes[name].dtype == np.float32
        np.testing.assert_array_equal(planes[name], frame.truth[:, :, index])


def test_exr_truth_of_mono_is_luminance(tmp_path: Path, mono_frame: Frame) -> None:
    save(mono_frame, tmp_path / "a.exr")
    assert mono_frame.truth is not None
    planes = exr_planes(tmp_path / "a.exr")
    assert set(planes) == {"Y"}
    np.testing.assert_array_equal(planes["Y"], mono_frame.truth[:, :, 0])


def test_exr_electrons_are_before_and_after_noise(tmp_path: Path, frame: Frame) -> None:
    save(frame, tmp_path / "a.exr", product="electrons")
    planes = exr_planes(tmp_path / "a.exr")
    np.testing.assert_array_equal(planes["mean.Y"], frame.mean_electrons.astype(np.float32))
    np.testing.assert_array_equal(planes["noisy.Y"], frame.electrons.astype(np.float32))


def test_exr_attributes_say_what_it_is(tmp_path: Path, frame: Frame) -> None:
    save(frame, tmp_path / "a.exr")
    file = OpenEXR.File(str(tmp_path / "a.exr"))  # 3.3 takes the header with it when it goes; alone, it finds none
    header = file.header()
    assert header["compression"] == OpenEXR.ZIP_COMPRESSION
    assert header["camsim:seed"] == str(2**40 + 1)
    assert header["camsim:errorEstimate"] == "4.5e-07"
    assert header["camsim:units"] == "electrons"
    assert header["expTime"] == pytest.approx(0.01)
    record = json.loads(header["camsim:record"])
    assert record["description"] == frame.description
    assert record["product"] == "truth"
    assert record["error_estimate"] == 4.5e-7


@pytest.mark.parametrize(("suffix", "year"), [(".tiff", "2021"), (".tif", "0099"), (".TIF", "2021")])
def test_tiff_holds_the_codes(tmp_path: Path, frame: Frame, suffix: str, year: str) -> None:
    path = tmp_path / f"a{suffix}"
    save(dataclasses.replace(frame, datetime=f"{year}-03-04 05:06:07"), path)
    with tifffile.TiffFile(path) as file:
        (page,) = file.pages
        np.testing.assert_array_equal(page.asarray(), frame.mosaic)
        assert page.dtype == np.uint16
        assert page.photometric == tifffile.PHOTOMETRIC.MINISBLACK
        assert page.tags["DateTime"].value == f"{year}:03:04 05:06:07"
        assert json.loads(page.description)["description"] == frame.description


@pytest.mark.parametrize("pattern", ["GB RG", "Y"])
def test_png_holds_the_codes_when_asked(tmp_path: Path, make_frame: MakeFrame, pattern: str) -> None:
    frame = make_frame(pattern=pattern)
    save(frame, tmp_path / "a.png", product="mosaic")
    with Image.open(tmp_path / "a.png") as image:
        assert image.mode == "I;16"
        np.testing.assert_array_equal(np.asarray(image), frame.mosaic)
        assert json.loads(image.text["camsim"])["description"] == frame.description


@pytest.mark.parametrize("pattern", ["GB RG", "Y"])
def test_png_holds_the_preview(tmp_path: Path, make_frame: MakeFrame, pattern: str) -> None:
    frame = make_frame(pattern=pattern)
    save(frame, tmp_path / "a.png")
    with Image.open(tmp_path / "a.png") as image:
        np.testing.assert_array_equal(np.asarray(image), develop(frame))


def test_npy_holds_each_product(tmp_path: Path, frame: Frame) -> None:
    for product, expected in (
        ("mosaic", frame.mosaic),
        ("electrons", frame.electrons),
        ("truth", frame.truth),
    ):
        save(frame, tmp_path / "a.npy", product=product, force=True)
        read = np.load(tmp_path / "a.npy", allow_pickle=False)
        assert read.dtype == expected.dtype
        np.testing.assert_array_equal(read, expected)


@pytest.mark.parametrize("layout", ["fortran", "strided", "big-endian"])
def test_the_memory_layout_of_arrays_does_not_matter(tmp_path: Path, frame: Frame, layout: str) -> None:
    if layout == "fortran":
        odd = np.asfortranarray(frame.mosaic)
    elif layout == "strided":
        odd = np.repeat(frame.mosaic, 2, axis=1)[:, ::2]
    else:
        odd = frame.mosaic.astype(">u2")
    for suffix in (".dng", ".tiff"):
        save(frame, tmp_path / f"a{suffix}")
        save(dataclasses.replace(frame, mosaic=odd), tmp_path / f"b{suffix}")
        assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()


def test_equal_frames_give_equal_bytes_at_any_time(tmp_path: Path, make_frame: MakeFrame) -> None:
    first = {}
    for suffix, product in EVERYTHING:
        save(make_frame(), tmp_path / f"one{suffix}", product=product, force=True)
        first[suffix, product] = (tmp_path / f"one{suffix}").read_bytes()
    # Time stamps of formats count seconds.
    time.sleep(1.1)
    slow = dataclasses.replace(make_frame().report, seconds={"render": 123.456})  # how a frame came is not in its files
    for suffix, product in EVERYTHING:
        save(make_frame(report=slow), tmp_path / f"another{suffix}", product=product, force=True)
        assert (tmp_path / f"another{suffix}").read_bytes() == first[suffix, product], (suffix, product)
    for suffix, product in EVERYTHING:
        save(make_frame(seed=6), tmp_path / f"other{suffix}", product=product, force=True)
        assert (tmp_path / f"other{suffix}").read_bytes() != first[suffix, product], (suffix, product)


@pytest.mark.parametrize("pattern", ["RG GB", "Y"])
def test_tiff_holds_the_truth_in_electrons(tmp_path: Path, make_frame: MakeFrame, pattern: str) -> None:
    frame = make_frame(pattern=pattern)
    save(frame, tmp_path / "a.tiff", product="truth")
    read = tifffile.imread(tmp_path / "a.tiff")
    assert frame.truth is not None
    np.testing.assert_array_equal(read, frame.truth if frame.truth.shape[2] == 3 else frame.truth[:, :, 0])
    assert read.dtype == np.float32


def test_npz_holds_everything(tmp_path: Path, frame: Frame) -> None:
    save(frame, tmp_path / "a.npz", force=True)
    with np.load(tmp_path / "a.npz", allow_pickle=False) as arrays:
        for name in ("mosaic", "electrons", "mean_electrons", "channel_index", "truth"):
            np.testing.assert_array_equal(arrays[name], getattr(frame, name))
        assert json.loads(arrays["record.json"])["description"] == frame.description
    save(dataclasses.replace(frame, truth=None), tmp_path / "a.npz", force=True)
    with np.load(tmp_path / "a.npz", allow_pickle=False) as arrays:
        assert "truth" not in arrays


def test_planes_are_read_back_where_they_were(tmp_path: Path) -> None:
    image = np.arange(3 * 5 * 2, dtype=np.float32).reshape(3, 5, 2)
    write_planes(str(tmp_path / "a.exr"), image, ("Z", "A"), {"camsim:units": "one"})
    channels = OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True).channels()
    for k, name in enumerate("ZA"):
        np.testing.assert_array_equal(channels[name].pixels, image[..., k])
    write_planes(str(tmp_path / "a.npy"), image, ("Z", "A"), {})
    np.testing.assert_array_equal(np.load(tmp_path / "a.npy"), image)
