"""What a worker does: draw and clock, draw and weigh. Every program through the same functions."""

from __future__ import annotations

import gc
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.memory import forget_peak, held_memory_mb, peak_memory_mb
from bench.paper.cases import (
    WINDOW_COLS,
    WINDOW_ORIGIN,
    WINDOW_ROWS,
    Psf,
    Setting,
    expected_s,
    frame,
    one_photosite,
    rendered,
    window,
)
from bench.paper.peers import PEERS
from camsim.core.arrays import F64
from camsim.errors import CamsimError

LONGEST_S = 15.0  # a frame; what takes longer is left out: closed forms of many wavelengths at 1e-10 take hours


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Drawn:
    """The window of one drawing: (rows, cols), what ran and what it says of its own error; or why it was refused."""

    image: F64 | None
    engine: str = ""
    error_estimate: float | None = None
    refused: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Lap:
    """One clocked drawing."""

    wall_s: float
    cpu_s: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Weighed:
    """The unshifted frame, the process's peak memory and how much that is beyond what it held, MB."""

    image: F64
    peak_mb: float | None
    beyond_mb: float | None


def draw_window(psf: Psf, setting: Setting, shift_px: Sequence[float]) -> Drawn:
    """Draw the window on which errors are taken."""
    if setting.program != "camsim":
        whole = PEERS[setting.program].draw(psf, _knob(setting), shift_px, 0)
        return Drawn(image=cut_window(whole), engine=setting.program)
    try:
        if (seconds := expected_s(psf, setting)) > LONGEST_S:
            return Drawn(image=None, refused=f"left out: {seconds:.2g} s of one core are expected for the frame")
        rendering = rendered(psf, setting, window(), shift_px=shift_px)
    except CamsimError as error:
        return Drawn(image=None, refused=str(error))
    return Drawn(image=rendering.image, engine=rendering.method, error_estimate=rendering.error_estimate)


def clock_frame(psf: Psf, setting: Setting, lap: int) -> Lap:
    """Clock the whole frame, set-up and check included, with a lens that no cache has seen."""
    _collect()
    wall, cpu = time.perf_counter(), time.process_time()
    if setting.program != "camsim":
        PEERS[setting.program].draw(psf, _knob(setting), (0.0, 0.0), lap)
    else:
        rendered(psf, setting, frame(), lap=lap)
    return Lap(wall_s=time.perf_counter() - wall, cpu_s=time.process_time() - cpu)


def clock_setup(psf: Psf, setting: Setting, laps: Sequence[int]) -> Lap:
    """Clock what comes before the first photosite, and the check: a frame of one photosite; the quickest of laps."""
    found = []
    for lap in laps:
        wall, cpu = time.perf_counter(), time.process_time()
        rendered(psf, setting, one_photosite(), lap=lap)
        found.append(Lap(wall_s=time.perf_counter() - wall, cpu_s=time.process_time() - cpu))
    return min(found, key=lambda lap: lap.cpu_s)


def weigh_frame(psf: Psf, setting: Setting) -> Weighed:
    """Draw the frame as it is clocked and watch the memory."""
    _collect()
    held = held_memory_mb() if forget_peak() else None
    if setting.program != "camsim":
        image = PEERS[setting.program].draw(psf, _knob(setting), (0.0, 0.0), 0)
    else:
        image = rendered(psf, setting, frame()).image
    peak = peak_memory_mb()
    known = held is not None and peak is not None
    return Weighed(
        image=image,
        peak_mb=peak if known else None,
        beyond_mb=max((peak or 0.0) - (held or 0.0), 0.0) if known else None,
    )


def _collect() -> None:
    """Collect what the last drawing left. What stays is not looked at again: that would take longer than a frame."""
    gc.collect()
    gc.freeze()


def _knob(setting: Setting) -> float:
    assert setting.knob is not None
    return setting.knob


def cut_window(frames: F64) -> F64:
    """Return the window (…, rows, cols) of whole frames."""
    row, col = WINDOW_ORIGIN
    part: F64 = np.ascontiguousarray(frames[..., row : row + WINDOW_ROWS, col : col + WINDOW_COLS])
    return part
