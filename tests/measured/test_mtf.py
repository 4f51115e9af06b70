"""The MTF measured on edges whose MTF is known: in closed form, and from the optics of a capture."""

import math
import re

import numpy as np
import pytest
import scipy.special
import scipy.stats
from edges import ABERRATED, gaussian_edge, gaussian_limit, gaussian_mtf, gaussian_sigma, pupil_edge
from tolerances import STATISTICAL

import camsim
from camsim.errors import InvalidValueError
from camsim.measure import CameraOtf, EdgeLine, Picture, Plane, Roi, measure_edge, measure_mtf, picture_of_frame
from camsim.measure.crossings import limit
from camsim.measure.find import find_edges
from camsim.measure.fit import _ordinary
from camsim.measure.picture import mosaic_planes
from camsim.optics import OpticalSystem

LIGHT = camsim.Light("D55", illuminance_lux=5000)
EXPOSURE = camsim.Exposure(time_s=0.01, iso=200)


def measured(image, step=1, first=(0, 0), size=64, **options):
    plane = Plane(name="Y", samples=image, step=(step, step), first=first)
    return measure_edge(plane, Roi(0, 0, size, size), **options)


@pytest.mark.parametrize(
    ("angle", "mtf50"),
    list(zip([2, 5, 11, 30, 43, -2, -20, -43, 92, 110, 184, -100], [0.10, 0.25, 0.40] * 4, strict=True)),
)
@pytest.mark.parametrize("step", [1, 2])
def test_an_edge_in_closed_form(angle, step, mtf50):
    sigma = gaussian_sigma(mtf50)
    first = (1, 0) if step == 2 else (0, 0)
    edge = measured(gaussian_edge(64, 64, angle, sigma, step=step, first=first), step, first)
    f, figures = edge.frequency_cycles_per_pixel, edge.figures
    nyquist = 0.5 / step
    assert edge.nyquist_cycles_per_pixel == nyquist
    assert np.abs(edge.mtf - gaussian_mtf(f, sigma))[f <= nyquist].max() < 2e-4
    assert figures.mtf50_cycles_per_pixel == pytest.approx(mtf50, rel=5e-4)
    assert figures.mtf30_cycles_per_pixel == pytest.approx(gaussian_limit(0.3, sigma), rel=5e-4)
    assert figures.mtf10_cycles_per_pixel == pytest.approx(gaussian_limit(0.1, sigma), rel=2e-3)
    assert figures.mtf_at_nyquist == pytest.approx(float(gaussian_mtf(nyquist, sigma)), abs=2e-4)
    assert figures.mtf_at_nyquist_of_sensor == pytest.approx(float(gaussian_mtf(0.5, sigma)), abs=2e-3)
    # 10 to 90 % of a normal distribution: 2·1.2815515655 standard deviations.
    assert figures.rise_10_90_pixel == pytest.approx(2.5631031311 * sigma, rel=1e-3)
    assert figures.contrast == pytest.approx(0.8, abs=1e-4)
    assert figures.angle_deg == pytest.approx((angle + 45) % 90 - 45, abs=2e-3)
    assert (edge.normal_deg - angle + 180) % 360 - 180 == pytest.approx(0, abs=2e-3)


