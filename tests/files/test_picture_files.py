"""Pictures from files that other programs wrote: the right reflectances, or one sentence."""

import io
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import imagecodecs
import numpy as np
import OpenEXR
import pytest
import tifffile
from PIL import Image, ImageCms, ImageOps
from scipy import io as scipy_io

import camsim
import camsim.measure
from camsim.camera.description import describe
from camsim.config.from_record import stages_from_record
from camsim.errors import CamsimError, InputError
from tests.tables import rows

ROWS, COLS = 5, 7
RGB = np.random.default_rng(3).integers(0, 256, (ROWS, COLS, 3)).astype(np.uint8)
DEEP = (RGB.astype(np.uint16) << 8) + 77
WAVELENGTH_NM = np.array([450.0, 520.0, 610.0, 700.0])
CUBE = np.random.default_rng(4).random((ROWS, COLS, 4))


def linear(encoded: np.ndarray) -> np.ndarray:
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def planes_of(path: Path, **how: Any) -> np.ndarray:
    """Return (rows, cols, planes) as the file is read."""
    picture = camsim.read_picture(path, width_um=100.0, **how)
    assert picture.source == path.name
    return np.moveaxis(picture.planes, 0, 2)


def cube_of(path: Path, **how: Any) -> np.ndarray:
    """Return (rows, cols, bands) at the cube's own wavelengths, put together again from planes and components."""
    picture = camsim.read_picture(path, width_um=100.0, tolerance=1e-6, **how)
    spectra = np.stack([spectrum.at(WAVELENGTH_NM) for spectrum in picture.spectra])
    return np.einsum("prc,pn->rcn", picture.planes, spectra)


@pytest.mark.parametrize(("samples", "top"), [(RGB, 255), (DEEP, 65535)])
@pytest.mark.parametrize("kind", ["png", "tiff"])
def test_encoded_colours(tmp_path: Path, samples: np.ndarray, top: int, kind: str) -> None:
    path = tmp_path / f"a.{kind}"
    if kind == "png":
        path.write_bytes(imagecodecs.png_encode(samples))
    else:
        tifffile.imwrite(path, samples, photometric="rgb")
    np.testing.assert_allclose(planes_of(path), linear(samples / top), rtol=0, atol=1e-12)
    np.testing.assert_allclose(planes_of(path, encoding="linear"), samples / top, rtol=0, atol=1e-12)
    np.testing.assert_allclose(planes_of(path, encoding=1.8), (samples / top) ** 1.8, rtol=0, atol=1e-12)


def test_the_largest_of_twelve_bits_is_white(tmp_path: Path) -> None:
    codes = np.array([[0, 1024, 2048, 4095]] * 2, np.uint16)
    packed = imagecodecs.packints_encode(codes, 12)
    how = {"shape": codes.shape, "dtype": np.uint16, "bitspersample": 12, "photometric": "minisblack"}
    tifffile.imwrite(tmp_path / "a.tiff", iter([packed]), **how)
    np.testing.assert_allclose(planes_of(tmp_path / "a.tiff")[..., 0], linear(codes / 4095), rtol=0, atol=1e-12)


def test_one_bit_is_black_or_white(tmp_path: Path) -> None:
    mask = RGB[..., 0] > 100
    Image.fromarray(mask).save(tmp_path / "a.png")
    np.testing.assert_array_equal(planes_of(tmp_path / "a.png")[..., 0], mask.astype(float))


def test_jpeg_and_grey(tmp_path: Path) -> None:
    Image.fromarray(RGB).resize((64, 48)).save(tmp_path / "a.jpg", quality=100, subsampling=0)
    with Image.open(tmp_path / "a.jpg") as image:
        expected = linear(np.asarray(image) / 255)
    np.testing.assert_allclose(planes_of(tmp_path / "a.jpg"), expected, rtol=0, atol=1e-12)
    Image.fromarray(RGB[..., 0]).save(tmp_path / "grey.png")
    picture = camsim.read_picture(tmp_path / "grey.png", width_um=1.0)
    assert picture.spectra == (1.0,)
    np.testing.assert_allclose(picture.planes[0], linear(RGB[..., 0] / 255), rtol=0, atol=1e-12)
    Image.fromarray(np.full((8, 8), 77, np.uint8)).save(tmp_path / "grey.jpg", quality=100)
    np.testing.assert_allclose(planes_of(tmp_path / "grey.jpg"), linear(np.array(77 / 255)), rtol=0, atol=0.01)


