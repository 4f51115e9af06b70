"""Other people's files: a DNG with its mosaic in a sub-directory, its own black levels and a border."""

import imagecodecs
import numpy as np
import OpenEXR
import pytest
import tifffile
from edges import gaussian_edge, gaussian_limit

import camsim
from camsim.errors import CamsimError
from camsim.measure import Roi, measure_mtf, read_picture

EDGE = gaussian_edge(96, 96, 5, 0.8)


def foreign_dng(path):
    """A BGGR mosaic behind a thumbnail, 8 rows and 6 columns of border, a black level for each filter."""
    black = np.array([[100, 200], [300, 400]])
    gain = np.array([[8000, 16000], [16000, 12000]])
    where = np.indices((96, 96)) % 2
    codes = np.rint(black[where[0], where[1]] + gain[where[0], where[1]] * EDGE).astype(np.uint16)
    raw = np.full((104, 102), 65535, np.uint16)
    raw[8:, 6:] = codes
    tags = [(33421, "H", 2, (2, 2), True), (33422, "B", 4, bytes([2, 1, 1, 0]), True), (50713, "H", 2, (2, 2), True)]
    tags += [(50714, "I", 4, (100, 200, 300, 400), True), (50717, "I", 1, 60000, True)]
    tags += [(50829, "I", 4, (8, 6, 104, 102), True)]
    with tifffile.TiffWriter(path) as tiff:
        version = [(50706, "B", 4, bytes([1, 4, 0, 0]), True)]
        thumbnail = np.zeros((16, 16, 3), np.uint8)
        tiff.write(thumbnail, subfiletype=1, subifds=1, photometric="rgb", extratags=version, metadata=None)
        tiff.write(raw, subfiletype=0, photometric=32803, extratags=tags, metadata=None)


def test_the_mosaic_of_a_foreign_dng(tmp_path):
    foreign_dng(tmp_path / "a.dng")
    picture = read_picture(tmp_path / "a.dng")
    assert picture.shape == (96, 96)
    assert picture.description is None
    levels = {plane.name: (plane.first, plane.black, plane.white) for plane in picture.planes}
    assert levels == {
        "R": ((1, 1), 400, 60000),
        "G1": ((1, 0), 300, 60000),
        "G2": ((0, 1), 200, 60000),
        "B": ((0, 0), 100, 60000),
    }
    for edge in measure_mtf(picture, rois=[Roi(0, 0, 96, 96)]).edges:
        assert edge.figures.mtf50_cycles_per_pixel == pytest.approx(gaussian_limit(0.5, 0.8), rel=1e-3)
        assert edge.figures.contrast == pytest.approx(0.8, abs=1e-3)


@pytest.mark.parametrize("sensor", ["x-trans-376", "mono-345"])
def test_lossless_jpeg_is_read_as_the_uncompressed_file(tmp_path, sensor):
    camera = camsim.Camera.from_yaml(sensor, lens=camsim.Airy(f_number=8.0))
    frame = camera.expose(
        camsim.Scene(background=0.5),
        light=camsim.Light("D55", illuminance_lux=5000),
        exposure=camsim.Exposure(time_s=0.01, iso=200),
        region=camsim.Region(rows=145, cols=97, origin=(11, 12)),
    )
    for name, compress in (("a.dng", False), ("b.dng", True)):
        camsim.save(frame, tmp_path / name, compress=compress)
    one, other = (read_picture(tmp_path / name) for name in ("a.dng", "b.dng"))
    assert len(one.planes) == len(other.planes)
    for plane, packed in zip(one.planes, other.planes, strict=True):
        np.testing.assert_array_equal(plane.samples, packed.samples)
        assert (plane.name, plane.first, plane.black) == (packed.name, packed.first, packed.black)


def dng(path, image, *tags, photometric=32803):
    """Write a DNG of another program: a mosaic of RGGB, or linear planes."""
    filters = [(33421, "H", 2, (2, 2), True), (33422, "B", 4, bytes((0, 1, 1, 2)), True)]
    version = [(50706, "B", 4, bytes((1, 4, 0, 0)), True)]
    extra = [*version, *(filters if photometric == 32803 else []), *((*tag, True) for tag in tags)]
    tifffile.imwrite(path, image, photometric=photometric, extratags=extra, metadata=None)
    return path


def fractions(values):
    return tuple(part for value in values for part in (round(8 * value), 8))