@pytest.mark.parametrize("sensor", ["mono-345", "d40-like"])
@pytest.mark.parametrize("f_number", [2.8, 8.0, 32.0])
@pytest.mark.parametrize("olpf", [True, False])
def test_a_capture_without_noise_shows_its_optics(sensor, f_number, olpf):
    """|ΔMTF| ≤ 0.002 up to Nyquist and MTF50 within 0.1 %; bench/mtf_study.py has all angles and f-numbers."""
    camera = camsim.Camera.from_yaml(sensor, lens=camsim.Airy(f_number=f_number))
    camera = camera.replace(olpf=camsim.FourSpotOlpf(split_um=0.75 * camera.pitch_um) if olpf else None)
    region = camsim.Region(rows=64, cols=64)
    # Each angle is met by both sensors and all f-numbers.
    angle = (2.0, 43.0, -11.0, 97.0)[(2 * (sensor == "d40-like") + olpf + int(f_number)) % 4]
    scene = camsim.Scene(background=0.05, shapes=[half_plane(angle, 0.7)])
    frame = camera.expose(scene, light=LIGHT, exposure=EXPOSURE, region=region, noise=False)
    theory = CameraOtf(camera=camera, scene=scene, light=LIGHT, region=region)
    report = measure_mtf(picture_of_frame(frame, "mean_electrons"), rois=[Roi(0, 0, 64, 64)], theory=theory)
    assert [edge.channel for edge in report.edges] == (["Y"] if sensor == "mono-345" else ["R", "G1", "G2", "B"])
    for edge in report.edges:
        assert edge.theory is not None
        assert edge.theory.difference_to_nyquist < 2e-3
        assert edge.figures.mtf50_cycles_per_pixel == pytest.approx(edge.theory.mtf50_cycles_per_pixel, rel=1e-3)
        assert edge.figures.contrast == pytest.approx(0.85 / 0.95, rel=1e-3)


def half_plane(angle_deg, shift_um=0.0):
    far, turn = 1e5, math.radians(angle_deg)
    centre_um = (0.5 * far * math.cos(turn) + shift_um, 0.5 * far * math.sin(turn))
    return camsim.Rectangle(width_um=far, height_um=4 * far, rotate_deg=angle_deg, centre_um=centre_um, reflectance=0.9)


@pytest.mark.parametrize(("f_number", "obstruction"), [(16, 0.0), (4, 0.3)])
def test_few_wavelengths_stand_for_daylight(f_number, obstruction):
    """A pupil without aberrations against the closed form, each channel's light summed at all of 450 wavelengths."""
    closed = (
        camsim.AnnularAiry(f_number=f_number, obstruction=obstruction)
        if obstruction
        else camsim.Airy(f_number=f_number)
    )
    lens = camsim.Wavefront(f_number=f_number, pupil=camsim.optics.Pupil(obstruction=obstruction))
    check_theory(lens, closed, np.linspace(0.0, 1.0, 60), within=1e-3)
    check_theory(closed, closed, np.linspace(0.0, 1.0, 60), within=1e-4)


def test_wavelengths_follow_what_an_aberrated_pupil_turns_by():
    """Five waves from end to end of daylight, against the integral over the pupil at each twelfth wavelength."""
    lens = camsim.Wavefront(f_number=4.0, zernike_waves={4: 2.0, 12: 0.5})
    check_theory(lens, lens, np.array([0.02, 0.05, 0.15]), within=1e-3, every=12)


def check_theory(lens, exact, frequency, *, within, every=1):
    """Hold the theory against a sum over the wavelengths of the light, of one lens's transfer at each."""
    camera, light = camsim.Camera.from_yaml("d40-like", lens=lens), camsim.Light("D55", illuminance_lux=5000)
    theory = CameraOtf(camera=camera, scene=camsim.Scene(background=0.9), light=light)
    samples = camera.samples(light)
    response = camera.electrons_per_reflectance(samples, 1.0)[:, ::every]
    fx, fy = 0.8 * frequency, -0.6 * frequency
    at = fx / camera.pitch_um, fy / camera.pitch_um
    footprint = camera.optics.footprint_otf(*at)
    each = np.array([exact.otf(*at, nm) for nm in samples.wavelength_nm[::every].tolist()])
    for channel, weight in zip(("R", "G1", "B"), response, strict=True):
        expected = weight @ each / weight.sum()
        np.testing.assert_allclose(
            theory.at(fx, fy, channel, 0.0, 1.0), footprint * expected, rtol=0.0, atol=within * np.abs(footprint).max()
        )
        np.testing.assert_allclose(
            theory.at(fx, fy, channel, 0.0, 1.0, lens_alone=True), expected, rtol=0.0, atol=within
        )


