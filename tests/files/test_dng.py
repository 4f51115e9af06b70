"""A DNG read back by LibRaw (rawpy) and tifffile."""

import dataclasses
import json
from fractions import Fraction
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
import rawpy
import tifffile
from tolerances import STATISTICAL

import camsim
from camsim.camera.frame import Frame
from camsim.errors import OutputError
from camsim.files import save
from camsim.files.dng import noise_profile
from camsim.files.dng_tags import odd_cfa
from camsim.files.reading import XMP_NAMESPACE
from camsim.spectra.colour_science import colour_science
from camsim.spectra.curve import Curve
from tests.files.conftest import MakeFrame
from tests.libraw import developed


def tags_of(path: Path) -> dict[Any, Any]:
    with tifffile.TiffFile(path) as file:
        return {tag.code: tag.value for tag in file.pages[0].tags}


def fractions(values: tuple[int, ...]) -> np.ndarray:
    return np.array([float(Fraction(n, d)) for n, d in zip(values[::2], values[1::2], strict=True)])


@pytest.mark.parametrize(
    ("pattern", "size"), [("RG GB", (48, 66)), ("BG GR", (49, 67)), ("GR BG", (30, 31)), ("GB RG", (49, 66))]
)
def test_libraw_reads_the_bayer_mosaic_bit_for_bit(
    tmp_path: Path, make_frame: MakeFrame, pattern: str, size: tuple[int, int]
) -> None:
    frame = make_frame(*size, pattern)
    save(frame, tmp_path / "a.dng")
    with rawpy.imread(str(tmp_path / "a.dng")) as raw:
        np.testing.assert_array_equal(raw.raw_image, frame.mosaic)
        np.testing.assert_array_equal(raw.raw_image_visible, frame.mosaic)
        assert raw.black_level_per_channel == [128] * 4
        assert raw.white_level == 4023
        assert raw.camera_white_level_per_channel == [4023] * 4
        assert raw.color_desc == b"RGBG"
        colours = np.where(raw.raw_colors_visible == 3, 1, raw.raw_colors_visible)
        np.testing.assert_array_equal(colours, frame.channel_index)
        assert raw.sizes.flip == 0


def test_libraw_reads_x_trans(tmp_path: Path, make_frame: MakeFrame, x_trans: str) -> None:
    frame = make_frame(516, 600, x_trans)
    save(frame, tmp_path / "a.dng")
    with rawpy.imread(str(tmp_path / "a.dng")) as raw:
        np.testing.assert_array_equal(raw.raw_image_visible, frame.mosaic)
        np.testing.assert_array_equal(raw.raw_colors_visible, frame.channel_index)


def test_libraw_reads_mono(tmp_path: Path, mono_frame: Frame) -> None:
    save(mono_frame, tmp_path / "a.dng")
    with rawpy.imread(str(tmp_path / "a.dng")) as raw:
        np.testing.assert_array_equal(raw.raw_image_visible, mono_frame.mosaic)
        assert raw.white_level == 4023
        assert raw.num_colors == 1


@pytest.mark.parametrize(
    ("bits", "black", "white"), [(12, 128, 4095), (14, 512, 16383), (16, 1024, 65535), (10, 0, 1023)]
)
def test_libraw_reads_levels(tmp_path: Path, make_frame: MakeFrame, bits: int, black: int, white: int) -> None:
    codes = np.random.default_rng(bits).integers(0, white + 1, (48, 66)).astype(np.uint16)
    frame = make_frame(bit_depth=bits, black_level_dn=black, white_level_dn=white, mosaic=codes)
    save(frame, tmp_path / "a.dng")
    with rawpy.imread(str(tmp_path / "a.dng")) as raw:
        np.testing.assert_array_equal(raw.raw_image, codes)
        assert raw.white_level == white
        assert raw.black_level_per_channel == [black] * 4


def test_libraw_reads_black_levels_that_differ(tmp_path: Path, make_frame: MakeFrame) -> None:
    save(make_frame(black_offsets_dn=((0, 2), (-1, 3))), tmp_path / "a.dng")
    with rawpy.imread(str(tmp_path / "a.dng")) as raw:
        # LibRaw's own order of a Bayer array: red, the green beside it, blue, the green beside that.
        assert raw.black_level_per_channel == [128, 130, 131, 127]