@pytest.mark.parametrize("kind", ["png", "jpg", "tiff"])
def test_photographs_come_upright(tmp_path: Path, kind: str) -> None:
    """All orientations, and numbers that are none (as stored), as Pillow turns the stored samples."""
    path = tmp_path / f"a.{kind}"
    for noted in (None, *range(10)):
        if kind == "tiff":  # tifffile's samples: Pillow turns those of a TIFF as it loads them
            extra = [] if noted is None else [(274, "H", 1, noted, True)]
            tifffile.imwrite(path, RGB, photometric="rgb", extratags=extra)
            stored = Image.fromarray(tifffile.imread(path))
        else:
            exif = Image.Exif()
            exif.update({} if noted is None else {274: noted})
            Image.fromarray(RGB).save(path, exif=exif, **({"quality": 100} if kind == "jpg" else {}))
            with Image.open(path) as image:
                stored = Image.fromarray(np.asarray(image))
        stored.getexif()[274] = noted or 1
        expected = linear(np.asarray(ImageOps.exif_transpose(stored)) / 255)
        np.testing.assert_allclose(planes_of(path), expected, rtol=0, atol=1e-12, err_msg=str(noted))


def exif_of(index: bytes) -> bytes:
    """A camera's notes (EXIF 2.32, 4.6.3): a directory that points at one that points at the rules' letters."""
    head = b"MM\0*\0\0\0\x08"
    one = b"\0\1" + struct.pack(">HHII", 34665, 4, 1, 26) + bytes(4)
    two = b"\0\1" + struct.pack(">HHII", 40965, 4, 1, 44) + bytes(4)
    return b"Exif\0\0" + head + one + two + b"\0\1" + struct.pack(">HHI4s", 1, 2, 4, index) + bytes(4)


@pytest.mark.parametrize("kind", ["png", "jpg", "tiff"])
def test_adobe_rgb_is_noticed_without_its_profile(tmp_path: Path, kind: str) -> None:
    """Cameras name the rules of their files: R98 of sRGB, R03 of Adobe RGB (DCF 2.0)."""
    path = tmp_path / f"a.{kind}"
    for index in (b"R98\0", b"R03\0"):
        if kind == "tiff":
            exif = Image.Exif()
            exif.load(exif_of(index))
            exif.get_ifd(34665)[40965] = {1: index.decode().rstrip("\0")}
            Image.fromarray(RGB).save(path, exif=exif)
        else:
            Image.fromarray(RGB).save(path, exif=exif_of(index))
        if index == b"R98\0":
            assert planes_of(path).shape == (ROWS, COLS, 3)
            continue
        with pytest.raises(InputError, match="those of the profile 'Adobe RGB, by EXIF'; convert it to sRGB, or give"):
            planes_of(path)
        assert planes_of(path, encoding="srgb").shape == (ROWS, COLS, 3)
    Image.fromarray(RGB[..., 0]).save(path, **({} if kind == "tiff" else {"exif": exif_of(b"R03\0")}))
    assert planes_of(path).shape == (ROWS, COLS, 1)


def test_damaged_notes_leave_a_photograph_as_it_is_stored(tmp_path: Path) -> None:
    for exif in (
        b"Exif\0\0",
        b"Exif\0\0MM\0*\xff\xff\xff\xff",
        b"Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0" + b"\xff" * 12,
        exif_of(b"R03\0")[:-9],
        exif_of(b"R03\0")[:40],
    ):
        Image.fromarray(RGB).save(tmp_path / "a.png", exif=exif)
        np.testing.assert_allclose(planes_of(tmp_path / "a.png"), linear(RGB / 255), rtol=0, atol=1e-12)


