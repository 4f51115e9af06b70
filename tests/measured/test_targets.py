"""The MTF of stars and textures, and acutance, against the optics that made them."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import integrate
from tolerances import STATISTICAL

import camsim
from camsim.errors import UnsupportedError
from camsim.measure import Picture, Plane, picture_of_frame, read_picture
from camsim.measure.acutance import acutance
from camsim.measure.colour import measure_colour
from camsim.measure.distortion import measure_distortion
from camsim.measure.lens_places import refuse_distortion
from camsim.measure.target import measure_moire, measure_star, measure_texture

LEAVES = (
    "scene.shapes=[{kind: chart, name: dead-leaves, width: 90, height: 90, least_radius: 1.5, "
    "largest_radius: 12, seed: 3}]"
)


def star(*changes):
    chart = (
        "scene.shapes=[{kind: chart, name: siemens-star, radius: 44, cycles: %d, light: 0.9, rotate_deg: 2, "
        "centre: [0.3, -0.2]}]"
    )
    cycles = 24 if "sensor" in changes else 36
    return camsim.load(
        "siemens-star",
        sensor="d40-like" if "sensor" in changes else None,
        overrides=["region={rows: 80, cols: 80}", "lens.f_number=11", chart % cycles],
    )


@pytest.mark.parametrize("sensor", ["", "sensor"])
def test_a_star_tells_the_mtf_of_lens_olpf_and_photosite(sensor):
    capture = star(sensor)
    report = measure_star(picture_of_frame(capture.frame()), capture)
    assert [each.channel for each in report.channels] == (["R", "G1", "G2", "B"] if sensor else ["Y"])
    for each in report.channels:
        off = (each.mtf - each.theory)[each.frequency_cycles_per_pixel < 0.9 * each.nyquist_cycles_per_pixel]
        assert np.abs(off).max() < 0.02
        if not sensor:
            assert each.mtf50_cycles_per_pixel == pytest.approx(each.theory_mtf50_cycles_per_pixel, rel=0.005)
            assert each.mtf50_error < 0.005 * each.mtf50_cycles_per_pixel


PLATE = "scene.shapes=[{kind: chart, name: zone-plate, radius: 50, rim_period: 0.72, dark: 0.1}]"
BENT = "sensor.charge.nonlinearity={kind: polynomial, coefficients: [-0.2], scale_e: 10700}"


@pytest.mark.parametrize(
    "changes",
    [
        ["lens.f_number=16"],
        ["lens.f_number=8", "scene.background.reflectance=0.9"],
        ["lens.f_number=8", "lens.falloff={kind: cos4, exit_pupil_mm: 1}"],
        ["lens.f_number=4"],
        ["lens.f_number=8", BENT],
        ["lens.f_number=8", "lens.veiling_glare=0.1"],
    ],
    ids=["rim", "bright beside it", "fall-off", "fifth harmonic", "bent", "glare"],
)
def test_outer_rings_are_right_too(changes):
    """The shipped star, 0.004 to 0.026 too low: light from beyond its rim, harmonics on the lattice, the read-out."""
    size = [] if changes == ["lens.f_number=4"] else ["region={rows: 184, cols: 184}"]
    capture = camsim.load(
        "siemens-star", overrides=["noise.enabled=false", "render.tolerance=1e-3", *size, *changes], sensor="mono-345"
    )
    (grey,) = measure_star(picture_of_frame(capture.frame()), capture).channels
    assert np.abs(grey.mtf - grey.theory)[:12].max() < 0.0025


@pytest.mark.parametrize(
    ("measure", "scene", "chart"),
    [
        (measure_texture, "dead-leaves", LEAVES),
        (measure_moire, "zone-plate", PLATE),
    ],
)
def test_a_bent_read_out_is_made_straight(measure, scene, chart):
    """Electrons with noise come after the read-out, mean electrons before it."""
    changes = [chart, "sensor.photosite={kind: square, fill_factor: 0.4}", "region={rows: 104, cols: 104}", BENT]
    changes += ["render.tolerance=1e-3", "noise.enabled=false"]
    capture = camsim.load(scene, overrides=changes, sensor="mono-345")
    frame = capture.frame()
    tells = []
    for product in ("electrons", "mean_electrons"):
        report = measure(picture_of_frame(frame, product), capture)
        tells.append(report.channels[0].mtf if measure is measure_texture else [g.contrast for g in report.ghosts])
    np.testing.assert_allclose(*tells, atol=1e-4)


@pytest.mark.parametrize("measure", [measure_star, measure_texture])
def test_a_picture_that_has_moved_is_no_softer(measure):
    """All charge goes to the photosite below. The star's MTF was negative, the leaves' half as wide."""
    if measure is measure_star:
        capture = replace(star(), noise=False)
    else:
        changes = [LEAVES, "region={rows: 72, cols: 72}", "lens.f_number=11", "render.tolerance=1e-3"]
        capture = camsim.load("dead-leaves", overrides=[*changes, "noise.enabled=false"])
    one_off = camsim.Crosstalk(kernel=((0, 0, 0), (0, 0, 0), (0, 1, 0)))
    moved = replace(capture, camera=capture.camera.replace(crosstalk=one_off))
    there, here = (measure(picture_of_frame(each.frame(), "mean_electrons"), each) for each in (moved, capture))
    (off,), (grey,) = there.channels, here.channels
    assert off.theory_mtf50_cycles_per_pixel == pytest.approx(grey.theory_mtf50_cycles_per_pixel, rel=2e-3)
    assert off.mtf50_cycles_per_pixel == pytest.approx(grey.theory_mtf50_cycles_per_pixel, rel=0.02)
    same = np.interp(off.frequency_cycles_per_pixel, grey.frequency_cycles_per_pixel, grey.theory)
    assert np.abs(off.mtf - same)[off.frequency_cycles_per_pixel < 0.4].max() < 0.03


def test_dead_leaves_tell_the_mtf_by_their_own_truth():
    """In noise too, which a power spectrum would count as sharpness."""
    changes = [LEAVES, "region={rows: 72, cols: 72}", "lens.f_number=11", "render.tolerance=1e-3"]
    capture = camsim.load("dead-leaves", overrides=[*changes, "exposure.iso=800"])
    report = measure_texture(picture_of_frame(capture.frame()), capture)
    (grey,) = report.channels
    assert grey.mtf50_cycles_per_pixel == pytest.approx(grey.theory_mtf50_cycles_per_pixel, rel=0.02)
    assert grey.mtf50_error < 0.025 * grey.mtf50_cycles_per_pixel
    off = (grey.mtf - grey.theory) / grey.mtf_error
    assert np.sqrt(np.mean(off**2)) < 2.0


@pytest.fixture(scope="module")
def in_the_dark(tmp_path_factory):
    """A star and leaves with more dark charge than light, in every file that can be measured."""
    place = tmp_path_factory.mktemp("dark")
    made = {}
    for measure, scene, chart in (
        (measure_star, "siemens-star", "siemens-star, radius: 44, cycles: 36, light: 0.9, centre: [0.3, -0.2]"),
        (measure_texture, "dead-leaves", "dead-leaves, width: 90, height: 90, least_radius: 1.5, largest_radius: 12"),
    ):
        chart = f"scene.shapes=[{{kind: chart, name: {chart}}}]"
        dark = ["exposure={time_s: 0.002, iso: 100}", "sensor.charge.dark_current_e_per_s=2e6"]
        size = ["region={rows: 48, cols: 48}", "lens.f_number=11", "render.tolerance=1e-3"]
        capture = camsim.load(scene, sensor="mono-345", overrides=[chart, *size, *dark])
        frame = capture.frame(products=("mosaic", "truth"))
        for file in ("a.dng", "a.tiff", "a.png:mosaic", "a.npz", "e.exr:electrons", "t.dng:truth", "t.exr:truth"):
            name, _, product = file.partition(":")
            frame.save(place / f"{scene}-{name}", product=product or None)
        made[measure] = capture, frame, str(place / scene)
    return made


LAYERS = [
    ("a.dng", None), ("a.npz", "electrons"), ("e.exr", "mean"), ("t.dng", None), ("t.exr", None), (None, "mosaic"),
    (None, "truth"), ("a.tiff", None), ("a.png", None), ("a.npz", "mosaic"), ("a.npz", "mean_electrons"),
    ("e.exr", "noisy"), (None, "electrons"), (None, "mean_electrons"),
]  # fmt: skip


# A texture's reference is rendered each time: three hold every kind of layer.
@pytest.mark.parametrize(
    ("measure", "file", "layer"),
    [(measure_star, *one) for one in LAYERS] + [(measure_texture, *one) for one in (LAYERS[0], LAYERS[2], LAYERS[4])],
)
def test_dark_charge_is_no_blur_in_any_file(in_the_dark, measure, file, layer):
    """A texture's MTF was 0.6094 for 0.9575; a star's was too low in electrons with noise, too high in a truth."""
    capture, frame, stem = in_the_dark[measure]
    picture = picture_of_frame(frame, layer) if file is None else read_picture(f"{stem}-{file}", layer=layer)
    (found,) = measure(picture, capture).channels
    weight = (found.theory / found.mtf_error) ** 2
    level = np.sum(weight * found.mtf / found.theory) / np.sum(weight)
    # Beside chance: bins of a star's rings and of a texture's window, and blur that its reference is rendered with.
    assert level == pytest.approx(1.0, abs=STATISTICAL / math.sqrt(np.sum(weight)) + 0.01)


def test_acutance_is_the_integral_over_what_the_eye_sees():
    f = np.linspace(0.0, 1.0, 401)
    curve = np.exp(-5.0 * f)
    got = acutance(f, curve, rows=1000, distance_picture_heights=2.0)
    per_degree = 1000 * 2.0 * math.pi / 180.0

    def csf(nu):
        return 75.0 * nu**0.8 * math.exp(-0.2 * nu) / 34.05  # IEEE 1858's constants, which cancel

    seen = integrate.quad(lambda nu: csf(nu) * math.exp(-5.0 * nu / per_degree), 0.0, per_degree, epsrel=1e-10)[0]
    assert got == pytest.approx(seen / integrate.quad(csf, 0.0, 300.0, epsrel=1e-10)[0], rel=1e-4)


@pytest.mark.parametrize(
    ("measure", "scene"),
    [
        (measure_star, "siemens-star"),
        (measure_texture, "dead-leaves"),
        (measure_moire, "zone-plate"),
        (measure_distortion, "dot-grid"),
        (measure_colour, "colorchecker"),
    ],
)
def test_a_picture_of_another_size_than_its_capture_is_refused(measure, scene):
    capture = camsim.load(scene, overrides=["region={rows: 120, cols: 120}"])
    picture = Picture(name="cut.dng", shape=(120, 118), planes=(Plane(name="Y", samples=np.zeros((120, 118))),))
    with pytest.raises(UnsupportedError, match=r"cut\.dng: it has 120 × 118 photosites and its capture 120 × 120"):
        measure(picture, capture)


@pytest.mark.parametrize(
    ("measure", "scene", "what"),
    [
        (measure_star, "siemens-star", "a star"),
        (measure_texture, "dead-leaves", "a texture"),
        (measure_moire, "zone-plate", "a zone plate"),
    ],
)
def test_what_a_lens_bends_is_refused(measure, scene, what):
    """Distortion by 2 % at 85 px, and by as much as is let through."""
    capture = camsim.load(scene, overrides=["region={rows: 120, cols: 120}"])
    picture = Picture(name="bent.dng", shape=(120, 120), planes=(Plane(name="Y", samples=np.zeros((120, 120))),))
    lens = {"f_number": 4.0, "wavelength_nm": [550], "zernike": [4], "waves": [[[0.0], [0.0]]], "height_um": [0, 300]}
    bent = capture.camera.replace(lens=camsim.FieldLens(**lens, distortion_powers=[-0.02]))
    with pytest.raises(
        UnsupportedError, match=rf"bent\.dng: the lens moves the scene by up to 1\.\d+ px here, and {what} is"
    ):
        measure(picture, replace(capture, camera=bent))
    straight = capture.camera.replace(lens=camsim.FieldLens(**lens, distortion_powers=[-0.001]))
    refuse_distortion(replace(capture, camera=straight), "straight.dng", "a star is")


def test_what_shows_no_star_or_no_structure_is_refused():
    capture = camsim.load("siemens-star", overrides=["region={rows: 40, cols: 40}", "scene.shapes=[]"])
    picture = picture_of_frame(capture.frame())
    with pytest.raises(UnsupportedError, match="no chart siemens-star"):
        measure_star(picture, capture)
    with pytest.raises(UnsupportedError, match="no structure to measure"):
        measure_texture(picture, capture)


@pytest.mark.parametrize(("noise", "exit_pupil_mm"), [("true", 0.5), ("true", 20.0), ("false", 1.5)])
def test_fall_off_is_no_structure(noise, exit_pupil_mm):
    """It gave an MTF of 4.25 and −13.87; a lens changes structure and no fall-off."""
    falloff = f"lens.falloff={{kind: cos4, exit_pupil_mm: {exit_pupil_mm}}}"
    changes = ["region={rows: 48, cols: 48}", "scene.shapes=[]", falloff, f"noise.enabled={noise}"]
    capture = camsim.load("dead-leaves", overrides=changes)
    with pytest.raises(UnsupportedError, match=r"no structure to measure: its contrast here is 0 % fall-off apart"):
        measure_texture(picture_of_frame(capture.frame()), capture)


def test_points_that_noise_hides_are_left_out():
    """Of 0.3 electrons a photosite, the MTF was −4.9 and 5.5; without light at all nothing is left."""
    for scene, measure, side in (("dead-leaves", measure_texture, 48), ("siemens-star", measure_star, 72)):
        size = [f"region={{rows: {side}, cols: {side}}}", "render.tolerance=1e-2"]
        dim = camsim.load(scene, sensor="mono-345", overrides=[*size, "exposure.time_s=2e-6"])
        (found,) = measure(picture_of_frame(dim.frame()), dim).channels
        assert found.mtf_error.max() < 1.0
        unlit = camsim.load(scene, sensor="mono-345", overrides=[*size, "exposure.time_s=1e-9"])
        with pytest.raises(UnsupportedError, match="more light"):
            measure(picture_of_frame(unlit.frame()), unlit)