def test_the_theory_of_ones_own_is_judged():
    """A surface given as a curve was dark beyond its table."""
    camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=8.0))
    scene, light = camsim.Scene(background=0.9), camsim.Light("D55", illuminance_lux=500.0)
    theory, fx, fy = CameraOtf(camera=camera, scene=scene, light=light), np.array([0.1, 0.4]), np.zeros(2)
    green = camsim.Curve((540.0, 560.0), (0.8, 0.8))
    np.testing.assert_allclose(theory.at(fx, fy, "Y", 0.0, green), theory.at(fx, fy, "Y", 0.0, 0.8), rtol=1e-9)
    with pytest.raises(InvalidValueError, match=r"CameraOtf.dark: must be a number from 0 to 1"):
        theory.at(fx, fy, "Y", -0.1, green)


@pytest.mark.parametrize("normal_deg", [0.0, 30.0, 90.0, -120.0])
def test_the_theory_of_an_oblique_edge_has_each_axis_own_part(normal_deg):
    """A plate that splits along x and a photosite wider than high: x counts by the cosine, y by the sine."""
    camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=8.0)).replace(
        olpf=camsim.TwoSpotOlpf(split_um=2.5),
        photosite=camsim.RectangularPhotosite(width_um=3.4, height_um=2.0),
    )
    turn = math.radians(normal_deg)
    across = (1e3 * math.cos(turn), 1e3 * math.sin(turn))
    dark = camsim.Rectangle(width_um=2e3, height_um=2e3, rotate_deg=normal_deg, centre_um=across, reflectance=0.05)
    scene, light = camsim.Scene(background=0.9, shapes=[dark]), camsim.Light(line_nm=550.0, illuminance_lux=5000)
    line = EdgeLine(x_pixel=0.5 * camera.cols, y_pixel=0.5 * camera.rows, normal_rad=turn + math.pi)
    f = np.array([0.0, 0.1, 0.25, 0.4])
    fx, fy = (f / 3.45 * part for part in (math.cos(turn), math.sin(turn)))
    overlap = np.array([1 - 4 / math.pi * _half_lens(x) for x in f / 3.45 * 0.55 * 8.0])
    expected = overlap * np.cos(np.pi * 2.5 * fx) * np.sinc(3.4 * fx) * np.sinc(2.0 * fy)
    theory = CameraOtf(camera=camera, scene=scene, light=light)
    np.testing.assert_allclose(theory.along_normal(f, channel="Y", line=line), expected, atol=1e-9)
    assert theory.along_normal(f, channel="G1", line=line) is None


def test_a_picture_that_a_tilt_has_moved_has_the_theory_of_its_edge():
    """2.6 px to the right, and 5.1, where both of its sides were looked for on one."""
    camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=8.0))
    light = camsim.Light(line_nm=550.0, illuminance_lux=5000)
    dark = camsim.Rectangle(width_um=2e3, height_um=2e3, centre_um=(-1e3, 0.0), reflectance=0.05)
    scene, f = camsim.Scene(background=0.9, shapes=[dark]), np.array([0.1, 0.25, 0.4])
    seen = []
    for waves in (0.0, 0.5, 1.0):
        # 2·cos θ·r waves: the slope over the radius is twice the coefficient, and 2Nλ of it is the way.
        tilted = camera.replace(lens=camsim.Wavefront(f_number=8.0, zernike_waves=[(2, waves)]))
        moved_pixel = 2.0 * 8.0 * 0.55 * 2.0 * waves / camera.pitch_um
        line = EdgeLine(x_pixel=0.5 * camera.cols + moved_pixel, y_pixel=0.5 * camera.rows, normal_rad=0.0)
        seen.append(CameraOtf(camera=tilted, scene=scene, light=light).along_normal(f, channel="Y", line=line))
    np.testing.assert_allclose(seen[1], seen[0], atol=1e-6)
    np.testing.assert_allclose(seen[2], seen[0], atol=1e-6)


