"""Veiling glare: means of scenes by their areas, and what of it a capture, its truths and a sweep have."""

from __future__ import annotations

import numpy as np
import pytest
from tolerances import METHOD, ROUNDING

import camsim
from camsim.measure.truth import truth_in
from camsim.rendering.veil import Veil
from camsim.sensor.colour_matrix import observer
from tests.tables import rows

PITCH_UM, ROWS, COLS = 5.0, 60, 80
FRAME = camsim.Grid(rows=ROWS, cols=COLS, pitch_um=PITCH_UM)
WIDTH_UM, HEIGHT_UM = PITCH_UM * COLS, PITCH_UM * ROWS
AREA_UM2 = WIDTH_UM * HEIGHT_UM
TOLERANCE = 1e-5
LIGHT = camsim.Light("D55", illuminance_lux=500.0)
EXPOSURE = camsim.Exposure(time_s=0.01, iso=100.0)
DISC = camsim.Disc(radius_um=60.0, reflectance=0.0)
ON_WHITE = camsim.Scene(background=1.0, shapes=[DISC])
WHITE_SHARE = 1.0 - np.pi * 60.0**2 / AREA_UM2
SAMPLES = np.random.default_rng(4).uniform(0.0, 1.0, (20, 30))
CUT = 2.0 * np.arccos(0.5)  # radians of a circle that a chord at half its radius cuts off


def mean_of(background, *shapes):
    """The mean over the frame; a share of one half, so that it must be divided by it."""
    scene = camsim.Scene(background=background, shapes=shapes)
    return Veil(share=0.5, frame=FRAME).light(scene, np.full((1, 1), 2.0), np.array([550.0]), TOLERANCE)[0]


def picture(**more):
    return camsim.Picture(planes=SAMPLES, **{"width_um": 120.0, **more})


# A spline through mirrored samples has their mean.
MEANS = {name: (eval(made_of), eval(mean)) for name, made_of, mean in rows("areas.txt", "means of scenes")}


@pytest.mark.parametrize("what", MEANS)
def test_the_mean_is_that_of_areas(what):
    made_of, right = MEANS[what]
    assert abs(mean_of(*made_of) - right) <= 1e-3 * TOLERANCE


def camera_of(glare=0.0, **more):
    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0))
    stages = {
        "rows": ROWS, "cols": COLS, "pitch_um": PITCH_UM, "photosite": camsim.SquarePhotosite(side_um=4.0),
        "olpf": None, "veiling_glare": glare,
    }  # fmt: skip
    return camera.replace(**(stages | more))


def taken(camera, scene=ON_WHITE, **more):
    how = {"light": LIGHT, "exposure": EXPOSURE, "tolerance": TOLERANCE, "noise": False, "products": ("truth",)}
    return camera.expose(scene, **(how | more))


def white_of(camera, light=LIGHT):
    return camera.diffuser_electrons(light, EXPOSURE.time_s)


def test_a_flat_field_is_unchanged():
    """Corners that are darker stay as dark: the veil falls off as the image does."""
    falls_off = {"falloff": camsim.Cos4Falloff(exit_pupil_mm=0.4)}
    flat = camsim.Scene(background=0.8)
    without, there = (taken(camera_of(glare, **falls_off), flat) for glare in (0.0, 0.3))
    np.testing.assert_allclose(there.truth, without.truth, rtol=2e-7)
    np.testing.assert_allclose(there.mean_electrons, without.mean_electrons, rtol=ROUNDING)


LENSES = {
    "airy": camsim.Airy(f_number=8.0),
    "wavefront": camsim.Wavefront(f_number=8.0, zernike_waves=((8, 0.05),)),
    "measured": camsim.MeasuredPsf(f_number=8.0, irradiance=np.ones((3, 3)), spacing_um=2.0),
    "field": camsim.read_lens("perfect"),
}


@pytest.mark.parametrize(("lens", "method"), [(lens, "auto") for lens in LENSES] + [("airy", "fourier")])
def test_a_black_disc_on_white_is_as_bright_as_its_share(lens, method):
    """The image less its share, and the share of the frame's mean, at every photosite and in every channel."""
    how = {"tolerance": 1e-3, "method": method, "light": camsim.Light(line_nm=550.0, irradiance_w_per_m2=1.0)}
    how |= {"region": camsim.Region(rows=6, cols=6, origin=(26, 50))} if lens == "field" else {}
    without, there = (taken(camera_of(glare, lens=LENSES[lens]), **how) for glare in (0.0, 0.25))
    illumination = taken(camera_of(lens=LENSES[lens]), camsim.Scene(background=1.0), **how).truth
    right = 0.75 * without.truth + 0.25 * WHITE_SHARE * illumination
    assert np.abs((there.truth - right) / illumination).max() <= METHOD * 1e-3


