"""Painter's order against painting: rectangles on a lattice, laid down in an array of cells one after the other."""

import numpy as np
import pytest
from examples import OPTICS, image_of, worst

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


@pytest.mark.parametrize("seed", range(12))
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
