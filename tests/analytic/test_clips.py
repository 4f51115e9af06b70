"""What clips many shapes at once, held against the same shapes under what the clip leaves out."""

import numpy as np
import pytest

import camsim

PITCH_UM = 4.0
OPTICS = [camsim.Airy(f_number=6.0), camsim.SquarePhotosite(side_um=PITCH_UM)]
GRID = camsim.Grid(rows=24, cols=24, pitch_um=PITCH_UM)


def rendered(*shapes, tolerance=1e-4):
    scene = camsim.Scene(background=0.6, shapes=shapes)
    found = camsim.render(scene, OPTICS, GRID, wavelength_nm=550.0, tolerance=tolerance)
    assert found.error_estimate <= tolerance
    return found.image


def half_plane(towards_deg):
    return camsim.HalfPlane(through_um=(1.3, 0.0), towards_deg=towards_deg, reflectance=0.6)


def leaves(count):
    chart = camsim.charts.dead_leaves(width_um=80.0, height_um=60.0, least_radius_um=4.0, largest_radius_um=20.0)
    return chart.shapes[-count:]


@pytest.mark.parametrize(
    "shapes",
    [
        [camsim.RepeatOnGrid(shapes=[camsim.Disc(radius_um=3.0, reflectance=0.1)], rows=15, cols=15, step_um=(8, 8))],
        leaves(300),
        [camsim.Text(text="Ag&8\nig%@", size_um=30.0, align="centre", vertical="middle", reflectance=0.1)],
    ],
    ids=["dots", "leaves", "letters"],
)
def test_a_crowd_under_one_clip_is_the_crowd_under_what_the_clip_leaves_out(shapes):
    """Every shape of it has the clip's outline: these are one, cut once, and of each place one is asked (100 dots under
    a disc took more than 8 GB)."""
    clipped = rendered(camsim.Group(shapes=shapes, clip=half_plane(20.0)))
    np.testing.assert_allclose(clipped, rendered(*shapes, half_plane(200.0)), atol=1e-4)


def test_a_clip_s_two_halves_are_the_whole():
    shapes = leaves(40)
    halves = [camsim.Group(shapes=shapes, clip=half_plane(towards_deg)) for towards_deg in (20.0, 200.0)]
    np.testing.assert_allclose(rendered(*halves), rendered(*shapes), atol=1e-4)


def test_a_clip_that_covers_nothing_leaves_nothing():
    nothing = camsim.Text(text=" ", size_um=9.0, reflectance=0.0)
    assert np.all(rendered(camsim.Group(shapes=leaves(5), clip=nothing)) == 0.6)


def test_more_shapes_in_one_another_than_memory_holds_are_refused_at_once(monkeypatch):
    """50 000 rings of a zone plate are 1.2 thousand million pairs; here 2000 are two million, and one is allowed."""
    monkeypatch.setattr("camsim.scene.visible.MOST_PAIRS", 1_000_000)
    plate = camsim.charts.zone_plate(radius_um=34.5, rim_period_um=0.0172)
    with pytest.raises(camsim.CamsimError, match="shapes more than 1 million pairs lie one over the other; draw fewer"):
        rendered(plate)
