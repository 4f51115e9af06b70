"""Laws of every electronic stage; a new stage gets all of them by a line in the list."""

import copy
import dataclasses

import numpy as np
import pytest
from tolerances import STATISTICAL

import camsim

TIME_S = 0.25
ADC = camsim.Adc(bit_depth=12, black_level_dn=100, electrons_per_dn=4.0, base_iso=100.0)


def with_normals(stage, electrons, rng):
    return stage.apply(electrons, normals=rng.standard_normal(electrons.shape, dtype=np.float32))


def with_generator(stage, electrons, rng):
    return stage.apply(electrons, rng=rng)


def with_time(stage, electrons, rng):
    return stage.apply(electrons, time_s=TIME_S)


def with_column_normals(stage, electrons, rng):
    # A column's offset, once for each photosite: the laws below count them as independent.
    return stage.apply(electrons, normals=rng.standard_normal(electrons.shape, dtype=np.float32))


def with_step(stage, electrons, rng):
    return stage.apply(electrons, electrons_per_dn=4.0, rng=rng)


def with_capacity(stage, electrons, rng):
    return stage.apply(electrons, capacity_e=900.0)


def alone(stage, electrons, rng):
    return stage.apply(electrons)


# name: stage, how it is applied, the same stage doing nothing, mean after it, variance added (m: mean before)
ELECTRONIC_STAGES = {
    "PRNU": (camsim.Prnu(0.02), with_normals, camsim.Prnu(0.0), lambda m: m, lambda m: (0.02 * m) ** 2),
    "dark current": (
        camsim.DarkCurrent(60.0),
        with_time,
        camsim.DarkCurrent(0.0),
        lambda m: m + 15.0,
        lambda m: 0.0,
    ),
    "shot noise": (camsim.ShotNoise(), with_generator, None, lambda m: m, lambda m: m),
    "full well": (
        camsim.FullWell(900.0),
        alone,
        camsim.FullWell(1e300),
        lambda m: min(m, 900.0),
        lambda m: 0.0,
    ),
    "read noise": (
        camsim.ReadNoise(3.5),
        with_generator,
        camsim.ReadNoise(0.0),
        lambda m: m,
        lambda m: 3.5**2,
    ),
    "blooming": (
        camsim.Blooming(0.0),
        with_capacity,
        None,
        lambda m: min(m, 900.0),
        lambda m: 0.0,
    ),
    "polynomial response": (
        camsim.PolynomialResponse((-0.05, 0.01), 5000.0),
        alone,
        camsim.PolynomialResponse((0.0,), 5000.0),
        lambda m: m * (1 - 0.05 * m / 5000.0 + 0.01 * (m / 5000.0) ** 2),
        lambda m: 0.0,
    ),
    "response table": (
        camsim.ResponseTable((0.0, 5000.0), (0.0, 4500.0)),
        alone,
        camsim.ResponseTable((0.0, 1.0), (0.0, 1.0)),
        lambda m: 0.9 * m,
        lambda m: 0.0,
    ),
    "reset noise": (camsim.ResetNoise(16.0), with_generator, camsim.ResetNoise(0.0), lambda m: m, lambda m: 16.0**2),
    "column noise": (
        camsim.ColumnNoise(2.0),
        with_column_normals,
        camsim.ColumnNoise(0.0),
        lambda m: m,
        lambda m: 2.0**2,
    ),
    "DSNU": (camsim.Dsnu(1.5), with_normals, camsim.Dsnu(0.0), lambda m: m, lambda m: 1.5**2),
    "output noise": (camsim.OutputNoise(0.7), with_step, camsim.OutputNoise(0.0), lambda m: m, lambda m: 2.8**2),
}
SHAPES = [(1, 1), (1, 7), (9, 1), (12, 17)]


@pytest.fixture(params=ELECTRONIC_STAGES.values(), ids=ELECTRONIC_STAGES)
def law(request):
    return request.param


def applied(law, electrons, seed=3):
    stage, apply, *_ = law
    return apply(stage, electrons, np.random.default_rng(seed))


@pytest.mark.parametrize("shape", SHAPES)
def test_shape_and_type_stay(law, shape, rng):
    out = applied(law, rng.uniform(0, 2000, shape))
    assert out.shape == shape
    assert out.dtype == np.float64
    assert np.isfinite(out).all()


