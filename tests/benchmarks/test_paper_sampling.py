"""What a cut Airy pattern does to the paper's sampling, against closed forms (bench/paper/README.md)."""

import numpy as np
import pytest

import camsim
from camsim.rendering.edges import Edges
from camsim.rendering.paper.rules import Rule, _importance

FAR = 2e4  # pitches: a square of this side is a half-plane
LENS = camsim.Airy(f_number=8.0)
LAMBDA_N_PX = 0.55 * 8.0 / 4.88
CORNERS = FAR * np.array([[0.0, -0.5], [1.0, -0.5], [1.0, 0.5], [0.0, 0.5]])


def cut_image(samples, cut, corners, *, origin, shape):
    """Black polygon on white, pitches."""
    places, shares = _importance(LENS, LAMBDA_N_PX, samples, cut)
    rule = Rule(places=places, shares=shares, width=1.0, height=1.0)
    contrast = np.full(len(corners), -1.0)
    sides = np.ones(len(corners), int)
    edges = Edges(start=corners, end=np.roll(corners, -1, axis=0), left=sides, right=0 * sides)
    return rule.image(edges, contrast, 1.0, origin=origin, shape=shape)


def test_beside_an_edge_the_cut_pattern_errs_by_the_light_beyond_the_cut():
    cut = 18.0
    distance = np.arange(6, 14) + 0.5  # inside the black: past the first rings, within either cut
    image = cut_image(40401, cut, CORNERS, origin=(distance[0], 0.0), shape=(1, distance.size))[0]
    grid = camsim.Grid(rows=1, cols=2 * int(distance[-1] + 1), pitch_um=4.88)
    black = camsim.Rectangle(
        width_um=FAR * 4.88, height_um=FAR * 4.88, centre_um=(0.5 * FAR * 4.88, 0.0), reflectance=0.0
    )
    exact = camsim.render(
        camsim.Scene(background=1.0, shapes=[black]),
        [LENS, camsim.SquarePhotosite(side_um=4.88)],
        grid,
        wavelength_nm=550.0,
        tolerance=1e-9,
    ).image[0, -distance.size :]
    # The pattern falls as 1/r³: 2/π²R of its light lies beyond R, and of a circle of radius r an edge d away leaves
    # arccos(d/r)/π on its bright side; k = d/R.
    beyond, k = 2.0 / (np.pi**2 * cut), distance / (cut * LAMBDA_N_PX)
    bright = (np.arccos(k) + (1.0 - np.sqrt(1.0 - k * k)) / k) / np.pi
    expected = beyond / (1.0 - beyond) * (exact - bright)
    assert np.all(expected < -0.1 * beyond)
    np.testing.assert_allclose((image - exact).mean(), expected.mean(), rtol=0.05)


def test_sampling_loses_no_light():
    """So the frame's mean error is the shadow that the whole pattern casts beyond it, whatever the cut and samples."""
    turn = np.array([[np.cos(0.07), np.sin(0.07)], [-np.sin(0.07), np.cos(0.07)]])
    corners = np.array([[-10.0, -10.0], [10.0, -10.0], [10.0, 10.0], [-10.0, 10.0]]) @ turn
    image = cut_image(40, 18.0, corners, origin=(-39.5, -39.5), shape=(80, 80))
    assert np.sum(1.0 - image) == pytest.approx(400.0, abs=1e-6)