@pytest.mark.parametrize(
    ("offsets", "white"), [(((0, 2), (-1, 3)), 4022), (((30,),), 4053), (((90, 100),), 4095), (((-40,),), 3983)]
)
def test_white_is_where_the_first_photosites_are_full(
    tmp_path: Path, make_frame: MakeFrame, offsets: tuple[tuple[int, ...], ...], white: int
) -> None:
    """Offsets move it as they move black: 4023 without one, and no code above 4095."""
    save(make_frame(black_offsets_dn=offsets), tmp_path / "a.dng")
    with rawpy.imread(str(tmp_path / "a.dng")) as raw:
        assert raw.white_level == white


def test_a_window_carries_the_black_levels_of_its_place(tmp_path: Path) -> None:
    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0))
    adc = dataclasses.replace(camera.adc, black_offsets_dn=((0, 2), (-1, 3)))
    frame = camera.replace(adc=adc).expose(
        camsim.Scene(background=0.0, shapes=[]),
        light=camsim.Light("D55", illuminance_lux=100.0),
        exposure=camsim.Exposure(time_s=0.01, iso=200.0),
        region=camsim.Region(rows=24, cols=24, origin=(101, 200)),
        noise=False,
    )
    assert frame.black_offsets_dn == ((-1, 3), (0, 2))
    assert frame.mosaic[:2, :2].tolist() == [[127, 131], [128, 130]]
    save(frame, tmp_path / "a.dng")
    tags = tags_of(tmp_path / "a.dng")
    assert tags[50713] == (2, 2)
    assert fractions(tags[50714]).tolist() == [127, 131, 128, 130]


NODES_NM = np.arange(360.0, 831.0)  # of conftest's curves


def sensitivities(frame: Frame) -> np.ndarray:
    """Return the channels' tables, on whole nanometres and per unit energy."""
    return np.array([curve.values for _, curve in frame.colour.quantum_efficiency.curves])


def response_to(frame: Frame, light: str) -> np.ndarray:
    """Return the channels' response to a perfect diffuser under a CIE illuminant, summed every 5 nm."""
    colour = colour_science()
    shape = colour.SpectralShape(380, 780, 5)
    power = colour.SDS_ILLUMINANTS[light].copy().align(shape).values
    nodes = shape.range()
    sums = [(power * np.interp(nodes, NODES_NM, curve)).sum() for curve in sensitivities(frame)]
    return np.array(sums) / max(sums)


# CIE 15:2018, table T.3: chromaticities of the illuminants for the 2° observer.
CHROMATICITY = {"A": (0.44758, 0.40745), "D65": (0.31272, 0.32903)}


def test_colour_matrices_take_white_to_neutral(tmp_path: Path, frame: Frame) -> None:
    save(frame, tmp_path / "a.dng")
    tags = tags_of(tmp_path / "a.dng")
    assert (tags[50778], tags[50779]) == (17, 21)
    for code, light in ((50721, "A"), (50722, "D65")):
        matrix = fractions(tags[code]).reshape(3, 3)
        x, y = CHROMATICITY[light]
        np.testing.assert_allclose(matrix @ [x / y, 1, (1 - x - y) / y], response_to(frame, light), rtol=1e-3)
    for code in (50964, 50965):
        np.testing.assert_allclose(
            fractions(tags[code]).reshape(3, 3).sum(axis=1), [0.9642, 1, 0.8249], rtol=0, atol=1e-7
        )


def test_forward_matrices_belong_to_the_colour_matrices_of_their_light(tmp_path: Path, frame: Frame) -> None:
    """Both are one fit: camera to XYZ under the light, balanced by its white, and taken to D50 by colour-science."""
    save(frame, tmp_path / "a.dng")
    tags = tags_of(tmp_path / "a.dng")
    adapted = colour_science().adaptation.matrix_chromatic_adaptation_VonKries
    for colour_tag, forward_tag, light in ((50721, 50964, "A"), (50722, 50965, "D65")):
        x, y = CHROMATICITY[light]
        white = np.array([x / y, 1, (1 - x - y) / y])
        from_xyz = fractions(tags[colour_tag]).reshape(3, 3)
        to_d50 = adapted(white, np.array([0.9642, 1, 0.8249]), transform="Bradford")
        expected = to_d50 @ np.linalg.inv(from_xyz) @ np.diag(from_xyz @ white)
        np.testing.assert_allclose(fractions(tags[forward_tag]).reshape(3, 3), expected, rtol=0, atol=2e-3)


