"""The first use on a machine: kernels are compiled in advance, by two processes in parallel.

Numba compiles one kernel at a time. The engine's and the check's kernels are independent and take about as long: a tiny
rendering compiles the engine's in this process, while a second process compiles the check's. Both store them in the
cache.
"""

from __future__ import annotations

import subprocess
import sys

import numba as nb
import numpy as np

from camsim.core.arrays import U8
from camsim.core.kernels import is_cached
from camsim.core.kernels.counts import fill_counts
from camsim.optics import Airy, FourSpotOlpf, OpticalSystem, SquarePhotosite
from camsim.rendering.auto import Choice
from camsim.rendering.boundary.tiles import render_tiles
from camsim.rendering.grid import Grid
from camsim.rendering.prune import joined_outlines
from camsim.rendering.render import plan_render
from camsim.scene import Path, Rectangle, Scene

SIDE, WAVELENGTHS = 16, 24  # photosites; enough wavelengths for the check to use its table of the PSF


def kernels_compiled() -> bool:
    """Return whether the compiled kernels are in the cache (the first use on a machine compiles them, once)."""
    return is_cached(render_tiles)


def compile_kernels() -> None:
    """Compile the kernels for a rendering of edges, on two cores if there are two."""
    check = None
    if nb.config.NUMBA_NUM_THREADS > 1 and sys.executable:  # type: ignore[attr-defined]
        nothing = subprocess.DEVNULL
        code = f"from {__name__} import compile_check; compile_check()"
        check = subprocess.Popen([sys.executable, "-c", code], stdin=nothing, stdout=nothing, stderr=nothing)
    choice, channel = _tiny()
    for _ in choice.plan.bands(channel, lambda done: None):
        pass
    joined_outlines(choice.plan.job.edges)  # of edges outside the frame
    fill_counts(np.empty(1), np.ones(1), np.zeros(1))  # photon noise
    if check is not None:
        check.wait()  # if it failed, kernels are compiled when they are needed


def compile_check() -> None:
    """Compile the kernels of the check."""
    choice, channel = _tiny()
    rows, cols = choice.checker.hardest(choice.plan)
    choice.checker.values(rows, cols, channel[rows, cols])


def _tiny() -> tuple[Choice, U8]:
    """Return a rendering that uses every kernel of a capture, and its photosites' channels."""
    square = Rectangle(width_um=20.0, height_um=30.0, rotate_deg=5.0, reflectance=0.1)
    leaf = Path(segments_um=[("move", 10, 0), ("cubic", 20, 0, 30, 10, 20, 30), ("close",)], reflectance=0.3)
    choice = plan_render(
        Scene(background=1.0, shapes=[square, leaf]),
        OpticalSystem.of([Airy(f_number=8.0), FourSpotOlpf(split_um=4.0), SquarePhotosite(side_um=5.0)]),
        Grid(rows=SIDE, cols=SIDE, pitch_um=5.0),
        response=np.ones((2, WAVELENGTHS)),
        wavelength_nm=np.linspace(450.0, 650.0, WAVELENGTHS),
        tolerance=1e-5,
        method="boundary",
    )
    return choice, np.zeros((SIDE, SIDE), np.uint8)
