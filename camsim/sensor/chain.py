"""The noise chain: mean electrons in, recorded electrons out, block by block on all cores."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from camsim.arrays import F32, F64
from camsim.errors import InvalidValueError
from camsim.sensor.linearity import Nonlinearity
from camsim.sensor.neighbours import Blooming, Crosstalk, Defects, Places
from camsim.sensor.noise import (
    ColumnNoise,
    DarkCurrent,
    Dsnu,
    FlickerRows,
    FullWell,
    OutputNoise,
    Prnu,
    ReadNoise,
    ResetNoise,
    RowNoise,
    ShotNoise,
)
from camsim.sensor.streams import BLOCK_ROWS, Stream, column_normals, fixed_normals, generator

STAGES = (
    "prnu",
    "defects",
    "crosstalk",
    "dark_current",
    "shot_noise",
    "full_well",
    "blooming",
    "nonlinearity",
    "reset_noise",
    "read_noise",
    "row_noise",
    "flicker_rows",
    "column_noise",
    "dsnu",
    "output_noise",
)
"""The stages by their names, in the order in which charge meets them."""

STAGES_OF_THE_MEAN = ("crosstalk", "full_well", "blooming", "nonlinearity")
"""Those that act on a capture without noise too."""


def record(
    mean_electrons: F64,
    *,
    prnu: Prnu | None = None,
    defects: Defects | None = None,
    crosstalk: Crosstalk | None = None,
    dark_current: DarkCurrent | None = None,
    shot_noise: ShotNoise | None = ShotNoise(),  # noqa: B008 (frozen, without fields)
    full_well: FullWell | None = None,
    blooming: Blooming | None = None,
    nonlinearity: Nonlinearity | None = None,
    reset_noise: ResetNoise | None = None,
    read_noise: ReadNoise | None = None,
    row_noise: RowNoise | None = None,
    flicker_rows: FlickerRows | None = None,
    column_noise: ColumnNoise | None = None,
    dsnu: Dsnu | None = None,
    output_noise: OutputNoise | None = None,
    time_s: float,
    temperature_c: float | None = None,
    electrons_per_dn: float = 1.0,
    seed: int,
    serial: int,
    origin: tuple[int, int],
    frame_cols: int,
    frame_number: int = 0,
    noise: bool = True,
    rows_before: int = 0,
    rows_in_all: int | None = None,
    threads: int | None = None,
) -> F64:
    """Return (rows, cols) electrons after noise and full well, before the ADC.

    In this order: mean × PRNU, dead photosites, crosstalk, + dark current × time (hot photosites with theirs), Poisson,
    full well and blooming, non-linearity, reset noise, read noise, row noise, 1/f rows, column noise, DSNU offset,
    noise after the gain. A stage that is None is left out and changes no other stage's draws.

    mean_electrons   : (rows, cols), of light alone; with ``crosstalk`` (rows + 2, cols + 2), because the window's
                       neighbours take part: one photosite more on every side
    temperature_c    : of the sensor, for the dark current; None: the one that its figure holds at
    electrons_per_dn : for the noise after the gain
    seed             : of the temporal noise, together with ``frame_number``
    serial           : of the sensor, for the fixed patterns
    origin           : (row, col) of the window's first photosite in the full frame
    rows_before, rows_in_all : of the window, when ``mean_electrons`` is a band of it; the band begins at a whole block.
                       Blooming runs over the window, so it needs all of it
    frame_cols       : width of the full frame
    noise            : False leaves what happens to the mean: crosstalk, full well, blooming, non-linearity. No dark
                       current, no pattern, no generator ever made
    threads          : at most so many; the result does not depend on it (None: as many as this process may use)
    """
    border = 0 if crosstalk is None else 1
    rows, cols = mean_electrons.shape[0] - 2 * border, mean_electrons.shape[1] - 2 * border
    rows_in_all = rows if rows_in_all is None else rows_in_all
    blocks_before, within_block = divmod(rows_before, BLOCK_ROWS)
    if within_block:
        raise ValueError(f"rows_before {rows_before}: a band begins at a multiple of {BLOCK_ROWS} rows")
    if blooming is not None and full_well is None:
        raise InvalidValueError("blooming: there is no full_well that charge could spill over; give one")
    if blooming is not None and rows != rows_in_all:
        raise ValueError("blooming runs over the whole window; give all of it at once")
    recorded = np.empty((rows, cols), dtype=np.float64)
    # A photosite's own light; crosstalk mixes it with that of rows that belong to other blocks.
    lit = mean_electrons if crosstalk is None or not noise else np.empty_like(mean_electrons)
    rows_e = None
    if noise and flicker_rows is not None:
        rng = generator(seed, Stream.FLICKER, block=0, frame_number=frame_number)
        rows_e = flicker_rows.offsets_e(rows_in_all, rng)[rows_before : rows_before + rows]
    columns = None
    if noise and column_noise is not None:
        columns = column_normals(serial, first_col=origin[1], cols=cols, frame_cols=frame_cols)

    def rng_of(stream: Stream, block: int) -> np.random.Generator:
        return generator(seed, stream, block=blocks_before + block, frame_number=frame_number)

    def place(first_row: int, margin: int = 0) -> tuple[int, int]:
        return origin[0] + rows_before + first_row - margin, origin[1] - margin

    def fixed(stream: Stream, first_row: int, shape: tuple[int, int], margin: int = 0) -> F32:
        where = place(first_row, margin)
        return fixed_normals(serial, stream, rows=shape[0], cols=shape[1], origin=where, frame_cols=frame_cols)

    def broken(first_row: int, shape: tuple[int, int], margin: int = 0) -> tuple[Places, F64, Places]:
        assert defects is not None
        return defects.within(serial=serial, shape=shape, origin=place(first_row, margin), frame_cols=frame_cols)

    def light(block: int) -> F64:
        """Return what a block's photosites see (of the array as it came, border included)."""
        first_row = block * BLOCK_ROWS
        electrons = mean_electrons[first_row : first_row + BLOCK_ROWS]
        if not np.isfinite(electrons).all():
            last_row = first_row + len(electrons) - 1
            raise ValueError(f"mean electrons of rows {first_row}..{last_row} are not all finite")
        shape = (electrons.shape[0], electrons.shape[1])
        if noise and prnu is not None:
            electrons = prnu.apply(electrons, normals=fixed(Stream.PRNU, first_row, shape, border))
        if noise and defects is not None:
            *_, dead = broken(first_row, shape, border)
            electrons = electrons.copy()
            electrons[dead] = 0.0
        return electrons

    def light_into_lit(block: int) -> None:
        first_row = block * BLOCK_ROWS
        if lit is mean_electrons:
            light(block)
        else:
            lit[first_row : first_row + BLOCK_ROWS] = light(block)

    def collect(block: int) -> F64:
        """Return the charge in the photosites at the end of the exposure, the full well not yet looked at."""
        first_row = block * BLOCK_ROWS
        own = lit[first_row : first_row + BLOCK_ROWS + 2]
        electrons = light(block) if crosstalk is None else crosstalk.apply(own)
        shape = (electrons.shape[0], electrons.shape[1])
        warming = 1.0
        if noise and dark_current is not None:
            normals = fixed(Stream.DCNU, first_row, shape) if dark_current.nonuniformity else None
            electrons = dark_current.apply(electrons, time_s=time_s, temperature_c=temperature_c, normals=normals)
            warming = dark_current.warming(temperature_c)
        if noise and defects is not None:
            hot, e_per_s, _ = broken(first_row, shape)
            electrons = electrons.copy()
            np.add.at(electrons, hot, (warming * time_s) * e_per_s)
        if noise and shot_noise is not None:
            electrons = shot_noise.apply(electrons, rng=rng_of(Stream.SHOT, block))
        return electrons

    def read_out(block: int, electrons: F64) -> None:
        """Write the charge of a block's photosites as it is read."""
        first_row = block * BLOCK_ROWS
        if full_well is not None:
            electrons = full_well.apply(electrons)
        if nonlinearity is not None:
            electrons = nonlinearity.apply(electrons)
        if noise:
            shape = (electrons.shape[0], electrons.shape[1])
            if reset_noise is not None:
                electrons = reset_noise.apply(electrons, rng=rng_of(Stream.RESET, block))
            if read_noise is not None:
                electrons = read_noise.apply(electrons, rng=rng_of(Stream.READ, block))
            if row_noise is not None:
                electrons = row_noise.apply(electrons, rng=rng_of(Stream.ROW, block))
            if rows_e is not None:
                electrons = electrons + rows_e[first_row : first_row + BLOCK_ROWS, None]
            if column_noise is not None and columns is not None:
                electrons = column_noise.apply(electrons, normals=columns)
            if dsnu is not None:
                electrons = dsnu.apply(electrons, normals=fixed(Stream.DSNU, first_row, shape))
            if output_noise is not None:
                rng = rng_of(Stream.OUTPUT, block)
                electrons = output_noise.apply(electrons, electrons_per_dn=electrons_per_dn, rng=rng)
        recorded[first_row : first_row + BLOCK_ROWS] = electrons

    def collect_into_recorded(block: int) -> None:
        recorded[block * BLOCK_ROWS : (block + 1) * BLOCK_ROWS] = collect(block)

    blocks = -(-rows // BLOCK_ROWS)
    if crosstalk is not None:
        _each(light_into_lit, -(-len(mean_electrons) // BLOCK_ROWS), threads)
    if blooming is not None and full_well is not None:
        _each(collect_into_recorded, blocks, threads)
        recorded = blooming.apply(recorded, capacity_e=full_well.capacity_e)
        _each(lambda block: read_out(block, recorded[block * BLOCK_ROWS : (block + 1) * BLOCK_ROWS]), blocks, threads)
    else:
        _each(lambda block: read_out(block, collect(block)), blocks, threads)
    return recorded


def mixed(mean_electrons: F64, crosstalk: Crosstalk) -> F64:
    """Return (rows, cols) mean electrons after crosstalk, of (rows + 2, cols + 2) before it."""
    rows = len(mean_electrons) - 2
    after = np.empty((rows, mean_electrons.shape[1] - 2))

    def mix(block: int) -> None:
        first_row = block * BLOCK_ROWS
        after[first_row : first_row + BLOCK_ROWS] = crosstalk.apply(
            mean_electrons[first_row : first_row + BLOCK_ROWS + 2]
        )

    _each(mix, -(-rows // BLOCK_ROWS), None)
    return after


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
