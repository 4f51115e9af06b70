"""Random streams: the same bytes whatever the threads, the window or the other stages."""

from __future__ import annotations

import itertools
import tracemalloc
from typing import Any

import numpy as np
import pytest
from electronics import EVERY as EXAMPLES
from electronics import context, recorded
from tolerances import STATISTICAL

from camsim import ColumnNoise, DarkCurrent, Dsnu, FullWell, Prnu, ReadNoise, ShotNoise
from camsim.core.errors import InvalidValueError
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


@pytest.mark.parametrize("rows", [1, 63, 64, 65, 300])
def test_threads_change_no_byte(rows: int) -> None:
    mean = ramp(rows, 90)
    one, two, five = (recorded(mean, threads=n, **EVERY, **PLACE).tobytes() for n in (1, 2, 5))
    assert one == two == five


def test_twice_the_same_and_another_seed_differs() -> None:
    mean = ramp(130, 90)
    again = [recorded(mean, **EVERY, **PLACE) for _ in range(2)]
    assert again[0].tobytes() == again[1].tobytes()
    for change in ({"seed": 8}, {"serial": 4}, {"frame_number": 1}):
        assert (recorded(mean, **EVERY, **(PLACE | change)) != again[0]).mean() > 0.9


def test_the_streams_are_the_documented_ones() -> None:
    """Files promise the same bytes in later versions: Philox(SeedSequence([seed, stage, frame, block]))."""
    electrons = recorded(np.zeros((130, 90)), read_noise=ReadNoise(2.0), **PLACE, **OFF)
    for block, rows in enumerate((64, 64, 2)):
        rng = np.random.Generator(np.random.Philox(np.random.SeedSequence([7, 3, 0, block])))
        expected = 2.0 * rng.standard_normal((rows, 90), dtype=np.float32).astype(np.float64)
        np.testing.assert_array_equal(electrons[64 * block : 64 * block + rows], expected)


@pytest.mark.parametrize("origin", [(0, 0), (1, 3), (63, 0), (64, 20), (100, 55), (199, 89)])
@pytest.mark.parametrize("stage", [{"prnu": Prnu(0.02)}, {"dsnu": Dsnu(3.0)}])
def test_a_windows_fixed_pattern_is_that_slice_of_the_frame(stage: dict[str, Any], origin: tuple[int, int]) -> None:
    full = recorded(np.full((200, 90), 100.0), **stage, **PLACE, **OFF)
    rows, cols = min(70, 200 - origin[0]), min(33, 90 - origin[1])
    window = recorded(np.full((rows, cols), 100.0), **stage, **OFF, **(PLACE | {"origin": origin}))
    assert full.std() > 0.0
    np.testing.assert_array_equal(window, full[origin[0] : origin[0] + rows, origin[1] : origin[1] + cols])


def test_fixed_patterns_stay_from_frame_to_frame() -> None:
    first, second = (
        recorded(np.full((80, 90), 100.0), prnu=EVERY["prnu"], dsnu=EVERY["dsnu"], frame_number=n, **PLACE, **OFF)
        for n in (0, 1)
    )
    np.testing.assert_array_equal(first, second)


def test_switching_a_stage_off_leaves_every_other_draw() -> None:
    """On a mean of nothing the additive stages can be told apart exactly, one by one."""
    nothing = np.zeros((130, 90))
    read = recorded(nothing, read_noise=EVERY["read_noise"], **PLACE, **OFF)
    dsnu = recorded(nothing, dsnu=EVERY["dsnu"], **PLACE, **OFF)
    both = recorded(nothing, read_noise=EVERY["read_noise"], dsnu=EVERY["dsnu"], **PLACE, **OFF)
    np.testing.assert_array_equal(both, read + dsnu)

    mean = ramp(130, 90)
    shot = recorded(mean, **PLACE)
    assert recorded(mean, full_well=FullWell(1e9), **PLACE).tobytes() == shot.tobytes()
    # 4 electrons of read noise on a whole number of electrons: what is taken off comes out whole again.
    with_read = recorded(mean, read_noise=EVERY["read_noise"], **PLACE)
    np.testing.assert_array_equal(np.rint(with_read - read), shot)

    for left_out in EVERY:
        others = {name: stage for name, stage in EVERY.items() if name != left_out}
        without = recorded(mean, **others, **PLACE)
        rebuilt = mean
        if "prnu" in others:
            normals = fixed_normals(3, Prnu.stream, rows=130, cols=90, origin=(0, 0), frame_cols=90)
            rebuilt = rebuilt * (1.0 + 0.01 * normals.astype(np.float64))
        if "dark_current" in others:
            rebuilt = rebuilt + 2.5
        rebuilt = np.vstack(
            [
                ShotNoise().apply(part, context((), rebuilt.shape, rows_before=64 * block))
                for block, part in enumerate((rebuilt[:64], rebuilt[64:128], rebuilt[128:]))
            ]
        )
        if "full_well" in others:
            rebuilt = np.minimum(rebuilt, 1e4)
        if "read_noise" in others:
            rebuilt = rebuilt + read
        if "dsnu" in others:
            rebuilt = rebuilt + dsnu
        np.testing.assert_array_equal(without, rebuilt)


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
    for a, b in itertools.combinations(draws, 2):
        assert abs(np.corrcoef(a, b)[0, 1]) < 4.5 / np.sqrt(50_000)


def test_rows_and_columns_do_not_know_one_another() -> None:
    noise = recorded(np.zeros((512, 500)), read_noise=ReadNoise(1.0), **OFF, **(PLACE | {"frame_cols": 500}))
    n = noise.size
    for row_lag, col_lag in ((0, 1), (1, 0), (1, 1), (64, 0), (63, 3)):
        product = noise[row_lag:, col_lag:] * noise[: 512 - row_lag, : 500 - col_lag]
        assert abs(product.mean()) < 4.0 / np.sqrt(n)
    assert noise.mean(axis=1).std() == pytest.approx(1 / np.sqrt(500), rel=4 / np.sqrt(2 * 512))
    assert noise.mean(axis=0).std() == pytest.approx(1 / np.sqrt(512), rel=4 / np.sqrt(2 * 500))


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


def test_large_seeds_work() -> None:
    assert generator(2**63 - 1, ShotNoise.stream, block=0).random() != generator(2**31 - 1, 2, block=0).random()


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
