"""Curved shapes keep the tolerance at every decade: discs, rings and ellipses against integrals in one dimension."""

import numpy as np
import pytest
from areas import brightness
from scipy import integrate, special

import camsim
from camsim.scene.arcs import Fineness, arcs_of
from camsim.scene.arrange import arrange
from camsim.scene.outlines import Outlines, area_of
from camsim.scene.primitives import flattened
from camsim.scene.regions import region_of
from camsim.scene.side_limits import SideLimits
from tests.truth import closed_forms

DECADES = [1e-2, 1e-4, 1e-7]


def seen(shapes, lens, place, tolerance):
    """What a point sees of white shapes on black."""
    found = camsim.render(
        camsim.Scene(background=0.0, shapes=[camsim.Group(shapes=shapes, move_um=(-place[0], -place[1]))]),
        [lens],
        camsim.Grid(rows=1, cols=1, pitch_um=1.0),
        wavelength_nm=1000.0,
        tolerance=tolerance,
    )
    assert found.error_estimate <= tolerance
    return found.image[0, 0]


def gaussian_ellipse(a, b, place, sigma):
    """A Gaussian over an ellipse: strips along y are error functions, and x = a·sin φ has no root at its ends."""

    def strip(phi):
        x, high = a * np.sin(phi), b * np.cos(phi)
        across = special.erf((high - place[1]) / (np.sqrt(2.0) * sigma)) + special.erf(
            (high + place[1]) / (np.sqrt(2.0) * sigma)
        )
        along = np.exp(-0.5 * ((x - place[0]) / sigma) ** 2) / (np.sqrt(2.0 * np.pi) * sigma)
        return 0.5 * across * along * a * np.cos(phi)

    middle = np.arcsin(np.clip(place[0] / a, -1.0, 1.0))
    return integrate.quad(strip, -np.pi / 2, np.pi / 2, points=[middle], epsabs=1e-13, epsrel=1e-13, limit=400)[0]


@pytest.mark.parametrize("tolerance", DECADES)
def test_an_ellipse(tolerance):
    for place in ((5.8, 0.3), (1.0, 2.1)):
        item = camsim.Ellipse(radius_x_um=6.0, radius_y_um=2.0, reflectance=1.0)
        turned = np.array([[0.6, -0.8], [0.8, 0.6]]) @ place
        upright = camsim.Group(shapes=[item], turn_deg=np.degrees(np.arctan2(0.8, 0.6)))
        expected = gaussian_ellipse(6.0, 2.0, place, 0.7)
        lens = camsim.Gaussian(sigma_um=0.7)
        assert seen([upright], lens, turned, tolerance) == pytest.approx(expected, abs=tolerance)


@pytest.mark.parametrize("tolerance", DECADES)
def test_a_disc_and_a_ring(tolerance):
    """The ring's hole is painted over by a disc of its very size: nothing shows between them."""
    lens = camsim.Airy(f_number=1.0)
    disc, ring = (
        camsim.Disc(radius_um=5.0, reflectance=1.0),
        camsim.Ring(radius_um=9.0, inner_radius_um=5.0, reflectance=1.0),
    )
    for distance in (4.6, 9.3):
        inner, outer = (closed_forms.disc_by_frequencies(radius, 1.0, distance) for radius in (5.0, 9.0))
        place = (0.6 * distance, 0.8 * distance)
        assert seen([disc], lens, place, tolerance) == pytest.approx(inner, abs=tolerance)
        assert seen([ring], lens, place, tolerance) == pytest.approx(outer - inner, abs=tolerance)
        grey = camsim.Disc(radius_um=5.0, reflectance=0.5)
        together = seen([camsim.Disc(radius_um=9.0, reflectance=0.2), ring, grey], lens, place, tolerance)
        assert together == pytest.approx(outer - 0.5 * inner, abs=tolerance)


def seen_brightness(shapes, limits):
    return brightness(arrange(camsim.Scene(background=0.0, shapes=shapes), limits))


@pytest.mark.parametrize(("at", "flat"), [(-0.9, 0.0254), (0.3, 0.5), (0.7465, 0.0254), (0.98, 0.5)])
def test_cut_ellipses_keep_their_areas(at, flat):
    """13 times what is allowed was met: a short side where the ellipse is cut leant on a long one beside it."""
    wide, high, over = 0.6, 0.6 * flat, 0.3
    ellipse = camsim.Ellipse(radius_x_um=wide, radius_y_um=high, reflectance=over)
    half_plane = camsim.Rectangle(width_um=8.0, height_um=8.0, centre_um=(at * wide - 4.0, 0.0), reflectance=1.0)
    right = wide * high * (np.arccos(at) - at * np.sqrt(1.0 - at * at))
    for cut_um2 in (1e-6, 1e-8, 1e-10):
        limits = SideLimits(20.0, np.sqrt(cut_um2), cut_um2, 5.0 * cut_um2)
        assert abs(seen_brightness([ellipse, half_plane], limits) - 64.0 - over * right) <= 2.0 * over * cut_um2


