"""The machine of a bench, its momentary speed, and whether it was otherwise loaded."""

from __future__ import annotations

import platform
import threading
import time
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from camsim.core.cores import cores

PACKAGES = ("camsim-spectral", "numpy", "scipy", "numba", "finufft", "galsim", "prysm")
SPIN_LAPS = 12
BUSY = 1.15  # wall over CPU time of the spin above which other processes use the cores
SLOWER = 1.15  # CPU time of the spin relative to the fastest, above which clock or caches changed


def versions() -> dict[str, str]:
    """Return the versions of relevant installed packages."""
    found = {"python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def machine() -> dict[str, str | int]:
    """Return the machine's properties, without name or location."""
    return {
        "processor": _processor(),
        "cores": cores(),
        "system": platform.system(),
        "architecture": platform.machine(),
    }


def _processor() -> str:
    table = Path("/proc/cpuinfo")
    if table.exists():
        for line in table.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or "unknown"


@dataclass(frozen=True, slots=True, kw_only=True)
class Spin:
    """Timing of equal work on every core at once.

    cpu_s         : CPU seconds of one core's work, the quickest core
    wall_over_cpu : wall over CPU time, the worst core; 1 on an idle machine
    """

    cpu_s: float
    wall_over_cpu: float

    @property
    def busy(self) -> bool:
        """Whether another process used a core meanwhile."""
        return self.wall_over_cpu > BUSY


def spin(threads: int | None = None) -> Spin:
    """Clock a fixed piece of arithmetic, about 0.1 s, on every core at once.

    A spin on one core would be scheduled on a free core; on all cores it detects other load.
    """
    count = threads or cores()
    start, found = threading.Barrier(count), [(0.0, 0.0)] * count
    grain = np.linspace(0.1, 1.0, 200_000)

    def work(k: int) -> None:
        one = grain.copy()
        try:
            start.wait()
        except threading.BrokenBarrierError:
            return
        wall, cpu = time.perf_counter(), time.thread_time()
        for _ in range(SPIN_LAPS):
            np.sqrt(np.exp(np.sin(one)), out=one)
        found[k] = (time.perf_counter() - wall, time.thread_time() - cpu)

    workers = [threading.Thread(target=work, args=(k,)) for k in range(count)]
    try:
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
    except BaseException:  # Ctrl-C before all had started: the others would wait forever, and Python for them
        start.abort()
        raise
    return Spin(cpu_s=min(cpu for _, cpu in found), wall_over_cpu=max(wall / cpu for wall, cpu in found))


def words_of_load(spins: list[Spin], so: str = "") -> str:
    """Return one sentence on what else happened on the machine, and what that means for the figures.

    so : how busy periods were handled
    """
    busy = [s for s in spins if s.busy]
    if not spins or not busy:
        words = "The machine was quiet"
    else:
        worst = max(s.wall_over_cpu for s in busy)
        words = (
            f"The machine was busy with other work at {len(busy)} of {len(spins)} looks "
            f"(up to {worst:.2f} s of wall time for a second of work): wall times are too long{so}"
        )
    slowest = max((s.cpu_s for s in spins), default=0.0) / min((s.cpu_s for s in spins), default=1.0)
    if slowest > SLOWER:
        words += f"; its cores ran at speeds that differed by a factor {slowest:.2f} during the run"
    return words + "."
