"""Matrix, white balance and sensitivities from charts whose camera, light and reflectances are known."""

import numpy as np
import pytest
from photographed_chart import BLACK_DN, CAMERA, FULL_E, NODES_NM, WHITE_DN, channels, photographed, place

import camsim
from camsim.errors import InvalidValueError, UnsupportedError
from camsim.measure import Picture
from camsim.measure.colour import calibrate_colour
from camsim.measure.picture import mosaic_planes
from camsim.spectra.colour_science import colour_science
from tests.colour_data import aligned, patches, white_xyz

D55 = camsim.Light("D55", irradiance_w_per_m2=1.0)
A = camsim.Light("A", irradiance_w_per_m2=1.0)


def xyz_of_patches(light: str) -> np.ndarray:
    observer, power = aligned("observer", "CIE 1931 2 Degree Standard Observer"), aligned("light", light)
    return (patches() * power) @ observer / (power @ observer[:, 1])


def difference(found_xyz: np.ndarray, light: str) -> np.ndarray:
    """ΔE2000 in the light's own white, by colour-science."""
    colour = colour_science()
    white = colour.XYZ_to_xy(white_xyz(light))
    lab = [colour.XYZ_to_Lab(xyz, white) for xyz in (found_xyz, xyz_of_patches(light))]
    return np.asarray(colour.delta_E(*lab, method="CIE 2000"))


@pytest.mark.parametrize(
    "how",
    [
        {"turn_deg": 0.0},
        {"turn_deg": 90.0, "width": 0.4},
        {"turn_deg": 187.0},
        {"turn_deg": -35.0, "width": 0.35},
        {"turn_deg": 6.0, "tilt": 0.25},
        {"turn_deg": 12.0, "light": "A", "camera": "Sigma SDMerill (NPL)"},
    ],
    ids=str,
)
def test_a_chart_is_found_and_its_matrix_makes_it_look_right(how: dict) -> None:
    light = how.get("light", "D55")
    found = calibrate_colour(photographed(**how), A if light == "A" else D55)
    sensitivities = np.maximum(aligned("camera", how["camera"]), 0.0) if "camera" in how else CAMERA
    seen, white = channels(sensitivities, light)
    # The matrix itself, on numbers without noise that it has not seen.
    matrix = np.array(found.matrix.camera_to_xyz)
    xyz = seen @ matrix.T
    xyz *= xyz_of_patches(light)[18:, 1].sum() / xyz[18:, 1].sum()
    # Stated under D50, here in the light's own white, which under A is another measure of the same.
    assert np.mean(difference(xyz, light)) == pytest.approx(np.mean(found.delta_e_after), rel=0.2, abs=0.15)
    assert np.mean(found.delta_e_after) < (3.0 if "camera" in how else 1.6)
    assert found.matrix.white_xyz == pytest.approx(white_xyz(light).tolist(), abs=5e-4)
    red, green, blue = found.white_balance
    assert (red, green, blue) == pytest.approx((white / white[1]).tolist(), rel=0.02)
    assert found.clipped == ()
    assert found.delta_e_before is None
    assert np.mean(found.delta_e_left_out) > np.mean(found.delta_e_after)


def test_a_camera_that_sees_as_the_eye_does_has_its_matrix_back() -> None:
    """Channels that are mixtures of x̄, ȳ, z̄: the matrix is the mixture's inverse, within its stated errors."""
    mixture = np.array([[0.8, 0.3, 0.0], [0.1, 1.0, 0.05], [0.0, 0.1, 0.9]])
    observer, power = aligned("observer", "CIE 1931 2 Degree Standard Observer"), aligned("light", "D55")
    of_patches = (patches() * power) @ observer @ mixture.T
    white = power @ observer @ mixture.T
    rng = np.random.default_rng(5)
    rows, cols, side = 4, 6, 80
    patch = np.kron(np.arange(24).reshape(rows, cols), np.ones((side, side), int))
    y, x = np.mgrid[0 : rows * side, 0 : cols * side]
    channel = np.array([[0, 1], [1, 2]])[y % 2, x % 2]
    electrons = rng.poisson(of_patches[patch, channel] * 0.9 * FULL_E / white.max())
    codes = np.rint(BLACK_DN + electrons * (WHITE_DN - BLACK_DN) / FULL_E).astype(np.uint16)
    planes = mosaic_planes(codes, ("RG", "GB"), black=float(BLACK_DN), white=float(WHITE_DN))
    found = calibrate_colour(Picture(name="eye", shape=codes.shape, planes=planes), D55)
    matrix, sigma = np.array(found.matrix.camera_to_xyz), np.array(found.sigma)
    truth = np.linalg.inv(mixture)
    truth *= np.abs(matrix).max() / np.abs(truth).max()
    assert np.all(np.abs(matrix - truth) < 5.0 * sigma + 1e-3)
    assert max(found.delta_e_after) < 1.0
    assert np.mean(found.delta_e_after) < 0.2
    assert found.white_balance == pytest.approx((white / white[1]).tolist(), rel=3e-3)