def test_black_levels_of_columns_and_rows(tmp_path):
    """BlackLevelDeltaH and -V; full ones stay full where black is high, and others are not where it is low."""
    across, down = (np.round(8 * np.linspace(*ends, 96)) / 8 for ends in ((-90.0, 150.0), (120.0, -60.0)))
    codes = np.rint(200.0 + down[:, None] + across + 4000.0 * EDGE).astype(np.uint16)
    codes[::2, :6] = 0
    codes[:40:2, 90:] = 4095
    tags = [(50714, "H", 1, 200), (50717, "H", 1, 4095)]
    tags += [(50715, "2i", 96, fractions(across)), (50716, "2i", 96, fractions(down))]
    picture = read_picture(dng(tmp_path / "a.dng", codes, *tags))
    for plane in picture.planes:
        where = tuple(slice(first, None, step) for first, step in zip(plane.first, plane.step, strict=True))
        np.testing.assert_array_equal(plane.samples >= plane.white, codes[where] == 4095)
        np.testing.assert_array_equal(plane.samples <= plane.lowest, codes[where] == 0)
        inside = (codes[where] > 0) & (codes[where] < 4095)
        off = plane.samples - plane.black - 4000.0 * EDGE[where]
        np.testing.assert_allclose(off[inside], 0.0, rtol=0, atol=0.501)
    for edge in measure_mtf(picture, rois=[Roi(40, 6, 56, 84)]).edges:
        assert edge.figures.mtf50_cycles_per_pixel == pytest.approx(gaussian_limit(0.5, 0.8), rel=2e-3)


def test_levels_of_linear_planes_are_each_planes_own(tmp_path):
    """DNG 1.7: WhiteLevel and BlackLevel by sample, the latter a rectangle of them as well."""
    image = np.full((6, 8, 3), 1000, np.uint16)
    levels = (50717, "H", 3, (4000, 3000, 2000))
    planes = read_picture(dng(tmp_path / "a.dng", image, levels, (50714, "H", 3, (1, 2, 3)), photometric=34892)).planes
    assert [(plane.name, plane.black, plane.white) for plane in planes] == [
        ("R", 1, 4000), ("G", 2, 3000), ("B", 3, 2000)
    ]  # fmt: skip
    tiled = [(50713, "H", 2, (1, 2)), (50714, "H", 6, (1, 2, 3, 11, 22, 33))]
    planes = read_picture(dng(tmp_path / "b.dng", image, levels, *tiled, photometric=34892)).planes
    for plane, even, odd in zip(planes, (1, 2, 3), (11, 22, 33), strict=True):
        np.testing.assert_array_equal(plane.samples - plane.black, np.tile([1000 - even, 1000 - odd], (6, 4)))
    with pytest.raises(CamsimError, match="it has 2 white levels for 3 samples"):
        read_picture(dng(tmp_path / "c.dng", image, (50717, "H", 2, (4000, 3000)), photometric=34892))


def test_levels_that_a_dng_leaves_out(tmp_path):
    """White is 1 of floating-point numbers, and the largest of the bits of whole ones."""
    light = EDGE.astype(np.float32)
    for image, white in ((light, 1.0), (np.rint(60000 * EDGE).astype(np.uint16), 65535.0)):
        assert {plane.white for plane in read_picture(dng(tmp_path / "a.dng", image)).planes} == {white}


@pytest.mark.parametrize(
    ("tag", "said"),
    [
        ((50711, "H", 1, 2), r"shifted by half of one \(CFALayout 2\), and only rectangular arrays are measured"),
        ((50715, "2i", 5, (1, 1) * 5), "it has black levels of 5 columns, and its active area has 96"),
        ((50716, "2i", 97, (1, 1) * 97), "it has black levels of 97 rows, and its active area has 96"),
    ],
)
def test_levels_and_layouts_that_cannot_be_are_refused(tmp_path, tag, said):
    with pytest.raises(CamsimError, match=said):
        read_picture(dng(tmp_path / "a.dng", np.rint(4000 * EDGE).astype(np.uint16), tag))


@pytest.mark.parametrize("channels", [2, 3, 4])
def test_sixteen_bits_of_a_png_are_all_read(tmp_path, channels):
    """Their low bytes were dropped (MTF50 0.2687 for 0.2807 of a faint edge), and they were said to be 8."""
    codes = np.rint(3000 + 600 * EDGE).astype(np.uint16)
    image = np.dstack([codes] * (channels - 1) + [np.full_like(codes, 65535) if channels % 2 == 0 else codes])
    (tmp_path / "a.png").write_bytes(imagecodecs.png_encode(image))
    picture = read_picture(tmp_path / "a.png")
    assert [plane.name for plane in picture.planes] == (["Y"] if channels == 2 else ["R", "G", "B"])
    for plane in picture.planes:
        np.testing.assert_array_equal(plane.samples, codes)
    if channels % 2 == 0:
        image[5, 5, -1] = 65534
        (tmp_path / "a.png").write_bytes(imagecodecs.png_encode(image))
        with pytest.raises(CamsimError, match=r"it is transparent in places \(alpha\)"):
            read_picture(tmp_path / "a.png")


@pytest.mark.parametrize("name", ["a.tiff", "a.npy", "a.npz", "a.exr"])
def test_what_alpha_hides_is_not_measured(tmp_path, name):
    image = np.dstack([EDGE, EDGE, EDGE, np.ones_like(EDGE)]).astype(np.float32)
    for hidden in (False, True):
        image[7, 9, 3] = 0.5 if hidden else 1.0
        if name == "a.exr":
            pixels = {letter: image[..., k].copy() for k, letter in enumerate("RGBA")}
            OpenEXR.File({"type": OpenEXR.scanlineimage}, pixels).write(str(tmp_path / name))
        elif name == "a.tiff":
            tifffile.imwrite(tmp_path / name, image, photometric="rgb", extrasamples=["unassalpha"])
        else:
            (np.save if name == "a.npy" else np.savez)(tmp_path / name, image)
        if not hidden:
            assert [plane.name for plane in read_picture(tmp_path / name).planes] == ["R", "G", "B"]
            continue
        with pytest.raises(CamsimError, match=r"it is transparent in places \(alpha\)"):
            read_picture(tmp_path / name)


