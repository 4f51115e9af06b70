"""Stages of the sensor beyond the basic ones: each against sums done by hand, another route, or its statistics."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy.signal
import scipy.stats
from electronics import EVERY as EXAMPLES
from electronics import KERNEL, LAWS, recorded
from tolerances import PROBABILITY, STATISTICAL

import camsim
from camsim import (
    Blooming,
    ColumnNoise,
    Cos4Falloff,
    Crosstalk,
    DarkCurrent,
    Defects,
    Dsnu,
    FlickerRows,
    FullWell,
    PolynomialResponse,
    Prnu,
    RadialFalloff,
    ReadNoise,
    ResetNoise,
    ResponseTable,
    RowNoise,
    TelegraphNoise,
)
from camsim.sensor.cfa import Cfa
from camsim.sensor.chain import mixed
from camsim.sensor.falloff import falloff_at

SIGMA = 4.0
PLACE: dict[str, Any] = {"time_s": 2.0, "seed": 7, "serial": 3, "origin": (0, 0), "frame_cols": 300}
QUIET: dict[str, Any] = {**PLACE, "shot_noise": None}


def ramp(rows: int, cols: int) -> Any:
    return np.random.default_rng(1).uniform(0.0, 2000.0, (rows, cols))


@pytest.mark.parametrize(
    ("noise", "law"),
    [
        (ReadNoise(3.0, student_dof=2.5), scipy.stats.t(2.5)),
        (ReadNoise(3.0, tukey_lambda=-0.3), scipy.stats.tukeylambda(-0.3)),
        (ReadNoise(3.0, tukey_lambda=1e-7), scipy.stats.logistic()),
        (ReadNoise(3.0, tukey_lambda=0.1), scipy.stats.tukeylambda(0.1)),
    ],
)
def test_read_noise_has_its_law_and_its_standard_deviation(noise: ReadNoise, law: Any) -> None:
    out = recorded(np.zeros((400, 300)), read_noise=noise, **QUIET)
    assert scipy.stats.kstest(out.ravel() * float(law.std()) / 3.0, law.cdf).pvalue > PROBABILITY


def test_uneven_read_noise_is_a_pattern_of_the_sensor() -> None:
    """Frames in a row show each photosite's own standard deviation, log-normal around the same mean variance."""
    frames = np.stack([
        recorded(np.zeros((100, 150)), read_noise=ReadNoise(3.0, spread=0.4), **{**QUIET, "frame_number": k})
        for k in range(150)
    ])  # fmt: skip
    each = frames.var(axis=0, ddof=1)
    normal = 2.0 / (len(frames) - 1)
    assert np.mean(each) == pytest.approx(9.0, rel=0.02)
    # A logarithm of a variance has 2/(n − 1) of its own; half of it is that of a standard deviation.
    assert 0.5 * np.sqrt(np.log(each).var() - normal) == pytest.approx(0.4, rel=0.02)


def test_telegraph_noise_jumps_between_two_values() -> None:
    """Of a share of the photosites; their distances are exponential, and each is as often up as down."""
    noise = TelegraphNoise(fraction=0.05, amplitude_e=20.0)
    frames = np.stack(
        [recorded(np.zeros((200, 300)), telegraph_noise=noise, **{**QUIET, "frame_number": k}) for k in range(40)]
    )
    jumping = np.ptp(frames, axis=0) > 0.0
    share = jumping.mean()
    assert abs(share - 0.05) < STATISTICAL * np.sqrt(0.05 * 0.95 / jumping.size)
    each = frames[:, jumping]
    distance = np.ptp(each, axis=0)
    np.testing.assert_allclose(np.abs(each), np.broadcast_to(0.5 * distance, each.shape))
    assert scipy.stats.kstest(distance, scipy.stats.expon(scale=20.0).cdf).pvalue > PROBABILITY
    assert abs((each > 0.0).mean() - 0.5) < STATISTICAL * 0.5 / np.sqrt(each.size)


@pytest.mark.parametrize("rows", [1, 63, 64, 65, 200])
def test_crosstalk_is_a_convolution_across_blocks(rows: int) -> None:
    wide = ramp(rows + 2, 42)
    expected = scipy.signal.convolve2d(wide, np.array(KERNEL), mode="valid")
    np.testing.assert_allclose(recorded(wide, crosstalk=Crosstalk(KERNEL), **QUIET), expected, rtol=1e-13)
    np.testing.assert_allclose(mixed(wide, Crosstalk(KERNEL)), expected, rtol=1e-13)


