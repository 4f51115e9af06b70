"""The noise chain: mean electrons in, recorded electrons out, block by block on all cores."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from camsim.core.arrays import F64
from camsim.core.cores import cores
from camsim.core.custom import is_custom
from camsim.core.kernels.threads import shared
from camsim.sensor.custom import acted, drawn
from camsim.sensor.stage import Context, ElectronicStage, Phase
from camsim.sensor.stages.crosstalk import Crosstalk
from camsim.sensor.streams import BLOCK_ROWS

Act: TypeAlias = tuple[ElectronicStage, Phase]


def record(
    mean_electrons: F64, stages: Sequence[ElectronicStage], context: Context, *, threads: int | None = None
) -> F64:
    """Return (rows, cols) electrons after the stages, before the ADC.

    mean_electrons : by light alone, in a window or a band of it that begins at a whole block of rows; with crosstalk
                     (rows + 2, cols + 2), because the window's neighbours contribute
    stages         : the active ones (``Electronics.stages``); without any, the mean is returned
    threads        : largest number of threads; the result does not depend on it (None: all available to this process)
    """
    margin = sum(stage.margin for stage in stages)
    rows = len(mean_electrons) - 2 * margin
    if context.rows_before % BLOCK_ROWS:
        raise ValueError(f"rows_before {context.rows_before}: a band begins at a multiple of {BLOCK_ROWS} rows")
    whole = [stage.name for stage in stages if stage.whole_window]
    if whole and rows != context.rows_in_all:
        raise ValueError(f"{whole[0]} runs over the whole window; give all of it at once")
    context = dataclasses.replace(context, stages=tuple(stages))
    electrons = mean_electrons
    for acts in _in_turn(stages):
        margin -= sum(stage.margin for stage, _ in acts)
        here = dataclasses.replace(context, margin=margin)
        retained = False
        if acts and acts[0][0].whole_window:
            (stage, phase), *acts = acts
            electrons = acted(stage, electrons, dataclasses.replace(here, phase=phase, asking=stage))
            retained = is_custom(stage)  # a custom stage may return its input or an array that it holds on to
        electrons = _in_blocks(electrons, acts, here, threads, ours=not retained and electrons is not mean_electrons)
    return electrons


def mixed(mean_electrons: F64, crosstalk: Crosstalk) -> F64:
    """Return (rows, cols) mean electrons after crosstalk from (rows + 2, cols + 2) before it."""
    rows, cols = mean_electrons.shape[0] - 2, mean_electrons.shape[1] - 2
    nowhere = Context(time_s=0.0, seed=0, serial=0, origin=(0, 0), frame_cols=cols, rows_in_all=rows)
    return record(mean_electrons, (crosstalk,), nowhere)


def random_numbers(stages: Sequence[ElectronicStage], shape: tuple[int, int], context: Context) -> int:
    """Return the number of random numbers that a window (rows, cols) uses, without drawing them.

    Places of random defects are not counted, as their number is random.
    """
    margin, count = sum(stage.margin for stage in stages), 0
    for acts in _in_turn(stages):
        margin -= sum(stage.margin for stage, _ in acts)
        wide = (shape[0] + 2 * margin, shape[1] + 2 * margin)
        for stage, phase in acts:
            count += drawn(stage, wide, dataclasses.replace(context, margin=margin, phase=phase))
    return count


def _in_turn(stages: Sequence[ElectronicStage]) -> list[list[Act]]:
    """Return rounds of actions done block by block; a stage that needs neighbouring rows starts a new round."""
    rounds: list[list[Act]] = [[]]
    for phase in Phase:
        for stage in stages:
            if phase not in stage.phases:
                continue
            if stage.whole_window or (stage.margin and rounds[-1]):
                rounds.append([])
            rounds[-1].append((stage, phase))
    return rounds


def _in_blocks(electrons: F64, acts: Sequence[Act], context: Context, threads: int | None, *, ours: bool) -> F64:
    """Return the electrons after a round; overwrites the input if it is ``ours`` and has the same size."""
    margin = sum(stage.margin for stage, _ in acts)
    rows, cols = electrons.shape[0] - 2 * margin, electrons.shape[1] - 2 * margin
    after = electrons if ours and not margin else np.empty((rows, cols))
    acting = [
        (stage.over(dataclasses.replace(context, asking=stage, begun=set())), stage, phase) for stage, phase in acts
    ]

    def work(block: int) -> None:
        first = block * BLOCK_ROWS
        part = electrons[first : first + BLOCK_ROWS + 2 * margin]
        if not ours and not np.isfinite(part).all():
            raise ValueError(f"mean electrons of rows {first}..{first + len(part) - 1} are not all finite")
        for here, stage, phase in acting:
            where = dataclasses.replace(context, rows_before=context.rows_before + first, phase=phase, asking=stage)
            part = acted(here, part, where)
        after[first : first + BLOCK_ROWS] = part

    def several(first: int, end: int) -> None:
        for block in range(first, end):
            work(block)

    # NumPy releases the GIL while drawing.
    shared(-(-rows // BLOCK_ROWS), several, most=cores() if threads is None else threads)
    return after
