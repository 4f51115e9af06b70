"""Laws of rendering: what OLPF, photosite and wavelength do, from renderings without them."""

import numpy as np
import pytest
from examples import (
    ARROW,
    BACKGROUND,
    OPTICS,
    PICTURE,
    PITCH_UM,
    TOLERANCE,
    TRIANGLE,
    WAVELENGTH_NM,
    grid_of,
    image_of,
    moved,
    scene_of,
    worst,
)
from tolerances import METHOD, ROUNDING

import camsim
from camsim.optics import OpticalSystem
from camsim.rendering import render_channels
from tests.truth import rays


def box(side):
    return camsim.SquarePhotosite(side_um=side * PITCH_UM)


def spots(split):
    return camsim.FourSpotOlpf(split_um=split * PITCH_UM)


@pytest.mark.parametrize(("f_number", "split", "side"), [(1.4, 0.31, 0.6), (8.0, 2.5, 1.0), (48.0, 1.0, 0.0)])
def test_an_olpf_is_the_mean_of_four_images(f_number, split, side):
    """A photosite with spots at ±d/2 sees what one without sees of the scene shifted by ∓d/2, four times."""
    lens = camsim.Airy(f_number=f_number)
    half = 0.5 * split
    shifted = [
        image_of(moved(PICTURE, shift=(dx, dy)), [lens, box(side)]) for dx in (-half, half) for dy in (-half, half)
    ]
    assert worst(image_of(PICTURE, [lens, spots(split), box(side)]), np.mean(shifted, axis=0)) <= METHOD * TOLERANCE


def test_energy():
    """With fill factor 1 the frame is one large detector: what it catches of a bright rectangle, all told.

    By reciprocity that is the integral over the rectangle of the share of a point's light that falls on the
    frame (on the frame shifted by each of the spots), and a point's share follows from rays to its border.
    What misses a frame of 40 × 48 is 2λN/(π²r) ≈ 1 % of the light: far more than is allowed here.
    """
    tolerance, split = 1e-7, 0.75
    rows, cols, width, height = 40, 48, 3.0, 2.0
    rectangle = np.array([(0.7, -4.1), (3.7, -4.1), (3.7, -2.1), (0.7, -2.1)])
    optics = [camsim.Airy(f_number=8.0), box(1.0), spots(split)]
    caught = image_of([(rectangle, 1.0)], optics, rows, cols, background=0.0, tolerance=tolerance).sum()

    frame = 0.5 * np.array([(-cols, -rows), (cols, -rows), (cols, rows), (-cols, rows)])
    x, w = np.polynomial.legendre.leggauss(8)
    shifts = [(sx, sy) for sx in (-0.5 * split, 0.5 * split) for sy in (-0.5 * split, 0.5 * split)]
    expected = 0.0
    for shift in shifts:
        for xi, wi in zip(x, w, strict=True):
            for xj, wj in zip(x, w, strict=True):
                point = np.array([2.2 + 0.5 * width * xi, -3.1 + 0.5 * height * xj]) + shift
                share = rays.coverage_by_rays(frame, point, lambda r: rays.rayleigh_energy(r, 1.0), advance=4.0)
                expected += width * height * wi * wj / 4 * share / len(shifts)
    assert 0.005 < 1 - expected / (width * height) < 0.02
    assert abs(caught - expected) <= rows * cols * tolerance


def channels_rendered(shapes, wavelength_nm, response, channel, *, every_channel=False, background=BACKGROUND):
    rendering = render_channels(
        scene_of(shapes, background),
        OpticalSystem.of(OPTICS["f/8, OLPF"]),
        grid_of(*channel.shape),
        response=response,
        wavelength_nm=wavelength_nm,
        channel=channel,
        tolerance=TOLERANCE,
        every_channel=every_channel,
    )
    assert rendering.error_estimate <= TOLERANCE
    return rendering


def coloured():
    """Two surfaces whose reflectance changes with wavelength, one up, one down."""
    nm = (400.0, 700.0)
    return [
        (ARROW, camsim.Curve(nm, (0.1, 0.9), outside="hold")),
        (TRIANGLE, camsim.Curve(nm, (0.8, 0.2), outside="hold")),
    ]


def monochromatic(shapes, wavelength_nm, rows, cols):
    """One image a wavelength, every spectrum replaced by its value there."""
    images = []
    for nm in wavelength_nm:
        here = [(corners, float(curve.at(np.array(nm)))) for corners, curve in shapes]
        images.append(
            camsim.render(
                scene_of(here),
                OPTICS["f/8, OLPF"],
                grid_of(rows, cols),
                wavelength_nm=float(nm),
                tolerance=TOLERANCE,
            ).image
        )
    return np.array(images)


