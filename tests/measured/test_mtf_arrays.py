"""Filter arrays beyond Bayer's, measured per channel straight from the mosaic, and black levels by position."""

import dataclasses
import math

import numpy as np
import pytest
from edges import gaussian_edge, gaussian_limit, gaussian_mtf, gaussian_sigma
from scipy import special

import camsim
from camsim.errors import InvalidValueError, UnsupportedError
from camsim.measure import CameraOtf, Picture, Roi, measure_edge, measure_mtf, picture_of_frame, read_picture
from camsim.measure.find import find_edges
from camsim.measure.picture import mosaic_planes
from camsim.sensor.cfa import Cfa

ARRAYS = {
    "x-trans": (Cfa.named("x-trans"), {"R": 8 / 36, "G": 20 / 36, "B": 8 / 36}),
    "quad-bayer": (Cfa.quad_bayer("RGGB"), {"R": 1 / 4, "G1": 1 / 4, "G2": 1 / 4, "B": 1 / 4}),
    "nona-bayer": (Cfa.quad_bayer("GBRG", group=3), {"R": 1 / 4, "G1": 1 / 4, "G2": 1 / 4, "B": 1 / 4}),
    "rgbw": (Cfa.named("rgbw"), {"R": 1 / 8, "G": 1 / 4, "B": 1 / 8, "W": 1 / 2}),
}


def picture_of(image, pattern, **levels):
    return Picture(name="x", shape=image.shape, planes=mosaic_planes(image, pattern, **levels))


@pytest.mark.parametrize(
    ("array", "angle", "mtf50"),
    [
        (array, a, (0.10, 0.25, 0.40)[(i + k) % 3])  # every pair of the three
        for i, array in enumerate(ARRAYS)
        for k, a in enumerate((5, 43, -20, 184))
    ],
)
def test_an_edge_in_closed_form(array, angle, mtf50):
    """Every channel of every array, as the Bayer ones: |ΔMTF| ≤ 0.002 up to Nyquist, MTF50 within 0.1 %."""
    cfa, density = ARRAYS[array]
    sigma = gaussian_sigma(mtf50)
    image = gaussian_edge(96, 96, angle, sigma)
    # A window may begin anywhere in the array.
    picture = picture_of(image, cfa.window_pattern((1, 2)))
    channels = picture.select("all")
    assert {channel.name for channel in channels} == set(density)
    for channel in channels:
        assert channel.inside(Roi(0, 0, 96, 96)).signal.size == pytest.approx(96 * 96 * density[channel.name])
        edge = measure_edge(channel, Roi(0, 0, 96, 96))
        f, nyquist = edge.frequency_cycles_per_pixel, edge.nyquist_cycles_per_pixel
        assert nyquist == pytest.approx(0.5 * math.sqrt(density[channel.name]))
        assert np.abs(edge.mtf - gaussian_mtf(f, sigma))[f <= nyquist].max() < 2e-4
        assert edge.figures.mtf50_cycles_per_pixel == pytest.approx(mtf50, rel=5e-4)
        assert edge.figures.angle_deg == pytest.approx((angle + 45) % 90 - 45, abs=2e-3)


@pytest.mark.parametrize("array", ["quad-bayer", "x-trans", "rgbw"])
@pytest.mark.parametrize("roi", [Roi(0, 0, 48, 60), Roi(5, 7, 40, 36)])
def test_every_photosite_is_where_its_centre_is(array, roi):
    """An image of its own coordinates, photosite (0, 0) having its centre at (½, ½)."""
    y, x = np.mgrid[:48, :60] + 0.5
    pattern, inside = ARRAYS[array][0].window_pattern((1, 2)), np.s_[roi.row : roi.row + roi.rows, :]
    counted = 0
    for channel in picture_of(x + 100.0 * y, pattern, black=10.0).select("all"):
        found = channel.inside(roi)
        np.testing.assert_array_equal(found.signal, found.x + 100.0 * found.y - 10.0)
        np.testing.assert_array_equal(found.stored, found.x + 100.0 * found.y)
        assert (roi.col < found.x).all()
        assert (found.x < roi.col + roi.cols).all()
        assert np.isin(found.y, y[inside]).all()
        counted += found.signal.size
    assert counted == roi.rows * roi.cols


