"""Colour filter arrays: the same letters whichever way they are asked for."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from camsim.sensor.cfa import Cfa

X_TRANS = Cfa(("GBGGRG", "RGRBGB", "GBGGRG", "GRGGBG", "BGBRGR", "GRGGBG"))
RGBW = Cfa(("WRWG", "RWGW", "WGWB", "GWBW"))
OBLONG = Cfa(("YCM",))
ALL = [*map(Cfa.bayer, ("RGGB", "BGGR", "GRBG", "GBRG")), Cfa.mono(), X_TRANS, RGBW, OBLONG]
NAMES = ["/".join(cfa.pattern) for cfa in ALL]


def letters(cfa: Cfa, rows: int, cols: int, origin: tuple[int, int]) -> list[str]:
    index = cfa.channel_index(rows, cols, origin)
    return ["".join(cfa.channels[code] for code in row) for row in index]


@pytest.mark.parametrize("cfa", ALL, ids=NAMES)
def test_the_pattern_repeats_over_the_sensor(cfa: Cfa) -> None:
    rows, cols = cfa.period
    assert letters(cfa, rows, cols, (0, 0)) == list(cfa.pattern)
    assert letters(cfa, 2 * rows, 3 * cols, (0, 0)) == [row * 3 for row in cfa.pattern] * 2


@pytest.mark.parametrize("cfa", ALL, ids=NAMES)
def test_a_window_is_that_slice_of_the_sensor(cfa: Cfa) -> None:
    full = cfa.channel_index(20, 23)
    for r, c in itertools.product(range(7), range(7)):
        np.testing.assert_array_equal(cfa.channel_index(9, 11, (r, c)), full[r : r + 9, c : c + 11])
        assert letters(cfa, *cfa.period, (r, c)) == list(cfa.window_pattern((r, c)))


def test_channels_come_in_a_fixed_order() -> None:
    assert Cfa.bayer("GBRG").channels == X_TRANS.channels == ("R", "G", "B")
    assert RGBW.channels == ("R", "G", "B", "W")
    assert OBLONG.channels == ("Y", "C", "M")
    assert Cfa.mono().channels == ("Y",)