@pytest.mark.parametrize("sides", [(), (-1,), (1,), (-1, 1)])
def test_the_surfaces_of_an_edge_are_looked_up_three_pixels_beside_it(sides):
    """Marks a third of a pixel wide on an even background: an edge is seen where just one side has its mark."""
    camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=8.0))
    region, turn = camsim.Region(rows=40, cols=50, origin=(600, 100)), math.radians(-110.0)
    x, y = 20.25, 18.75  # in the window, from its upper left corner
    marks = [
        camsim.Rectangle(
            width_um=0.3 * camera.pitch_um,
            height_um=0.3 * camera.pitch_um,
            centre_um=(
                (100 + x + 3.0 * side * math.cos(turn) - 0.5 * camera.cols) * camera.pitch_um,
                (600 + y + 3.0 * side * math.sin(turn) - 0.5 * camera.rows) * camera.pitch_um,
            ),
            reflectance=0.2,
        )
        for side in sides
    ]
    theory = CameraOtf(camera=camera, scene=camsim.Scene(background=0.9, shapes=marks), light=LIGHT, region=region)
    line = EdgeLine(x_pixel=x, y_pixel=y, normal_rad=turn)
    seen = theory.along_normal(np.array([0.0]), channel="Y", line=line) is not None
    assert seen == (len(sides) == 1)


def _half_lens(u):
    """∫₀^u √(1 − t²) dt by brute force: what two circles u·diameter apart do not share."""
    t = (np.arange(200_000) + 0.5) / 200_000 * u
    return float(np.sqrt(1 - t * t).mean() * u)


def test_what_lies_beyond_the_region_is_added_or_left_out():
    """The plain figure of ±32 px is too high at f/32, and by as much as the line spread beyond says."""
    camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=32.0))
    scene, region = camsim.Scene(background=0.05, shapes=[half_plane(6.0)]), camsim.Region(rows=64, cols=64)
    frame = camera.expose(scene, light=LIGHT, exposure=EXPOSURE, region=region, noise=False)
    theory = CameraOtf(camera=camera, scene=scene, light=LIGHT, region=region)
    plane_y = picture_of_frame(frame, "mean_electrons").planes[0]
    whole, plain = (measure_edge(plane_y, Roi(0, 0, 64, 64), tail=tail, theory=theory) for tail in (True, False))
    right = whole.theory.mtf50_cycles_per_pixel
    assert whole.tail
    assert not plain.tail
    assert whole.figures.mtf50_cycles_per_pixel == pytest.approx(right, rel=1e-3)
    assert 1.01 < plain.figures.mtf50_cycles_per_pixel / right < 1.06
    # A half-plane at distance h takes 2λN/(π³h) of the light (design of the renderer); both sides at 32 px.
    lambda_n_px = 32.0 * 0.56 / 3.45
    assert whole.tail_fraction == pytest.approx(2 * 2 * lambda_n_px / (math.pi**3 * 32), rel=0.1)


def test_a_bent_edge_is_followed():
    sigma = 0.8
    straight, bent = (measured(gaussian_edge(64, 64, 5, sigma, bend=bend)) for bend in (0.0, 1e-3))
    assert bent.curvature_per_pixel == pytest.approx(1e-3, rel=0.01)
    assert bent.figures.mtf50_cycles_per_pixel == pytest.approx(straight.figures.mtf50_cycles_per_pixel, rel=1e-3)


def test_a_wide_edge_has_a_note_of_what_aberrations_may_do():
    """By transfers of pupils MTF50 is low by 3 to 13 % of that share (the table of docs/mtf.md)."""
    plane_y = Plane(name="Y", samples=gaussian_edge(64, 64, 7, 3.0))
    whole, plain = (measure_edge(plane_y, Roi(0, 0, 64, 64), tail=tail) for tail in (True, False))
    (note,) = whole.notes
    assert re.search(r"rises over 2[3-5] % .* off by up to 3\.\d %", note.text)
    assert plain.notes == measured(gaussian_edge(64, 64, 7, 1.2)).notes == ()


def aberrated(size, waves, *, f_number=8.0, pitch_um=4.88, side=1.0):
    """An edge behind a lens with aberrations, the light of its other side on request, and its MTF50."""
    lens, angle = camsim.Wavefront(f_number=f_number, zernike_waves=waves), math.radians(5.3)
    system = OpticalSystem.of([lens, camsim.SquarePhotosite(side_um=pitch_um)])
    along = side * math.cos(angle) / pitch_um, side * math.sin(angle) / pitch_um
    cutoff = pitch_um * system.cutoff_per_um(550.0)
    return pupil_edge(size, 5.3, lambda f: system.otf(f * along[0], f * along[1], 550.0), cutoff)


