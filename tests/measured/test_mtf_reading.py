"""Other people's files: a DNG with its mosaic in a sub-directory, its own black levels and a border."""

import numpy as np
import pytest
import tifffile
from edges import gaussian_edge, gaussian_limit

import camsim
from camsim.measure import CameraOtf, EdgeLine, Roi, measure_mtf, read_picture


def foreign_dng(path):
    """A BGGR mosaic behind a thumbnail, 8 rows and 6 columns of border, a black level for each filter."""
    scene = gaussian_edge(96, 96, 5, 0.8)
    black = np.array([[100, 200], [300, 400]])
    gain = np.array([[8000, 16000], [16000, 12000]])
    where = np.indices((96, 96)) % 2
    codes = np.rint(black[where[0], where[1]] + gain[where[0], where[1]] * scene).astype(np.uint16)
    raw = np.full((104, 102), 65535, np.uint16)
    raw[8:, 6:] = codes
    tags = [
        (33421, "H", 2, (2, 2), True),
        (33422, "B", 4, bytes([2, 1, 1, 0]), True),
        (50713, "H", 2, (2, 2), True),
        (50714, "I", 4, (100, 200, 300, 400), True),
        (50717, "I", 1, 60000, True),
        (50829, "I", 4, (8, 6, 104, 102), True),
    ]
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


def test_a_capture_with_a_gaussian_lens_has_its_theory():
    camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Gaussian.from_mtf50(0.1))
    square = camsim.Rectangle(width_um=345.0, height_um=345.0, centre_um=(172.5, 0.0), reflectance=0.9)
    theory = CameraOtf(
        camera=camera,
        scene=camsim.Scene(background=0.1, shapes=[square]),
        light=camsim.Light("D55", illuminance_lux=5000),
    )
    line = EdgeLine(x_pixel=0.5 * camera.cols, y_pixel=0.5 * camera.rows, normal_rad=0.0)
    got = theory.along_normal(np.array([0.0, 0.345]), channel="Y", line=line)
    np.testing.assert_allclose(got, [1.0, 0.5 * np.sinc(0.345)], rtol=1e-12)


@pytest.mark.parametrize("sensor", ["d40-like", "x-trans-376", "mono-345"])
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
