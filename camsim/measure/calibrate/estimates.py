"""Combination of figures with errors."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from camsim.measure.noise import Estimate
from camsim.measure.noise.estimate import SURE, no_figure


def without(before_e2: Estimate, jumps_e2: Estimate) -> Estimate:
    """Return a standard deviation, electrons, after the variance of telegraph noise has been subtracted."""
    return root(Estimate(before_e2.value - jumps_e2.value, math.hypot(before_e2.sigma, jumps_e2.sigma)))


def root(squared: Estimate) -> Estimate:
    """Return the root of a variance; an upper limit if it is not significantly above 0."""
    if not squared.measurable:
        return squared
    if squared.value > SURE * squared.sigma:
        root = math.sqrt(squared.value)
        return Estimate(root, 0.5 * squared.sigma / root)
    most = math.sqrt(max(squared.value, 0.0) + SURE * squared.sigma)
    return no_figure(f"its square is within {SURE:g} standard errors of 0", at_most=most)


def mean_of(stated: Sequence[Estimate]) -> Estimate:
    """Return the weighted mean of independent figures; its error is widened if they disagree."""
    known = [each for each in stated if each.measurable]
    if not known:
        return stated[0]
    if any(each.sigma == 0.0 for each in known):
        return known[0]
    weight = np.array([1.0 / each.sigma**2 for each in known])
    value = np.array([each.value for each in known])
    mean = float(np.sum(weight * value) / np.sum(weight))
    misfit = float(np.sum(weight * (value - mean) ** 2))
    wider = max(1.0, misfit / (len(known) - 1)) if len(known) > 1 else 1.0
    return Estimate(mean, math.sqrt(wider / float(np.sum(weight))))


def best_of(stated: Sequence[Estimate]) -> Estimate:
    """Return the figure with the least relative error, not a mean: settings share photosites and are dependent."""
    known = [each for each in stated if each.measurable]
    return min(known, key=lambda each: each.sigma / each.value) if known else stated[0]
