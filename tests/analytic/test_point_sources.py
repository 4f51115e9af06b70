"""Point sources: the pattern itself over photosite and OLPF, by plain quadrature that shares nothing with camsim."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from examples import worst
from truth.round_lenses import Airy

import camsim
from camsim.errors import CamsimError

PITCH_UM, NM, ROWS, COLS = 4.0, 550.0, 30, 41
GRID = camsim.Grid(rows=ROWS, cols=COLS, pitch_um=PITCH_UM)
SYSTEM = [camsim.FourSpotOlpf(split_um=3.0), camsim.RectangularPhotosite(width_um=4.0, height_um=3.0)]
SPOTS = [(x, y) for x in (-0.375, 0.375) for y in (-0.375, 0.375)]
X = GRID.first_centre[0] + np.arange(COLS)
Y = (GRID.first_centre[1] + np.arange(ROWS))[:, None]


@functools.cache
def light(at, pattern):
    """The light of a point of 1 over a photosite and its spots, (rows, cols)."""
    nodes, weights = np.polynomial.legendre.leggauss(16)
    total = np.zeros((ROWS, COLS))
    for across, w in zip(0.5 * nodes, 0.5 * weights, strict=True):
        for down, v in zip(0.375 * nodes, 0.5 * weights, strict=True):
            for x, y in SPOTS:
                total += 0.25 * w * v * pattern(np.hypot(X + across + x - at[0], Y + down + y - at[1]))
    return total


def point(x, y, photosites, **more):
    return camsim.PointSource(photosites=photosites, centre_um=(PITCH_UM * x, PITCH_UM * y), **more)


def rendered(shapes, lens, tolerance, background=0.1, **more):
    scene = camsim.Scene(background=background, shapes=shapes)
    found = camsim.render(scene, [lens, *SYSTEM], GRID, wavelength_nm=NM, tolerance=tolerance, **more)
    assert found.error_estimate <= tolerance
    return found.image


PATTERNS = {"airy": Airy(8.0 * NM * 1e-3 / PITCH_UM).pattern, "annular": Airy(8.0 * NM * 1e-3 / PITCH_UM, 0.4).pattern}


@pytest.mark.parametrize(
    ("kind", "bright", "tolerance"),
    [("airy", 0.2, 1e-2), ("airy", 300.0, 1e-6), ("annular", 40.0, 1e-4), ("annular", 300.0, 1e-6)],
)
def test_a_point_is_the_pattern(kind, bright, tolerance):
    """Inside the frame and outside; the error is of a perfect diffuser, however bright a point is."""
    lens = camsim.Airy(f_number=8.0) if kind == "airy" else camsim.AnnularAiry(f_number=8.0, obstruction=0.4)
    pattern = PATTERNS[kind]
    image = rendered([point(0.3, -1.1, bright), point(23.4, 9.7, 0.5 * bright)], lens, tolerance)
    right = 0.1 + bright * light((0.3, -1.1), pattern) + 0.5 * bright * light((23.4, 9.7), pattern)
    assert worst(image, right) <= tolerance


def test_far_points_are_heard_as_their_powers():
    """Where rings are averaged: a bright point 300 pitches off, and one in the frame that sets the tolerance."""
    image = rendered([point(300.0, 41.0, 2000.0), point(1.2, 2.1, 30.0)], camsim.Airy(f_number=8.0), 1e-4)
    pattern = PATTERNS["airy"]
    right = 0.1 + 2000.0 * light((300.0, 41.0), pattern) + 30.0 * light((1.2, 2.1), pattern)
    assert worst(image, right) <= 1e-4


def test_what_covers_a_point_hides_it_and_what_lies_under_it_does_not():
    lens, spot = camsim.Airy(f_number=4.0), point(1.0, 2.0, 5.0)
    disc = camsim.Disc(radius_um=12.0, centre_um=(6.0, 8.0), reflectance=0.4)
    ring = camsim.Ring(radius_um=12.0, inner_radius_um=6.0, centre_um=(6.0, 8.0), reflectance=0.4)
    alone = rendered([disc], lens, 1e-6)
    assert worst(rendered([spot, disc], lens, 1e-6), alone) <= 2e-6
    seen = rendered([spot], lens, 1e-6, background=0.0)
    assert worst(seen, 5.0 * light((1.0, 2.0), Airy(4.0 * NM * 1e-3 / PITCH_UM).pattern)) <= 1e-6
    assert worst(rendered([disc, spot], lens, 1e-6), alone + seen) <= 3e-6
    through = rendered([spot, ring], lens, 1e-6) - rendered([ring], lens, 1e-6)  # the hole of a ring hides nothing
    assert worst(through, seen) <= 3e-6


TILTED = camsim.Group(
    shapes=[camsim.Ellipse(radius_x_um=20.0, radius_y_um=6.0, reflectance=0.3)], turn_deg=30.0, move_um=(3.0, -2.0)
)
LEAF = camsim.Path(segments_um=[("move", -20, 0), ("cubic", -9, 30, 14, 25, 20, 0), ("close",)], reflectance=0.3)
LENS = camsim.Group(shapes=[camsim.Rectangle(width_um=90.0, height_um=90.0, reflectance=0.3)], clip=LEAF)


def on_an_ellipse(part):
    """Where it is and which way is out."""
    angle, turn = 2.0 * np.pi * part, np.exp(1j * np.pi / 6.0)
    out = turn * complex(np.cos(angle) / 20.0, np.sin(angle) / 6.0)
    return complex(3.0, -2.0) + turn * complex(20.0 * np.cos(angle), 6.0 * np.sin(angle)), out / abs(out)


def on_a_curve(t):
    """The same of a cubic that bends over what it encloses."""
    ends = np.array([-20.0, -9.0 + 30.0j, 14.0 + 25.0j, 20.0])
    along = 1j * np.dot(np.diff(ends), [(1.0 - t) ** 2, 2.0 * t * (1.0 - t), t * t])
    place = np.dot(ends, [(1.0 - t) ** 3, 3.0 * t * (1.0 - t) ** 2, 3.0 * t * t * (1.0 - t), t**3])
    return place, along / abs(along)


def on_a_circle(part):
    """The same of a circle."""
    out = np.exp(2j * np.pi * part)
    return 20.0 * out, out


COVERS = {
    "disc": (camsim.Disc(radius_um=20.0, reflectance=0.3), on_a_circle),
    "ellipse": (TILTED, on_an_ellipse),
    "curve": (LEAF, on_a_curve),
    "clip": (LENS, on_a_curve),
}


@pytest.mark.parametrize("kind", list(COVERS))
@pytest.mark.parametrize(("off_um", "tolerance"), [(1e-3, 1e-2), (1e-4, 1e-4)])
def test_a_point_beside_a_rim_is_hidden_by_the_shape_itself(kind, off_um, tolerance):
    """By chords it was shown inside a rim, or hidden outside; where the check saw none that was a traceback."""
    shape, rim = COVERS[kind]
    alone = rendered([shape], camsim.Airy(f_number=16.0), tolerance)
    for part in (0.07, 0.32, 0.7):
        for side in (-1.0, 1.0):
            place, out = rim(part)
            at = (place + side * off_um * out) / PITCH_UM
            added = rendered([point(at.real, at.imag, 3.0), shape], camsim.Airy(f_number=16.0), tolerance) - alone
            assert abs(added).max() > 0.05 if side > 0.0 else abs(added).max() <= 2.0 * tolerance


def test_a_point_behind_any_lens_is_what_a_small_square_of_as_much_light_is():
    """A square of 0.2 pitches is off by 0.2²/24 of the pattern's second derivative."""
    lens = camsim.Wavefront(
        f_number=8.0, pupil=camsim.Pupil(shape="square"), zernike_waves=((7, 0.1),), reference_nm=NM
    )
    side_um = 0.2 * PITCH_UM
    square = camsim.Rectangle(width_um=side_um, height_um=side_um, centre_um=(1.2, -4.4), reflectance=1.0)
    small = rendered([square], lens, 1e-4, background=0.0)
    one = rendered([point(0.3, -1.1, 0.2**2)], lens, 1e-4, background=0.0)
    assert small.max() > 4e-3
    assert worst(one, small) <= 2e-4


def test_its_electrons_are_those_of_the_channel_that_collects_most():
    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=16.0))
    frame = camera.expose(
        camsim.Scene(background=0.0, shapes=[camsim.PointSource(electrons=5e4, centre_um=(2.0, 1.0), reflectance=0.5)]),
        light=camsim.Light("D55", illuminance_lux=2000.0),
        exposure=camsim.Exposure(time_s=0.01, iso=200.0),
        region=camsim.Region(rows=160, cols=160),
        tolerance=1e-4,
        noise=False,
        products=("truth",),
    )
    totals = frame.truth.sum(axis=(0, 1))
    # Nothing passes the lens that photosites would alias; 80 of them off all but 2λN/π²r of the light has arrived.
    assert totals.max() == pytest.approx(5e4, rel=0.02)
    assert totals.min() < 0.8 * totals.max()
    with pytest.raises(CamsimError, match="electrons: needs a camera"):
        rendered([camsim.PointSource(electrons=5.0)], camsim.Airy(f_number=4.0), 1e-4)