def test_noise_hides_nothing_of_what_coma_throws():
    """Its tail on the dark side, in a small region: 2.7 % high with knots so wide that it was taken for shading."""
    image, half = aberrated(48, {4: 0.2, 8: 0.15})
    rng, found = np.random.default_rng(3), []
    for _ in range(12):
        noisy = image + rng.normal(0.0, 0.009, image.shape)
        found.append(measured(noisy, size=48).figures.mtf50_cycles_per_pixel)
    assert np.mean(found) == pytest.approx(half, rel=0.017)  # four standard errors


@pytest.mark.parametrize(
    ("name", "size", "side"), [*((name, 48, 1.0) for name in ABERRATED), ("defocus 0.2, coma 0.15", 128, -1.0)]
)
def test_aberrations_stay_within_stated_errors(name, size, side):
    """What they throw beyond a region passes for shading; MTF50 is then low, and the error says by how much."""
    image, half = aberrated(size, ABERRATED[name], f_number=5.6, pitch_um=3.45, side=side)
    edge = measured(image, size=size)
    error = edge.standard_error.mtf50_cycles_per_pixel
    assert abs(edge.figures.mtf50_cycles_per_pixel - half) <= 2.5 * error
    assert error < (0.04 if size == 48 else 0.006) * half


def test_a_disc_tells_the_same_as_a_straight_edge():
    """A Gaussian's light within a disc is Rice's distribution; the rim is an arc, and no parabola."""
    radius, sigma, turn = 100.0, 1.0, math.radians(20.0)
    y, x = np.mgrid[:64, :64] + 0.5 - 32.0
    far = np.hypot(x + radius * math.cos(turn), y + radius * math.sin(turn))
    edge = measured(0.9 - 0.8 * scipy.stats.ncx2.cdf((radius / sigma) ** 2, 2, (far / sigma) ** 2))
    assert edge.figures.mtf50_cycles_per_pixel == pytest.approx(gaussian_limit(0.5, sigma), rel=3e-4)
    assert edge.curvature_per_pixel == pytest.approx(-1.0 / radius, rel=0.01)


@pytest.mark.parametrize("direction", ["across", "along"])
def test_shading_does_not_count_as_blur(direction):
    """Light that falls by 10 % over the region."""
    ramp = np.linspace(1.05, 0.95, 64)
    image = gaussian_edge(64, 64, 5, 0.8) * (ramp if direction == "across" else ramp[:, None])
    mtf50 = measured(image).figures.mtf50_cycles_per_pixel
    assert mtf50 == pytest.approx(gaussian_limit(0.5, 0.8), rel=2e-3)


@pytest.mark.parametrize(("along_x", "along_y"), [(0.0024, -0.0032), (0.003, 0.0)])
def test_steep_lamps_do_not_blur_either(along_x, along_y):
    """Light that doubles over the region: what the sides have at the edge is not what they have in their middles."""
    sigma, middle = 1.5, np.arange(96) - 47.5
    image = gaussian_edge(96, 96, -23.6, sigma, dark=1.0 / 3.0, bright=1.0, shift_px=0.0)
    edge = measured(image * (1.0 + along_x * middle + along_y * middle[:, None]), size=96)
    figures = edge.figures
    assert figures.mtf50_cycles_per_pixel == pytest.approx(gaussian_limit(0.5, sigma), rel=1e-3)
    assert figures.rise_10_90_pixel == pytest.approx(2.5631031311 * sigma, rel=2e-3)
    assert figures.contrast == pytest.approx(0.5, abs=5e-4)
    assert figures.angle_deg == pytest.approx(-23.6, abs=0.02)


