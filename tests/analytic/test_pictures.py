"""Pictures against brute-force sums, against the same scene drawn as shapes, and against what is known of them."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from examples import tiles, worst
from truth import samples as truth

import camsim
from camsim.optics import OpticalSystem
from camsim.rendering.fields.layer import Layer
from camsim.rendering.render import plan_render, render_channels
from camsim.rendering.waves.fields import FieldSource
from camsim.rendering.waves.levels import Lattice
from camsim.spectra.curve import Curve
from camsim.spectra.rgb import reflectance_of_rgb

PITCH_UM, NM = 4.0, 500.0
LENS, OLPF, PHOTOSITE = (
    camsim.Airy(f_number=8.0),
    camsim.FourSpotOlpf(split_um=3.0),
    camsim.SquarePhotosite(side_um=4.0),
)
OPTICS = [LENS, OLPF, PHOTOSITE]
GRID = camsim.Grid(rows=9, cols=11, pitch_um=PITCH_UM)


def rendered(*shapes, tolerance, background=0.0, optics=None, grid=GRID, **how):
    scene = camsim.Scene(background=background, shapes=shapes)
    found = camsim.render(scene, optics or OPTICS, grid, wavelength_nm=NM, tolerance=tolerance, **how)
    assert found.error_estimate <= tolerance, (found.error_estimate, tolerance)
    return found.image


@pytest.mark.parametrize(("seed", "interpolation"), [(0, "squares"), (2, "linear"), (5, "cubic"), (2, "cubic")])
def test_brute_force(seed, interpolation):
    """Random size, scale 0.05 … 6, place and angle, at two tolerances."""
    rng = np.random.default_rng(seed)
    rows, cols = rng.integers(1, 8, 2)
    scale, angle, centre = np.exp(rng.uniform(np.log(0.05), np.log(6.0))), rng.uniform(0, 360), rng.uniform(-2, 2, 2)
    planes = rng.random((rows, cols))
    how = {"interpolation": interpolation, "step": scale, "centre": centre, "rotate_deg": angle}
    light = truth.light_of_picture(planes, nodes=int(np.ceil(1.6 * scale)) + 8, **how)
    spots = np.array([(x, y) for x in (-0.375, 0.375) for y in (-0.375, 0.375)])
    places = [(0, 0), (4, 6)]
    x0, y0 = GRID.first_centre
    centres = [(x0 + col, y0 + row) for row, col in places]
    right = truth.photosites(light, centres=centres, blur=8.0 * NM * 1e-3 / PITCH_UM, side=1.0, spots=spots, nodes=8)
    for tolerance in (1e-2, 1e-7):
        picture = camsim.Picture(
            planes=planes,
            width_um=scale * cols * PITCH_UM,
            centre_um=centre * PITCH_UM,
            rotate_deg=angle,
            interpolation=interpolation,
        )
        image = rendered(picture, tolerance=tolerance)
        assert worst([image[place] for place in places], right) <= tolerance


@pytest.mark.parametrize(
    ("rows", "cols", "scale", "angle", "interpolation"),
    [
        (32, 24, 0.05, 33.0, "cubic"),
        (24, 32, 0.7, 0.0, "squares"),
        (3, 4, 20.0, 61.0, "linear"),
        (2, 5, 20.0, 0.0, "cubic"),
        (2, 1, 4.5, 0.0, "cubic"),
        (1, 2, 4.5, 17.0, "cubic"),
    ],
)
def test_brute_force_of_many_samples_and_of_large_ones(rows, cols, scale, angle, interpolation):
    planes = np.random.default_rng(rows).random((rows, cols))
    how = {"interpolation": interpolation, "rotate_deg": angle}
    nodes = int(np.ceil(1.6 * scale)) + 4
    light = truth.light_of_picture(planes, nodes=nodes, step=scale, centre=(0.3, -0.8), **how)
    x0, y0 = GRID.first_centre
    place = (4, 6)
    centres, spots = [(x0 + place[1], y0 + place[0])], np.zeros((1, 2))
    right = truth.photosites(light, centres=centres, blur=8.0 * NM * 1e-3 / PITCH_UM, side=1.0, spots=spots, nodes=8)
    for tolerance in (1e-2, 1e-6):
        picture = camsim.Picture(
            planes=planes, width_um=scale * cols * PITCH_UM, centre_um=(0.3 * PITCH_UM, -0.8 * PITCH_UM), **how
        )
        assert worst(rendered(picture, tolerance=tolerance, optics=[LENS, PHOTOSITE])[place], right[0]) <= tolerance


@pytest.mark.parametrize(
    "spectra",
    [
        (0.5,),
        (np.float32(0.5), 0.25),
        (0.5, camsim.Curve((400.0, 700.0), (0.25, 0.25))),
        (0.5, camsim.Curve((540.0, 560.0), (0.25, 0.25))),
    ],
)
def test_numbers_are_spectra(spectra):
    """A camera refused them for wavelengths that nobody gave; a curve was dark beyond its table, as no surface is."""
    picture = camsim.Picture(planes=np.full((len(spectra), 2, 3), 0.4), spectra=spectra, width_um=6000.0)
    grey = 0.4 * (0.5 + 0.25 * (len(spectra) - 1))
    capture = camsim.load(
        "flat-field", overrides=["region={rows: 2, cols: 2}", "render.tolerance=1e-4", "noise.enabled=false"]
    )
    frames = [
        dataclasses.replace(capture, scene=camsim.Scene(background=grey, shapes=shapes)).frame()
        for shapes in ((), (picture,))
    ]
    np.testing.assert_allclose(*(frame.mean_electrons for frame in frames), rtol=1e-3)


@pytest.mark.parametrize(("turn_deg", "interpolation"), [(1e-9, "squares"), (90.0 + 1e-7, "linear"), (-1e-12, "cubic")])
def test_hardly_turned_is_upright(interpolation, turn_deg):
    """The cosine of a billionth of a degree is 1; its sine was taken for a direction, and the capture crashed."""
    planes = np.random.default_rng(9).random((4, 5))
    hardly, upright = (
        rendered(
            camsim.Picture(planes=planes, width_um=24.0, rotate_deg=angle, interpolation=interpolation), tolerance=1e-6
        )
        for angle in (turn_deg, 90.0 * round(turn_deg / 90.0))
    )
    assert worst(hardly, upright) <= 2e-6


@pytest.mark.parametrize("origin", [(2, 2), (10, 0)])
def test_a_window_beside_a_picture_is_that_of_the_frame(origin):
    """A lens that fades: a window takes part of the samples, which begin within the picture and end beyond its rim."""
    planes = np.random.default_rng(8).random((3, 4))
    placed = {"width_um": 14.4, "centre_um": (4.8, 0.0), "rotate_deg": 185.0}
    picture = camsim.Picture(planes=planes, interpolation="cubic", **placed)
    optics = [camsim.Gaussian(sigma_um=0.4), camsim.SquarePhotosite(side_um=1.0)]
    window = camsim.Grid(rows=3, cols=2, pitch_um=2.4, origin=origin, frame=(15, 4))
    whole = rendered(picture, tolerance=1e-6, optics=optics, grid=camsim.Grid(rows=15, cols=4, pitch_um=2.4))
    part = rendered(picture, tolerance=1e-6, optics=optics, grid=window)
    rows, cols = (slice(first, first + count) for first, count in zip(origin, (3, 2), strict=True))
    assert worst(part, whole[rows, cols]) <= 2e-6


def test_a_chart_of_shapes_is_a_picture_of_squares_under_shapes():
    """The same behind a disc and a polygon, over another shape: what lies in front hides it exactly."""
    planes = np.random.default_rng(3).random((5, 7))
    under = camsim.Rectangle(width_um=90.0, height_um=14.0, centre_um=(0.0, 12.0), reflectance=0.9)
    above = [
        camsim.Disc(radius_um=11.0, centre_um=(8.0, 5.0), reflectance=0.6),
        camsim.Polygon(points_um=[(-30, -20), (-5, -12), (-22, 6)], reflectance=0.1),
    ]
    picture = camsim.Picture(planes=planes, width_um=63.0, centre_um=(2.0, -1.0), rotate_deg=23.0)
    drawn = tiles(planes, 9.0, np.array([2.0, -1.0]), 23.0)
    right = rendered(under, *drawn, *above, tolerance=1e-8, background=0.3, method="fourier")
    for tolerance in (1e-4, 1e-7):
        displayed = rendered(under, picture, *above, tolerance=tolerance, background=0.3, method="fourier")
        assert worst(displayed, right) <= tolerance


@pytest.mark.parametrize("interpolation", ["squares", "cubic"])
def test_what_is_hidden_might_be_anything(interpolation):
    """A picture wholly behind a shape is that shape; two halves of a mask show all of a picture."""
    planes = np.random.default_rng(4).random((6, 6))
    picture = camsim.Picture(planes=planes, width_um=24.0, rotate_deg=10.0, interpolation=interpolation)
    cover = camsim.Rectangle(width_um=60.0, height_um=60.0, reflectance=0.4)
    assert worst(rendered(picture, cover, tolerance=1e-6), rendered(cover, tolerance=1e-9, method="fourier")) <= 1e-6
    left = camsim.Polygon(points_um=[(-99, -99), (3, -99), (-2, 99), (-99, 99)], reflectance=0.0)
    right = camsim.Polygon(points_um=[(3, -99), (99, -99), (99, 99), (-2, 99)], reflectance=0.0)
    halves = rendered(picture, left, tolerance=1e-6, method="fourier")
    halves = halves + rendered(picture, right, tolerance=1e-6, method="fourier")
    assert worst(halves, rendered(picture, tolerance=1e-7)) <= 3e-6


WAVEFRONTS = {
    "defocus": camsim.Wavefront(f_number=8.0, zernike_waves={4: 0.15}),
    "coma and a tilt": camsim.Wavefront(f_number=8.0, zernike_waves={1: 0.3, 8: 0.1}),
    "annular": camsim.Wavefront(f_number=8.0, zernike_waves={12: 0.1}, pupil=camsim.Pupil(obstruction=0.4)),
    "a tilt alone": camsim.Wavefront(f_number=8.0, zernike_waves={1: 0.3, 2: -0.2}),
}


@pytest.mark.parametrize("name", ["airy", "coma and a tilt", "annular"])
def test_light_from_far_away(name):
    """A picture of 120 pitches behind 11 photosites, against its squares drawn one by one."""
    planes, optics = np.random.default_rng(8).random((6, 7)), [WAVEFRONTS.get(name, LENS), PHOTOSITE]
    picture = camsim.Picture(planes=planes, width_um=120 * PITCH_UM, rotate_deg=7.0)
    drawn = tiles(planes, 120 * PITCH_UM / 7, np.zeros(2), 7.0)
    right = rendered(*drawn, tolerance=1e-6, optics=optics)
    for tolerance in (1e-2, 1e-4):
        assert worst(rendered(picture, tolerance=tolerance, optics=optics), right) <= tolerance


def test_many_wavelengths_behind_a_wavefront():
    """Wavelengths fused into as many transfers as there are planes, against each on its own."""
    planes = np.random.default_rng(9).random((2, 6, 6)) / 2
    picture = camsim.Picture(planes=planes, spectra=(Curve((400.0, 700.0), (0.0, 1.0)), 0.5), width_um=30.0)
    scene, lens = camsim.Scene(background=0.2, shapes=[picture]), WAVEFRONTS["coma and a tilt"]
    nm, grid = np.linspace(450.0, 650.0, 5), camsim.Grid(rows=4, cols=5, pitch_um=PITCH_UM)
    each = camsim.render(scene, [lens, PHOTOSITE], grid, wavelength_nm=nm, tolerance=1e-6)
    together = render_channels(
        scene, OpticalSystem.of([lens, PHOTOSITE]), grid, response=np.full((1, 5), 0.2), wavelength_nm=nm,
        channel=np.zeros((4, 5), np.uint8), tolerance=1e-5,
    )  # fmt: skip
    assert each.error_estimate <= 1e-6
    assert together.error_estimate <= 1e-5
    assert worst(together.image, each.image.mean(axis=0)) <= 1e-5


def exposed(*shapes, background=0.2, **how):
    camera = camsim.Camera.from_yaml("d40-like", lens=LENS)
    return camera.expose(
        camsim.Scene(background=background, shapes=shapes),
        light=camsim.Light("D55", illuminance_lux=1000.0),
        exposure=camsim.Exposure(time_s=0.01, iso=200.0),
        region=camsim.Region(rows=16, cols=16),
        tolerance=1e-5,
        noise=False,
        **how,
    )


@pytest.mark.parametrize(("rgb", "background"), [((0.7, 0.2, 0.05), 0.2), ((0.4,) * 3, camsim.reflectance("orange"))])
def test_a_colour_is_its_spectrum(rgb, background):
    """Planes of a flat colour, or a grey, give every channel what a rectangle of that reflectance gives it."""
    placed, how = {"width_um": 40.0, "rotate_deg": 5.0}, {"background": background}
    picture = exposed(camsim.Picture.of_rgb(np.full((3, 4, 3), rgb), **placed), **how)
    drawn = exposed(camsim.Rectangle(height_um=30.0, reflectance=reflectance_of_rgb(rgb), **placed), **how)
    full = 1e-5 * drawn.mean_electrons.max() * 4
    assert worst(picture.mean_electrons, drawn.mean_electrons) <= full


def test_grey_stays_grey():
    """Equal components are a flat reflectance, in any light and for any camera, also beside coloured samples."""
    rgb = np.full((4, 4, 3), 0.18)
    grey = exposed(camsim.Picture.of_rgb(rgb, width_um=400.0), background=0.18)
    flat = exposed(background=0.18)
    assert worst(grey.mean_electrons / flat.mean_electrons, 1.0) < 1e-12
    rgb[0, 0] = (0.181, 0.179, 0.179)
    spotted = camsim.Picture.of_rgb(rgb, width_um=4_000.0)
    assert len(spotted.planes) == 3
    grey = exposed(spotted, background=0.18)
    assert worst(grey.mean_electrons / flat.mean_electrons, 1.0) < 1e-6


@pytest.mark.parametrize(
    "cover",
    [
        camsim.Disc(radius_um=11.0, centre_um=(8.0, 5.0), reflectance=0.6),
        camsim.Polygon(points_um=[(-30, -20), (-5, -12), (-22, 6)], reflectance=0.1),
    ],
    ids=["disc", "polygon"],
)
def test_what_checks_pictures_is_right_where_a_shape_cuts_their_samples(cover):
    """At photosites that it does not look at as well: sides of its own that samples cut, and nodes that slide."""
    planes = np.random.default_rng(3).random((5, 7))
    picture = camsim.Picture(planes=planes, width_um=63.0, centre_um=(2.0, -1.0), rotate_deg=23.0)
    drawn = tiles(planes, 9.0, np.array([2.0, -1.0]), 23.0)
    right = rendered(*drawn, cover, tolerance=1e-8, background=0.3, method="boundary")
    choice = plan_render(
        camsim.Scene(background=0.3, shapes=[picture, cover]),
        OpticalSystem.of(OPTICS),
        GRID,
        response=np.ones((1, 1)),
        wavelength_nm=np.array([float(NM)]),
        tolerance=1e-6,
        method="fourier",
    )
    rows, cols = np.divmod(np.arange(0, GRID.rows * GRID.cols, 9), GRID.cols)
    found = choice.checker.values(rows, cols, np.zeros(rows.size, np.uint8))
    assert worst(found, right[rows, cols]) <= 1e-7


@pytest.mark.parametrize("seed", [0, 1])
def test_a_flat_picture_of_which_a_corner_is_hidden(seed):
    """The check took patches beyond a hidden corner for seen, 0.02 off: it asked on the picture's own side."""
    rng = np.random.default_rng(seed)
    side_um, centre = float(rng.uniform(20.0, 40.0)), tuple(rng.uniform(-4.0, 4.0, 2).tolist())
    turn = float(rng.uniform(0.0, 45.0))
    disc = camsim.Disc(radius_um=100.0, centre_um=(104.0, float(rng.uniform(-9.0, 9.0))), reflectance=0.7)
    picture = camsim.Picture(
        planes=np.full((1, 1), 0.27), width_um=side_um, centre_um=centre, rotate_deg=turn, interpolation="linear"
    )
    square = camsim.Rectangle(width_um=side_um, height_um=side_um, centre_um=centre, rotate_deg=turn, reflectance=0.27)
    image = rendered(picture, disc, tolerance=1e-5)
    np.testing.assert_allclose(image, rendered(square, disc, tolerance=1e-6), rtol=0.0, atol=1.1e-5)


