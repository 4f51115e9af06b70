"""Frames of one photosite or one row, windows in corners, and numbers from very small to very large."""

import numpy as np
import pytest
from examples import (
    ARROW,
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

SIZES = [(1, 1), (1, 2), (2, 1), (1, 300), (300, 1), (65, 63)]


@pytest.fixture(params=OPTICS.values(), ids=OPTICS, scope="module")
def optics(request):
    return request.param


@pytest.fixture(scope="module")
def whole(optics):
    return image_of(PICTURE, optics, 300, 300)


@pytest.mark.parametrize(("rows", "cols"), SIZES)
def test_small_and_narrow_frames(optics, whole, rows, cols):
    """The middle of a large frame; an odd size has its middle on a photosite, so there the scene is moved by half."""
    shift = (0.5 * (cols % 2), 0.5 * (rows % 2))
    image = image_of(moved(PICTURE, shift=np.negative(shift)), optics, rows, cols)
    row, col = 150 - rows // 2, 150 - cols // 2
    expected = whole[row : row + rows, col : col + cols]
    assert image.shape == (rows, cols)
    assert worst(image, expected) <= METHOD * TOLERANCE


CAMERA = camsim.Camera(
    rows=131,
    cols=170,
    pitch_um=PITCH_UM,
    lens=camsim.Airy(f_number=5.6),
    olpf=camsim.FourSpotOlpf(split_um=3.0),
    photosite=camsim.SquarePhotosite(side_um=PITCH_UM),
    cfa=camsim.Cfa.bayer("GRBG"),
    quantum_efficiency=camsim.QuantumEfficiency.named("Nikon 5100 (NPL)", peak=0.4),
    adc=camsim.Adc(bit_depth=12, black_level_dn=64, electrons_per_dn=5.0, base_iso=100.0),
)


def exposed(region=None):
    return CAMERA.expose(
        scene_of(moved(PICTURE, np.eye(2) * 9.0)),
        light=camsim.Light("D55", illuminance_lux=3000.0),
        exposure=camsim.Exposure(time_s=0.02, iso=100.0),
        region=region,
        tolerance=1e-5,
        noise=False,
    )


@pytest.fixture(scope="module")
def full_frame():
    return exposed()


@pytest.mark.parametrize("corner", [(0, 0), (0, 1), (1, 0), (1, 1)])
@pytest.mark.parametrize(("rows", "cols"), [(1, 1), (7, 9), (64, 65), (131, 1)])
def test_a_window_in_every_corner_of_the_frame(full_frame, corner, rows, cols):
    row, col = corner[0] * (131 - rows), corner[1] * (170 - cols)
    window = exposed(camsim.Region(rows=rows, cols=cols, origin=(row, col)))
    part = np.s_[row : row + rows, col : col + cols]
    np.testing.assert_array_equal(window.channel_index, full_frame.channel_index[part])
    scale = full_frame.mean_electrons.max()
    assert worst(window.mean_electrons / scale, full_frame.mean_electrons[part] / scale) <= 2 * METHOD * 1e-5
    # The window's own pattern begins with its own first photosite.
    letters = np.array(full_frame.channels)[full_frame.channel_index]
    first = letters[row : row + 2, col : col + 2]
    for r in range(first.shape[0]):
        assert "".join(first[r]) == window.cfa_pattern[r][: first.shape[1]]


@pytest.mark.parametrize("origin", [(-1, 0), (0, -1), (125, 0), (0, 165)])
def test_a_window_beyond_the_frame_is_refused(origin):
    with pytest.raises(camsim.CamsimError, match=r"puts the last of the|must be a whole number of 0 or more"):
        exposed(camsim.Region(rows=8, cols=8, origin=origin))


def test_a_window_without_origin_is_the_middle_in_phase():
    window = exposed(camsim.Region(rows=10, cols=10))
    assert window.cfa_pattern == CAMERA.cfa.pattern
    # (131 − 10)/2 = 60.5 and (170 − 10)/2 = 80, rounded down to even.
    again = exposed(camsim.Region(rows=10, cols=10, origin=(60, 80)))
    np.testing.assert_array_equal(window.mosaic, again.mosaic)


@pytest.mark.parametrize("contrast", [1e-6, 1e-3, 1e3, 1e6])
def test_contrast(optics, contrast):
    """Surfaces of reflectance ``contrast`` on white: white plus (contrast − 1) times the masks."""
    brightest = max(1.0, contrast)  # no surface returns more than all of the light
    shapes = [(corners, contrast / brightest) for corners, _ in PICTURE]
    masks = image_of([(corners, 1.0) for corners, _ in PICTURE], optics, background=0.0)
    image = brightest * image_of(shapes, optics, background=1.0 / brightest)
    assert worst(image, 1.0 + (contrast - 1.0) * masks) <= METHOD * TOLERANCE * brightest
    assert image.min() >= min(1.0, contrast) - TOLERANCE * brightest


@pytest.mark.parametrize("lambda_n", [0.08, 0.15, 0.4, 1.0, 3.0, 8.0, 20.0])
@pytest.mark.parametrize("point", [(0.1, 0.2), (6.2, -1.5), (-9.0, 8.0)])
def test_from_sharp_to_blurred_by_rays(lambda_n, point):
    """λN from 0.08 to 20 pitches, for a point in the shape, at its tip and beside it."""
    optics = [camsim.Airy(f_number=8.0 * lambda_n)]
    found = image_of(moved([(ARROW, 1.0)], shift=np.negative(point)), optics, 1, 1, background=0.0)[0, 0]
    expected = rays.coverage_by_rays(
        ARROW, np.array(point), lambda r: rays.rayleigh_energy(r, lambda_n), advance=0.2 * min(1.0, lambda_n)
    )
    assert found == pytest.approx(expected, abs=TOLERANCE)


@pytest.mark.parametrize("lambda_n", [0.08, 0.3, 2.0, 20.0])
@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-6])
def test_from_sharp_to_blurred_in_a_frame(lambda_n, tolerance):
    """Black on white and white on black add up, nothing is NaN, and light only ever spreads."""
    optics = [
        camsim.Airy(f_number=8.0 * lambda_n),
        camsim.FourSpotOlpf(split_um=0.75 * PITCH_UM),
        camsim.SquarePhotosite(side_um=PITCH_UM),
    ]
    image = image_of(PICTURE, optics, tolerance=tolerance)
    inverse = image_of([(corners, 1.0 - r) for corners, r in PICTURE], optics, background=0.7, tolerance=tolerance)
    assert worst(image + inverse, 1.0) <= METHOD * tolerance
    assert 0.05 - tolerance <= image.min() <= image.max() <= 0.9 + tolerance