@pytest.mark.parametrize(("along_x", "along_y"), [(0.15, 0.15), (0.0, -0.15)])
@pytest.mark.parametrize("wide", [False, True])
def test_tilted_light_turns_no_edge(rng, along_x, along_y, wide):
    """±15 % over the region, of edges whose shape is no error function: angle and MTF50 are within their errors."""
    ramp = np.linspace(-1.0, 1.0, 64)
    narrow, broad = (gaussian_edge(64, 64, 7.3, sigma, dark=0.05, bright=0.9) for sigma in (0.5, 3.0 if wide else 1.0))
    image = (0.6 * narrow + 0.4 * broad) * (1.0 + along_x * ramp + along_y * ramp[:, None])
    f = np.linspace(0.0, 1.0, 20_001)
    mtf = 0.6 * gaussian_mtf(f, 0.5) + 0.4 * gaussian_mtf(f, 3.0 if wide else 1.0)
    for noise in (0.0, 0.002):
        edge = measured(image + rng.normal(0.0, noise, image.shape) if noise else image)
        assert abs(edge.figures.angle_deg - 7.3) < 4.0 * edge.standard_error.angle_deg + 2e-5
        mtf50 = float(np.interp(-0.5, -mtf, f))
        assert abs(edge.figures.mtf50_cycles_per_pixel - mtf50) < 4.0 * edge.standard_error.mtf50_cycles_per_pixel


def test_defects_are_left_out(rng):
    image = gaussian_edge(64, 64, 5, 0.8) + rng.normal(0, 0.002, (64, 64))
    clean = measured(image).figures.mtf50_cycles_per_pixel
    image[rng.integers(0, 64, 12), rng.integers(0, 64, 12)] = 2.0
    edge = measured(image)
    assert edge.left_out == 12
    assert "12 photosites" in edge.notes[0].text
    assert edge.figures.mtf50_cycles_per_pixel == pytest.approx(clean, rel=2e-3)


def test_standard_errors_are_true(rng):
    """64 draws of even noise at SNR 100: no bias beyond its own error, and errors true to a third."""
    image = gaussian_edge(64, 64, 5, gaussian_sigma(0.25))
    values, errors = [], []
    for _ in range(64):
        edge = measured(image + rng.normal(0.0, 0.008, image.shape))
        figures, error = edge.figures, edge.standard_error
        names = ("mtf50_cycles_per_pixel", "rise_10_90_pixel", "angle_deg", "contrast", "snr")
        at = np.searchsorted(edge.frequency_cycles_per_pixel, 0.1)
        values.append([getattr(figures, name) for name in names] + [edge.mtf[at]])
        errors.append([getattr(error, name) for name in names] + [edge.mtf_error[at]])
    values, errors = np.array(values), np.array(errors)
    spread = values.std(axis=0, ddof=1)
    ratio = np.sqrt((errors**2).mean(axis=0)) / spread
    # The spread of 64 draws is itself known to 9 %.
    assert np.all(np.abs(ratio - 1.0) < 0.33), ratio
    assert abs(values[:, 0].mean() - 0.25) < STATISTICAL * spread[0] / math.sqrt(len(values))
    assert values[:, 4].mean() == pytest.approx(100, rel=0.02)


@pytest.mark.parametrize(("angle", "lines"), [(95, "rows"), (-4, "columns")])
def test_noise_that_rows_or_columns_share_is_in_the_errors(rng, angle, lines):
    """An edge along them: of independent photosites the contrast's error would be a fifth, the angle's a third."""
    image = gaussian_edge(64, 64, angle, 0.8)
    off = []
    for _ in range(32):
        shared = rng.normal(0.0, 0.012, (64, 1))
        edge = measured(image + rng.normal(0.0, 0.012, image.shape) + (shared if lines == "rows" else shared.T))
        figures, error = edge.figures, edge.standard_error
        f = edge.frequency_cycles_per_pixel
        stated = (f > 0.02) & (f < 0.3)
        curve = (edge.mtf - gaussian_mtf(f, 0.8))[stated] / edge.mtf_error[stated]
        turned = figures.angle_deg - ((angle + 45) % 90 - 45)
        pulls = [(figures.contrast - 0.8) / error.contrast, turned / error.angle_deg]
        off.append([*pulls, math.sqrt(np.mean(curve**2))])
    assert np.all(np.sqrt(np.mean(np.square(off), axis=0)) < 1.5)
    assert np.sqrt(np.mean(np.square(off), axis=0))[0] > 0.6


