"""Discs over discs, whose rims are followed in closed form: against polygons of many sides, and the other road."""

import functools

import numpy as np
import pytest
import shapely
from areas import area_of

import camsim
from camsim.scene import arrange
from camsim.scene.side_limits import SideLimits

LEVELS = (0.0, 0.3, 0.5, 1.0)
FINE = SideLimits(0.02, 1e-6, 1e-6, 1e-6)


def discs(seed, count=25):
    """Of all sizes, in one another and over one another, some of the background's own reflectance."""
    rng = np.random.default_rng(seed)
    return [
        camsim.Disc(radius_um=radius, centre_um=tuple(centre), reflectance=float(level))
        for radius, centre, level in zip(
            rng.uniform(0.3, 2.5, count) ** 2, rng.uniform(-8, 8, (count, 2)), rng.choice(LEVELS, count), strict=True
        )
    ]


@pytest.mark.parametrize("seed", range(4))
def test_areas_are_those_of_polygons_painted_one_after_the_other(seed):
    shapes = discs(seed)
    found = arrange(camsim.Scene(background=0.5, shapes=shapes), FINE)
    x0, y0, x1, y1 = *found.start_um.T, *found.end_um.T
    areas = [area_of(found, number) for number in range(1, len(found.spectra))]
    # Where edges end others begin: each visible region is closed, and so is the background.
    for number in range(len(found.spectra)):
        left, right = found.left == number, found.right == number
        whole = (x1 - x0)[left].sum() - (x1 - x0)[right].sum(), (y1 - y0)[left].sum() - (y1 - y0)[right].sum()
        np.testing.assert_allclose(whole, 0.0, atol=1e-11)
    painted = {level: shapely.Point() for level in LEVELS}
    for disc in shapes:
        one = shapely.Point(disc.centre_um).buffer(disc.radius_um, quad_segs=800)
        painted = {level: area.difference(one) for level, area in painted.items()}
        painted[disc.reflectance] = painted[disc.reflectance].union(one)
    expected = [painted[level].area for level in found.spectra[1:]]
    np.testing.assert_allclose(areas, expected, rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-5])
def test_both_roads_give_one_picture(tolerance):
    """A mark that cannot be seen makes all that it touches be cut as polygons are."""
    shapes = discs(3, 12)
    mark = functools.partial(camsim.Rectangle, width_um=0.5, height_um=0.5, reflectance=shapes[-1].reflectance)
    for photosite in (camsim.SquarePhotosite(side_um=0.0), camsim.SquarePhotosite(side_um=2.0)):
        images = [
            camsim.render(
                camsim.Scene(background=0.5, shapes=painted),
                [camsim.Airy(f_number=4.0), photosite],
                camsim.Grid(rows=8, cols=8, pitch_um=2.0),
                wavelength_nm=450.0,
                tolerance=tolerance,
            ).image
            for painted in (shapes, [*shapes, mark(centre_um=shapes[-1].centre_um)])
        ]
        assert np.abs(images[0] - images[1]).max() <= tolerance


def test_circles_that_touch_are_cut_as_polygons_are():
    inner = camsim.Disc(radius_um=1.0, centre_um=(2.0, 0.0), reflectance=0.2)
    outer = camsim.Disc(radius_um=3.0, reflectance=0.9)
    for shapes, areas in (([outer, inner], (8.0, 1.0)), ([inner, outer], (9.0,)), ([outer, outer], (9.0,))):
        found = arrange(camsim.Scene(background=0.5, shapes=shapes), FINE)
        seen = [area for n in range(1, len(found.spectra)) if abs(area := area_of(found, n)) > 1e-9]
        np.testing.assert_allclose(seen, np.pi * np.array(areas), rtol=1e-6)