def test_gamma_of_a_png_is_noticed(tmp_path: Path) -> None:
    Image.fromarray(RGB).save(tmp_path / "a.png")
    content = (tmp_path / "a.png").read_bytes()
    chunk = b"gAMA" + struct.pack(">I", 55556)  # 1/1.8
    content = content[:33] + struct.pack(">I", 4) + chunk + struct.pack(">I", zlib.crc32(chunk)) + content[33:]
    (tmp_path / "a.png").write_bytes(content)
    np.testing.assert_allclose(planes_of(tmp_path / "a.png"), (RGB / 255) ** 1.8, rtol=0, atol=1e-4)


@pytest.mark.parametrize("kind", ["png", "jpg", "tiff"])
def test_colour_profiles_are_noticed(tmp_path: Path, kind: str) -> None:
    path = tmp_path / f"a.{kind}"
    for name, profile in (("sRGB", ImageCms.createProfile("sRGB")), ("LAB", ImageCms.createProfile("LAB"))):
        content = ImageCms.ImageCmsProfile(profile).tobytes()
        Image.fromarray(RGB).save(path, icc_profile=content)
        if name == "sRGB":
            assert planes_of(path).shape == (ROWS, COLS, 3)
            continue
        with pytest.raises(InputError, match=r"its colours are those of the profile '.*'; convert it to sRGB, or give"):
            planes_of(path)
        assert planes_of(path, encoding="srgb").shape == (ROWS, COLS, 3)


def test_a_profile_of_version_2_has_a_name(tmp_path: Path) -> None:
    """ICC.1:2001-04, 6.5.17; with a byte of fill before its marker (ITU-T T.81, B.1.1.2)."""
    name = b"Adobe RGB (1998)\0"
    tag = b"desc" + bytes(4) + struct.pack(">I", len(name)) + name + bytes(78)
    profile = bytes(128) + struct.pack(">I4sII", 1, b"desc", 144, len(tag)) + tag
    Image.fromarray(RGB).save(tmp_path / "a.jpg", icc_profile=profile)
    content = (tmp_path / "a.jpg").read_bytes()
    (tmp_path / "b.jpg").write_bytes(content.replace(b"\xff\xe2", b"\xff\xff\xe2", 1))
    for file in ("a.jpg", "b.jpg"):
        with pytest.raises(InputError, match=r"those of the profile 'Adobe RGB \(1998\)'; convert"):
            planes_of(tmp_path / file)


def test_exr_is_linear(tmp_path: Path) -> None:
    light = (RGB / 255).astype(np.float32)
    OpenEXR.File({}, {"RGB": light}).write(str(tmp_path / "a.exr"))
    np.testing.assert_array_equal(planes_of(tmp_path / "a.exr"), light)
    OpenEXR.File({}, {"RGB": 4 * light}).write(str(tmp_path / "b.exr"))
    np.testing.assert_allclose(planes_of(tmp_path / "b.exr", scale=0.25), light, rtol=1e-7)
    with pytest.raises(CamsimError, match=r"scale: makes samples from 0 to \d.*, and a reflectance is 0 to 1; give"):
        planes_of(tmp_path / "b.exr")


RED, DIM = np.full((ROWS, COLS), 0.8, np.float32), np.full((ROWS, COLS), 0.1, np.float32)


def exr(path: Path, *parts: dict[str, np.ndarray], **header: Any) -> Path:
    """Write layers by name, each of R, G and B, or of the channels behind a colon, as parts of an EXR."""
    made = []
    for number, layers in enumerate(parts):
        channels = {}
        for said, plane in layers.items():
            layer, _, letters = said.partition(":")
            channels |= {f"{layer}.{each}".removeprefix("."): plane for each in letters.split() or "RGB"}
        made.append(OpenEXR.Part({"name": f"part{number}", "type": OpenEXR.scanlineimage, **header}, channels))
    with OpenEXR.File(made) as file:
        file.write(str(path))
    return path