def test_crosstalk_mixes_what_the_pattern_has_made_of_the_light() -> None:
    """PRNU first: its contrast is softened by the kernel, √Σk² on independent gains."""
    out = recorded(np.full((402, 302), 1e6), prnu=Prnu(0.01), crosstalk=Crosstalk(KERNEL), **QUIET)
    softened = 0.01 * 1e6 * np.sqrt(np.sum(np.square(KERNEL)))
    assert out[:, 1:-1].std() == pytest.approx(softened, rel=0.02)
    dark = recorded(
        np.zeros((402, 302)), crosstalk=Crosstalk(KERNEL), dark_current=DarkCurrent(50.0, nonuniformity=0.2), **QUIET
    )
    assert dark.std() == pytest.approx(0.2 * 100.0, rel=0.02)


@pytest.mark.parametrize("origin", [(0, 0), (64, 100)])
def test_a_window_with_crosstalk_is_that_slice_of_the_frame(origin: tuple[int, int]) -> None:
    """The neighbours' pattern counts too, whether they lie in the window or not."""
    stages: dict[str, Any] = {
        "prnu": Prnu(0.02),
        "crosstalk": Crosstalk(KERNEL),
        "dark_current": DarkCurrent(30.0, nonuniformity=0.3),
        "defects": Defects(
            hot_fraction=0.01, hot_e_per_s=100.0, dead_fraction=0.01, hot=((70, 105, 5e3),), dead=((6, 9),)
        ),
        "column_noise": ColumnNoise(5.0),
        "dsnu": Dsnu(2.0),
    }
    wide = ramp(202, 302)
    full = recorded(wide, **stages, **QUIET)
    r, c = origin
    window = recorded(wide[r : r + 42, c : c + 32], **stages, **(QUIET | {"origin": origin}))
    np.testing.assert_allclose(window, full[r : r + 40, c : c + 30], rtol=1e-13)


def test_dark_current_doubles_with_warmth() -> None:
    current = DarkCurrent(3.0, at_c=20.0, doubling_c=6.0)
    nothing = np.zeros((4, 4))
    for temperature_c, factor in ((20.0, 1.0), (26.0, 2.0), (14.0, 0.5), (80.0, 1024.0), (-40.0, 1 / 1024)):
        warm = recorded(nothing, dark_current=current, temperature_c=temperature_c, **QUIET)
        np.testing.assert_allclose(warm, 6.0 * factor, rtol=1e-12)


def test_hot_and_dead_photosites() -> None:
    defects = Defects(hot_fraction=0.02, hot_e_per_s=500.0, dead_fraction=0.01, hot=((3, 4, 1e4),), dead=((7, 8),))
    light = np.full((400, 300), 100.0)
    out = recorded(light, defects=defects, **QUIET)
    n = light.size
    hot, dead = out > 100.0, out < 100.0
    assert abs(np.count_nonzero(hot) - 0.02 * n) < SIGMA * np.sqrt(0.02 * n) + 1
    assert abs(np.count_nonzero(dead) - 0.01 * n) < SIGMA * np.sqrt(0.01 * n) + 1
    assert out[3, 4] == 2.0 * 1e4 + 100.0
    assert out[7, 8] == 0.0
    drawn = np.delete((out[hot] - 100.0) / 2.0, np.flatnonzero(out[hot] == out[3, 4]))
    assert scipy.stats.kstest(drawn, "expon", args=(0.0, 500.0)).pvalue > PROBABILITY
    # They are the sensor's: the same in every frame, hotter when it is warm.
    again = recorded(light, defects=defects, dark_current=DarkCurrent(0.0), temperature_c=32.0, **(QUIET | {"seed": 8}))
    np.testing.assert_allclose(again[hot] - 100.0, 2.0 * (out[hot] - 100.0), rtol=1e-12)
    # Where none is hot there are none that could not be dead.
    assert not recorded(light, defects=Defects(dead_fraction=1.0), **QUIET).any()


def bloomed_one_by_one(electrons: Any, capacity_e: float, spill: float) -> Any:
    """Every photosite's excess walks its own way, half up and half down, and fills what it finds."""
    held = np.minimum(electrons, capacity_e)
    for step in (1, -1):
        order = range(len(held)) if step == 1 else range(len(held) - 1, -1, -1)
        for row in order:
            for col in range(held.shape[1]):
                excess = 0.5 * spill * max(0.0, electrons[row, col] - capacity_e)
                place = row + step
                while excess > 0.0 and 0 <= place < len(held):
                    taken = min(excess, capacity_e - held[place, col])
                    held[place, col] += taken
                    excess -= taken
                    place += step
    return held