@pytest.mark.parametrize("array", ["x-trans", "rgbw", "bayer"])
def test_the_picture_that_edges_are_looked_for_in_is_in_its_place(array):
    """Of several lattices it is smoothed: exact in the mean, within what an uneven pattern moves it."""
    y, x = np.mgrid[:60, :72] + 0.5
    pattern = ("RG", "GB") if array == "bayer" else ARRAYS[array][0].pattern
    for image, axis in ((x, 1), (y, 0)):
        for channel in picture_of(image, pattern).select("all"):
            smooth, across, down = channel.on_a_lattice(Roi(6, 8, 50, 60))
            expected = np.broadcast_to(across if axis == 1 else down[:, None], smooth.shape)
            middle = np.s_[8:-8, 8:-8] if len(channel.planes) > 1 else np.s_[:, :]
            assert abs((smooth - expected)[middle].mean()) < 0.15
            assert np.abs((smooth - expected)[middle]).max() < (0.6 if len(channel.planes) > 1 else 1e-12)


def test_phases_that_hardly_come_again_are_refused():
    """Columns 4 px apart: an edge of 2.5° has to be longer than 96 px to pass over all of them twice."""
    picture = picture_of(gaussian_edge(96, 96, 2.5, 0.5), ARRAYS["nona-bayer"][0].pattern)
    with pytest.raises(UnsupportedError, match=r"take a region \d+ px long, or turn the edge to 3° or more"):
        measure_mtf(picture, rois=[Roi(0, 0, 96, 96)], channel="R")


@pytest.mark.parametrize(
    ("sensor", "kernel"),
    [
        ("x-trans-376", None),
        ("phone-080", None),
        ("x-trans-376", ((0.0, 0.05, 0.0), (0.05, 0.8, 0.05), (0.0, 0.05, 0.0))),
        ("d40-like", ((0.0, 0.05, 0.0), (0.05, 0.8, 0.05), (0.0, 0.05, 0.0))),
        ("d40-like", ((0.0, 0.02, 0.0), (0.01, 0.7, 0.15), (0.0, 0.05, 0.0))),
        ("mono-345", ((0.0, 0.02, 0.0), (0.01, 0.7, 0.15), (0.0, 0.05, 0.0))),
    ],
)
def test_a_capture_without_noise_shows_its_optics(sensor, kernel):
    """And crosstalk, which tells the greens of a Bayer array apart where it is lopsided; the phone has some."""
    camera = camsim.Camera.from_yaml(sensor, lens=camsim.Airy(f_number=4.0))
    if kernel is not None:
        camera = camera.replace(crosstalk=camsim.Crosstalk(kernel))
    light, region = camsim.Light("D55", illuminance_lux=5000), camsim.Region(rows=96, cols=96)
    # Places of one channel that have other neighbours each show another edge; theory is their mean.
    several = camera.crosstalk is not None and len(camera.cfa.pattern) > 2
    scene = camsim.Scene(background=0.05, shapes=[camsim.HalfPlane(towards_deg=-20.0, reflectance=0.9)])
    exposure = camsim.Exposure(time_s=0.01, iso=200)
    frame = camera.expose(scene, light=light, exposure=exposure, region=region, noise=False)
    theory = CameraOtf(camera=camera, scene=scene, light=light, region=region)
    report = measure_mtf(picture_of_frame(frame, "mean_electrons"), rois=[Roi(0, 0, 96, 96)], theory=theory)
    assert {edge.channel[0] for edge in report.edges} == ({"Y"} if sensor == "mono-345" else {"R", "G", "B"})
    for edge in report.edges:
        assert edge.theory is not None
        assert edge.theory.difference_to_nyquist < (2e-2 if several else 2e-3)
        assert edge.figures.mtf50_cycles_per_pixel == pytest.approx(
            edge.theory.mtf50_cycles_per_pixel, rel=1e-2 if several else 1e-3
        )


