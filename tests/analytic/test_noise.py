"""Noise stages and their chain: whole distributions, photon transfer, and the order of the stages."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy.stats
from electronics import context, recorded
from tolerances import PROBABILITY, STATISTICAL

from camsim import DarkCurrent, Dsnu, FullWell, Prnu, ReadNoise, ShotNoise
from camsim.core.errors import InvalidValueError
from camsim.sensor.adc import Adc

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


@pytest.mark.parametrize("mean_e", [0.1, 3.0, 9.99, 10.0, 170.0, 40_000.0])
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


@pytest.mark.parametrize("level_e", [0.1, 10.0, 1000.0, 40_000.0])
def test_read_noise_is_normal_at_every_level(level_e: float) -> None:
    noisy = flat(level_e, shot_noise=None, read_noise=ReadNoise(3.3))
    assert normal_p(noisy - level_e, 3.3) > PROBABILITY


def test_fixed_patterns_are_normal() -> None:
    assert normal_p(flat(0.0, dsnu=Dsnu(0.7)), 0.7) > PROBABILITY
    gain = flat(1e6, shot_noise=None, prnu=Prnu(0.01)) / 1e6
    assert normal_p(gain - 1.0, 0.01) > PROBABILITY


@pytest.mark.parametrize("mean_e", [50.0, 1_000.0, 8_000.0, 30_000.0])
def test_photon_transfer_gives_back_gain_and_read_noise(mean_e: float) -> None:
    """From codes alone: the temporal variance of flats less that of darks, over the signal."""
    adc = Adc(bit_depth=14, black_level_dn=600, electrons_per_dn=2.5, base_iso=100.0)
    stages = {"prnu": Prnu(0.02), "dsnu": Dsnu(2.0), "read_noise": ReadNoise(9.0), "full_well": FullWell(5e4)}

    def codes(level_e: float, seed: int) -> F64:
        out = flat(level_e, seed=seed, **stages)
        return adc.quantise(out, iso=100.0).astype(np.float64)

    flats = codes(mean_e, 1), codes(mean_e, 2)
    darks = codes(0.0, 3), codes(0.0, 4)
    signal_dn = np.mean(flats) - np.mean(darks)
    variance, dark_variance = (np.var(a - b) / 2 for a, b in (flats, darks))
    n = ROWS * COLS
    gain = (variance - dark_variance) / signal_dn
    error = np.sqrt(2 / n) * np.hypot(variance, dark_variance) / signal_dn
    assert abs(gain - 1 / 2.5) < STATISTICAL * error
    # The rounding of the converter adds a twelfth of a squared code.
    read_dn = np.sqrt(dark_variance - 1 / 12)
    assert abs(read_dn - 9.0 / 2.5) < STATISTICAL * read_dn / np.sqrt(2 * n)
    # Pattern: what stays in the mean of both frames, less what noise leaves there.
    pattern_dn2 = np.cov(flats[0].ravel(), flats[1].ravel())[0, 1]
    expected_dn2 = ((0.02 * mean_e) ** 2 + 2.0**2) / 2.5**2
    total_dn2 = expected_dn2 + variance
    assert abs(pattern_dn2 - expected_dn2) < STATISTICAL * np.sqrt(2 / n) * total_dn2


def test_dark_current_comes_with_its_own_shot_noise() -> None:
    dark = flat(0.0, dark_current=DarkCurrent(0.5), time_s=30.0)
    n = dark.size
    assert abs(dark.mean() - 15.0) < STATISTICAL * np.sqrt(15.0 / n)
    # Var of a Poisson sample variance: (2λ² + λ)/n.
    assert abs(dark.var() - 15.0) < STATISTICAL * np.sqrt((2 * 15.0**2 + 15.0) / n)


def test_photo_response_works_on_light_and_not_on_dark_current() -> None:
    """The pattern multiplies the light's mean: a dark frame has none of it."""
    stages: dict[str, Any] = {"shot_noise": None, "dark_current": DarkCurrent(1e4), "prnu": Prnu(0.1)}
    assert np.ptp(flat(0.0, **stages)) == 0.0
    assert flat(1e4, **stages).std() == pytest.approx(0.1 * 1e4, rel=0.01)


def test_charge_is_cut_before_it_is_read() -> None:
    """A full photosite still shows the whole read noise, around its capacity and on both sides of it."""
    full = flat(1e6, full_well=FullWell(20_000.0), read_noise=ReadNoise(5.0))
    assert normal_p(full - 20_000.0, 5.0) > PROBABILITY


