"""Far light of aberrated round pupils is what their rims throw: against patterns, and transforms of all at once."""

import dataclasses

import numpy as np
import pytest

import camsim
from camsim.optics import FourSpotOlpf, OpticalSystem, PolygonPhotosite, Pupil, SquarePhotosite, Wavefront
from camsim.optics.difference import Difference, _rim_of
from camsim.optics.rim_light import FINE, wavefront_about
from camsim.rendering.edges import Edges
from camsim.rendering.fourier.apart import by_distance
from camsim.rendering.fourier.image import FourierImage
from camsim.rendering.fourier.rim import RimLight
from camsim.rendering.render import plan_render

LAMBDA_N = 1.2  # µm
MIXED = ((4, 0.1), (6, 0.08), (8, 0.1), (7, 0.05), (12, 0.05), (15, 0.03))
WAVES = {
    "mixed": MIXED,
    "trefoil": ((6, 0.25),),
    "tilted": ((1, 0.3), (2, -0.8), (9, 0.2)),
    "defocused": ((4, 0.6), (5, 0.2)),
    "order 9": ((45, 0.05), (54, 0.03)),
    "order 20": ((210, 0.01), (223, 0.02)),
}


def lens_of(waves, obstruction=0.0):
    return Wavefront(
        f_number=LAMBDA_N / 0.55, zernike_waves=waves, reference_nm=550.0, pupil=Pupil(obstruction=obstruction)
    )