def test_a_picture_behind_two_shapes_whose_common_side_is_one_but_for_rounding():
    """All of its visible part was lost, silently behind an elliptical lens: its outline held a sliver without area."""
    samples = [[0.55, 0.71, 0.85, 0.49, 0.48], [0.54, 0.17, 0.01, 0.89, 0.49]]
    place = {"centre_um": (3.6700545060569887, -1.5927007317149524), "rotate_deg": 296.6442729702279}
    picture = camsim.Picture(planes=[samples], width_um=5 * 4.588042872339196, **place)

    def image(off):
        x, y, z = (0.5000000000000007, 1.4033326903789049e-15, 0.4999999999999979) if off else (0.5, 0.0, 0.5)
        above = camsim.Polygon(
            points_um=((0.5, 0.0), (x, 11.459081029370752), (-10.959081029370752, y)), reflectance=0.9
        )
        below = camsim.Polygon(
            points_um=((0.5, 0.0), (-10.959081029370752, y), (z, -11.459081029370752)), reflectance=0.3
        )
        return rendered(picture, above, below, tolerance=1e-5, grid=camsim.Grid(rows=16, cols=16, pitch_um=1.0))

    np.testing.assert_allclose(image(True), image(False), rtol=0.0, atol=1e-9)


def test_a_large_frame_has_tiles_whose_rows_fit_as_well():
    """Of few samples one tile would be the quickest, and with 45 megapixels beside it too large: it was refused."""
    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0)).replace(rows=5478, cols=8216)
    picture = camsim.Picture.of_rgb(np.full((512, 512, 3), 0.5), width_um=5200 * camera.pitch_um)
    capture = camsim.Capture(
        camera=camera,
        scene=camsim.Scene(background=0.2, shapes=[picture]),
        light=camsim.Light("D55", illuminance_lux=2000.0),
        exposure=camsim.Exposure(time_s="auto", iso=200.0),
        tolerance=1e-5,
    )
    assert capture.plan().cost.memory_bytes <= 2e9


