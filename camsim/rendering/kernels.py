"""What the compiled kernels have in common: one caller at a time, whether they are compiled yet, and of what source."""

from __future__ import annotations

import contextlib
import os
import threading
from pathlib import Path

# OpenMP's workers otherwise spin for milliseconds after each loop: on a busy machine they spin on the very core that
# the other half of the work waits for, and a rendering takes four times as long. Read when the first loop runs.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

ONE_AT_A_TIME = threading.Lock()
"""Held while a parallel kernel runs. Each uses every core, so a second caller loses nothing by waiting; and
Numba's work-queue thread layer, the only one sure to be there, may not be entered by two threads."""


def forget_stale(sources: Path, cache: Path) -> None:
    """Remove Numba's indices in or under ``cache`` that are older than any of the ``sources``.

    An index knows the file of its own function only, while kernels take in functions of other files: after a change
    there it would go on giving the old numbers.
    """
    newest = max(source.stat().st_mtime for source in sources.rglob("*.py"))
    for index in cache.rglob("*.nbi"):
        with contextlib.suppress(OSError):  # read-only, or another process was quicker
            if index.stat().st_mtime < newest:
                index.unlink()


forget_stale(Path(__file__).parent, Path(__file__).parent)


def kernels_compiled() -> bool:
    """Whether the kernels lie compiled in Numba's cache (the first use on a machine compiles them, once)."""
    from camsim.rendering.boundary import tiles

    kernel = tiles.render_edges
    if kernel.signatures:
        return True
    source = Path(tiles.__file__)
    compiled = Path(kernel.stats.cache_path or ".").glob(f"{source.stem}.render_edges-*.nbi")
    return any(index.stat().st_mtime >= source.stat().st_mtime for index in compiled)