@pytest.mark.parametrize(
    ("size", "pattern", "margin"),
    [
        ((48, 66), "RG GB", 4),
        ((66, 24), "GB RG", 4),
        ((23, 66), "RG GB", 2),
        ((5, 66), "RG GB", 2),
        ((66, 4), "RG GB", 0),
        ((48, 66), "x-trans", 6),
        ((66, 23), "x-trans", 6),
        ((12, 66), "x-trans", 0),
        ((13, 66), "x-trans", 6),
        ((48, 66), "Y", 4),
    ],
)
def test_the_default_crop_leaves_whole_periods_and_a_middle(
    tmp_path: Path, make_frame: MakeFrame, x_trans: str, size: tuple[int, int], pattern: str, margin: int
) -> None:
    """Two photosites a side at least, for demosaicing, where that leaves anything; counted by hand."""
    save(make_frame(*size, x_trans if pattern == "x-trans" else pattern), tmp_path / "a.dng")
    tags = tags_of(tmp_path / "a.dng")
    assert fractions(tags[50719]).tolist() == [margin, margin]
    assert fractions(tags[50720]).tolist() == [size[1] - 2 * margin, size[0] - 2 * margin]
    assert tags[50829] == (0, 0, *size)


def test_libraw_takes_the_default_crop_from_the_file(tmp_path: Path, frame: Frame) -> None:
    save(frame, tmp_path / "a.dng")
    with rawpy.imread(str(tmp_path / "a.dng")) as raw:
        sizes = raw.sizes
        assert (sizes.crop_left_margin, sizes.crop_top_margin) == (4, 4)
        assert (sizes.crop_width, sizes.crop_height) == (66 - 8, 48 - 8)


def test_libraw_takes_white_balance_and_matrix_from_the_file(tmp_path: Path, frame: Frame) -> None:
    save(frame, tmp_path / "a.dng")
    assert isinstance(frame.colour.light.spectrum, Curve)
    seen = sensitivities(frame) @ np.array(frame.colour.light.spectrum.values)
    with rawpy.imread(str(tmp_path / "a.dng")) as raw:
        np.testing.assert_allclose(raw.camera_whitebalance[:3], seen.max() / seen, rtol=1e-5)
        # LibRaw makes its daylight multipliers of the D65 matrix alone.
        np.testing.assert_allclose(raw.daylight_whitebalance[:3], 1 / response_to(frame, "D65"), rtol=1e-3)


@pytest.mark.parametrize(
    ("level_e", "offsets"), [(200.0, ((0,),)), (200.0, ((0, 600), (-60, 30))), (30000.0, ((0, 600), (-60, 30)))]
)
def test_noise_profile_is_the_variance_of_a_flat_field(
    tmp_path: Path, make_frame: MakeFrame, level_e: float, offsets: tuple[tuple[int, ...], ...]
) -> None:
    """On the scale of DNG 1.4, chapter 5, by the file's own tags: one span for all, from the largest black level."""
    frame = make_frame(black_offsets_dn=offsets)
    save(frame, tmp_path / "a.dng")
    tags = tags_of(tmp_path / "a.dng")
    rng = np.random.default_rng(3)
    photosites = 400_000
    electrons = rng.poisson(level_e, photosites) + rng.normal(0, frame.read_noise_e, photosites)
    black_dn = np.resize(128 + np.array(offsets), photosites)
    codes = np.rint(black_dn + electrons / frame.electrons_per_dn)
    x = (codes - black_dn) / (tags[50717] - fractions(tags[50714]).max())
    shot, floor = tags[51041][:2]
    # The variance of n values has a relative standard deviation of sqrt(2/n).
    assert x.var() == pytest.approx(shot * x.mean() + floor, rel=STATISTICAL * np.sqrt(2 / photosites))


def test_a_white_level_below_others_black_is_refused(tmp_path: Path, make_frame: MakeFrame) -> None:
    with pytest.raises(OutputError, match=r"340 DN, where the first .* full, is not above the black level 728"):
        save(make_frame(black_offsets_dn=((0, 600), (-60, 30)), white_level_dn=400), tmp_path / "a.dng")
    assert not [*tmp_path.iterdir()]


def test_noise_profile_is_written_for_every_plane(tmp_path: Path, frame: Frame, mono_frame: Frame) -> None:
    for each, planes in ((frame, 3), (mono_frame, 1)):
        save(each, tmp_path / "a.dng", force=True)
        assert tags_of(tmp_path / "a.dng")[51041] == noise_profile(each) * planes


def test_the_exposure_is_in_exif(tmp_path: Path, frame: Frame) -> None:
    save(frame, tmp_path / "a.dng")
    exif = tags_of(tmp_path / "a.dng")[34665]
    assert exif["ExposureTime"] == (1, 100)
    assert exif["FNumber"] == (28, 5)
    assert exif["RecommendedExposureIndex"] == 200
    assert exif["DateTimeOriginal"] == "2021:03:04 05:06:07"
    assert exif["LensModel"] == "f/5.6"