def test_shot_noise_follows_the_pattern_of_the_response() -> None:
    """Per photosite, variance over mean stays 1 when the response differs: the pattern is first."""
    stack = np.stack([flat(400.0, prnu=Prnu(0.3), seed=seed) for seed in range(12)])
    mean, variance = stack.mean(axis=0), stack.var(axis=0, ddof=1)
    weak, strong = mean < 250.0, mean > 550.0
    for part in (weak, strong):
        ratio = variance[part].mean() / mean[part].mean()
        # Selecting by the mean favours neither, and 12 frames leave √(2/11) a photosite.
        assert abs(ratio - 1.0) < STATISTICAL * np.sqrt(2 / 11 / part.sum()) + 0.01


def test_without_noise_the_mean_stays_and_no_generator_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    def forbidden(*_: object, **__: object) -> None:
        raise AssertionError("a generator was made")

    for name in ("Generator", "Philox", "SeedSequence", "default_rng"):
        monkeypatch.setattr(np.random, name, forbidden)
    every = {
        "prnu": Prnu(0.1),
        "dark_current": DarkCurrent(1e3),
        "full_well": FullWell(500.0),
        "read_noise": ReadNoise(9.0),
        "dsnu": Dsnu(9.0),
    }
    mean = np.linspace(0.0, 1000.0, 200 * 30).reshape(200, 30)
    settings: dict[str, Any] = {"time_s": 1.0, "seed": 1, "serial": 1, "origin": (0, 0), "frame_cols": 30}
    np.testing.assert_array_equal(recorded(mean, noise=False, **every, **settings), np.minimum(mean, 500.0))
    np.testing.assert_array_equal(recorded(mean, shot_noise=None, **settings), mean)


def test_the_mean_that_comes_in_is_left_alone() -> None:
    mean = np.full((70, 50), 100.0)
    mean.setflags(write=False)
    out = recorded(mean, time_s=1.0, seed=1, serial=1, origin=(0, 0), frame_cols=50, noise=False)
    assert not np.shares_memory(out, mean)


@pytest.mark.parametrize("mean_e", [0.0, -1e-7, 1e-12, 1e9, 1e15])
@pytest.mark.parametrize("full_well_e", [None, 1.0, 1e5])
def test_extremes_are_right_or_cut(mean_e: float, full_well_e: float | None) -> None:
    well = None if full_well_e is None else FullWell(full_well_e)
    out = flat(mean_e, full_well=well, read_noise=ReadNoise(0.0), dsnu=Dsnu(0.0), prnu=Prnu(0.0))
    assert np.isfinite(out).all()
    assert out.min() >= 0.0
    if full_well_e is not None:
        assert out.max() <= full_well_e
    elif mean_e == 1e9:
        error = np.sqrt(mean_e / out.size)
        assert abs(out.mean() - mean_e) < STATISTICAL * error
        assert out.std() == pytest.approx(np.sqrt(mean_e), rel=0.01)
    for bits in (1, 16):
        codes = Adc(bit_depth=bits, black_level_dn=0, electrons_per_dn=0.01, base_iso=1.0).quantise(out, iso=1e6)
        assert codes.max() <= 2**bits - 1


def test_a_wild_pattern_never_makes_light_negative() -> None:
    assert flat(100.0, shot_noise=None, prnu=Prnu(1.0)).min() > 0.0


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("noise", [True, False])
def test_a_mean_that_is_no_number_is_an_error(bad: float, noise: bool) -> None:
    with pytest.raises(ValueError, match="not all finite"):
        flat(bad, noise=noise)


@pytest.mark.parametrize(
    ("stage", "value", "message"),
    [
        (Prnu, -0.1, "Prnu.fraction: .* not -0.1"),
        (Prnu, 1.5, "1.5 % is 0.015"),
        (DarkCurrent, -1.0, "DarkCurrent.e_per_s: .* not -1.0"),
        (FullWell, 0.0, "must be a number above 0"),
        (FullWell, float("nan"), "FullWell.capacity_e: .* not nan"),
        (Dsnu, float("inf"), "Dsnu.sigma_e: .* not inf"),
        (ReadNoise, -3.0, "ReadNoise.sigma_e: must be a number of 0 or more, not -3.0"),
    ],
)
def test_an_impossible_stage_is_refused(stage: type, value: float, message: str) -> None:
    with pytest.raises(InvalidValueError, match=message):
        stage(value)


def test_stages_work_alone() -> None:
    here = context((), (1, 1000))
    electrons = FullWell(120.0).apply(ShotNoise().apply(np.full((1, 1000), 100.0), here), here)
    electrons = ReadNoise(2.0).apply(electrons, here)
    assert 95.0 < electrons.mean() < 105.0
