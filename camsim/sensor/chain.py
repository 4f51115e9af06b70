"""The noise chain: mean electrons in, recorded electrons out, block by block on all cores."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from camsim.arrays import F32, F64
from camsim.sensor.noise import DarkCurrent, Dsnu, FullWell, Prnu, ReadNoise, ShotNoise
from camsim.sensor.streams import BLOCK_ROWS, Stream, fixed_normals, generator


def record(
    mean_electrons: F64,
    *,
    prnu: Prnu | None = None,
    dark_current: DarkCurrent | None = None,
    shot_noise: ShotNoise | None = ShotNoise(),  # noqa: B008 (frozen, without fields)
    full_well: FullWell | None = None,
    read_noise: ReadNoise | None = None,
    dsnu: Dsnu | None = None,
    time_s: float,
    seed: int,
    serial: int,
    origin: tuple[int, int],
    frame_cols: int,
    frame_number: int = 0,
    noise: bool = True,
    threads: int | None = None,
) -> F64:
    """Return (rows, cols) electrons after noise and full well, before the ADC.

    In this order: mean × PRNU, + dark current × time, Poisson, full well, read noise, DSNU offset. A stage
    that is None is left out and changes no other stage's draws.

    mean_electrons : (rows, cols), of light alone
    seed           : of the temporal noise, together with ``frame_number``
    serial         : of the sensor, for the fixed patterns
    origin         : (row, col) of the window's first photosite in the full frame
    frame_cols     : width of the full frame
    noise          : False leaves the mean, cut at the full well: no dark current, no generator ever made
    threads        : at most so many; the result does not depend on it (None: as many as this process may use)
    """
    rows, cols = mean_electrons.shape
    recorded = np.empty((rows, cols), dtype=np.float64)

    def fixed(stream: Stream, first_row: int, height: int) -> F32:
        place = (origin[0] + first_row, origin[1])
        return fixed_normals(serial, stream, rows=height, cols=cols, origin=place, frame_cols=frame_cols)

    def record_block(block: int) -> None:
        first_row = block * BLOCK_ROWS
        electrons = mean_electrons[first_row : first_row + BLOCK_ROWS]
        height = len(electrons)
        if not np.isfinite(electrons).all():
            raise ValueError(
                f"mean electrons of rows {first_row}..{first_row + height - 1} are not all finite"
            )
        if noise and prnu is not None:
            electrons = prnu.apply(electrons, normals=fixed(Stream.PRNU, first_row, height))
        if noise and dark_current is not None:
            electrons = dark_current.apply(electrons, time_s=time_s)
        if noise and shot_noise is not None:
            rng = generator(seed, Stream.SHOT, block=block, frame_number=frame_number)
            electrons = shot_noise.apply(electrons, rng=rng)
        if full_well is not None:
            electrons = full_well.apply(electrons)
        if noise and read_noise is not None:
            rng = generator(seed, Stream.READ, block=block, frame_number=frame_number)
            electrons = read_noise.apply(electrons, rng=rng)
        if noise and dsnu is not None:
            electrons = dsnu.apply(electrons, normals=fixed(Stream.DSNU, first_row, height))
        recorded[first_row : first_row + height] = electrons

    _each(record_block, -(-rows // BLOCK_ROWS), threads)
    return recorded


def _each(work: Callable[[int], None], count: int, threads: int | None) -> None:
    """Do ``work`` for 0..count − 1; numpy lets go of the interpreter while it draws, so threads pay."""
    workers = min(count, _usable_cores() if threads is None else threads)
    if workers <= 1:
        for number in range(count):
            work(number)
        return
    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(work, range(count)))


def _usable_cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
