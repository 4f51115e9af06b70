"""Circles that edges touch, held against asking every edge of every circle."""

import math

import numpy as np
import pytest

import camsim
from camsim.numerics.quadrature import gauss_legendre
from camsim.rendering.boundary.rings import (
    is_short,
    oscillation_lengths,
    piece_phases,
    ring_amplitudes,
    ring_part,
    ring_tail,
)
from camsim.rendering.edges import Edges
from camsim.rendering.focus import SAME, Foci, distinct, foci, touching

BLUR = 0.7


@pytest.fixture(scope="module")
def crowd():
    """Discs of very different sizes as polygons, a few long edges across them, and circles about and beside them."""
    rng = np.random.default_rng(3)
    starts, ends, centre, radius = [], [], [], []
    for size in np.exp(rng.uniform(0.0, 5.0, 40)):
        angle = np.linspace(0.0, 2.0 * np.pi, int(rng.integers(5, 90)))
        middle = rng.uniform(-200.0, 200.0, 2)
        corners = middle + size * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        starts, ends = [*starts, *corners[:-1]], [*ends, *corners[1:]]
        centre += [middle + rng.normal(0.0, scale * size, 2) for scale in (0.0, 0.01, 0.05, 0.5)]
        radius += [size * math.cos(math.pi / (len(angle) - 1)), size, 1.04 * size, 0.8 * size]
    starts, ends = [*starts, *rng.uniform(-300.0, 0.0, (7, 2))], [*ends, *rng.uniform(0.0, 3000.0, (7, 2))]
    none = np.zeros(len(starts), np.int64)
    edges = Edges(start=np.array(starts), end=np.array(ends), left=none, right=none)
    return np.array(centre), np.array(radius), edges


def _beside(point, edges):
    """Distances of a point from edges' lines, how far its foot lies from the start, and distances from the edges."""
    along = (edges.end - edges.start) / edges.length[:, None]
    gap = point - edges.start
    foot = np.sum(gap * along, axis=1)
    nearest = edges.start + np.clip(foot, 0.0, edges.length)[:, None] * along
    return np.abs(gap[:, 0] * along[:, 1] - gap[:, 1] * along[:, 0]), foot, np.hypot(*(nearest - point).T)


def test_shares_are_those_of_all_edges_a_radius_away(crowd):
    centre, radius, edges = crowd
    passed = np.random.default_rng(1).uniform(0.1, 1.0, len(edges))
    found = foci(centre, radius, edges, BLUR, passed)
    for c, r, share in zip(centre, radius, found.share, strict=True):
        in_step = np.abs(_beside(c, edges)[2] - r) <= 0.25 * BLUR
        filled = passed[in_step] @ np.minimum(edges.length[in_step], math.sqrt(BLUR * r)) / (2.0 * math.pi * r)
        assert share == pytest.approx(min(filled, 1.0), rel=1e-12)
    assert found.share.max() > 0.5
    assert found.share.min() < 0.1


def test_a_focus_has_all_edges_that_touch_its_circle(crowd):
    centre, radius, edges = crowd
    first, picked = touching(Foci(centre, radius, np.zeros(radius.size)), edges)
    for k, (c, r) in enumerate(zip(centre, radius, strict=True)):
        off, foot, _ = _beside(c, edges)
        slack = 2.0 * SAME * r
        touches = (np.abs(off - r) <= slack) & (foot >= -slack) & (foot <= edges.length + slack)
        assert sorted(picked[first[k] : first[k + 1]]) == np.flatnonzero(touches).tolist()


def test_of_foci_with_much_in_common_the_strongest_is_kept():
    rng = np.random.default_rng(5)
    radius = np.exp(rng.uniform(0.0, 3.0, 40))[rng.integers(0, 40, 3000)] * rng.uniform(0.97, 1.03, 3000)
    found = Foci(rng.uniform(-3.0, 3.0, (3000, 2)), radius, rng.integers(0, 30, 3000) / 30.0)
    kept = distinct(found)
    expected: list[int] = []
    for k in np.argsort(-found.share, kind="stable"):
        apart = np.abs(found.centre[expected] - found.centre[k]).max(axis=1, initial=0.0)
        apart = np.maximum(apart, np.abs(radius[expected] - radius[k]))
        if not (apart <= SAME * radius[expected]).any():
            expected.append(int(k))
    assert np.array_equal(kept.radius, radius[expected])
    assert len(expected) < 2000


def test_no_circle_has_no_focus():
    nothing = Foci(np.empty((0, 2)), np.empty(0), np.empty(0))
    assert not distinct(nothing).radius.size


@pytest.mark.parametrize(("tolerance", "left"), [(1e-9, 2e-6), (1e-4, 1e-5)])
@pytest.mark.parametrize("lens", [camsim.Airy(f_number=5.6), camsim.AnnularAiry(f_number=5.6, obstruction=0.4)])
def test_rings_of_short_pieces_along_them_and_off_the_real_axis(lens, tolerance, left):
    """By nodes on a piece, and as the difference of what its two ends send: two paths of one contour integral."""
    pattern, blur, weights, near = lens.pattern(), np.array([0.55, 0.63]), np.array([0.4, 0.6]), 8.0
    x, w = gauss_legendre(12)
    nodes, footprint = 0.5 * np.stack(np.meshgrid(x, x), axis=-1).reshape(-1, 2), 0.25 * np.outer(w, w).ravel()
    amplitude = ring_amplitudes(pattern.oscillations, blur, nodes, footprint, turns=4, nearest=near)
    lengths, rng, pieces, ends = oscillation_lengths(pattern.oscillations, blur), np.random.default_rng(1), [], []
    known = (weights, lengths, amplitude, 4, near)
    for _ in range(300):
        (h, s), long = np.exp(rng.uniform(2.1, 4.0, 2)), np.exp(rng.uniform(-4.0, 0.5))
        way = np.exp(2j * np.pi * rng.uniform())
        if is_short(long, lengths.min(), piece_phases(tolerance)):
            pieces.append(ring_part(h, (s, s + long), way, *known, piece_phases(tolerance)))
            ends.append([ring_tail(h, end, way.real, way.imag, *known) for end in (s, s + long)])
    assert len(pieces) > 200
    strongest = np.abs(ends).max()
    assert np.abs(pieces).max() > 0.5 * strongest
    # Rays end where e⁻¹⁶ is left.
    assert np.abs(pieces + np.diff(ends, axis=1)[:, 0]).max() <= left * strongest