@pytest.mark.parametrize(
    ("parts", "layer"),
    [
        ([{"": RED, "specular": DIM}], None),
        ([{"": RED, "Albedo": DIM, "N:X Y Z": DIM, ":Z": DIM, "fog:R G B A": DIM}], None),
        ([{"ViewLayer.Combined": RED, "ViewLayer.Noisy Image": DIM, "ViewLayer.Depth:Z": DIM}], None),
        ([{"N:X Y Z": DIM, "beauty": RED}], None),
        ([{":Y": RED, "left:Y": DIM}], None),
        ([{"left": DIM, "right": RED}], "right"),
        ([{"": DIM, "specular": RED}], "specular"),
        ([{"": RED, "specular": DIM}], ""),
        ([{"": RED}, {"": DIM}], None),
        ([{":Z": DIM}, {"": RED, "N:X Y Z": DIM}], None),
        ([{"": DIM}, {"": RED}], "part1"),
    ],
)
def test_of_an_exr_with_layers_the_image_is_read(tmp_path: Path, parts: list[Any], layer: str | None) -> None:
    """``specular`` beside the image, and Blender's ``Noisy Image``, were read for it (0.1 for 0.8)."""
    path = exr(tmp_path / "a.exr", *parts)
    np.testing.assert_array_equal(planes_of(path, layer=layer), RED[0, 0])
    measured = camsim.measure.read_picture(path, layer=layer)
    assert {float(plane.samples[0, 0]) for plane in measured.planes if plane.name in "RGBY"} == {float(RED[0, 0])}


def test_another_image_comes_back_by_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two images in an EXR, NPZ or MATLAB file; a picture's description says which of them it shows."""
    path = exr(tmp_path / "a.exr", {"left": DIM, "right": RED})
    picture = camsim.read_picture(path, width_um=9.0, layer="right")
    assert stages_from_record(describe(picture), tmp_path).sha256 == picture.sha256
    for name, write in (("a.npz", np.savez), ("a.mat", lambda path, **arrays: scipy_io.savemat(path, arrays))):
        write(tmp_path / name, Other=RGB / 510, image=RGB / 255)
        np.testing.assert_array_equal(planes_of(tmp_path / name, layer="image", encoding="linear"), RGB / 255)


@pytest.mark.parametrize("name", ["T.{:.6f}nm", "S0.{:.6f}nm", "w{:.0f}nm", "{:.1f}nm", "left.{:.0f}nm"])
def test_spectral_exr(tmp_path: Path, name: str) -> None:
    names = [name.format(nm) for nm in WAVELENGTH_NM]
    if name.startswith(("T", "S0")):
        names = [
            f"{item[:3] if item[0] == 'S' else item[:2]}{item.split('.', 1)[1].replace('.', ',')}" for item in names
        ]
    channels = {item: CUBE[..., k].astype(np.float32) for k, item in enumerate(names)}
    if name.startswith("S0"):
        channels |= {item.replace("S0", "S1"): np.full((ROWS, COLS), -9.0, np.float32) for item in names}
    OpenEXR.File({}, channels).write(str(tmp_path / "a.exr"))
    np.testing.assert_allclose(cube_of(tmp_path / "a.exr"), CUBE, rtol=0, atol=2e-6)


