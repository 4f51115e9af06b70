"""What sides are heard of rings beyond a taper, against the integrals themselves."""

import math

import numpy as np
from scipy import integrate, interpolate

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


def test_no_side_is_heard_more_than_is_told_and_few_are_told_much_more(rng):
    angle, size = rng.uniform(0.0, 2.0 * np.pi, (2, 400)), 10.0 ** rng.uniform(0.5, 3.1, (2, 400))
    start, end = np.moveaxis(size * np.stack([np.cos(angle), np.sin(angle)]), 0, -1)
    edges = Edges(start=start, end=end, left=np.zeros(400, np.int64), right=np.ones(400, np.int64))
    away, part = Loudness.of(edges, (1, 1), 0.0, 1.0, 1.0).beyond(HEM.inner)
    told = part * away**-2.5 / (2.0 * np.pi)
    heard = _sounds(start, end)
    assert np.all(heard <= told + 1e-10)  # what the taper leaves, and what the integrals are wrong by
    within = np.maximum(np.hypot(*start.T), np.hypot(*end.T)) < 0.8 * HEM.inner
    assert within.any()
    assert not told[within].any()
    # As if each line were heard from the taper on.
    as_lines = np.minimum(1.0, 0.5 * np.hypot(*(end - start).T) / np.sqrt(away)) * away**-2.5 / (2.0 * np.pi)
    assert told.sum() < 0.2 * as_lines.sum()