def test_circles_that_cut_one_another_keep_their_areas():
    """470 times what is allowed was met: where two corners fell together the sides beside them could not make up."""
    disc = camsim.Disc(radius_um=1.0, centre_um=(0.0, -2.0), reflectance=0.5)
    ring = camsim.Ring(
        radius_um=0.7431250212181278, inner_radius_um=0.3715625106090639, centre_um=(-0.5, -1.5), reflectance=0.9
    )
    both = [common_circles(np.sqrt(0.5), 1.0, radius) for radius in (ring.radius_um, ring.inner_radius_um)]
    exact = 0.5 * (np.pi - both[0] + both[1]) + 0.9 * np.pi * (ring.radius_um**2 - ring.inner_radius_um**2)
    for cut_um2 in (1e-8, 1e-10, 1e-12):
        limits = SideLimits(20.0, np.sqrt(cut_um2), cut_um2, 5.0 * cut_um2)
        assert abs(seen_brightness([disc, ring], limits) - exact) <= 2.0 * cut_um2


def common_circles(distance, one, two):
    """Area that two circles have in common."""
    along = (distance**2 + one**2 - two**2) / (2.0 * distance)
    high = np.sqrt(max(one**2 - along**2, 0.0))
    first = one**2 * np.arccos(along / one) - along * high
    return first + two**2 * np.arccos((distance - along) / two) - (distance - along) * high


@pytest.mark.parametrize("straight", [False, True])
@pytest.mark.parametrize("cut_um2", [1e-4, 1e-6, 1e-8])
def test_what_crosses_once_more_beside_its_corner_keeps_its_areas(cut_um2, straight):
    """Two curves, or a curve and a line, that leave a corner by a small angle and turn into each other's way: where no
    other stretch came between, their sides stayed as long as areas let them be that nothing cuts."""
    rng = np.random.default_rng(5)
    limits = SideLimits(3.0, np.sqrt(cut_um2), cut_um2, cut_um2)
    t = np.linspace(0.0, 1.0, 20_001)[:, None]
    basis = np.hstack([(1.0 - t) ** 3, 3.0 * t * (1.0 - t) ** 2, 3.0 * t**2 * (1.0 - t), t**3])
    worst = 0.0
    for _ in range(8):
        slope, high = rng.uniform(0.005, 0.03), rng.uniform(0.1, 0.4, 4)
        tip, one = np.zeros(2), np.array([(0.0, 0.0), (1.0, 0.0), (2.0, high[0]), (3.0, high[1])])
        other = np.array([(0.0, 0.0), (1.0, slope), (2.0, -high[2]), (3.0, -high[3])])
        if straight:
            one = np.array([tip, (1.0, -slope), (2.0, high[0]), (3.0, 0.0)])
            segments, drawn = [("move", *tip), ("cubic", *one[1:].ravel()), ("close",)], basis @ one
        else:
            segments = [("move", *tip), ("cubic", *one[1:].ravel()), ("line", *other[3])]
            segments += [("cubic", *other[2::-1].ravel()), ("close",)]
            drawn = np.concatenate([basis @ one, (basis @ other)[::-1]])
        leaf = flattened([camsim.Path(segments_um=segments, fill_rule="evenodd", reflectance=1.0)])
        outlines = Outlines.of(leaf)
        sides = outlines.polygons(limits, meets=np.ones(1, bool))
        item = area_of(leaf[0], outlines.each(sides, np.zeros(1, int))[0])
        worst = max(worst, abs(item.area - region_of([drawn], "evenodd", simple=False).area))
    assert worst <= 4.0 * cut_um2 + 1e-8


@pytest.mark.parametrize("far_um", [0.0, 3.0, 1000.0])
def test_arcs_end_where_rounding_begins(far_um):
    """Areas that no double tells apart were asked for, and pieces halved until memory was full."""
    ellipse = camsim.Ellipse(
        radius_x_um=0.5, radius_y_um=0.25, centre_um=(far_um, 1.7), rotate_deg=45.0, reflectance=0.5
    )
    (curves,) = (fill.curves for one in flattened([ellipse]) for fill in one.fills)
    parts = arcs_of(curves, Fineness(0.02, 1e-13))
    assert len(parts.owner) < 100_000
    assert abs(np.abs(parts.bend_rad.sum()) - 2.0 * np.pi) < 1e-6