@pytest.mark.parametrize(("array", "sigma"), [("x-trans", 0.7), ("quad-bayer", 6.0), ("mono", 6.0)])
def test_edges_are_found_sharp_or_blurred(array, sigma):
    """All four sides of a square; a blurred edge's skirts are no edges of others."""
    y, x = np.mgrid[:420, :420] + 0.5 - 210
    turn = math.radians(7)
    u, v = x * math.cos(turn) + y * math.sin(turn), y * math.cos(turn) - x * math.sin(turn)
    image = 0.9 - 0.8 * _step(u + 110, sigma) * _step(110 - u, sigma) * _step(v + 110, sigma) * _step(110 - v, sigma)
    cfa = Cfa.named(array) if array != "quad-bayer" else Cfa.quad_bayer()
    picture = picture_of(image, cfa.pattern)
    assert len(find_edges(picture).edges) == 4
    for edge in measure_mtf(picture, channel="Y" if array == "mono" else "R").edges:
        assert edge.figures.mtf50_cycles_per_pixel == pytest.approx(gaussian_limit(0.5, sigma), rel=1e-3)


def _step(distance, sigma):
    return special.ndtr(distance / sigma)


@pytest.mark.parametrize("sensor", ["mono-345", "d40-like"])
def test_black_levels_that_differ_by_photosite(sensor, tmp_path):
    """In a Frame and in files: taken for one level they would pass for noise and for light."""
    camera = camsim.Camera.from_yaml(sensor, lens=camsim.Airy(f_number=8.0))
    black = ((0, 40), (80, 120))
    uneven = camera.replace(adc=dataclasses.replace(camera.adc, black_offsets_dn=black))
    turned = camsim.Rectangle(width_um=600.0, height_um=4000.0, rotate_deg=5, centre_um=(300.0, 0.0), reflectance=0.1)
    found = []
    for each in (camera, uneven):
        frame = each.expose(
            camsim.Scene(background=0.9, shapes=[turned]),
            light=camsim.Light("D55", illuminance_lux=5000),
            exposure=camsim.Exposure(time_s="auto", iso=camera.adc.base_iso),
            region=camsim.Region(rows=64, cols=64, origin=(camera.rows // 2 - 33, camera.cols // 2 - 32)),
            noise=False,
        )
        for name in ("a.dng", "a.tiff", "a.npz"):
            camsim.save(frame, tmp_path / name, force=True)
        pictures = [picture_of_frame(frame), *(read_picture(tmp_path / name) for name in ("a.dng", "a.tiff", "a.npz"))]
        found.append([measure_mtf(picture, rois=[Roi(0, 0, 64, 64)], channel="all").edges for picture in pictures])
    even, uneven_edges = found
    for before, after in zip(sum(even, ()), sum(uneven_edges, ()), strict=True):
        assert after.channel == before.channel
        assert after.figures.contrast == pytest.approx(before.figures.contrast, abs=2e-4)
        assert after.figures.snr > 100
        assert after.figures.mtf50_cycles_per_pixel == pytest.approx(before.figures.mtf50_cycles_per_pixel, rel=3e-3)


def test_the_array_of_a_file_that_does_not_say_it(tmp_path):
    cfa, sigma = Cfa.named("x-trans"), 0.8
    np.save(tmp_path / "a.npy", gaussian_edge(96, 96, 5, sigma))
    rows = "/".join(cfa.pattern)
    for said in ("x-trans", rows, rows.lower()):
        picture = read_picture(tmp_path / "a.npy", cfa=said)
        assert [channel.name for channel in picture.select("all")] == ["R", "G", "B"]
    with pytest.raises(InvalidValueError, match=r"cfa: 'RGBX'; give one of RGGB, .* x-trans, .* RRGG/RRGG/GGBB/GGBB"):
        read_picture(tmp_path / "a.npy", cfa="RGBX")


@pytest.mark.parametrize(("rows", "cols"), [(0, 0), (1, 2), (2, 3), (3, 1)])
def test_a_window_of_a_quad_bayer_array_keeps_the_names_of_its_filters(rows, cols):
    """G1 is in the rows of red wherever the window begins."""
    whole = np.array([list(row) for row in ("RRGG", "RRGG", "GGBB", "GGBB")])
    names = np.array([["R", "R", "G1", "G1"]] * 2 + [["G2", "G2", "B", "B"]] * 2)
    pattern = ["".join(row) for row in np.roll(whole, (-rows, -cols), axis=(0, 1))]
    planes = mosaic_planes(np.zeros((8, 8)), pattern)
    assert {plane.name for plane in planes} == {"R", "G1", "G2", "B"}
    for plane in planes:
        row, col = plane.first
        assert plane.name == names[(row + rows) % 4, (col + cols) % 4]