@pytest.mark.parametrize("obstruction", [0.0, 0.35])
@pytest.mark.parametrize("waves", sorted(set(WAVES) - {"order 20"}))  # known too far out for a pattern of all of it
def test_two_places_of_each_rim_make_the_pattern(waves, obstruction):
    """With their phases they are all of it, ring by ring."""
    lens, count = lens_of(WAVES[waves], obstruction), 40
    radii = (1.0, obstruction) if obstruction else (1.0,)
    circles = [wavefront_about(lambda x, y: lens.waves(x, y, 550.0), radius) for radius in radii]
    known = lens.split().rest.rim_known(1e-12, 550.0)[0] / LAMBDA_N
    for r in (known, known + 1.3, 4.0 * known):
        total = np.zeros(count, complex)
        for circle, sign in zip(circles, (1.0, -1.0), strict=False):
            [outward], [back] = circle.amplitudes(np.array([r]), count, FINE)
            back = np.conj(np.roll(back, count // 2))  # of the opposite place
            turn = np.exp(1j * np.pi * r * circle.share)
            total += sign * (outward / turn + back * turn)
        light = np.abs(total) ** 2 / (4.0 * np.pi * (1.0 - obstruction**2))
        size = 1.0 / (np.pi**3 * r**3)  # about what is between the rings
        for k in (0, 3, 17, 29):
            x, y = LAMBDA_N * r * np.cos(np.pi * k / 20), LAMBDA_N * r * np.sin(np.pi * k / 20)
            exact = LAMBDA_N**2 * lens.point_spread_on(np.array([x]), np.array([y]), 550.0, 1e-14)[0, 0]
            assert abs(light[k] - exact) <= 1e-7 * size


def test_what_is_known_of_it_is_measured():
    """By a finer rule, whose own error is far below: distances from which it is right, and directions that tell it."""
    for waves in WAVES.values():
        rest = lens_of(waves).split().rest
        last = 0.0
        for allowed in (1e-5, 1e-7, 1e-9, 1e-11):
            from_um, directions = rest.rim_known(allowed, 550.0)
            assert from_um >= last
            last = from_um
            x = np.array([from_um])
            coarse, fine = rest.rim_light(x, 550.0, directions), rest._between_rings(x, 550.0, 256, FINE)
            finer = np.fft.irfft(np.fft.rfft(coarse), 1024) * 1024 / directions
            other = np.fft.irfft(np.fft.rfft(fine), 1024) * 4
            assert np.abs(finer - other).max() * np.pi * from_um**2 <= 10.0 * allowed


@pytest.mark.parametrize("waves", [{4: 0.6}, {6: 0.25}, {9: -0.2}, {20: 0.1}, {54: 0.1}, {12: 0.2, 20: 0.1}], ids=str)
def test_what_an_edge_gains_ahead(waves):
    """The rim's light beyond a distance, of the half-plane that has most of it: two powers of the distance tell it."""
    rest, count = lens_of(waves).split().rest, 240
    x = np.geomspace(3.0 * rest.rim_known(1e-10, 550.0)[0], 1e7, 300)
    light = rest.rim_light(x, 550.0, count)
    along = np.trapezoid(light * x[:, None] ** 2, np.log(x), axis=0) * 2.0 * np.pi / count
    sums = np.concatenate([[0.0], np.cumsum(np.tile(along, 2))])
    most = np.abs(sums[count // 2 : count // 2 + count] - sums[:count]).max()
    first, second = _rim_of(rest, 550.0).ahead_waves
    far = x[0] / LAMBDA_N
    assert 0.93 <= most / (first / far**2 + second / far**3) <= 1.01


def test_nothing_is_known_of_what_is_no_polynomial():
    def ridge(x, y):
        return 0.1 * np.exp(-30.0 * (x - 0.9) ** 2 - 200.0 * y * y)

    assert wavefront_about(ridge, 1.0) is None
    assert wavefront_about(lambda x, y: 0.1 * x**3 * y, 1.0) is not None


L = 500.0
SCENES = {
    "large": [(0.3, 0.2 - L), (L, -L), (L, L), (0.3, L)],
    "grazed": [(3.3, -L), (L, -L), (L, L), (4.3, L)],
    "wedge": [(-6.0, -2.0), (0.7 * L, -0.8 * L), (0.9 * L, 0.2 * L)],
    "far": [(250.0, 80.0), (500.0, 90.0), (470.0, 400.0)],
    "endless": [(-4.0, 3.0), (2e6, -1e6), (1e6, 3e6)],
}
FOOTPRINTS = {
    "square": [SquarePhotosite(side_um=2.0)],
    "point": [SquarePhotosite(side_um=0.0)],
    "turned": [FourSpotOlpf(split_um=1.3, split_y_um=0.8, rotate_deg=30.0), SquarePhotosite(side_um=1.5)],
    "polygon": [
        FourSpotOlpf(split_um=1.0),
        PolygonPhotosite(points_um=((-0.9, -0.7), (0.9, -0.7), (0.3, 0.9), (-0.8, 0.4))),
    ],
}


def image_of(waves, corners, tolerance, footprint="square", obstruction=0.0, nm=(550.0,)):
    points = np.array(corners)
    one, count = np.ones(len(points), np.int64), len(nm)
    split = lens_of(waves, obstruction).split()
    return FourierImage(
        edges=Edges(start=points, end=np.roll(points, -1, axis=0), left=one, right=0 * one),
        density=np.stack([np.zeros((1, count)), np.full((1, count), 1.0 / count)]),
        base=np.zeros(1),
        wavelength_nm=np.array(nm),
        system=OpticalSystem.of([split.rest, *FOOTPRINTS[footprint]]),
        pitch_um=2.0,
        tolerance=tolerance,
        memory_limit_bytes=4e9,
    )


ORIGIN, SHAPE = (-1.2, -0.7), (2, 3)


def near_and_far(image, width=0):
    """Return what both parts make of 2 × 3 photosites, of tapers that are narrow (0) or wider."""
    parts = by_distance(image, ORIGIN, SHAPE)[width]
    assert isinstance(parts[-1], RimLight)
    return [part.rendered(ORIGIN, np.zeros(SHAPE, np.uint8)) for part in parts]


def at_once(image):
    return dataclasses.replace(image, undivided=True).rendered(ORIGIN, np.zeros(SHAPE, np.uint8))


CASES = [
    ("mixed", "large", "square", 1e-6),
    ("mixed", "wedge", "turned", 1e-7),
    ("mixed", "far", "point", 1e-7),
    ("trefoil", "large", "polygon", 1e-6),
    ("trefoil", "grazed", "square", 3e-6),
    ("order 9", "wedge", "point", 1e-6),
    ("order 20", "large", "square", 1e-6),
]


@pytest.mark.parametrize(("waves", "scene", "footprint", "tolerance"), CASES)
def test_the_light_of_the_rim_is_what_is_far(waves, scene, footprint, tolerance):
    image = image_of(WAVES[waves], SCENES[scene], tolerance, footprint)
    whole = at_once(dataclasses.replace(image, tolerance=0.3 * tolerance))
    for width in range(len(by_distance(image, ORIGIN, SHAPE))):
        near, far = near_and_far(image, width)
        assert np.abs(near + far - whole).max() <= 0.1 * tolerance
        assert np.abs(far).max() > 0.01 * tolerance  # it counts


@pytest.mark.parametrize(("waves", "scene", "footprint", "tolerance"), [CASES[1], CASES[3], CASES[4]])
def test_few_places_are_enough_for_all_of_a_frame(monkeypatch, waves, scene, footprint, tolerance):
    """It changes no faster than its taper, so photosites, their spots and their sides are interpolated."""
    channel = np.zeros((19, 26), np.uint8)
    image = image_of(WAVES[waves], SCENES[scene], tolerance, footprint)
    lights = [parts[-1] for parts in by_distance(image, ORIGIN, channel.shape)]
    few = [light.rendered(ORIGIN, channel) for light in lights]
    size, places = lights[-1]._size(channel.shape)
    assert size
    assert places < 0.5 * channel.size * len(lights[-1]._offsets)
    monkeypatch.setattr(RimLight, "_size", lambda self, shape: (0, 0.0))
    for light, seen in zip(lights, few, strict=True):
        assert np.abs(light.rendered(ORIGIN, channel) - seen).max() <= 0.01 * tolerance
        assert np.abs(seen).max() > 0.01 * tolerance


def test_windows_and_colours(monkeypatch):
    """Every photosite in its own channel, of several images too; windows that do not fill a frame."""
    image = image_of(MIXED, SCENES["wedge"], 1e-6, "point", nm=(500.0, 600.0))
    density = np.zeros((2, 2, 2))
    density[1] = [[0.7, 0.1], [0.2, 0.8]]
    image = dataclasses.replace(image, density=density, base=np.zeros(2))
    channel = np.indices((3, 11, 17)).sum(axis=0) % 2
    light = by_distance(image, ORIGIN, channel.shape[1:])[-1][-1]
    images = []
    for size in (17, 5, 0):
        monkeypatch.setattr(RimLight, "_size", lambda self, shape, size=size: (size, 0.0))
        images.append(light.rendered(ORIGIN, channel.astype(np.uint8)))
    assert np.abs(images[0] - images[2]).max() <= 1e-8
    assert np.abs(images[1] - images[2]).max() <= 1e-8
    assert np.abs(images[2][0] - images[2][1]).max() > 1e-7  # the other colour
    assert np.array_equal(images[0][0], images[0][2])


def test_scenery_that_never_ends():
    """Two photosites and a triangle of 10⁶ pitches: a part of it as far as the transform goes, and the plane beyond."""
    tolerance, cut = 3e-6, 2000.0
    image = image_of(MIXED, SCENES["endless"], tolerance)
    near, far = near_and_far(image)
    # As far as 2000 pitches alone: beyond it a difference's tail of (4/π³)·⟨s⟩/x² is below the tolerance.
    points = image.edges.start
    ways = points - points[0]
    short = points[0] + cut * ways / np.maximum(np.hypot(*ways.T), 1e-9)[:, None]
    whole = at_once(image_of(MIXED, short, 0.5 * tolerance))
    assert np.abs(near + far - whole).max() <= 0.3 * tolerance


def test_a_spectrum_is_summed_at_few_wavelengths():
    nm = tuple(np.linspace(420.0, 680.0, 27).tolist())
    image = image_of(MIXED, SCENES["wedge"], 1e-6, nm=nm)
    far = by_distance(image, ORIGIN, SHAPE)[0][-1]
    assert isinstance(far, RimLight)
    each = [
        RimLight(
            edges=far.edges, density=27.0 * far.density[:, :, k : k + 1], wavelength_nm=far.wavelength_nm[k : k + 1],
            system=far.system, pitch_um=2.0, hem=far.hem, directions=far.directions, leave=far.leave,
        ).rendered(ORIGIN, np.zeros(SHAPE, np.uint8)) for k in range(27)
    ]  # fmt: skip
    exact = np.mean(each, axis=0)
    assert len(far._light[1]) < 20
    assert np.abs(far.rendered(ORIGIN, np.zeros(SHAPE, np.uint8)) - exact).max() <= 1e-5 * np.abs(exact).max()


@pytest.mark.parametrize("obstruction", [0.2, 0.5])
def test_behind_an_obstruction_the_inner_rim_throws_light_too(obstruction):
    tolerance = 3e-6
    image = image_of(MIXED, [(0.3, -2e3), (2e3, -2e3), (2e3, 2e3), (0.3, 2e3)], tolerance, "point", obstruction)
    near, far = near_and_far(image)
    whole = at_once(dataclasses.replace(image, tolerance=0.3 * tolerance))
    assert np.abs(near + far - whole).max() <= 0.15 * tolerance


def test_daylight_at_1e_7_fits_the_memory():
    """31 GB for the check, whose overlaps have no far light: where that is much it takes patterns too."""
    shape = camsim.Rectangle(width_um=9e3, height_um=9e3, centre_um=(4500.0, 100.0), rotate_deg=4.0, reflectance=1.0)
    optics = OpticalSystem.of([lens_of(MIXED), SquarePhotosite(side_um=4.0)])
    nm = np.linspace(420.0, 680.0, 105)
    choice = plan_render(
        camsim.Scene(background=0.0, shapes=[shape]), optics, camsim.Grid(rows=4, cols=4, pitch_um=4.88),
        response=np.full((1, nm.size), 1.0 / nm.size), wavelength_nm=nm, tolerance=1e-7, method="fourier",
    )  # fmt: skip
    assert any("rim" in one.decision for one in choice.plan.decisions())
    assert choice.cost.memory_bytes < 2e9
    assert choice.cost.seconds < 10.0 * choice.plan.cost.seconds


def test_the_check_looks_farther_before_it_trusts_the_rim(monkeypatch):
    """Its own taper ends later: what is wrong between the two is seen."""
    grid = camsim.Grid(rows=2, cols=2, pitch_um=2.0)
    plane = camsim.Rectangle(width_um=4e3, height_um=4e3, centre_um=(2000.6, 10.0), reflectance=1.0)
    scene, optics = camsim.Scene(background=0.0, shapes=[plane]), [lens_of(MIXED), SquarePhotosite(side_um=2.0)]

    def rendered():
        return camsim.render(scene, optics, grid, wavelength_nm=550.0, tolerance=3e-7, method="fourier")

    right = rendered()
    assert right.error_estimate <= 3e-8
    light = Difference.rim_light
    monkeypatch.setattr(Difference, "rim_light", lambda self, *a: 2.0 * light(self, *a))
    assert rendered().error_estimate > 3e-7