@pytest.mark.parametrize("spill", [0.3, 1.0])
def test_blooming_against_one_walk_after_another(spill: float) -> None:
    electrons = np.random.default_rng(5).uniform(0.0, 130.0, (40, 6))
    electrons[12, 3] = 900.0
    held = Blooming(spill).spilt(electrons, capacity_e=100.0)
    # The amount in each column is the same whoever walks first.
    expected = bloomed_one_by_one(electrons, 100.0, spill)
    np.testing.assert_allclose(held.sum(axis=0), expected.sum(axis=0), rtol=1e-12)
    np.testing.assert_allclose(held, expected, atol=1e-9)
    assert held.max() <= 100.0


def test_noise_comes_after_the_bent_response() -> None:
    """A response with slope ½ halves what is in the well; the noise of the read-out stays whole."""
    bent = ResponseTable((0.0, 1000.0), (0.0, 500.0))
    out = recorded(np.full((400, 300), 1000.0), nonlinearity=bent, read_noise=ReadNoise(6.0), **QUIET)
    assert out.mean() == pytest.approx(500.0, abs=SIGMA * 6.0 / np.sqrt(out.size))
    assert out.std() == pytest.approx(6.0, rel=SIGMA / np.sqrt(2 * out.size))


def test_a_table_goes_on_straight_beyond_both_ends() -> None:
    """By hand: 0.45 electrons an electron up to (200, 90), 0.5 from there on."""
    table = ResponseTable((0.0, 200.0, 1200.0), (0.0, 90.0, 590.0))
    np.testing.assert_allclose(table.response(np.array([-2.0, 150.0, 700.0, 2200.0])), [-0.9, 67.5, 340.0, 1090.0])


def test_full_wells_are_bent_too() -> None:
    polynomial = PolynomialResponse((-0.1,), 1000.0)
    out = recorded(np.full((4, 4), 5e3), nonlinearity=polynomial, full_well=FullWell(1000.0), noise=False, **PLACE)
    np.testing.assert_allclose(out, 900.0, rtol=1e-12)


def test_reset_noise_of_a_capacitor() -> None:
    """By equipartition: ½CV² = ½kT, so the charge's variance is kTC. 1 pF at 300 K: 402 e⁻ (Janesick)."""
    assert ResetNoise.of_capacitance(1000.0, 26.85).sigma_e == pytest.approx(402.0, abs=0.5)


def test_rows_have_offsets_of_their_own_that_last_one_frame() -> None:
    first, second = (recorded(np.zeros((400, 300)), row_noise=RowNoise(3.0), frame_number=n, **QUIET) for n in (0, 1))
    assert np.ptp(first, axis=1).max() == 0.0
    assert first[:, 0].std() == pytest.approx(3.0, rel=SIGMA / np.sqrt(800))
    assert abs(np.corrcoef(first[:, 0], second[:, 0])[0, 1]) < SIGMA / np.sqrt(400)
    # Neighbours know nothing of one another.
    assert abs(np.corrcoef(first[:-1, 0], first[1:, 0])[0, 1]) < SIGMA / np.sqrt(400)


@pytest.mark.parametrize("exponent", [0.0, 1.0, 2.0])
def test_flicker_rows_have_their_spectrum(exponent: float) -> None:
    """Averaged over many frames: the variance asked for, and power that falls as 1/f^exponent."""
    stage = FlickerRows(2.0, exponent)
    rng = np.random.default_rng(4)
    frames = np.stack([stage.offsets_e(512, rng) for _ in range(400)])
    assert np.mean(frames**2) == pytest.approx(4.0, rel=0.15)
    frequency, power = scipy.signal.welch(frames, nperseg=256, axis=1, detrend=False)
    middle = (frequency > 0.02) & (frequency < 0.4)
    slope = np.polyfit(np.log(frequency[middle]), np.log(power.mean(axis=0)[middle]), 1)[0]
    assert slope == pytest.approx(-exponent, abs=0.1)


def test_a_row_alone_flickers_too() -> None:
    """A window of one row, or two, has the noise that a frame's rows have."""
    for rows in (1, 2):
        frames = np.stack([FlickerRows(2.0).offsets_e(rows, np.random.default_rng(k)) for k in range(4000)])
        assert np.mean(frames**2) == pytest.approx(4.0, rel=SIGMA * np.sqrt(2 / 4000))