def test_a_few_wavelengths_add_up(rng):
    wavelength_nm = np.array([420.0, 480.0, 550.0, 610.0, 690.0])
    response = rng.uniform(0.1, 900.0, (3, 5))
    channel = rng.integers(0, 3, (14, 16)).astype(np.uint8)
    found = channels_rendered(coloured(), wavelength_nm, response, channel).image
    planes = np.tensordot(response, monochromatic(coloured(), wavelength_nm, 14, 16), axes=1)
    expected = np.take_along_axis(planes, channel[None].astype(int), axis=0)[0]
    full_scale = response.sum(axis=1)[channel]
    assert worst(found / full_scale, expected / full_scale) <= METHOD * TOLERANCE


def test_a_whole_spectrum_adds_up():
    """59 wavelengths, two of them far brighter than the rest, fused into fewer nodes: the same as one by one."""
    wavelength_nm = np.arange(405.0, 700.0, 5.0)
    smooth = np.exp(-(((wavelength_nm - 560.0) / 70.0) ** 2))
    lines = np.where(np.isin(wavelength_nm, (435.0, 545.0)), 40.0, 0.2)
    response = np.stack([smooth, lines])
    channel = np.array([[0, 1, 0, 1], [1, 0, 1, 0]], np.uint8).repeat(3, axis=0)
    rendering = channels_rendered(coloured(), wavelength_nm, response, channel)
    assert rendering.wavelengths < wavelength_nm.size
    planes = np.tensordot(response, monochromatic(coloured(), wavelength_nm, *channel.shape), axes=1)
    expected = np.take_along_axis(planes, channel[None].astype(int), axis=0)[0]
    full_scale = response.sum(axis=1)[channel]
    assert worst(rendering.image / full_scale, expected / full_scale) <= METHOD * TOLERANCE


def test_several_wavelengths_are_several_images():
    stack = camsim.render(scene_of(PICTURE), OPTICS["f/8"], grid_of(6, 8), wavelength_nm=[450.0, 620.0])
    assert stack.image.shape == (2, 6, 8)
    for nm, image in zip((450.0, 620.0), stack.image, strict=True):
        alone = camsim.render(scene_of(PICTURE), OPTICS["f/8"], grid_of(6, 8), wavelength_nm=nm)
        assert image.tobytes() == alone.image.tobytes()


def test_metamers_of_different_wavelengths_have_a_coloured_fringe():
    """Two surfaces alike to the channel, one all red and one all violet: no contrast in sum, yet an edge."""
    violet = camsim.Curve((449.0, 450.0, 451.0), (0.0, 1.0, 0.0))
    red = camsim.Curve((649.0, 650.0, 651.0), (0.0, 1.0, 0.0))
    wavelength_nm, response = np.array([450.0, 650.0]), np.array([[1.0, 1.0]])
    channel = np.zeros((14, 16), np.uint8)
    found = channels_rendered([(ARROW, red)], wavelength_nm, response, channel, background=violet).image
    shapes_at = {450.0: (0.0, 1.0), 650.0: (1.0, 0.0)}  # arrow, background
    expected = sum(
        camsim.render(
            scene_of([(ARROW, arrow)], background), OPTICS["f/8, OLPF"], grid_of(14, 16), wavelength_nm=nm
        ).image
        for nm, (arrow, background) in shapes_at.items()
    )
    assert worst(found, expected) <= 2 * METHOD * TOLERANCE
    assert worst(found, 1.0) > 0.02


def test_every_channel_changes_no_bit_of_the_mosaic(rng):
    wavelength_nm = np.linspace(420.0, 680.0, 30)
    response = rng.uniform(0.1, 1.0, (3, 30))
    channel = camsim.Cfa.bayer("GRBG").channel_index(14, 16)
    alone = channels_rendered(coloured(), wavelength_nm, response, channel)
    every = channels_rendered(coloured(), wavelength_nm, response, channel, every_channel=True)
    assert alone.planes is None
    assert every.image.tobytes() == alone.image.tobytes()
    one = np.take_along_axis(every.planes, channel[None].astype(int), axis=0)[0]
    assert worst(one, every.image) == 0.0
    assert every.planes_error <= TOLERANCE


def test_a_channel_that_sees_nothing_stays_dark(rng):
    response = np.array([[0.0, 0.0], [1.0, 2.0]])
    channel = np.array([[0, 1], [1, 0]], np.uint8).repeat(4, axis=1)
    image = channels_rendered(coloured(), np.array([500.0, 600.0]), response, channel).image
    assert worst(image[channel == 0], 0.0) == 0.0
    assert image[channel == 1].min() > 0.1


def test_wavelengths_without_light_do_not_count():
    """A response of exactly 0 may stand at any wavelength, even one the settings could not follow."""
    channel = np.zeros((8, 8), np.uint8)
    alone = channels_rendered(PICTURE, np.array([WAVELENGTH_NM]), np.array([[1.0]]), channel).image
    beside = channels_rendered(PICTURE, np.array([1.0, WAVELENGTH_NM, 1e6]), np.array([[0.0, 1.0, 0.0]]), channel).image
    assert worst(alone, beside) <= ROUNDING