def test_the_input_is_not_touched(law, rng):
    electrons = rng.uniform(0, 2000, (20, 30))
    before = electrons.copy()
    out = applied(law, electrons)
    out[:] = -1.0
    np.testing.assert_array_equal(electrons, before)


def test_the_generator_decides(law, rng):
    electrons = rng.uniform(100, 800, (20, 30))
    np.testing.assert_array_equal(applied(law, electrons), applied(law, electrons))
    random = law[1] in (with_normals, with_generator, with_column_normals, with_step)
    assert np.array_equal(applied(law, electrons, 3), applied(law, electrons, 4)) != random


def test_mean_and_variance(law):
    """Over n photosites the mean is off by σ/√n, the variance by σ²·√((2 + 1/m)/n) at most (Poisson's)."""
    *_, mean_after, variance_added = law
    n = 40_000
    for mean_e in (40.0, 700.0, 5000.0):
        out = applied(law, np.full((200, 200), mean_e))
        variance = variance_added(mean_e)
        assert abs(out.mean() - mean_after(mean_e)) <= STATISTICAL * np.sqrt(variance / n) + 1e-9
        assert abs(out.var() - variance) <= STATISTICAL * variance * np.sqrt((2 + 1 / mean_e) / n) + 1e-9


def test_more_light_never_gives_less(law):
    """For the same draws; a Poisson count is drawn anew at each mean: there the mean of many rises."""
    level = np.linspace(0.0, 2000.0, 41)
    steps = np.stack([applied(law, np.full((30, 30), mean_e)) for mean_e in level])
    if isinstance(law[0], camsim.ShotNoise):
        steps = steps.mean(axis=(1, 2))
    assert np.diff(steps, axis=0).min() >= 0.0


def test_a_stage_of_no_strength_does_nothing(law, rng):
    _, apply, idle, *_ = law
    electrons = rng.uniform(0, 2000, (20, 30))
    if idle is not None:
        np.testing.assert_allclose(apply(idle, electrons, rng), electrons, rtol=1e-15)
    # There is no weak shot noise; but no charge makes none.
    assert (applied(law, np.zeros((5, 5))) >= 0.0).all() or law[3](0.0) == 0.0


def test_frozen_and_equal_by_value(law):
    stage = law[0]
    assert copy.deepcopy(stage) == stage
    assert hash(copy.deepcopy(stage)) == hash(stage)
    for field in dataclasses.fields(stage):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(stage, field.name, 1.0)


@pytest.mark.parametrize("bit_depth", [1, 8, 12, 14, 16])
@pytest.mark.parametrize("iso", [100.0, 250.0, 6400.0])
def test_adc_gives_back_the_charge_to_half_a_step(bit_depth, iso, rng):
    adc = dataclasses.replace(ADC, bit_depth=bit_depth, black_level_dn=(1 << bit_depth) // 5)
    step_e = 4.0 * 100.0 / iso
    top_e = (adc.largest_dn - adc.black_level_dn) * step_e
    electrons = rng.uniform(-adc.black_level_dn * step_e, top_e, (50, 60))
    codes = adc.quantise(electrons, iso=iso)
    assert codes.dtype == np.uint16
    assert codes.shape == electrons.shape
    back_e = (codes.astype(float) - adc.black_level_dn) * step_e
    assert np.abs(back_e - electrons).max() <= 0.5 * step_e * (1 + 1e-12)
    # And every code comes back as itself.
    every = np.arange(adc.largest_dn + 1.0)
    np.testing.assert_array_equal(adc.quantise((every - adc.black_level_dn) * step_e, iso=iso), every)


def test_adc_is_monotone_and_clips(rng):
    electrons = np.sort(rng.normal(8000.0, 9000.0, 5000))
    before = electrons.copy()
    codes = ADC.quantise(electrons, iso=100.0)
    assert np.diff(codes.astype(int)).min() >= 0
    assert (codes[0], codes[-1]) == (0, 4095)
    np.testing.assert_array_equal(electrons, before)
    # White is the first code that a full well of whole steps can reach.
    assert ADC.white_level_dn(100.0, full_well_e=8000.0) == ADC.quantise(np.array([8000.0]), iso=100.0)[0]
    assert ADC.white_level_dn(100.0, full_well_e=1e9) == ADC.quantise(np.array([1e9]), iso=100.0)[0]
