"""What sides are heard of rings beyond a taper, against the integrals themselves."""

import math

import numpy as np
import pytest
from scipy import integrate, interpolate

from camsim.rendering.check.sides import Sides
from camsim.rendering.edges import Edges
from camsim.rendering.fourier.loudness import Loudness
from camsim.rendering.fourier.taper import Hem, taper, tapered

HEM = Hem(60.0, 74.0, 20.0)  # in λN, of a band of half a ring's frequency
FAR, STEP = 2000.0, 0.005


def _sounds(start, end):
    """∫ (G(r) − G(∞)) dφ along sides, G′ = (1 − taper)·cos(2πr)/r²: rings of one in r³."""
    r = np.arange(HEM.inner, FAR, STEP)
    slope = (1.0 - tapered(r, HEM.inner, HEM.outer, taper(HEM.sharpness))) * np.cos(2.0 * np.pi * r) / r**2
    gained = integrate.cumulative_simpson(slope, x=r, initial=0.0)
    gained -= gained[-1] - np.sin(2.0 * np.pi * r[-1]) / (2.0 * np.pi * r[-1] ** 2)  # and what is beyond
    gained = interpolate.CubicSpline(r, gained)
    x, w = np.polynomial.legendre.leggauss(20)
    found = []
    for a, b in zip(start, end, strict=True):
        panels = max(4, math.ceil(np.hypot(*(b - a)) / 2.0))
        t = ((np.arange(panels)[:, None] + 0.5 * (1.0 + x)) / panels).ravel()
        places = a + t[:, None] * (b - a)
        away = np.hypot(*places.T)
        turn = (places[:, 0] * (b - a)[1] - places[:, 1] * (b - a)[0]) / away**2
        found.append(np.sum(gained(np.maximum(away, HEM.inner)) * turn * np.tile(0.5 / panels * w, panels)))
    return np.abs(found)


@pytest.mark.parametrize("hearing", [Loudness, Sides])
@pytest.mark.parametrize("slowest", [1.0, 7.0])
def test_a_frame_hears_what_any_of_its_photosites_does(rng, hearing, slowest):
    edges, shape = _sides(rng, 300), (12, 50)
    away, part = hearing.of(edges, shape, 0.7, 1.0, slowest).beyond(HEM.inner)
    for place in ((0.0, 0.0), (49.0, 0.0), (0.0, 11.0), (49.0, 11.0), (20.0, 5.0)):
        own_away, own_part = hearing.of(edges.seen_from(place), (1, 1), 0.7, 1.0, slowest).beyond(HEM.inner)
        assert np.all(part * away**-2.5 >= (1.0 - 1e-9) * own_part * own_away**-2.5)


def _sides(rng, count):
    angle, size = rng.uniform(0.0, 2.0 * np.pi, (2, count)), 10.0 ** rng.uniform(0.5, 3.1, (2, count))
    start, end = np.moveaxis(size * np.stack([np.cos(angle), np.sin(angle)]), 0, -1)
    return Edges(start=start, end=end, left=np.zeros(count, np.int64), right=np.ones(count, np.int64))


@pytest.mark.parametrize("hearing", [Loudness, Sides])
def test_no_side_is_heard_more_than_is_told_and_few_are_told_much_more(rng, hearing):
    edges = _sides(rng, 400)
    start, end = edges.start, edges.end
    away, part = hearing.of(edges, (1, 1), 0.0, 1.0, 1.0).beyond(HEM.inner)
    told = part * away**-2.5 / (2.0 * np.pi)
    heard = _sounds(start, end)
    assert np.all(heard <= told + 1e-10)  # what the taper leaves, and what the integrals are wrong by
    within = np.maximum(np.hypot(*start.T), np.hypot(*end.T)) < 0.8 * HEM.inner
    assert within.any()
    assert not told[within].any()
    # As if each line were heard from the taper on.
    as_lines = np.minimum(1.0, 0.5 * np.hypot(*(end - start).T) / np.sqrt(away)) * away**-2.5 / (2.0 * np.pi)
    assert told.sum() < 0.2 * as_lines.sum()