def test_in_the_sharp_limit_photosites_see_covered_area():
    """λN = 0.08: pictures of the triangle by clipping it, within the blur of 0.065·λN/h for an edge h away."""
    import shapely

    image = image_of(
        [(TRIANGLE, 1.0)], [camsim.Airy(f_number=0.64), camsim.SquarePhotosite(side_um=PITCH_UM)], background=0.0
    )
    triangle = shapely.Polygon(TRIANGLE)
    rows, cols = image.shape
    for row in range(rows):
        for col in range(cols):
            x, y = col - cols / 2, row - rows / 2
            cell = shapely.box(x, y, x + 1, y + 1)
            away = cell.centroid.distance(triangle.exterior)
            # Half a photosite nearer at most; within a photosite of an edge the blur is a fraction of λN itself.
            allowed = 3 * 0.065 * 0.08 / (away - 0.71) if away > 1.0 else 0.3 * 0.08
            assert abs(image[row, col] - triangle.intersection(cell).area) <= allowed


@pytest.mark.parametrize("lambda_n", [10.0, 20.0])
def test_in_the_blurred_limit_the_psf_is_added_up_over_the_shape(lambda_n):
    """Long waves: the PSF is smooth over the triangle, and a product rule over the triangle adds it up."""
    found = image_of([(TRIANGLE, 1.0)], [camsim.Airy(f_number=8 * lambda_n)], 3, 3, background=0.0, tolerance=1e-7)
    x, w = np.polynomial.legendre.leggauss(12)
    u, v = np.meshgrid(0.5 * (1 + x), 0.5 * (1 + x), indexing="ij")
    a, b, c = TRIANGLE
    (bx, by), (cx, cy) = b - a, c - b
    weight = np.outer(w, w) / 4 * u * abs(bx * cy - by * cx)
    points = a + u[..., None] * (b - a) + (u * v)[..., None] * (c - b)
    for row in range(3):
        for col in range(3):
            r = np.hypot(*np.moveaxis(points - (col - 1, row - 1), 2, 0))
            assert found[row, col] == pytest.approx(np.sum(weight * rays.airy_psf(r, lambda_n)), abs=1e-7)


@pytest.mark.parametrize("pitch_um", [1e-3, 0.7, 30.0, 1e4])
def test_pitches(pitch_um):
    """From a thousandth of a micron to a centimetre, with the f-number in step: the same picture."""
    factor = pitch_um / PITCH_UM
    image = camsim.render(
        scene_of(moved(PICTURE, np.eye(2) * factor)),
        [camsim.Airy(f_number=8.0 * factor), camsim.SquarePhotosite(side_um=pitch_um)],
        camsim.Grid(rows=12, cols=12, pitch_um=pitch_um),
        wavelength_nm=WAVELENGTH_NM,
    ).image
    assert worst(image, image_of(PICTURE, OPTICS["f/8"], 12, 12)) <= 1000 * ROUNDING


