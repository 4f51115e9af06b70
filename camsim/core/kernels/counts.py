"""Fast Poisson counts, for training loops; captures use numpy's."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from camsim.core.arrays import F64
from camsim.core.kernels.dispatch import kernel

_FEW = 10.0
"""Means below it use inversion by search from 0 on, others Hörmann's transformed rejection."""

_STEP, _MIX, _MIX_AGAIN = (np.uint64(odd) for odd in (0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB))
_30, _27, _31, _11 = (np.uint64(shift) for shift in (30, 27, 31, 11))
_UNIT = 2.0**-53

_NOTHING = 1e-18  # probability: no number drawn is this near to 1
_TABLED = 128  # no count of a small mean is this large
_INVERSE = np.array([0.0, *(1.0 / count for count in range(1, _TABLED))])
_LOG_FACTORIAL = np.array([math.lgamma(count + 1.0) for count in range(_TABLED)])
_HALF_LOG_2_PI = 0.5 * math.log(2.0 * math.pi)


@kernel()
def _uniform(state: Any) -> float:
    """Return a uniform number in [0, 1) from a state of SplitMix64 (Steele, Lea and Flood 2014)."""
    mixed = (state ^ (state >> _30)) * _MIX
    mixed = (mixed ^ (mixed >> _27)) * _MIX_AGAIN
    drawn: float = ((mixed ^ (mixed >> _31)) >> _11) * _UNIT
    return drawn


@kernel()
def _log_factorial(count: float) -> float:
    """Return ln(count!) to rounding, from a table, and beyond it by Stirling's series."""
    if count < _TABLED:
        tabled: float = _LOG_FACTORIAL[int(count)]
        return tabled
    inverse = 1.0 / count
    return (count + 0.5) * math.log(count) - count + _HALF_LOG_2_PI + inverse * (1.0 / 12.0 - inverse * inverse / 360.0)


@kernel()
def fill_counts(counts: F64, mean: F64, state: npt.NDArray[np.uint64]) -> None:
    """Write a Poisson count for each mean, exactly distributed for any mean.

    counts, mean : (n,), of 0 or more;  state: (1,) of the generator, which is advanced

    W. Hörmann, "The transformed rejection method for generating Poisson random variables", Insurance: Mathematics and
    Economics 12 (1993), algorithm PTRS.

    >>> counts = np.empty(2)
    >>> fill_counts(counts, np.array([0.0, 1e6]), np.array([7], np.uint64))
    >>> bool(counts[0] == 0.0 and abs(counts[1] - 1e6) < 6e3)
    True
    """
    at = state[0]
    for place in range(mean.size):
        one = mean[place]
        if one < _FEW:
            at += _STEP
            left, chance, few = _uniform(at), math.exp(-one), 0
            while left >= chance and chance > _NOTHING:
                left -= chance
                few += 1
                chance *= one * _INVERSE[few]
            counts[place] = few
            continue
        root = math.sqrt(one)
        b = 0.931 + 2.53 * root
        a = -0.059 + 0.02483 * b
        quick = 0.9277 - 3.6224 / (b - 2.0)
        while True:
            at += _STEP
            u = _uniform(at) - 0.5
            at += _STEP
            v = _uniform(at)
            us = 0.5 - abs(u)
            if us <= 0.0:
                continue
            count = math.floor((2.0 * a / us + b) * u + one + 0.43)
            if us >= 0.07 and v <= quick:
                break
            if count < 0.0 or (us < 0.013 and v > us) or v <= 0.0:
                continue
            inverse = 1.1239 + 1.1328 / (b - 3.4)
            height = math.log(v * inverse / (a / (us * us) + b))
            if height <= count * math.log(one) - one - _log_factorial(count):
                break
        counts[place] = count
    state[0] = at