@pytest.mark.parametrize("width_um", [1e8, 1e12])
def test_samples_far_larger_than_the_frame_are_refused_in_a_sentence(width_um):
    picture = camsim.Picture(planes=np.ones((3, 40, 60)), width_um=width_um, spectra=(0.3, 0.5, 0.2))
    with pytest.raises(camsim.CamsimError, match=r"pitches wide, and divided .* crop it to what lies near the frame"):
        rendered(picture, tolerance=1e-4, background=0.1)


def test_samples_wider_than_the_frame():
    """White as far as 3300 µm sees white, but for light from beyond its four sides: 2λN/π³d of each at the most."""
    picture = camsim.Picture(planes=np.ones((40, 60)), width_um=1e4, rotate_deg=10.0)
    white = rendered(picture, tolerance=1e-4, background=0.1)
    assert worst(white, 1.0) <= 1e-4 + 4 * 2.0 * 4.0 / (np.pi**3 * 3300.0)


def test_an_ellipse_over_a_picture():
    """Its check drew arcs as chords between their ends, smaller than they are: an alarm of 4 tolerances."""
    picture = camsim.Picture(planes=np.full((3, 5), 0.9), width_um=80.0, interpolation="squares", rotate_deg=45.0)
    drawn = camsim.Rectangle(width_um=80.0, height_um=48.0, reflectance=0.9, rotate_deg=45.0)
    over = camsim.Ellipse(radius_x_um=8.0, radius_y_um=4.0, centre_um=(1.0, 2.0), reflectance=0.1)
    optics = [camsim.Airy(f_number=4.8), camsim.SquarePhotosite(side_um=0.0)]
    how = {"background": 0.5, "optics": optics, "grid": camsim.Grid(rows=16, cols=16, pitch_um=4.0)}
    found, right = (rendered(one, over, tolerance=1e-6, **how) for one in (picture, drawn))
    assert worst(found, right) <= 1e-6