@pytest.mark.parametrize("side", [1e-9, 1e-3, 3.0, 10.0])
def test_photosites_from_a_point_to_ten_pitches(side):
    """A photosite as wide as ten pitches is the mean of a hundred of one pitch (an image of them, averaged)."""
    lens = camsim.Airy(f_number=4.0)
    wide = image_of(PICTURE, [lens, camsim.SquarePhotosite(side_um=side * PITCH_UM)], 5, 5)
    if side < 1.0:
        assert worst(wide, image_of(PICTURE, [lens], 5, 5)) <= METHOD * TOLERANCE + side
        return
    fine = image_of(PICTURE, [lens, camsim.SquarePhotosite(side_um=PITCH_UM)], 5 + int(side) - 1, 5 + int(side) - 1)
    n = int(side)
    mean = [[fine[r : r + n, c : c + n].mean() for c in range(5)] for r in range(5)]
    assert worst(wide, mean) <= METHOD * TOLERANCE


def test_metameric_neighbours():
    """Two surfaces alike to the channel but not at any wavelength, side by side on a third; one by one it adds up."""
    nm = np.array([450.0, 650.0])
    violet = camsim.Curve((449.0, 450.0, 451.0), (0.0, 0.8, 0.0))
    red = camsim.Curve((649.0, 650.0, 651.0), (0.0, 0.4, 0.0))
    left = np.array([(-6.0, -5.0), (0.5, -5.0), (-0.5, 5.0), (-6.0, 5.0)])
    right = np.array([(0.5, -5.0), (6.0, -5.0), (6.0, 5.0), (-0.5, 5.0)])
    response = np.array([[1.0, 2.0], [3.0, 0.0]])  # the first channel sees 0.8 of both, the second of violet only
    channel = np.indices((12, 14)).sum(axis=0).astype(np.uint8) % 2
    found = render_channels(
        scene_of([(left, violet), (right, red)], 0.0),
        OpticalSystem.of(OPTICS["f/8, OLPF"]),
        grid_of(12, 14),
        response=response,
        wavelength_nm=nm,
        channel=channel,
        tolerance=TOLERANCE,
    )
    assert found.error_estimate <= TOLERANCE
    planes = np.zeros((2, 12, 14))
    for j, (in_left, in_right) in enumerate(((0.8, 0.0), (0.0, 0.4))):
        alone = camsim.render(
            scene_of([(left, in_left), (right, in_right)], 0.0),
            OPTICS["f/8, OLPF"],
            grid_of(12, 14),
            wavelength_nm=nm[j],
        )
        planes += response[:, j, None, None] * alone.image
    expected = np.take_along_axis(planes, channel[None].astype(int), axis=0)[0]
    assert worst(found.image / 3.0, expected / 3.0) <= 2 * METHOD * TOLERANCE
    # On the border of both, in the first channel, there is no contrast to blur: yet wavelengths blur differently.
    assert worst(planes[0][5:7, 5:9], 0.8) > 1e-3


@pytest.mark.parametrize("wavelength_nm", [0.55, 5.5e-7, (550.0, 0.6), 5.5e4])
def test_wavelengths_in_another_unit_are_refused(wavelength_nm):
    """0.55 took a minute and all memory."""
    photosite = camsim.SquarePhotosite(side_um=PITCH_UM)
    with pytest.raises(camsim.CamsimError, match=r"is not a wavelength of light; give nm, 100 … 20000"):
        camsim.render(
            camsim.Scene(background=0.2, shapes=[camsim.Disc(radius_um=9.0, reflectance=0.9)]),
            [camsim.Airy(f_number=8.0), photosite],
            grid_of(8, 8),
            wavelength_nm=wavelength_nm,
        )


def test_a_table_of_light_in_another_unit_is_refused():
    with pytest.raises(camsim.CamsimError, match=r"ends at 0.7 nm, where there is no light; give nm"):
        camsim.Curve(wavelength_nm=(0.4, 0.5, 0.7), values=(1.0, 1.0, 1.0))
    table = camsim.Curve(wavelength_nm=(4e4, 5e4, 7e4), values=(1.0, 1.0, 1.0))
    with pytest.raises(camsim.CamsimError, match=r"ends at 70000 nm; give nm, 100 … 20000"):
        camsim.Light(table, irradiance_w_per_m2=1.0)