@pytest.mark.parametrize("letters", ["RGBW", "RGBA"])
def test_no_filter_is_taken_for_alpha(tmp_path, letters):
    """The fourth of the truth's channels was left out where it had an electron or more everywhere."""
    sensor = f"cfa: {{kind: letters, pattern: [{letters[:2]}, {letters[2:]}]}}"
    even = "{wavelength_nm: [380, 780], values: [1, 1], outside: zero}"
    curves = f"quantum_efficiency: {{per: photon, peak: 0.5, curves: {{{', '.join(f'{c}: {even}' for c in letters)}}}}}"
    changes = [f"sensor.{change.replace(': ', '=', 1)}" for change in (sensor, curves)]
    frame = camsim.capture("flat-field", overrides=[*changes, "region={rows: 4, cols: 4}"], products=("truth",))
    assert frame.truth.min() > 1000.0
    for name, names in (("t.exr", list(letters)), ("t.npy", ["C1", "C2", "C3", "C4"])):
        frame.save(tmp_path / name, product="truth")
        picture = read_picture(tmp_path / name)
        assert [plane.name for plane in picture.planes] == names
        for k, plane in enumerate(picture.planes):
            np.testing.assert_array_equal(plane.samples, frame.truth[..., k])


@pytest.mark.parametrize("bits", [10, 12, 14])
def test_the_largest_number_of_packed_bits_is_white(tmp_path, bits):
    """Clipped, it had MTF50 0.2217 for 0.18, and --gamma took it for nearly black."""
    most = (1 << bits) - 1
    codes = np.minimum(np.rint(1.15 * most * EDGE), most).astype(np.uint16)
    how = {"photometric": "minisblack", "bitspersample": bits}
    tifffile.imwrite(tmp_path / "a.tiff", codes, **how)
    with pytest.raises(CamsimError, match=rf"photosites are clipped highlights \(at {most} or above\)"):
        measure_mtf(read_picture(tmp_path / "a.tiff"), rois=[Roi(0, 0, 96, 96)])
    encoded = np.rint(most * EDGE ** (1 / 2.2)).astype(np.uint16)
    tifffile.imwrite(tmp_path / "b.tiff", encoded, **how)
    (plane,) = read_picture(tmp_path / "b.tiff", gamma=2.2).planes
    np.testing.assert_allclose(plane.samples, EDGE, rtol=0, atol=2.0 / most)


def test_the_image_of_a_tiff_is_its_largest_page(tmp_path):
    """A thumbnail that does not say that it is one was measured, and the first of many frames."""
    image = np.rint(50000 * EDGE).astype(np.uint16)
    pages = [(image[::4, ::4], 0), (image, 0), (np.tile(image, (2, 2)), 1), (image[::2, ::2], 1)]
    how = {"photometric": "minisblack", "metadata": None}
    for name, written in (("a.tiff", pages), ("b.tiff", [*pages, (image, 0)])):
        with tifffile.TiffWriter(tmp_path / name) as tiff:
            for page, kind in written:
                tiff.write(page, subfiletype=kind, **how)
    (plane,) = read_picture(tmp_path / "a.tiff").planes
    np.testing.assert_array_equal(plane.samples, image)
    for read in (read_picture, lambda path: camsim.read_picture(path, width_um=1.0, encoding="linear")):
        with pytest.raises(CamsimError, match=r"it holds 2 pages of one size, and nobody knows which is meant"):
            read(tmp_path / "b.tiff")


def test_options_that_a_file_has_no_use_for_are_refused(tmp_path):
    """They were ignored, or obeyed against what the file says."""
    small = ["region={rows: 8, cols: 8}"]
    frame = camsim.capture("flat-field", sensor="d40-like", overrides=small, products=("mosaic", "truth"))
    for name in ("a.dng", "a.exr"):
        frame.save(tmp_path / name)
    for name, option, sentence in (
        ("a.dng", {"gamma": 2.2}, r"gamma: a \.dng is linear; leave it out"),
        ("a.dng", {"layer": "mean"}, r"layer: a \.dng has none; leave it out"),
        ("a.dng", {"cfa": "BGGR"}, "cfa: 'BGGR', and the file says RG/GB; leave it out"),
        ("a.exr", {"cfa": "RGGB"}, "cfa: it has a plane for each channel, and no filter array; leave it out"),
    ):
        with pytest.raises(CamsimError, match=sentence):
            read_picture(tmp_path / name, **option)
    assert [plane.name for plane in read_picture(tmp_path / "a.dng", cfa="RGGB").planes] == ["R", "G1", "G2", "B"]
