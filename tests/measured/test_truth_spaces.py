"""Truth in every space, against colour-science where the whole window shows one surface."""

import dataclasses

import numpy as np
import pytest

import camsim
from camsim.errors import UnknownNameError, UnsupportedError
from camsim.measure.truth import balanced, truth_in
from camsim.spectra.colour_science import colour_science


def flat(surface, light=None, lens=None, sensor="d40-like"):
    camera = camsim.Camera.from_yaml(sensor, lens=lens or camsim.Airy(f_number=8.0, transmission=0.7))
    return camsim.Capture(
        camera=camera,
        scene=camsim.Scene(background=camsim.reflectance(surface) if isinstance(surface, str) else surface),
        light=light or camsim.Light("D65", illuminance_lux=500.0),
        exposure=camsim.Exposure(time_s="auto", iso=200.0),
        region=camsim.Region(rows=8, cols=8),
        tolerance=1e-2,
    )


@pytest.mark.parametrize(("patch", "illuminant"), [("orange", "D65"), ("blue sky", "A")])
def test_colours_are_those_of_the_spectra(patch, illuminant):
    colour = colour_science()
    light = camsim.Light(illuminant, illuminance_lux=500.0)
    xyz = truth_in(flat(patch, light), "xyz")
    chart = {name.lower(): sd for name, sd in colour.SDS_COLOURCHECKERS["ISO 17321-1"].items()}
    shape = colour.SpectralShape(380, 780, 1)
    sd = chart[patch].copy().align(shape, extrapolator_kwargs={"method": "Constant"})
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape)
    lamp = colour.SDS_ILLUMINANTS[illuminant].copy().align(shape)
    expected = colour.sd_to_XYZ(sd, observer, lamp, method="Integration") / 100.0
    np.testing.assert_allclose(xyz.image[4, 4], expected, rtol=2e-3)
    white = colour.sd_to_XYZ(colour.sd_constant(1.0, shape), observer, lamp, method="Integration")
    xy = colour.XYZ_to_xy(white)
    rgb = colour.XYZ_to_RGB(
        expected, "sRGB", illuminant=xy, chromatic_adaptation_transform="Bradford", apply_cctf_encoding=False
    )
    np.testing.assert_allclose(truth_in(flat(patch, light), "srgb").image[4, 4], rgb, rtol=5e-3, atol=5e-4)


def test_a_grey_is_grey_in_every_space():
    capture = flat(0.5)
    rgb, srgb = truth_in(capture, "camera-rgb"), truth_in(capture, "srgb")
    np.testing.assert_allclose(rgb.image, 0.4, rtol=1e-5)  # "auto" puts a diffuser at 0.8
    np.testing.assert_allclose(srgb.image, 0.5, rtol=1e-5)
    np.testing.assert_allclose(rgb.diffuser, 0.8, rtol=1e-6)
    assert rgb.channels == ("R", "G", "B")
    assert "white clips" in repr(rgb)


def test_codes_are_the_truth_but_for_noise_dark_current_and_rounding():
    capture = flat("orange")
    frame = capture.frame(products=("mosaic", "truth"))
    truth = balanced(frame.truth, capture)
    np.testing.assert_array_equal(truth, truth_in(capture, "camera-rgb").image)
    span = frame.white_level_dn - frame.black_level_dn
    neutral = frame.truth.mean(axis=(0, 1)) / truth.mean(axis=(0, 1)) / frame.electrons_per_dn / span
    each = np.take_along_axis(truth, frame.channel_index[..., None].astype(int), axis=2)[..., 0]
    codes = (frame.mosaic.astype(float) - frame.black_level_dn) / span / neutral[frame.channel_index]
    for k in range(3):
        here = frame.channel_index == k
        noise = np.sqrt(frame.mean_electrons[here].mean() + 100.0) / (frame.electrons_per_dn * span * neutral[k])
        assert abs(codes[here].mean() - each[here].mean()) < 5 * noise / np.sqrt(here.sum())


@pytest.mark.parametrize("surface", [1.0, camsim.reflectance("orange")])
def test_points_given_in_electrons_have_the_colours_of_their_light(surface):
    lens, electrons = camsim.Gaussian(sigma_um=2.0), 30_000.0
    even = dataclasses.replace(flat(surface, lens=lens), tolerance=1e-5)
    one = even.frame(products=("truth",)).truth[4, 4].max()  # of a photosite full of that surface
    point = camsim.PointSource(electrons=electrons, reflectance=surface)
    dark = dataclasses.replace(even, scene=camsim.Scene(background=0.0, shapes=[point]))
    for space in ("xyz", "srgb"):
        expected = truth_in(even, space).image[4, 4] * electrons / one
        np.testing.assert_allclose(truth_in(dark, space).image.sum(axis=(0, 1)), expected, rtol=1e-4)


def test_mono_cameras_have_colours_too():
    truth = truth_in(flat("orange", sensor="mono-345"), "xyz")
    assert truth.image.shape == (8, 8, 3)


def test_what_cannot_be():
    with pytest.raises(UnknownNameError, match=r"unknown space 'sRGB'.*srgb"):
        truth_in(flat(0.5), "sRGB")
    infrared = camsim.Light(line_nm=900.0, irradiance_w_per_m2=1.0)
    with pytest.raises(UnsupportedError, match="the eye sees nothing"):
        truth_in(flat(0.5, infrared, sensor="mono-345"), "xyz")