@pytest.mark.parametrize("time_s", [1e-6, 1 / 3, 3600.0])
def test_extreme_exposures_are_kept(tmp_path: Path, make_frame: MakeFrame, time_s: float) -> None:
    save(make_frame(time_s=time_s, iso=409600.0), tmp_path / "a.dng")
    exif = tags_of(tmp_path / "a.dng")[34665]
    assert float(Fraction(*exif["ExposureTime"])) == pytest.approx(time_s, rel=1e-9)
    assert exif["RecommendedExposureIndex"] == 409600


@pytest.mark.parametrize("product", ["mosaic", "truth"])
def test_readers_of_the_formats_version_1_1_are_not_sent_away(tmp_path: Path, frame: Frame, product: str) -> None:
    """One that is older than DNGBackwardVersion must not read the file; nothing in ours asks for more than 1.1."""
    save(frame, tmp_path / "a.dng", product=product)
    tags = tags_of(tmp_path / "a.dng")
    version, oldest = (tuple(bytes(tags[number])) for number in (50706, 50707))
    assert oldest == (1, 1, 0, 0) <= version


def test_xmp_carries_the_whole_description(tmp_path: Path, frame: Frame) -> None:
    save(frame, tmp_path / "a.dng")
    xmp = bytes(tags_of(tmp_path / "a.dng")[700]).decode()
    tree = ElementTree.fromstring(xmp[xmp.index("<x:xmpmeta") : xmp.index("<?xpacket end")])
    (properties,) = tree.iter("{http://www.w3.org/1999/02/22-rdf-syntax-ns#}Description")

    def prop(name: str) -> str | None:
        return properties.get(f"{{{XMP_NAMESPACE}}}{name}")

    assert prop("Seed") == str(2**40 + 1)
    assert prop("ErrorEstimate") == "3.2e-07"
    assert prop("Tolerance") == "1e-06"
    record = json.loads(properties.findtext(f"{{{XMP_NAMESPACE}}}Record"))
    assert record["description"] == frame.description
    assert record["seed"] == 2**40 + 1
    assert record["error_estimate"] == 3.2e-7
    assert record["description_sha256"] == prop("DescriptionSHA256")


def test_the_identifier_follows_the_content(tmp_path: Path, frame: Frame) -> None:
    def identifier(each: Frame) -> bytes:
        save(each, tmp_path / "a.dng", force=True)
        return bytes(tags_of(tmp_path / "a.dng")[50781])

    other = frame.mosaic.copy()
    other[-1, -1] ^= 1
    described = {**frame.description, "note": "another"}
    three = {
        identifier(frame),
        identifier(dataclasses.replace(frame, mosaic=other)),
        identifier(dataclasses.replace(frame, description=described)),
    }
    assert len(three) == 3
    assert identifier(frame) in three


def test_names_beyond_ascii_are_written_in_ascii(tmp_path: Path, make_frame: MakeFrame) -> None:
    save(make_frame(camera_name="Größe 4.88 µm 相机"), tmp_path / "a.dng")
    tags = tags_of(tmp_path / "a.dng")
    assert tags[271] == "camsim"
    assert tags[272] == "Groe 4.88 um"
    assert tags[50708] == "camsim Groe 4.88 um"


@pytest.mark.parametrize("size", [(48, 66), (49, 67), (700, 30)])
def test_the_truth_is_linear_raw_of_16_bits(tmp_path: Path, make_frame: MakeFrame, size: tuple[int, int]) -> None:
    frame = make_frame(*size)
    save(frame, tmp_path / "a.dng", product="truth")
    expected = np.minimum(frame.truth.astype(np.float64) / ((4023 - 128) * 10) * 65535, 65535)
    assert (expected == 65535).any()
    read = tifffile.imread(tmp_path / "a.dng")
    assert read.dtype == np.uint16
    # Half a code, and what single precision rounds.
    assert np.abs(read - expected).max() <= 0.51
    tags = tags_of(tmp_path / "a.dng")
    assert (tags[262], tags[277], tags[50714], tags[50717]) == (34892, 3, (0, 1) * 3, (65535,) * 3)


def test_libraw_develops_the_truth_as_it_does_the_mosaic(tmp_path: Path, frame: Frame) -> None:
    flat = np.broadcast_to(np.array([9000.0, 16000.0, 11000.0], np.float32), (48, 66, 3))
    codes = np.rint(128 + np.take_along_axis(flat, frame.channel_index[:, :, None].astype(int), axis=2) / 10)
    even = dataclasses.replace(frame, truth=flat, mosaic=codes[:, :, 0].astype(np.uint16))
    save(even, tmp_path / "mosaic.dng")
    save(even, tmp_path / "truth.dng", product="truth")
    one, other = (developed(tmp_path / f"{name}.dng", "sRGB") for name in ("mosaic", "truth"))
    # The mosaic's codes are whole numbers of 3895.
    np.testing.assert_allclose(one, other, atol=1e-3)