@pytest.mark.parametrize("precision", [1e-4, 1e-8])
@pytest.mark.parametrize(
    ("interpolation", "angle"), [("squares", 31.0), ("linear", 90.0), ("cubic", 0.0), ("cubic", 3.0)]
)
def test_low_frequencies_of_a_thinned_picture(interpolation, angle, precision):
    """Thinned once and twice, against sums over the picture's own nodes."""
    planes, step, centre, far = np.random.default_rng(3).random((60, 47)), 0.6, np.array([2.3, -1.4]), (0.3, 0.07)
    how = {"interpolation": interpolation, "rotate_deg": angle}
    picture = camsim.Picture(planes=planes, width_um=47 * step * PITCH_UM, centre_um=centre * PITCH_UM, **how)
    layer = Layer.of(picture, 0.0, PITCH_UM, None)
    x, y, light = truth.light_of_picture(planes, nodes=4, step=step, centre=centre, **how)
    source = FieldSource(layer=layer, mixture=np.eye(1), cut=1.0, precision=precision, far=far)
    for cut in far:
        lattice = Lattice((128, 120), cut, (-200.0, -200.0), (200.0, 200.0))
        columns, rows = lattice.counts
        fx, fy = np.arange(columns) / 128, np.arange(1 - rows, rows) / 120
        right = np.einsum(
            "ni,nj->ji",
            light[:, None] * np.exp(-2j * np.pi * np.outer(x, fx)),
            np.exp(-2j * np.pi * np.outer(y, fy)),
            optimize=True,
        )
        wrong = np.abs(source.transform(lattice, (0.0, 0.0))[0] - right)[np.hypot(fx, fy[:, None]) <= cut]
        assert wrong.max() <= 2.0 * precision * np.abs(light).sum()