@pytest.mark.parametrize("interleave", ["bsq", "bil", "bip"])
@pytest.mark.parametrize("order", ["<", ">"])
def test_envi(tmp_path: Path, interleave: str, order: str) -> None:
    axes = {"bsq": (2, 0, 1), "bil": (0, 2, 1), "bip": (0, 1, 2)}[interleave]
    whole = np.rint(10_000 * CUBE).astype(f"{order}i2")
    (tmp_path / "a.img").write_bytes(b"xx" + np.ascontiguousarray(whole.transpose(axes)).tobytes())
    (tmp_path / "a.hdr").write_text(
        f"ENVI\ndescription = {{a\n cube}}\nsamples = {COLS}\nlines = {ROWS}\nbands = 4\nheader offset = 2\n"
        f"data type = 2\ninterleave = {interleave.upper()}\nbyte order = {int(order == '>')}\n"
        "reflectance scale factor = 10000\nwavelength units = Micrometers\n"
        f"wavelength = {{ {', '.join(str(nm / 1e3) for nm in WAVELENGTH_NM)} }}\n"
    )
    for name in ("a.img", "a.hdr"):
        np.testing.assert_allclose(cube_of(tmp_path / name), whole / 10_000, rtol=0, atol=2e-6)


def test_matlab_of_both_versions(tmp_path: Path) -> None:
    scipy_io.savemat(
        tmp_path / "five.mat", {"cube": CUBE, "wavelengths": WAVELENGTH_NM, "note": "x"}, do_compression=True
    )
    others = {"illumination_wavelength": np.arange(1.0, 5.0), "owl": np.arange(4.0)}
    scipy_io.savemat(tmp_path / "six.mat", {"cube": CUBE, **others, "wavelength": WAVELENGTH_NM})
    with h5py.File(tmp_path / "hdf.mat", "w", userblock_size=512) as file:
        file["rad"] = CUBE.T  # as MATLAB writes it: columns first
        file["bands"] = WAVELENGTH_NM[:, None]
    for name in ("five.mat", "six.mat", "hdf.mat"):
        np.testing.assert_allclose(cube_of(tmp_path / name), CUBE, rtol=0, atol=2e-6)
    scipy_io.savemat(tmp_path / "rgb.mat", {"rgb": RGB})
    np.testing.assert_allclose(planes_of(tmp_path / "rgb.mat"), linear(RGB / 255), rtol=0, atol=1e-12)


def test_matlabs_doubles_are_light_however_they_are_stored(tmp_path: Path) -> None:
    """MATLAB stores doubles that are whole as bytes (MAT-File Format, "Data Compression"): here a mask of 0 and 1."""
    mask = RGB[..., 0] > 100

    def element(kind: int, content: bytes) -> bytes:
        return struct.pack("<2I", kind, len(content)) + content + bytes(-len(content) % 8)

    flags, dimensions = element(6, struct.pack("<2I", 6, 0)), element(5, struct.pack("<2i", ROWS, COLS))
    matrix = flags + dimensions + element(1, b"mask") + element(2, mask.astype(np.uint8).tobytes("F"))
    (tmp_path / "a.mat").write_bytes(b"MATLAB 5.0".ljust(124) + struct.pack("<H2s", 0x100, b"IM") + element(14, matrix))
    np.testing.assert_array_equal(planes_of(tmp_path / "a.mat")[..., 0], mask)


def test_numpys_own(tmp_path: Path) -> None:
    np.save(tmp_path / "cube.npy", CUBE)
    np.testing.assert_allclose(cube_of(tmp_path / "cube.npy", wavelength_nm=WAVELENGTH_NM), CUBE, rtol=0, atol=2e-6)
    np.savez_compressed(tmp_path / "cube.npz", cube=CUBE, wavelength_nm=WAVELENGTH_NM)
    np.testing.assert_allclose(cube_of(tmp_path / "cube.npz"), CUBE, rtol=0, atol=2e-6)
    np.save(tmp_path / "rgb.npy", RGB / 255)
    np.testing.assert_array_equal(planes_of(tmp_path / "rgb.npy", encoding="linear"), RGB / 255)
    np.testing.assert_allclose(planes_of(tmp_path / "rgb.npy", encoding="srgb"), linear(RGB / 255), rtol=0, atol=1e-12)
    with pytest.raises(CamsimError, match=r"encoding: must be said: the samples are all whole 255ths, .*: srgb"):
        planes_of(tmp_path / "rgb.npy")
    np.savez(tmp_path / "rgb.npz", rgb=RGB)
    np.save(tmp_path / "rgb.npy", DEEP.astype(">u2"))
    for name, samples in (("rgb.npz", RGB / 255), ("rgb.npy", DEEP / 65535)):
        np.testing.assert_allclose(planes_of(tmp_path / name), linear(samples), rtol=0, atol=1e-12)
        np.testing.assert_allclose(planes_of(tmp_path / name, encoding="linear"), samples, rtol=0, atol=1e-12)