def test_a_window_has_the_frames_veil():
    """Also with crosstalk, whose neighbours lie outside of the window, and row by row."""
    camera = camera_of(0.1, crosstalk=camsim.Crosstalk(((0.0, 0.01, 0.0), (0.02, 0.95, 0.01), (0.0, 0.01, 0.0))))
    region = camsim.Region(rows=10, cols=12, origin=(20, 30))
    frame, window = taken(camera), taken(camera, region=region)
    error = np.abs(window.truth - frame.truth[20:30, 30:42]) / white_of(camera)
    assert error.max() <= METHOD * TOLERANCE
    rows = []
    how = {"light": LIGHT, "exposure": EXPOSURE, "tolerance": TOLERANCE, "noise": False, "region": region}
    camsim.Capture(camera=camera, scene=ON_WHITE, **how).rows(rows.append)
    np.testing.assert_array_equal(np.concatenate(rows), window.mosaic)


def test_a_table_is_a_share_at_every_wavelength():
    """In light of lines; in daylight as numpy sums light, filters and table up on its own."""
    table = camsim.Curve((400.0, 500.0, 700.0), (0.05, 0.2, 0.1))
    for nm, share in ((450.0, 0.125), (600.0, 0.15)):
        line = camsim.Light(line_nm=nm, irradiance_w_per_m2=1.0)
        camera = camera_of(table)
        centre = taken(camera, light=line).truth[ROWS // 2, COLS // 2]
        without = taken(camera_of(), light=line).truth[ROWS // 2, COLS // 2]
        right = (1.0 - share) * without + share * WHITE_SHARE * white_of(camera, line)
        assert np.abs((centre - right) / white_of(camera, line)).max() <= METHOD * TOLERANCE
    camera = camera_of(table)
    capture = camsim.Capture(camera=camera, scene=ON_WHITE, light=LIGHT, exposure=EXPOSURE)
    nm = np.arange(300.0, 830.0, 0.01)
    each = LIGHT.irradiance_at(nm)  # its curves are per energy
    for filtered in camera.filters:
        each = each * (filtered.at(nm) if isinstance(filtered, camsim.Curve) else filtered)
    seen = {letter: curve.at(nm) * each for letter, curve in camera.with_ends(LIGHT).quantum_efficiency.curves}
    held = np.interp(nm, table.wavelength_nm, table.values)
    shares = [np.sum(seen[letter] * held) / np.sum(seen[letter]) for letter in camera.cfa.channels]
    np.testing.assert_allclose(capture.veil_e / white_of(camera), np.multiply(shares, WHITE_SHARE), rtol=1e-4)


def test_every_truth_has_it():
    """Cubes are radiances, and the eye's truths are of the same image."""
    flat = {"lens": camsim.Gaussian(f_number=8.0, sigma_um=1.0), "rows": ROWS}
    capture = camsim.Capture(
        camera=camera_of(0.1, **flat), scene=ON_WHITE, light=LIGHT, exposure=EXPOSURE, tolerance=TOLERANCE, noise=False,
        region=camsim.Region(rows=2, cols=2), spectral_nm=(550.0,),
    )  # fmt: skip
    frame = capture.frame(products=("spectral",))
    plane, _ = frame.spectral.plane(0)
    np.testing.assert_allclose(
        np.pi * plane / LIGHT.irradiance_at(np.array([550.0])), 0.1 * WHITE_SHARE, atol=METHOD * TOLERANCE
    )
    eye = truth_in(capture, "xyz")
    np.testing.assert_allclose(eye.image[..., 1], 0.1 * WHITE_SHARE, atol=METHOD * TOLERANCE)


@pytest.mark.parametrize(
    ("wavelength_nm", "values"),
    [((300.0, 549.6, 549.601, 1100.0), (0.0, 0.0, 0.5, 0.5)),
     ((300.0, 549.99, 550.0, 550.3, 550.31, 1100.0), (0.02, 0.02, 0.5, 0.5, 0.02, 0.02))],
)  # fmt: skip
def test_the_eyes_truth_follows_its_steps(wavelength_nm, values):
    """Light was looked at where the eye and the scene bend: a band of 0.3 nm between two such places was missed."""
    light = camsim.Light(line_nm=550.0, width_nm=1.0, illuminance_lux=100.0)
    glare = camsim.Curve(wavelength_nm, values, outside="hold")
    flat = {"lens": camsim.Gaussian(f_number=8.0, sigma_um=1.0), "rows": ROWS}
    capture = camsim.Capture(
        camera=camera_of(glare, **flat), scene=ON_WHITE, light=light, exposure=EXPOSURE, tolerance=TOLERANCE,
        noise=False, region=camsim.Region(rows=2, cols=2),
    )  # fmt: skip
    low_nm, high_nm = light.ends_nm
    nm = np.unique(np.concatenate([np.arange(low_nm, high_nm, 0.002), wavelength_nm]))
    nm = nm[(nm >= low_nm) & (nm <= high_nm)]
    exposed = light.irradiance_at(nm) * observer()[1].at(nm)
    share = np.trapezoid(exposed * np.interp(nm, wavelength_nm, values), nm) / np.trapezoid(exposed, nm)
    image = truth_in(capture, "xyz").image
    np.testing.assert_allclose(image[..., 1], share * WHITE_SHARE, atol=1e-5)
