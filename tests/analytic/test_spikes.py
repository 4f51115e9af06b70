"""Far light of pupils with straight sides comes along spikes: against closed forms and transforms of all at once."""

import dataclasses
import functools
import math

import numpy as np
import pytest

import camsim
from camsim.optics import Airy, OpticalSystem, Pupil, SquarePhotosite, TwoSpotOlpf, Wavefront
from camsim.optics.of_pupil import OfPupil
from camsim.optics.spikes import spikes_of
from camsim.quadrature import gauss_legendre
from camsim.rendering.edges import Edges
from camsim.rendering.fourier.apart import by_distance
from camsim.rendering.fourier.crossings import Crossings
from camsim.rendering.fourier.image import FourierImage
from camsim.rendering.fourier.spikes import Spikes
from camsim.rendering.render import plan_render

BENT = {8: 0.15, 5: 0.1, 3: -0.05}
PUPILS = {
    "square": Pupil(shape="square", rotate_deg=20.0),
    "upright": Pupil(shape="square"),
    "5": Pupil(shape="bladed", blades=5, rotate_deg=13.0),
    "6": Pupil(shape="bladed", blades=6),
    "7": Pupil(shape="bladed", blades=7, rotate_deg=25.0),
}
L = 200.0
LARGE = [(0.3, 0.2 - L), (L, -L), (L, L), (0.3, L)]
SCENES = {
    "large": LARGE,
    "grazed": [(3.3, -L), (L, -L), (L, L), (4.3, L)],
    "bar": [(-20.0, 18.0), (240.0, 66.0), (239.5, 69.0), (-20.5, 21.0)],
    "far": [(100.0, 20.0), (160.0, 30.0), (120.0, 80.0)],
    "on a spike": [(88.0, -2.0), (93.0, -2.0), (93.0, 3.0), (88.0, 3.0)],
}


def image_of(pupil, corners, tolerance, waves=(), extra=(), wavelength_nm=(550.0,)):
    points = np.array(corners)
    one = np.ones(len(points), np.int64)
    lens = Wavefront(f_number=1.0 / 0.55, pupil=pupil, zernike_waves=waves)
    count = len(wavelength_nm)
    return FourierImage(
        edges=Edges(start=points, end=np.roll(points, -1, axis=0), left=one, right=0 * one),
        density=np.stack([np.zeros((1, count)), np.full((1, count), 1.0 / count)]),
        base=np.zeros(1),
        wavelength_nm=np.array(wavelength_nm),
        system=OpticalSystem.of([lens, *extra, SquarePhotosite(side_um=0.9)]),
        pitch_um=1.0,
        tolerance=tolerance,
        memory_limit_bytes=4e9,
    )


def apart_and_together(make, tolerance, finer=1e-6):
    """Return what parts by distance make of 4 × 5 photosites, all at once as finely, and whether spikes had a part."""
    origin, channel = (-2.0, -1.5), np.zeros((4, 5), np.uint8)
    [parts] = by_distance(make(tolerance), origin, channel.shape)
    whole = make(finer)
    whole._apart[origin, channel.shape] = ()
    image = sum(part.rendered(origin, channel) for part in parts)
    return image, whole.rendered(origin, channel), bool(parts) and isinstance(parts[-1], Spikes)


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("pupil", PUPILS)
def test_spikes_are_what_is_far(pupil, scene):
    tolerance = 3e-4
    image, exact, spiked = apart_and_together(lambda t: image_of(PUPILS[pupil], SCENES[scene], t), tolerance)
    assert spiked
    assert np.abs(image - exact).max() <= 0.1 * tolerance


@pytest.mark.parametrize("waves", [BENT, {2: 0.4, 1: 0.3}, {4: 0.6}], ids=["bent", "tilted", "defocused"])
@pytest.mark.parametrize("pupil", ["square", "7"])
def test_aberrations_move_spikes_and_widen_them(pupil, waves):
    extra = [TwoSpotOlpf(split_um=0.7, rotate_deg=35.0)]
    image, exact, spiked = apart_and_together(lambda t: image_of(PUPILS[pupil], LARGE, t, waves, extra), 3e-4)
    assert spiked
    assert np.abs(image - exact).max() <= 0.1 * 3e-4


