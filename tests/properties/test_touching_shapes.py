"""Shapes that share sides but for rounding: areas add up, whatever the angle."""

import numpy as np
import pytest
import shapely
from areas import brightness
from examples import tiles

import camsim
from camsim.scene.arrange import arrange


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
    for _ in range(25):
        shapes, brighter = drawn_tiles(rng, float(about + rng.uniform(-1.0, 1.0) + 90.0 * rng.integers(4)))
        assert abs(brightness(arrange(camsim.Scene(background=0.3, shapes=shapes))) - brighter) < 1e-11


@pytest.mark.parametrize(
    ("corners", "box"),
    [
        # GEOS cut this to a box 1 % larger, through two of whose corners its sides pass, and lost 5 of 10 µm².
        ([(-48, -12), (-10, -12), (-8, -10), (12, -15), (19, -1)], (-9.0, -11.0, -4.0, -8.0)),
        # Of this sliver it left a ring of two corners, and gave up.
        (
            [
                *((59.39187706941625, -8.495043293329392), (28.086494876565133, -39.598809207157224)),
                (45.23928724845758, -22.55648608785451),
            ],
            (0.4681849149732568, -55.60181508502674, 37.34381508502674, -19.77690423115159),
        ),
    ],
)
def test_a_shape_of_many_corners_hides_all_that_it_covers(corners, box):
    low, high = np.array(box[:2]), np.array(box[2:])
    size = (high - low) - 0.02 * (high - low).max() / 1.02
    below = camsim.Rectangle(width_um=size[0], height_um=size[1], centre_um=0.5 * (low + high), reflectance=0.5)
    many = [shapely.Polygon([(200 + 9 * k, 0), (205 + 9 * k, 0), (200 + 9 * k, 5)]) for k in range(20)]
    over = shapely.MultiPolygon([shapely.Polygon(corners), *many])
    seen = arrange(camsim.Scene(background=0.0, shapes=[below, camsim.Path.of(over, reflectance=1.0)]))
    light = over.area + 0.5 * shapely.Polygon(below.corners_um).difference(over).area
    assert abs(brightness(seen) - light) < 1e-9


def test_shapes_that_only_touch_keep_their_very_numbers(monkeypatch):
    """Crooked tiles that share corners bit by bit: none is cut out of another, which took longer than their image."""
    steps = np.linspace(-20.0, 20.0, 13)
    points = np.stack(np.meshgrid(steps, steps), axis=-1)
    points[1:-1, 1:-1] += np.random.default_rng(3).uniform(-1.0, 1.0, (11, 11, 2))
    corners = np.stack([points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]], axis=2).reshape(-1, 4, 2)
    shapes = [camsim.Polygon(points_um=each, reflectance=0.1 + 0.2 * (k % 3)) for k, each in enumerate(corners)]
    monkeypatch.setattr(shapely, "difference", None)
    seen = arrange(camsim.Scene(background=0.0, shapes=shapes))
    drawn = {tuple(place) for place in points.reshape(-1, 2).tolist()}
    assert {tuple(place) for place in np.concatenate([seen.start_um, seen.end_um]).tolist()} == drawn
    over = [*shapes, camsim.Rectangle(width_um=3.0, height_um=3.0, rotate_deg=10.0, reflectance=0.9)]
    with pytest.raises(TypeError):  # which covers some, and they are cut
        arrange(camsim.Scene(background=0.0, shapes=over))
