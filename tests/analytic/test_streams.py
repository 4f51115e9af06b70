"""Random streams: the same bytes whatever the threads, the window or the other stages."""

from __future__ import annotations

import tracemalloc
from typing import Any

import numpy as np
import pytest
from electronics import EVERY as EXAMPLES
from electronics import context, recorded
from tolerances import STATISTICAL

from camsim import ColumnNoise, DarkCurrent, Dsnu, FullWell, Prnu, ReadNoise, ShotNoise
from camsim.errors import InvalidValueError
from camsim.sensor.stage import streams_of
from camsim.sensor.stages.column_noise import column_normals
from camsim.sensor.streams import fixed_normals, generator

EVERY: dict[str, Any] = {
    "prnu": Prnu(0.01),
    "dark_current": DarkCurrent(5.0),
    "full_well": FullWell(1e4),
    "read_noise": ReadNoise(4.0),
    "dsnu": Dsnu(1.5),
}
STREAMS = [stream for stage in EXAMPLES.values() for stream in streams_of(stage)]
OFF: dict[str, Any] = {"shot_noise": None}
PLACE: dict[str, Any] = {"time_s": 0.5, "seed": 7, "serial": 3, "origin": (0, 0), "frame_cols": 90}


def ramp(rows: int, cols: int) -> Any:
    return np.linspace(0.0, 12_000.0, rows * cols).reshape(rows, cols)


def test_the_streams_are_the_documented_ones() -> None:
    """Files promise the same bytes in later versions: Philox(SeedSequence([seed, stage, frame, block]))."""
    electrons = recorded(np.zeros((130, 90)), read_noise=ReadNoise(2.0), **PLACE, **OFF)
    for block, rows in enumerate((64, 64, 2)):
        rng = np.random.Generator(np.random.Philox(np.random.SeedSequence([7, 3, 0, block])))
        expected = 2.0 * rng.standard_normal((rows, 90), dtype=np.float32).astype(np.float64)
        np.testing.assert_array_equal(electrons[64 * block : 64 * block + rows], expected)


def test_the_stages_of_a_chain_act_in_their_order_each_on_its_own_draws() -> None:
    """Pattern of the light, dark charge, photons, well, read-out: put together again from each one's own numbers."""
    nothing, mean = np.zeros((130, 90)), ramp(130, 90)
    read = recorded(nothing, read_noise=EVERY["read_noise"], **PLACE, **OFF)
    dsnu = recorded(nothing, dsnu=EVERY["dsnu"], **PLACE, **OFF)
    normals = fixed_normals(3, Prnu.stream, rows=130, cols=90, origin=(0, 0), frame_cols=90)
    charge = mean * (1.0 + 0.01 * normals.astype(np.float64)) + 2.5
    counts = [
        ShotNoise().apply(charge[first : first + 64], context((), charge.shape, rows_before=first))
        for first in (0, 64, 128)
    ]
    expected = np.minimum(np.vstack(counts), 1e4) + read + dsnu
    np.testing.assert_array_equal(recorded(mean, **EVERY, **PLACE), expected)


def test_streams_are_independent_of_one_another() -> None:
    """Correlation of every pair of stages, seeds, frames and blocks is that of strangers."""
    keys = [
        *((seed, stream, 0, 0) for seed in (0, 1, 2**32) for stream in STREAMS),
        (1, ReadNoise.stream[0], 0, 1),
        (1, ReadNoise.stream[0], 1, 0),
    ]
    draws = [
        generator(seed, stream, frame_number=frame, block=block).standard_normal(50_000)
        for seed, stream, frame, block in keys
    ]
    # A thousand pairs: 4.5 σ is passed by chance once in 150.
    assert np.abs(np.corrcoef(draws) - np.eye(len(draws))).max() < 4.5 / np.sqrt(50_000)


@pytest.mark.parametrize("seed", [-1, 2**63])
def test_a_seed_that_no_file_can_hold_is_refused(seed: int) -> None:
    with pytest.raises(InvalidValueError, match="must be a whole number from 0"):
        generator(seed, ShotNoise.stream, block=0)


def test_columns_have_the_numbers_that_the_page_says() -> None:
    """Philox(SeedSequence([serial, stage, frame number, block])), the first of them; a window has its part."""
    whole = np.random.Generator(np.random.Philox(np.random.SeedSequence([17, 8, 0, 0]))).standard_normal(
        300, dtype=np.float32
    )
    np.testing.assert_array_equal(column_normals(17, 300), whole)
    window = recorded(np.zeros((2, 9)), column_noise=ColumnNoise(1.0), serial=17, origin=(0, 40), frame_cols=300, **OFF)
    np.testing.assert_array_equal(window[1], whole[40:49].astype(np.float64))


def test_rows_columns_and_blocks_know_nothing_of_one_another() -> None:
    """Photon and read noise beside one another, below one another, and on both sides of a block's border."""
    out = recorded(np.full((256, 90), 100.0), read_noise=ReadNoise(5.0), **PLACE)
    noise = (out - out.mean()) / out.std()
    for one, other in (
        (noise[:, 1:], noise[:, :-1]),
        (noise[1:], noise[:-1]),
        (noise[64:128], noise[:64]),
        (noise[:, 45:], noise[:, :45]),
    ):
        assert abs(np.mean(one * other)) < 4.0 / np.sqrt(one.size)
    at_borders = np.mean(noise[64::64] * noise[63:-1:64])
    assert abs(at_borders) < 4.0 / np.sqrt(3 * 90)
    for axis, count in ((0, 90), (1, 256)):
        means = noise.mean(axis=axis)
        # As many independent means as there are lines: their variance is a χ².
        assert abs(np.var(means) * noise.size / count - 1.0) < STATISTICAL * np.sqrt(2.0 / count)


def test_a_windows_fixed_pattern_takes_no_memory_for_the_frames_width() -> None:
    """A record that says 2³¹ columns asked for half a terabyte, whatever the window."""
    tracemalloc.start()
    try:
        normals = fixed_normals(3, Prnu.stream, rows=2, cols=4, origin=(1, 3_000_000), frame_cols=6_000_000)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    of_frame = generator(3, Prnu.stream, block=0).standard_normal((3, 6_000_000), dtype=np.float32)
    np.testing.assert_array_equal(normals, of_frame[1:, 3_000_000:3_000_004])
    assert peak < 4e6, peak
