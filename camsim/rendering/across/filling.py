"""Weights that fill in what lies between every n-th photosite: the best there are for what a band has to show.

    g(n + t) ≈ Σ_k w_k(t)·g(n + k)        t = 0, 1/step, 2/step …; k = 1 − points/2 … points/2

They are least squares over waves, each as loud as it is in the band: what is hardly there may be lost. Lagrange's,
which are exact at frequency 0 and worst where a band ends, take twice as many samples along either axis for the same.
"""

from __future__ import annotations

import numpy as np
import scipy

from camsim.arrays import F64

STEPS = (8, 6, 4, 2)  # photosites from one to the next: even, or every second one asks for all phases
POINTS = (28, 8, 12, 16, 20, 24)  # weighed along either axis: the most first, which tells whether a step is possible
WAVES = 128  # at which what is lost is looked at: nine or more in the finest wave of the weights
FAINT = 1e-9  # of the loudest wave: none is let run wild
ALL: F64 = np.ones((1, 1))  # every photosite is there


def coarsest(frequency: F64, density: F64, allowed: float) -> F64:
    """Return weights (step, points) for the largest step that loses no more than allowed.

    frequency : cycles/pitch, even steps from 0 to the highest;  density: how much a line shows there, per cycle/pitch
    """
    waves = np.linspace(0.0, float(frequency[-1]), WAVES)
    loud = np.maximum(np.interp(waves, frequency, density), 0.0)
    for step in STEPS:
        if 2.0 * waves[-1] * step >= 1.0:
            continue
        most, *fewer = POINTS
        if lost(waves, loud, best := weights(waves, loud, step, most)) > allowed:
            continue
        each = (weights(waves, loud, step, points) for points in fewer)
        return next((own for own in each if lost(waves, loud, own) <= allowed), best)
    return ALL


def weights(frequency: F64, density: F64, step: int, points: int) -> F64:
    """Return weights (step, points), least squares over waves of frequencies in cycles/pitch.

    >>> near = weights(np.linspace(0.0, 0.05, 50), np.ones(50), 2, 12)
    >>> wave = near @ np.cos(0.1 * np.pi * (np.arange(12) - 5))
    >>> bool(np.abs(wave - np.cos(0.05 * np.pi * np.arange(2))).max() < 1e-9)
    True
    """
    times = density + FAINT * density.max()
    turns = 2.0 * np.pi * step * frequency

    def waves(places: F64) -> F64:
        turned = np.multiply.outer(turns, places)
        return np.concatenate([np.cos(turned) * times[:, None], np.sin(turned) * times[:, None]])

    left, right = waves(np.arange(float(points)) - (points // 2 - 1)), waves(np.arange(float(step)) / step)
    return np.ascontiguousarray(scipy.linalg.lstsq(left, right, cond=1e-12)[0].T)


def lost(frequency: F64, density: F64, between: F64) -> float:
    """Return what is lost of a line along both axes: no wave counts for less than those below it."""
    step, points = between.shape
    turns = 2j * np.pi * step * frequency
    made = np.exp(np.multiply.outer(turns, np.arange(points) - (points // 2 - 1.0))) @ between.T
    off = np.abs(made - np.exp(np.multiply.outer(turns, np.arange(step) / step))).max(axis=1)
    return 2.0 * float(np.sum(np.maximum.accumulate(off) * density)) * float(frequency[1])