def test_the_truth_of_mono_is_grey(tmp_path: Path, mono_frame: Frame) -> None:
    save(mono_frame, tmp_path / "a.dng", product="truth")
    with rawpy.imread(str(tmp_path / "a.dng")) as raw:
        codes = np.minimum(mono_frame.truth[:, :, 0] / 38950 * 65535, 65535)
        assert np.abs(raw.raw_image_visible - codes).max() <= 0.51


def test_the_truth_of_other_channels_is_no_dng(tmp_path: Path, frame: Frame) -> None:
    four = dataclasses.replace(frame, channels=("R", "G", "B", "W"), truth=np.zeros((48, 66, 4), np.float32))
    with pytest.raises(OutputError, match="holds red, green and blue, and this camera has R, G, B, W"):
        save(four, tmp_path / "a.dng", product="truth")


@pytest.mark.parametrize("pattern", ["RRGG RRGG GGBB GGBB", "RG BG", "RGB"])
def test_odd_arrays_are_written_when_insisted_on(tmp_path: Path, make_frame: MakeFrame, pattern: str) -> None:
    frame = make_frame(48, 66, pattern)
    save(frame, tmp_path / "a.dng", allow_odd_cfa=True)
    tags = tags_of(tmp_path / "a.dng")
    rows = pattern.split()
    assert tags[33421] == (len(rows), len(rows[0]))
    assert list(bytes(tags[33422])) == ["RGB".index(letter) for letter in "".join(rows)]
    np.testing.assert_array_equal(tifffile.imread(tmp_path / "a.dng"), frame.mosaic)


def test_white_and_complementary_filters_have_their_codes(tmp_path: Path, frame: Frame) -> None:
    white = Curve(NODES_NM, sensitivities(frame).sum(axis=0) ** 2)
    given = frame.colour.quantum_efficiency
    colour = dataclasses.replace(
        frame.colour, quantum_efficiency=dataclasses.replace(given, curves=(*given.curves, ("W", white)))
    )
    letters = {"channels": ("R", "G", "B", "W"), "cfa_pattern": ("RG", "WB")}
    four = dataclasses.replace(frame, **letters, colour=colour, truth=None)
    save(four, tmp_path / "a.dng", allow_odd_cfa=True)
    tags = tags_of(tmp_path / "a.dng")
    assert list(bytes(tags[33422])) == [0, 1, 6, 2]
    assert list(bytes(tags[50710])) == [0, 1, 2, 6]
    assert len(tags[50722]) == 2 * 12
    strange = dataclasses.replace(four, channels=("R", "G", "B", "K"), cfa_pattern=("RG", "KB"))
    with pytest.raises(OutputError, match="no code for the colour filters K"):
        save(strange, tmp_path / "b.dng", allow_odd_cfa=True)


@pytest.mark.parametrize("pattern", ["RRGG RRGG GGBB GGBB", "RG BG", "RG GW", "RY YB", "RGB"])
def test_arrays_that_developers_misread_are_refused(tmp_path: Path, make_frame: MakeFrame, pattern: str) -> None:
    frame = make_frame()
    rows = tuple(pattern.split())
    with pytest.raises(OutputError, match=r"misread a DNG of the colour filter array .*; write a \.tiff"):
        save(dataclasses.replace(frame, cfa_pattern=rows), tmp_path / "a.dng")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("long", "said"), [(255, "raw developers misread"), (258, "a DNG cannot hold")])
def test_a_period_beyond_a_byte_cannot_be_written(long: int, said: str) -> None:
    across, down = (("RGB" * 86)[:long],), tuple(("RGB" * 86)[:long])
    assert str(odd_cfa(across)).startswith(said)
    assert str(odd_cfa(down)).startswith(said)


def test_more_than_4_gib_is_refused(tmp_path: Path, frame: Frame) -> None:
    # One row repeated by a stride of zero: 8 GB that take no memory.
    arrays = {name: getattr(frame, name) for name in ("mosaic", "mean_electrons", "electrons", "channel_index")}
    huge = {name: np.lib.stride_tricks.as_strided(array, (60000, 66 * 1000), (0, 0)) for name, array in arrays.items()}
    with pytest.raises(OutputError, match="a TIFF or DNG file holds 4 GiB at most"):
        save(dataclasses.replace(frame, **huge, truth=None), tmp_path / "a.dng")
