"""Noise stages: whole distributions, and photon transfer."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy.stats
from electronics import recorded
from tolerances import PROBABILITY

from camsim import Dsnu, Prnu, ReadNoise

F64 = np.ndarray[Any, np.dtype[np.float64]]

ROWS, COLS = 400, 1000


def flat(mean_e: float, **stages: Any) -> F64:
    settings = {"time_s": 1.0, "seed": 11, "serial": 5, "origin": (0, 0), "frame_cols": COLS} | stages
    electrons: F64 = recorded(np.full((ROWS, COLS), float(mean_e)), **settings)
    return electrons


def chi_square_p(counted: F64, expected: F64) -> float:
    """Probability of so bad a fit, after joining bins until each expects 10 or more."""
    joined_counted, joined_expected = [0.0], [0.0]
    for n, e in zip(counted.tolist(), expected.tolist(), strict=True):
        if joined_expected[-1] >= 10.0:
            joined_counted.append(0.0)
            joined_expected.append(0.0)
        joined_counted[-1] += n
        joined_expected[-1] += e
    n, e = np.array(joined_counted), np.array(joined_expected)
    if e[-1] < 10.0 and len(e) > 1:
        n, e = np.append(n[:-2], n[-2:].sum()), np.append(e[:-2], e[-2:].sum())
    return float(scipy.stats.chi2.sf(np.sum((n - e) ** 2 / e), len(e) - 1))


def normal_p(sample: F64, sigma: float) -> float:
    """χ² of a sample against a centred normal, in 200 classes of equal probability."""
    edges = scipy.stats.norm.ppf(np.linspace(0.0, 1.0, 201), scale=sigma)
    counted, _ = np.histogram(sample, bins=edges)
    assert counted.sum() == sample.size
    return chi_square_p(counted.astype(np.float64), np.full(200, sample.size / 200))


@pytest.mark.parametrize("mean_e", [0.1, 9.99, 10.0, 40_000.0])
def test_photons_are_poisson_distributed(mean_e: float) -> None:
    counts = flat(mean_e)
    assert (counts == np.rint(counts)).all()
    low, high = scipy.stats.poisson.ppf([1e-9, 1 - 1e-9], mean_e).astype(int)
    # Up to some 300 classes, the first and the last open.
    edges = np.unique(np.linspace(low, high + 1, min(300, high - low + 2)).astype(int)) - 0.5
    edges[0], edges[-1] = -np.inf, np.inf
    counted, _ = np.histogram(counts, bins=edges)
    expected = np.diff(scipy.stats.poisson.cdf(edges, mean_e)) * counts.size
    assert chi_square_p(counted.astype(np.float64), expected) > PROBABILITY


def test_read_noise_and_fixed_patterns_are_normal() -> None:
    assert normal_p(flat(1000.0, shot_noise=None, read_noise=ReadNoise(3.3)) - 1000.0, 3.3) > PROBABILITY
    assert normal_p(flat(0.0, dsnu=Dsnu(0.7)), 0.7) > PROBABILITY
    gain = flat(1e6, shot_noise=None, prnu=Prnu(0.01)) / 1e6
    assert normal_p(gain - 1.0, 0.01) > PROBABILITY


def test_a_wild_pattern_never_makes_light_negative() -> None:
    assert flat(100.0, shot_noise=None, prnu=Prnu(1.0)).min() > 0.0


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("noise", [True, False])
def test_a_mean_that_is_no_number_is_an_error(bad: float, noise: bool) -> None:
    with pytest.raises(ValueError, match="not all finite"):
        flat(bad, noise=noise)