def test_radiances_become_reflectances_in_their_light(tmp_path: Path) -> None:
    light = camsim.Light("D65", illuminance_lux=20_000.0)
    radiance = CUBE * light.irradiance_at(WAVELENGTH_NM) / np.pi
    channels = {f"S0.{nm:.6f}nm".replace(".", ",").replace("S0,", "S0."): radiance[..., k].astype(np.float32)
                for k, nm in enumerate(WAVELENGTH_NM)}  # fmt: skip
    OpenEXR.File({"emissiveUnits": "W.m^-2.sr^-1.nm^-1"}, channels).write(str(tmp_path / "a.exr"))
    np.testing.assert_allclose(cube_of(tmp_path / "a.exr", light=light), CUBE, rtol=0, atol=2e-6)
    with pytest.raises(InputError, match="its bands are radiances; give the light"):
        cube_of(tmp_path / "a.exr")


def envi_of_a_thousand_million(folder: Path) -> Path:
    (folder / "a.img").write_bytes(bytes(100))
    (folder / "a.hdr").write_text(
        "ENVI\nsamples = 40000\nlines = 25000\nbands = 1\ndata type = 4\nwavelength = {500}\n"
    )
    return folder / "a.img"


def envi_of_a_thousand_million_that_are_there(folder: Path) -> Path:
    """As many numbers as it says, in a file of holes, which a scale would make 8 GB of."""
    with (folder / "a.img").open("wb") as file:
        file.truncate(1_000_000_000)
    (folder / "a.hdr").write_text(
        "ENVI\nsamples = 40000\nlines = 25000\nbands = 1\ndata type = 1\nreflectance scale factor = 255\n"
    )
    return folder / "a.img"


def png(path: Path, *chunks: bytes) -> Path:
    """Write chunks (kind and content) as a PNG."""
    packed = [struct.pack(">I", len(c) - 4) + c + struct.pack(">I", zlib.crc32(c)) for c in chunks]
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(packed))
    return path


def png_of_a_thousand_million(folder: Path) -> Path:
    head = b"IHDR" + struct.pack(">2I5B", 40_000, 25_000, 8, 2, 0, 0, 0)
    return png(folder / "a.png", head, b"IDAT" + zlib.compress(bytes(1000)), b"IEND")


def png_with(*chunks: bytes) -> Callable[[Path], Path]:
    """Return what writes a picture of one red sample with chunks before its pixels."""
    head, data = b"IHDR" + struct.pack(">2I5B", 1, 1, 8, 2, 0, 0, 0), b"IDAT" + zlib.compress(b"\0\xff\0\0")
    return lambda folder: png(folder / "a.png", head, *chunks, data, b"IEND")


def primaries(*x_y: float) -> bytes:
    return b"cHRM" + struct.pack(">8I", *(round(1e5 * value) for value in x_y))


def exr_with(*parts: dict[str, np.ndarray], **header: Any) -> Callable[[Path], Path]:
    return lambda folder: exr(folder / "a.exr", *parts, **header)


def tiff_of_adobe(folder: Path) -> Path:
    red_green_blue, white = (64, 100, 33, 100, 21, 100, 71, 100, 15, 100, 6, 100), (3127, 10000, 3290, 10000)
    extra = [(319, "2I", 6, red_green_blue, True), (318, "2I", 2, white, True)]
    tifffile.imwrite(folder / "a.tiff", DEEP, photometric="rgb", extratags=extra)
    return folder / "a.tiff"


def arrays_of_one_size(folder: Path) -> Path:
    np.savez(folder / "a.npz", clean=RGB / 255, noisy=RGB / 510)
    return folder / "a.npz"


