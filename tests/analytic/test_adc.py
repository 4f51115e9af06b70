"""The converter: rounding, clipping, gain and white level by counting."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from camsim.errors import InvalidValueError
from camsim.sensor.adc import Adc


def test_every_code_is_the_nearest_one() -> None:
    """Counted with fractions: a code covers half a step to either side."""
    adc = Adc(bit_depth=8, black_level_dn=10, electrons_per_dn=2.5, base_iso=100.0)
    electrons = np.arange(-60.0, 700.0, 0.125)
    codes = adc.quantise(electrons, iso=100.0)
    for electron, code in zip(electrons.tolist(), codes.tolist(), strict=True):
        exact = Fraction(electron) / Fraction(5, 2) + 10
        if code == 0:
            assert exact <= Fraction(1, 2)
        elif code == 255:
            assert exact >= 255 - Fraction(1, 2)
        else:
            assert abs(exact - code) <= Fraction(1, 2)


@pytest.mark.parametrize("bits", range(1, 17))
def test_codes_are_clipped_and_never_wrap(bits: int) -> None:
    adc = Adc(bit_depth=bits, black_level_dn=0, electrons_per_dn=1.0, base_iso=100.0)
    electrons = np.array([-np.inf, -1e18, -1.0, 0.0, 2.0**bits - 1, 2.0**bits, 65_536.0, 1e18, np.inf])
    codes = adc.quantise(electrons, iso=100.0)
    top = 2**bits - 1
    assert codes.dtype == np.uint16
    assert codes.tolist() == [0, 0, 0, 0, top, top, top, top, top]


def test_nan_is_an_error_and_not_a_code() -> None:
    adc = Adc(bit_depth=12, black_level_dn=0, electrons_per_dn=1.0, base_iso=100.0)
    with pytest.raises(ValueError, match="NaN"):
        adc.quantise(np.array([1.0, np.nan]), iso=100.0)


@pytest.mark.parametrize("shape", [(), (0, 5), (513, 700), (2, 3, 4)])
def test_any_shape_comes_back_in_its_shape(shape: tuple[int, ...]) -> None:
    adc = Adc(bit_depth=12, black_level_dn=5, electrons_per_dn=1.0, base_iso=100.0)
    electrons = np.arange(np.prod(shape), dtype=np.float64).reshape(shape) % 4000
    codes = adc.quantise(electrons, iso=100.0)
    assert codes.shape == shape
    np.testing.assert_array_equal(codes, electrons.astype(np.int64) + 5)


def test_twice_the_iso_is_twice_the_code() -> None:
    adc = Adc(bit_depth=14, black_level_dn=512, electrons_per_dn=4.0, base_iso=200.0)
    signal = np.array([400.0, 4000.0])
    for iso, step in ((100.0, 0.5), (200.0, 1.0), (400.0, 2.0), (3200.0, 16.0)):
        assert (adc.quantise(signal, iso=iso) - 512.0).tolist() == np.minimum(
            step * signal / 4.0, 16_383 - 512
        ).tolist()
        assert adc.electrons_per_dn_at(iso) == 4.0 / step


@pytest.mark.parametrize(
    ("iso", "full_well_e", "white_dn"),
    [
        (200.0, 40_000.0, 4095),  # 4000 DN would not fit above black
        (200.0, 30_000.0, 3128),
        (400.0, 30_000.0, 4095),
        (100.0, 30_000.0, 1628),
        (200.0, None, 4095),
        (200.0, 1.0, 129),  # a tenth of a code: white stays above black
    ],
)
def test_white_is_where_the_signal_clips(iso: float, full_well_e: float | None, white_dn: int) -> None:
    adc = Adc(bit_depth=12, black_level_dn=128, electrons_per_dn=10.0, base_iso=200.0)
    assert adc.white_level_dn(iso, full_well_e) == white_dn
    assert adc.saturation_e(iso, full_well_e) == pytest.approx((white_dn - 128) * 10.0 * 200.0 / iso)
    if full_well_e is not None and full_well_e > 5.0:
        assert adc.quantise(np.array([full_well_e]), iso=iso).tolist() == [white_dn]


def test_black_offsets_lie_on_the_full_frame_whatever_the_window():
    adc = Adc(
        bit_depth=12,
        black_level_dn=100,
        electrons_per_dn=1.0,
        base_iso=100.0,
        black_offsets_dn=((0, 5), (-3, 9), (1, 2)),
    )
    whole = adc.quantise(np.zeros((40, 31)), iso=100.0)
    for row in range(6):
        assert whole[row, :2].tolist() == [[100, 105], [97, 109], [101, 102]][row % 3]
    for origin in ((0, 0), (1, 0), (2, 3), (7, 1)):
        window = adc.quantise(np.zeros((9, 8)), iso=100.0, origin=origin)
        np.testing.assert_array_equal(window, whole[origin[0] : origin[0] + 9, origin[1] : origin[1] + 8])
    # In pieces or at once: large frames are converted piece by piece.
    large = adc.quantise(np.zeros((3001, 700)), iso=100.0)
    np.testing.assert_array_equal(large[:40, :31], whole)
    np.testing.assert_array_equal(large[2700:2740, :31], whole)


@pytest.mark.parametrize(
    ("offsets", "side", "black_dn", "common"),
    [(((100, 130), (120, 100)), "above", 200, 100), (((-7, -3),), "below", 97, -3)],
)
def test_offsets_that_move_black_altogether_are_black_level(offsets, side, black_dn, common):
    """Codes from black to white were counted from where no photosite has black: of 4095 − 228 the 4095 − 128 were told,
    and the truth's DNG was 3 % darker than its mosaic's."""
    how = {"bit_depth": 12, "electrons_per_dn": 1.0, "base_iso": 100.0}
    way_out = f"all lie {side} 0, .* give black_level_dn {black_dn}, and offsets that are less by {common}"
    with pytest.raises(InvalidValueError, match=rf"black_offsets_dn: {way_out}"):
        Adc(black_level_dn=100, black_offsets_dn=offsets, **how)
    less = tuple(tuple(offset - common for offset in row) for row in offsets)
    adc = Adc(black_level_dn=black_dn, black_offsets_dn=less, **how)
    dark = adc.quantise(np.zeros((2, 2)), iso=100.0)
    assert dark.tolist() == (100 + np.resize(offsets, (2, 2))).tolist()
    assert adc.saturation_e(100.0) == 4095 - black_dn


def test_codes_in_steps() -> None:
    """12 bits in 16: every code is a multiple of the step, the nearest one, and rounding has the step's variance."""
    adc = Adc(bit_depth=16, black_level_dn=1600, electrons_per_dn=0.25, base_iso=100.0, code_step_dn=16.0)
    electrons = np.random.default_rng(3).uniform(0.0, 15_000.0, 200_000)
    codes = adc.quantise(electrons, iso=100.0).astype(np.int64)
    off = codes - 1600 - electrons / 0.25
    assert not np.any(codes % 16)
    assert np.abs(off).max() <= 8.0
    assert abs(np.mean(off**2) - 16.0**2 / 12.0) < 4.5 * np.std(off**2) / np.sqrt(off.size)
    assert adc.quantise(np.array([1e9]), iso=100.0)[0] == adc.white_level_dn(100.0) == adc.largest_dn == 65520
    stretched = Adc(bit_depth=16, black_level_dn=0, electrons_per_dn=1.0, base_iso=100.0, code_step_dn=65535.0 / 4095.0)
    assert np.unique(stretched.quantise(np.arange(65536.0), iso=100.0)).size == 4096
    assert stretched.largest_dn == 65535


def test_gains_that_depart_from_the_proportion() -> None:
    adc = Adc(bit_depth=14, black_level_dn=0, electrons_per_dn=4.0, base_iso=100.0, gain_at_iso=[(400.0, 1.1)])
    assert [adc.quantise(np.array([2200.0]), iso=iso)[0] for iso in (100.0, 400.0, 800.0)] == [550, 2000, 4000]
