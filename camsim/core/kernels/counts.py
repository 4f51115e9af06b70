"""Poisson counts by inversion: each a function of a mean and a standard normal number."""

from __future__ import annotations

import math

import numpy as np

from camsim.core.arrays import F64
from camsim.core.kernels.dispatch import kernel

_FEW, _MANY = 4.0, 1e6
"""Below: probabilities are summed. From ``_MANY`` on: the expansion, the error of which is that of rounding."""
_NOTHING = 1e-18  # probability: far less than the rounding of a sum of probabilities
_DARK, _DARK_NORMAL = 0.0227, 2.0
"""A mean and a normal number below these give 0: its probability e⁻ᵐ ≥ 1 − m exceeds that of a normal below 2."""


@kernel(error_model="numpy")
def _chance(count: float, mean: float) -> float:
    """Return the probability of a count, to rounding: Stirling's series keeps the digits of a large one."""
    if count < 1.0:
        return math.exp(-mean)
    if count < 20.0:
        return math.exp(count * math.log(mean) - mean - math.lgamma(count + 1.0))
    off = (mean - count) / count
    series = (1.0 / 12.0 - (1.0 / 360.0 - 1.0 / 1260.0 / (count * count)) / (count * count)) / count
    return math.exp(count * (math.log1p(off) - off) - series) / math.sqrt(2.0 * math.pi * count)


@kernel(error_model="numpy")
def _summed(mean: float, normal: float) -> float:
    """Return the least count whose cumulative probability reaches that of a normal number."""
    wanted = 0.5 * math.erfc(-math.sqrt(0.5) * normal)
    count = max(math.floor(mean + normal * math.sqrt(mean)), 0.0) if mean >= _FEW else 0.0
    chance = _chance(count, mean)
    cumulative = part = chance
    below = count
    while part > _NOTHING:
        part *= below / mean
        below -= 1.0
        cumulative += part
    while count > 0.0 and cumulative - chance >= wanted:
        cumulative -= chance
        chance *= count / mean
        count -= 1.0
    while cumulative < wanted and chance > _NOTHING:
        count += 1.0
        chance *= mean / count
        cumulative += chance
    return count


@kernel(error_model="numpy")
def fill_counts(counts: F64, mean: F64, normals: F64) -> None:
    """Write for each mean the Poisson count that has the cumulative probability of a standard normal number.

    counts, mean, normals : (n,); means of 0 or less give 0

    Counts are distributed exactly: a normal number decides wrongly between two neighbouring counts with a probability
    below 1e-13 for means up to 1e6; for larger means, with that due to their rounding to 53 bits. Counts increase with
    mean and number. The expansion in the mean's root is M. Giles, "Algorithm 955: approximation of the inverse Poisson
    cumulative distribution function", ACM TOMS 42 (2016); within ``doubt`` of a whole number probabilities are summed.

    >>> counts = np.empty(3)
    >>> fill_counts(counts, np.array([0.0, 2.0, 1e6]), np.array([0.5, 0.5, 1.0]))
    >>> counts.tolist()
    [0.0, 3.0, 1001000.0]
    """
    for place in range(mean.size):  # without branches: vectorised
        one, normal = mean[place], normals[place]
        inverse = 1.0 / one
        inverse_root = math.sqrt(inverse)
        square = normal * normal
        guess = one + normal * one * inverse_root + (1.0 / 3.0 + square / 6.0)
        guess -= normal * (1.0 / 36.0 + square / 72.0) * inverse_root
        guess += (square * (square / 270.0 + 7.0 / 810.0) - 8.0 / 405.0) * inverse
        count = np.floor(guess)
        doubt = 0.02 * (1.0 + square * square * abs(normal)) * inverse * inverse_root
        sure = (one >= _FEW) & (doubt < guess - count) & (guess - count < 1.0 - doubt) | (one >= _MANY)
        counts[place] = count if sure else -1.0
    for place in range(mean.size):
        if counts[place] < 0.0:
            one, normal = mean[place], normals[place]
            dark = one <= 0.0 or (one < _DARK and normal < _DARK_NORMAL)
            counts[place] = 0.0 if dark else _summed(one, normal)