@pytest.mark.parametrize(
    ("pupil", "waves", "tolerance"),
    [
        (("square", "6")[(k + more) % 2], waves, tolerance)  # every pair of the three
        for k, waves in enumerate([{4: 1.2}, {4: -2.0}, {11: 0.6}, {1: 2.0, 7: 0.7}])
        for more, tolerance in enumerate((1e-2, 1e-3))
    ],
    ids=str,
)
def test_within_the_spot_that_a_wavefront_makes_there_is_no_spike(pupil, waves, tolerance):
    """888 times the tolerance: a taper began where a side's light was moved to, and 1/(s − moved)² has a pole there."""
    along_spikes = 0
    for name in ("far", "on a spike", "large"):
        make = functools.partial(image_of, PUPILS[pupil], SCENES[name])
        image, exact, spiked = apart_and_together(functools.partial(make, waves=waves), tolerance)
        along_spikes += spiked
        assert not spiked or np.abs(image - exact).max() <= 0.1 * tolerance
    assert along_spikes or tolerance < 1e-2


def disc(x, y, radius, sides):
    angle = 2.0 * np.pi * np.arange(sides) / sides
    return np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle)], axis=1)


DISCS = {
    "beside": disc(60.3, 3.0, 58.0, 800),
    "around": disc(3.0, -5.0, 90.0, 1200),
    "far": disc(120.0, 40.0, 30.0, 600),
    "on a spike": disc(100.0, 0.0, 20.0, 500),
}


@pytest.mark.parametrize("waves", [{}, {4: 0.6}], ids=str)
@pytest.mark.parametrize("scene", DISCS)
@pytest.mark.parametrize("pupil", ["upright", "square", "6"])
def test_spikes_hear_where_they_cross_an_outline_and_not_its_sides(pupil, scene, waves):
    """A disc of a thousand sides was taken for a thousand edges: everything was transformed, however far away."""
    tolerance = 1e-4
    image, exact, spiked = apart_and_together(lambda t: image_of(PUPILS[pupil], DISCS[scene], t, waves), tolerance)
    assert spiked or (waves and scene == "on a spike")  # what is small and near a spot is transformed
    assert not spiked or np.abs(image - exact).max() <= 0.1 * tolerance


def test_crossings_are_counted():
    """Of a square's spikes: both ways of each cross a disc twice, of sides that are as many as one likes."""
    spikes = spikes_of(Wavefront(f_number=1.0 / 0.55, pupil=PUPILS["upright"]), 550.0)

    def most(points, each=1.0):
        edges = Edges(
            start=points,
            end=np.roll(points, -1, axis=0),
            left=np.ones(len(points), np.int64),
            right=np.zeros(len(points), np.int64),
        )
        return Crossings(spikes, edges, (5, 5), 1.0).most(np.full(len(points), each), 0.0)

    for sides in (40, 4000):
        assert most(disc(0.0, 0.0, 60.0, sides)) == pytest.approx(4.0, abs=0.1)
    assert most(disc(60.0, 0.0, 20.0, 4000)) == pytest.approx(2.0, abs=0.1)
    assert most(disc(60.0, 60.0, 20.0, 4000)) == 0.0
    assert most(disc(60.0, 60.0, 20.0, 4000)[::-1], 3.0) == 0.0


def test_all_wavelengths_at_once():
    nm = tuple(np.linspace(400.0, 700.0, 31).tolist())
    origin, channel = (-2.0, -1.5), np.zeros((4, 5), np.uint8)
    far = by_distance(image_of(PUPILS["5"], LARGE, 1e-4, wavelength_nm=nm), origin, channel.shape)[0][-1]
    each = [Spikes(
        edges=far.edges, density=far.density[:, :, k : k + 1] * 31, wavelength_nm=far.wavelength_nm[k : k + 1],
        system=far.system, pitch_um=1.0, hem=far.hem,
    ).rendered(origin, channel) for k in range(31)]  # fmt: skip
    exact = np.mean(each, axis=0)
    assert np.abs(far.rendered(origin, channel) - exact).max() <= 2e-3 * exact.max()