def test_the_dark_noise_of_all_is_what_dark_frames_have() -> None:
    """The spread of many dark rows is the figure that files carry (of each stage alone: its law)."""
    stages = {
        law.stage.name: EXAMPLES[law.stage.name] for law in LAWS.values() if law.adds and law.stage.name in EXAMPLES
    }
    camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=8.0)).replace(**stages)
    gain = {"electrons_per_dn": camera.adc.electrons_per_dn / 2.0}
    dark = [recorded(np.zeros((4000, 4)), **stages, **gain, frame_number=n, **QUIET) for n in (0, 1)]
    spread_e = float((dark[0] - dark[1]).std()) / np.sqrt(2.0)  # what stays from frame to frame is no noise
    assert camera.dark_noise_e(2.0 * camera.adc.base_iso) == pytest.approx(spread_e, rel=SIGMA / np.sqrt(2 * 4000))


EVERY: dict[str, Any] = EXAMPLES | {
    "full_well": FullWell(1500.0),
    "blooming": Blooming(0.5),
    "nonlinearity": PolynomialResponse((-0.02,), 1500.0),
}


def test_threads_change_no_byte_of_the_whole_chain() -> None:
    wide = ramp(302, 302)
    one, two = (recorded(wide, **EVERY, **PLACE, threads=n).tobytes() for n in (1, 2))
    assert one == two


def test_with_everything_there_and_noise_off_no_generator_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    def forbidden(*_: object, **__: object) -> None:
        raise AssertionError("a generator was made")

    for name in ("Generator", "Philox", "SeedSequence", "default_rng"):
        monkeypatch.setattr(np.random, name, forbidden)
    wide = np.linspace(0.0, 1000.0, 102 * 32).reshape(102, 32)
    out = recorded(wide, noise=False, **EVERY, **PLACE)
    mean = scipy.signal.convolve2d(wide, np.array(KERNEL), mode="valid")
    np.testing.assert_allclose(out, mean * (1.0 - 0.02 * mean / 1500.0), rtol=1e-12)


def test_cosine_to_the_fourth() -> None:
    """A full frame's corner 21.6 mm from the axis, seen from 50 mm: cos⁴(23.4°) = 0.71."""
    corner = Cos4Falloff(exit_pupil_mm=50.0).relative(np.array([21.633]))
    assert corner[0] == pytest.approx(np.cos(np.arctan(21.633 / 50.0)) ** 4, rel=1e-12)
    field = falloff_at(Cos4Falloff(exit_pupil_mm=1.0), shape=(3, 5), first_centre=(-2.0, -1.0), pitch_um=100.0)
    np.testing.assert_allclose(field, field[::-1, ::-1], rtol=1e-15)
    assert field[1, 2] == 1.0
    assert field[0, 0] == pytest.approx((1.0 + 0.05) ** -2, rel=1e-12)


def test_a_measured_falloff_is_held_beyond_its_table() -> None:
    falloff = RadialFalloff(radius_mm=(0.0, 10.0), values=(1.0, 0.4))
    np.testing.assert_allclose(falloff.relative(np.array([0.0, 5.0, 20.0])), [1.0, 0.7, 0.4], rtol=1e-15)


@pytest.mark.parametrize("cfa", [Cfa.named("mono"), Cfa.bayer("GRBG"), Cfa.named("x-trans")])
@pytest.mark.parametrize("kernel", [KERNEL, ((0.1, 0, 0), (0, 0.5, 0.3), (0, 0, 0))])
def test_crosstalk_averages_gains(cfa: Cfa, kernel: tuple[tuple[float, ...], ...]) -> None:
    """Photosite by photosite: what random gains add to flat light, of which neighbours have more or less."""
    rows, sigma = 302, 0.05
    each_e = np.array([200.0, 1000.0, 500.0])[: len(cfa.channels)]
    level = each_e[cfa.channel_index(rows, rows, (-1, -1))]
    gains = np.random.default_rng(5).normal(0.0, sigma, level.shape)
    mixes, index = Crosstalk(kernel), cfa.channel_index(rows - 2, rows - 2, (0, 0))
    mean, off = mixes.spread(level), mixes.spread(level * gains)
    for channel, left in enumerate(mixes.left_of_pattern(cfa, each_e)):
        here = index == channel
        found = np.sqrt(np.mean(off[here] ** 2)) / mean[here].mean() / sigma
        assert found == pytest.approx(left, rel=STATISTICAL * 2.2 * np.sqrt(0.5 / np.count_nonzero(here)))
