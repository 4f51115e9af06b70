"""Painter's order against painting: rectangles on a lattice, laid down in an array of cells one after the other."""

import numpy as np
import pytest
from areas import area_seen
from examples import OPTICS, image_of, worst

import camsim
from camsim.rendering.direct.scenery import pieces_of
from camsim.scene import arrange
from camsim.scene.arcs import Fineness

OPTICS_HERE = OPTICS["f/8, OLPF"]
CELLS = 12  # of one pitch, on each side
TOLERANCE = 1e-6
LEVELS = (0.0, 0.2, 0.7, 1.0)
BACKGROUND = 0.2


@pytest.fixture(scope="module")
def one_cell():
    """Image of one white cell at the middle of a frame so large that every shift of it can be cut out."""
    size = 4 * CELLS
    square = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    return image_of([(square, 1.0)], OPTICS_HERE, size + 1, size + 1, background=0.0, tolerance=1e-7)


def painted(rectangles):
    cells = np.full((CELLS, CELLS), BACKGROUND)
    for (left, top, right, bottom), reflectance in rectangles:
        cells[top:bottom, left:right] = reflectance
    return cells


def outline(box, rng):
    """The rectangle's corners from the lattice's middle, from a random corner on and either way round."""
    left, top, right, bottom = box
    corners = np.array([(left, top), (right, top), (right, bottom), (left, bottom)], float) - CELLS / 2
    return np.roll(corners[:: rng.choice([1, -1])], rng.integers(4), axis=0)


@pytest.mark.parametrize("seed", range(5))
def test_random_rectangles(one_cell, seed):
    """Covered, cut, cut in two, holed, alike to a neighbour or to the background: the sum over cells knows it all."""
    rng = np.random.default_rng(seed)
    rectangles = []
    for _ in range(rng.integers(2, 15)):
        x, y = np.sort(rng.choice(CELLS + 1, 2, replace=False)), np.sort(rng.choice(CELLS + 1, 2, replace=False))
        rectangles.append(((x[0], y[0], x[1], y[1]), float(rng.choice(LEVELS))))
    found = image_of(
        [(outline(box, rng), reflectance) for box, reflectance in rectangles],
        OPTICS_HERE,
        CELLS,
        CELLS,
        background=BACKGROUND,
    )
    contrast = painted(rectangles) - BACKGROUND
    expected = np.full((CELLS, CELLS), BACKGROUND)
    middle = 2 * CELLS
    for row, col in np.argwhere(contrast != 0.0):
        # Photosite (r, c) sees a cell in (row, col) as the middle one sees it from as far away.
        window = np.s_[middle - row : middle - row + CELLS, middle - col : middle - col + CELLS]
        expected += contrast[row, col] * one_cell[window]
    assert worst(found, expected) <= TOLERANCE + 1e-7 * np.abs(contrast).sum()


@pytest.mark.parametrize("turned_deg", [-180.0, -90.0, 0.0, 90.0])
@pytest.mark.parametrize("middle", [(0.0, -4.0), (-2.0, 4.75)])
def test_sides_whose_middle_lies_on_a_half_rings_chords(turned_deg, middle):
    """The check asks what is beside a piece at its middle: here it lies on a chord, at either end's very height."""
    ring = camsim.Sector(
        radius_um=4, inner_radius_um=2, centre_um=middle, from_deg=turned_deg, turn_deg=180, reflectance=0.1
    )
    across = camsim.Rectangle(width_um=2.0, height_um=2.0, centre_um=middle, reflectance=0.7)
    pieces, spectra = pieces_of(camsim.Scene(background=BACKGROUND, shapes=(across, ring)), 1.0, Fineness())
    found = [area_seen(pieces, k) for k in range(1, len(spectra))]
    assert found == pytest.approx([4.0, 6.0 * np.pi], abs=1e-9)


def fan(rng):
    """Triangles about one corner that share their other corners: their sides all but coincide where they are cut."""
    count = int(rng.integers(3, 6))
    around, corner = 10.0 * rng.normal(size=(count, 2)), rng.choice([-2.44, 0.0, 2.44], 2)
    return [np.array([corner, around[i], around[(i + 1) % count]]) for i in range(count)]


def within(triangle, points):
    """Whether points lie in a triangle: on the same side of all three sides."""
    turns = [
        (b - a)[0] * (points[:, 1] - a[1]) - (b - a)[1] * (points[:, 0] - a[0])
        for a, b in zip(triangle, np.roll(triangle, -1, axis=0), strict=True)
    ]
    return (np.min(turns, axis=0) > 0.0) | (np.max(turns, axis=0) < 0.0)


def region_at(arrangement, points):
    """Region of each point: how often an upward ray to the right crosses its outline, forth less back."""
    found = np.zeros(len(points), int)
    a, b = arrangement.start_um, arrangement.end_um
    for region in range(1, len(arrangement.spectra)):
        crossings = np.zeros(len(points), int)
        for edge in np.flatnonzero((arrangement.left == region) ^ (arrangement.right == region)):
            (x0, y0), (x1, y1) = a[edge], b[edge]
            spans = (y0 <= points[:, 1]) != (y1 <= points[:, 1])
            with np.errstate(divide="ignore", invalid="ignore"):
                beyond = x0 + (points[:, 1] - y0) / (y1 - y0) * (x1 - x0) > points[:, 0]
            turn = (1 if y1 > y0 else -1) * (1 if arrangement.left[edge] == region else -1)
            crossings += turn * (spans & beyond)
        assert set(crossings.tolist()) <= {0, 1}
        found[crossings == 1] = region
    return found


def test_fans_of_triangles():
    """A whole face was lost in 3 of 1000: polygons were joined, or one cut by others, in floating point."""
    points = np.random.default_rng(5).uniform(-15.0, 15.0, (100, 2))
    for seed in range(150):
        triangles = fan(np.random.default_rng([7, seed]))
        # The first, the third and the fifth are alike: they are joined.
        shapes = [camsim.Polygon(points_um=t, reflectance=0.3 + 0.3 * (k % 2)) for k, t in enumerate(triangles)]
        painted_last = np.zeros(len(points), int)
        for k, triangle in enumerate(triangles):
            painted_last[within(triangle, points)] = 1 + k % 2
        found = arrange(camsim.Scene(background=0.9, shapes=shapes))
        np.testing.assert_array_equal(region_at(found, points), painted_last, err_msg=f"fan {seed}")
