"""How long the first capture on a machine takes, and the next ones: ``python -m bench.first_use`` on an idle machine.

Each capture is a process of its own with its imports; before the first one the folder of caches is empty, as after an
installation. Python keeps the modules that it has compiled, as an installed package's are. CPU seconds are of all
processes of a capture. Of the later ones the quickest counts: other work on the machine only ever adds.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time

SCENE = "slanted-edge"
FIRST_S, WARM_S = 20.0, 0.8  # wall seconds on two idle cores that are asked for
WARM = 5  # later captures


def capture(folder: str) -> tuple[float, float]:
    """Return wall and CPU seconds of a capture that finds its caches in a folder."""
    elsewhere = ("NUMBA_CACHE_DIR", "PYTHONDONTWRITEBYTECODE")
    environment = {name: value for name, value in os.environ.items() if name not in elsewhere}
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(
        [sys.executable, "-m", "camsim", "capture", SCENE, "--force", "-q"],
        cwd=folder,
        env=environment | {"XDG_CACHE_HOME": folder},
        check=True,
    )
    wall_s, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall_s, after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def main() -> None:
    """Print the first capture and the quickest of the later ones."""
    with tempfile.TemporaryDirectory() as folder:
        first = capture(folder)
        warm = min(capture(folder) for _ in range(WARM))
    for name, (wall_s, cpu_s), asked_s in (("first", first, FIRST_S), ("warm", warm, WARM_S)):
        print(f"{name:5} {wall_s:6.2f} s wall, {cpu_s:6.2f} s CPU (asked: {asked_s:g} s wall on two idle cores)")


if __name__ == "__main__":
    main()