@pytest.mark.parametrize("pattern", [("Y",), ("RG", "GB")])
def test_regions_lie_in_the_middle_of_their_sides(rng, pattern):
    """Turned rectangles at places between pixels: each side's region is about its middle, and no side is left out."""
    y, x = np.mgrid[:200, :220] + 0.5
    aside = []
    for _ in range(20):
        cx, cy, turn = 110.0 + rng.uniform(-4, 4), 100.0 + rng.uniform(-4, 4), math.radians(rng.uniform(4.0, 12.0))
        u = (x - cx) * math.cos(turn) + (y - cy) * math.sin(turn)
        v = (y - cy) * math.cos(turn) - (x - cx) * math.sin(turn)
        image = 0.8 - 0.6 * _step(u + 60) * _step(60 - u) * _step(v + 50) * _step(50 - v)
        picture = Picture(name="a square", shape=image.shape, planes=mosaic_planes(image, pattern))
        regions = [best for best, *_ in find_edges(picture).edges]
        assert len(regions) == 4
        for roi in regions:
            dx, dy = roi.col + 0.5 * roi.cols - cx, roi.row + 0.5 * roi.rows - cy
            u, v = dx * math.cos(turn) + dy * math.sin(turn), dy * math.cos(turn) - dx * math.sin(turn)
            upright = abs(u) / 60 > abs(v) / 50
            off = (u - math.copysign(60, u), v) if upright else (u, v - math.copysign(50, v))
            aside.append((off[0] + 1j * off[1]) * np.exp(1j * turn))
    # Regions begin at even rows and columns: 1 px at most, and nothing in the mean.
    assert np.abs(aside).max() < 3.5
    assert abs(np.mean(aside)) < 0.25


def test_a_large_region_is_measured_with_all_that_is_near_the_edge():
    """Of 160 000 photosites the edge's few thousand, and of the even surfaces beside it as many as tell their level."""
    edge = measured(gaussian_edge(400, 400, 5, 0.8), size=400)
    assert edge.figures.mtf50_cycles_per_pixel == pytest.approx(gaussian_limit(0.5, 0.8), rel=1e-5)
    assert 101_000 < edge.photosites < 120_000


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_the_unit_of_the_numbers_is_no_matter(scale):
    image = gaussian_edge(64, 64, 5, 0.8)
    one, other = (measured(factor * image) for factor in (1.0, scale))
    assert other.figures.mtf50_cycles_per_pixel == pytest.approx(one.figures.mtf50_cycles_per_pixel, rel=1e-9)
    assert other.figures.contrast == pytest.approx(one.figures.contrast, rel=1e-9)
    assert other.left_out == one.left_out


def _step(distance):
    return scipy.special.ndtr(distance / 0.7)


def test_a_defect_is_told_by_the_noise_of_its_own_side():
    """Dark photosites scatter by 0.01 here, bright ones by 0.1: 0.2 is far off for the ones, usual for the others."""
    rng = np.random.default_rng(3)
    distance = np.linspace(-20.0, 20.0, 2001)
    residual = rng.normal(0.0, np.where(distance < 0.0, 0.01, 0.1))
    for place, usual in ((-15.0, False), (-2.0, True), (15.0, True)):
        here = int(np.argmin(np.abs(distance - place)))
        lifted = residual.copy()
        lifted[here] = 0.2
        keep = _ordinary(distance, lifted, half_width=5.0)
        assert keep[here] == usual
        assert np.delete(keep, here).mean() > 0.99


def test_a_curve_that_lingers_above_a_level_does_not_know_where_it_falls():
    """Half of what two standard errors move the crossing by, and not the error over the slope just there: 0.002."""
    frequency, mtf = np.array([0.0, 0.4, 0.6, 0.61, 1.0]), np.array([1.0, 0.52, 0.505, 0.4, 0.0])
    fine = np.linspace(0.0, 1.0, 1001)
    curve = np.interp(fine, frequency, mtf)

    def at(f):
        return np.interp(f, frequency, mtf)

    found, error = limit(fine, curve, np.full_like(fine, 0.02), 0.5, at)
    assert found == pytest.approx(0.6 + 0.01 * 0.005 / 0.105, abs=1e-4)
    assert error == pytest.approx(0.5 * (found - 0.4 * (1.0 - 0.54) / 0.48), abs=1e-3)
