"""Shapes that share sides but for rounding: areas add up, whatever the angle."""

import numpy as np
import pytest
import shapely
from examples import tiles

import camsim
from camsim.scene.arrange import arrange
from camsim.scene.overlap import common_area


def drawn_tiles(rng, angle_deg):
    """Squares side by side, and what they add to a background of 0.3."""
    rows, cols = rng.integers(2, 5, 2)
    step, centre = rng.uniform(1.0, 9.0), rng.uniform(-6.0, 6.0, 2)
    grey = rng.random((rows, cols))
    return tiles(grey, step, centre, angle_deg), float(np.sum(grey - 0.3)) * step**2


@pytest.mark.parametrize("about", [0.0, 45.0, 180.0])
def test_tiles_add_up(about):
    """A square of four was lost, 0.003 of full scale, where two corners differed in their last bits."""
    rng = np.random.default_rng(int(about))
    for _ in range(60):
        shapes, brighter = drawn_tiles(rng, float(about + rng.uniform(-1.0, 1.0) + 90.0 * rng.integers(4)))
        seen = arrange(camsim.Scene(background=0.3, shapes=shapes))
        area = 0.5 * (seen.start_um[:, 0] * seen.end_um[:, 1] - seen.start_um[:, 1] * seen.end_um[:, 0])
        surface = np.array(seen.spectra, float)
        assert abs(area @ (surface[seen.left] - surface[seen.right]) - brighter) < 1e-11


def test_what_areas_have_in_common():
    rng = np.random.default_rng(4)
    for _ in range(50):
        around = np.sort(rng.uniform(0.0, 2.0 * np.pi, 9))
        one, two = (
            shapely.Polygon(place + radius[:, None] * np.stack([np.cos(around), np.sin(around)], axis=1), [hole])
            for place, radius, hole in (
                (at, rng.uniform(1.0, 3.0, 9), at + 0.1 * np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, -1.0]]))
                for at in rng.uniform(-1.0, 1.0, (2, 2)) + 1e3
            )
        )
        if one.is_valid and two.is_valid:
            assert abs(common_area(one, two) - one.intersection(two).area) < 1e-11
    square = shapely.box(0.0, 0.0, 2.0, 2.0)
    assert common_area(square, shapely.box(2.0, -1.0, 3.0, 4.0)) == 0.0
    assert common_area(square, square) == 4.0
    assert common_area(square, shapely.Polygon()) == 0.0
    apart = shapely.MultiPolygon([shapely.box(-1.0, 0.0, 0.5, 1.0), shapely.box(1.0, 1.0, 3.0, 3.0)])
    assert common_area(apart, square) == common_area(square, apart) == 1.5


def test_common_area_of_outlines_of_many_sides():
    """What two discs of 200 000 sides have in common: 4e10 pairs of sides, of which those that meet are looked at."""
    count, apart = 200_000, 0.5
    turn = 2.0 * np.pi * np.arange(count) / count
    one, two = (shapely.Polygon(np.stack([np.cos(turn) + x, np.sin(turn) + 0.3 * x], axis=1)) for x in (0.0, apart))
    half = 0.5 * apart * np.hypot(1.0, 0.3)
    lens = 2.0 * (np.arccos(half) - half * np.sqrt(1.0 - half**2))
    assert abs(common_area(one, two) - lens) < 1e-9  # sides lie inside of circles: π³·2/3 over the count squared


def test_shapes_that_only_touch_keep_their_very_numbers(monkeypatch):
    """Crooked tiles that share corners bit by bit: none is cut out of another, which took longer than their image."""
    steps = np.linspace(-20.0, 20.0, 13)
    points = np.stack(np.meshgrid(steps, steps), axis=-1)
    points[1:-1, 1:-1] += np.random.default_rng(3).uniform(-1.0, 1.0, (11, 11, 2))
    corners = np.stack([points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]], axis=2).reshape(-1, 4, 2)
    shapes = [camsim.Polygon(points_um=own, reflectance=0.1 + 0.2 * (k % 3)) for k, own in enumerate(corners)]
    monkeypatch.setattr(shapely, "difference", None)
    seen = arrange(camsim.Scene(background=0.0, shapes=shapes))
    drawn = {tuple(place) for place in points.reshape(-1, 2).tolist()}
    assert {tuple(place) for place in np.concatenate([seen.start_um, seen.end_um]).tolist()} == drawn
    over = [*shapes, camsim.Rectangle(width_um=3.0, height_um=3.0, rotate_deg=10.0, reflectance=0.9)]
    with pytest.raises(TypeError):  # which covers some, and they are cut
        arrange(camsim.Scene(background=0.0, shapes=over))