@pytest.mark.parametrize("light", ["D55", "A"])
def test_smooth_sensitivities_are_the_cameras_within_their_stated_errors(light: str) -> None:
    found = calibrate_colour(photographed(light=light), A if light == "A" else D55)
    assert found.measured
    nodes, smooth = np.arange(380.0, 781.0, 10.0), found.smooth
    truth = np.stack([np.interp(nodes, NODES_NM, curve) for curve in CAMERA.T])
    truth *= (smooth.values * truth).sum() / (truth * truth).sum()
    off = np.abs(smooth.values - truth)
    assert np.mean(off < 2.0 * smooth.sigma + 2e-3) >= 0.9
    real = np.sqrt((off**2).mean(axis=1) / (truth**2).mean(axis=1))
    assert np.all(real < 2.0 * smooth.relative)
    assert np.all(smooth.relative < 0.2)
    assert "Gaussian process of 20 nm" in found.sensitivities


def test_a_chart_lit_unevenly_tells_no_curves_and_the_nearest_camera_is_named() -> None:
    found = calibrate_colour(photographed(camera="Nikon 5100 (NPL)", unevenness=0.02), D55)
    assert not found.measured
    assert found.nearest.name == "Nikon 5100 (NPL)"
    assert found.smooth.noise > 0.008
    assert "too much; in their place the nearest measured camera: Nikon 5100 (NPL)" in found.sensitivities
    # Each channel is scaled: white is the chart's.
    power = aligned("light", "D55")
    curves = np.stack([found.nearest.curves[letter].at(NODES_NM) for letter in "RGB"], axis=1)
    red, green, blue = power @ curves
    assert (red / green, blue / green) == pytest.approx((found.white_balance[0], found.white_balance[2]), rel=0.03)


def test_a_camera_that_is_shipped_is_recognised() -> None:
    found = calibrate_colour(photographed(camera="Nikon 5100 (NPL)"), D55)
    assert not found.measured
    assert found.nearest.name == "Nikon 5100 (NPL)"
    assert found.nearest.misfit < 2e-3
    assert "shows the chart the same" in found.sensitivities


def test_corners_say_where_a_chart_lies() -> None:
    how = {"shape": (600, 900), "turn_deg": 12.0, "width": 0.4, "tilt": 0.2}
    corners = [tuple(place(x, y, **how)) for x, y in ((0.5, 0.5), (5.5, 0.5), (5.5, 3.5), (0.5, 3.5))]
    picture = photographed(**how)
    found, given = calibrate_colour(picture, D55), calibrate_colour(picture, D55, corners=corners)
    assert given.delta_e_after == pytest.approx(found.delta_e_after, abs=0.15)
    turned = [corners[k] for k in (1, 2, 3, 0)]
    with pytest.raises(InvalidValueError, match=r"no ColorChecker in the order dark skin, bluish green, black and wh"):
        calibrate_colour(picture, D55, corners=turned)
    with pytest.raises(InvalidValueError, match="outside the picture of 600 rows × 900 columns"):
        calibrate_colour(picture, D55, corners=[(700.0, 1.0), *corners[1:]])
    with pytest.raises(InvalidValueError, match="no four corners in turn"):
        calibrate_colour(picture, D55, corners=[corners[k] for k in (0, 2, 1, 3)])


def test_what_shows_no_chart_is_refused_with_the_way_out() -> None:
    codes = np.random.default_rng(1).integers(600, 4000, (300, 400)).astype(np.uint16)
    bare = Picture(name="noise", shape=codes.shape, planes=mosaic_planes(codes, ("RG", "GB"), white=4095.0))
    with pytest.raises(UnsupportedError, match=r"noise: shows no ColorChecker that is found .* --corners"):
        calibrate_colour(bare, D55)
    mono = Picture(name="grey", shape=codes.shape, planes=mosaic_planes(codes, ("Y",), white=4095.0))
    with pytest.raises(UnsupportedError, match="grey: has the channels Y; colours need R, G and B"):
        calibrate_colour(mono, D55)


def test_clipped_patches_are_left_out_by_name() -> None:
    picture = photographed()
    planes = tuple(
        type(plane)(
            name=plane.name, samples=np.minimum(plane.samples, 11_000), first=plane.first, step=plane.step,
            black=plane.black, white=11_000.0,
        )
        for plane in picture.planes
    )  # fmt: skip
    found = calibrate_colour(Picture(name="bright", shape=picture.shape, planes=planes), D55)
    assert "white 9.5" in found.clipped
    assert np.isnan(found.delta_e_after[18])
    assert np.nanmean(found.delta_e_after) < 1.6