ACES = (0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767)
SRGB = primaries(0.3127, 0.329, 0.64, 0.33, 0.3, 0.6, 0.15, 0.06)
ADOBE = primaries(0.3127, 0.329, 0.64, 0.33, 0.21, 0.71, 0.15, 0.06)


def hdf5_of_a_thousand_million(folder: Path) -> Path:
    with h5py.File(folder / "a.mat", "w") as file:
        file.create_dataset("cube", (31, 40_000, 25_000), "f4", chunks=(1, 100, 100), compression="gzip")
    return folder / "a.mat"


def saved(name: str, image: Any, **how: Any) -> Callable[[Path], Path]:
    def save(folder: Path) -> Path:
        path = folder / name
        if isinstance(image, np.ndarray):
            np.save(path, image)
        else:
            image.save(path, **how)
        return path

    return save


def truncated(name: str, image: Any) -> Callable[[Path], Path]:
    def save(folder: Path) -> Path:
        buffer = io.BytesIO()
        image.resize((64, 64)).save(buffer, format={"jpg": "JPEG"}.get(name[2:], name[2:].upper()))
        (folder / name).write_bytes(buffer.getvalue()[:-900])
        return folder / name

    return save


def with_alpha(alpha: int) -> Image.Image:
    return Image.fromarray(np.dstack([RGB, np.full((ROWS, COLS), alpha, np.uint8)]))


REFUSED = rows("wrong-contents.txt", "pictures")


@pytest.mark.parametrize(("make", "words"), [case[1:] for case in REFUSED], ids=[case[0] for case in REFUSED])
def test_what_cannot_be_read_is_one_sentence(tmp_path: Path, make: str, words: str) -> None:
    path = eval(make)(tmp_path)
    with pytest.raises(CamsimError) as refused:
        camsim.read_picture(path, width_um=10.0)
    said = str(refused.value)
    assert words in said
    assert str(path) in said
    assert "\n" not in said


def test_alpha_that_hides_nothing_is_no_matter(tmp_path: Path) -> None:
    with_alpha(255).save(tmp_path / "a.png")
    np.testing.assert_allclose(planes_of(tmp_path / "a.png"), linear(RGB / 255), rtol=0, atol=1e-12)
    grey = np.dstack([DEEP[..., 0], np.full((ROWS, COLS), 65535, np.uint16)])
    (tmp_path / "a.png").write_bytes(imagecodecs.png_encode(grey))
    np.testing.assert_allclose(planes_of(tmp_path / "a.png")[..., 0], linear(DEEP[..., 0] / 65535), rtol=0, atol=1e-12)


def test_a_layer_of_a_file_that_has_none_is_refused(tmp_path: Path) -> None:
    with_alpha(255).save(tmp_path / "a.png")
    with pytest.raises(CamsimError, match=r"a\.png': layer: a \.png has none; leave it out"):
        planes_of(tmp_path / "a.png", layer="left")
    with pytest.raises(CamsimError, match=r"'up' is not in it; there are 'left', 'right'"):
        planes_of(exr(tmp_path / "a.exr", {"left": RED, "right": DIM}), layer="up")


@pytest.mark.parametrize(
    "chunks", [[SRGB], [b"cICP\x01\x0d\x00\x01"], [b"sRGB\0", ADOBE]], ids=["cHRM", "cICP", "sRGB goes before"]
)
def test_srgb_by_other_names(tmp_path: Path, chunks: list[bytes]) -> None:
    np.testing.assert_array_equal(planes_of(png_with(*chunks)(tmp_path)).ravel(), [1.0, 0.0, 0.0])


@pytest.mark.parametrize("name", ["a.mat", "a.hdr", "a.exr", "a.npz"])
def test_noise_is_no_picture(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(np.random.default_rng(1).bytes(3000))
    with pytest.raises(CamsimError, match="cannot read"):
        camsim.read_picture(tmp_path / name, width_um=10.0)