@pytest.mark.parametrize(
    ("towards_deg", "tolerance"), [(0.0, 1e-3), (25.0, 1e-3), (45.0, 1e-4), (0.0, 1e-5), (25.0, 1e-6)]
)
def test_a_knife_edge_that_leaves_every_frame(towards_deg, tolerance):
    """Refused before: a period as long as the half-plane, 10 km."""
    angle, f_number, pitch_um = math.radians(towards_deg), 5.6, 4.88
    lens = Wavefront(f_number=f_number, pupil=Pupil(shape="square"))
    plane = camsim.HalfPlane(through_um=(1.0, 2.0), towards_deg=towards_deg, reflectance=1.0)
    grid = camsim.Grid(rows=5, cols=9, pitch_um=pitch_um)
    optics = [lens, SquarePhotosite(side_um=pitch_um)]
    found = camsim.render(
        camsim.Scene(background=0.0, shapes=[plane]), optics, grid, wavelength_nm=550.0, tolerance=tolerance
    )
    cos, sin = abs(math.cos(angle)), abs(math.sin(angle))
    band = 1.0 / (0.55 * f_number)  # along x and along y
    last = band / max(cos, sin)
    ends = np.linspace(0.0, last, 200)
    x, w = gauss_legendre(12)
    f = (ends[:-1, None] + 0.5 * np.diff(ends)[:, None] * (1.0 + x)).ravel()
    w = np.tile(0.5 * np.diff(ends)[:1] * w, ends.size - 1)
    transfer = (
        (1.0 - f * cos / band) * (1.0 - f * sin / band) * np.sinc(pitch_um * f * cos) * np.sinc(pitch_um * f * sin)
    )
    col, row = np.meshgrid(pitch_um * (np.arange(9) - 4.0), pitch_um * (np.arange(5) - 2.0))
    beyond = (col - 1.0) * math.cos(angle) + (row - 2.0) * math.sin(angle)
    exact = 0.5 + np.sin(np.multiply.outer(beyond, 2.0 * np.pi * f)) @ (w * transfer / (np.pi * f))
    assert np.abs(found.image - exact).max() <= tolerance
    assert found.error_estimate <= tolerance


@pytest.mark.parametrize(
    ("pupil", "f_number"),
    [(p, n) for i, p in enumerate(PUPILS) for k, n in enumerate((2.8, 5.6, 16.0)) if (i + k) % 2 == 0],
)
def test_everyday_frames_are_not_refused(pupil, f_number):
    """446 × 446 within 2 GB, in front of a half-plane, and of a chart ten frames wide: 10¹³ and 49 GB before."""
    lens = Wavefront(f_number=f_number, pupil=PUPILS[pupil], zernike_waves={8: 0.1})
    system = OpticalSystem.of([lens, SquarePhotosite(side_um=4.88)])
    grid = camsim.Grid(rows=446, cols=446, pitch_um=4.88)
    plane = camsim.HalfPlane(through_um=(1.0, 2.0), towards_deg=4.0, reflectance=1.0)
    chart = camsim.Rectangle(width_um=2e4, height_um=2e4, centre_um=(9000.0, 0.0), rotate_deg=4.0, reflectance=1.0)
    for shape in (plane, chart):
        scene = camsim.Scene(background=0.0, shapes=[shape])
        choice = plan_render(
            scene, system, grid, response=np.ones((1, 1)), wavelength_nm=np.array([550.0]), tolerance=1e-4
        )
        assert choice.cost.memory_bytes < 2e9
        assert choice.cost.seconds < 30.0
        assert any("spikes" in decision.decision for decision in choice.plan.decisions())


def test_the_check_looks_farther_before_it_trusts_spikes(monkeypatch):
    """Its own taper ends later: what is wrong between the two is seen."""
    lens, grid = (
        Wavefront(f_number=5.6, pupil=Pupil(shape="bladed", blades=6)),
        camsim.Grid(rows=8, cols=8, pitch_um=4.88),
    )
    scene = camsim.Scene(background=0.0, shapes=[camsim.HalfPlane(towards_deg=25.0, reflectance=1.0)])

    def estimate():
        optics = [lens, SquarePhotosite(side_um=4.88)]
        return camsim.render(scene, optics, grid, wavelength_nm=550.0, tolerance=1e-4).error_estimate

    assert estimate() <= 1e-5
    right = OfPupil.spikes

    def brighter(self, wavelength_nm):
        return tuple(dataclasses.replace(one, light_um=1.3 * one.light_um) for one in right(self, wavelength_nm))

    monkeypatch.setattr(OfPupil, "spikes", brighter)
    assert estimate() > 1e-4


def test_round_pupils_and_obstructed_ones_have_none():
    for lens in (Wavefront(f_number=8.0), Wavefront(f_number=8.0, pupil=Pupil(shape="square", obstruction=0.3))):
        assert lens.spikes(550.0) == ()
    assert not hasattr(Airy(f_number=8.0), "spikes")
