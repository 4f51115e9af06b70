"""The clocks: every setting's frame in turn, on one thread and on all, then its set-up and its memory."""

from __future__ import annotations

import statistics
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from bench.paper.cases import Psf, Setting
from bench.paper.measuring import Lap, clock_frame, clock_setup, draw_window, weigh_frame
from bench.worker import Worker
from camsim.core.arrays import F64

FEWEST_LAPS = 2  # of anything but the long: the quickest of many laps would flatter beside the only one
SETUP_LAPS = (101, 102, 103)  # numbers of laps that no frame had: lenses that no cache has seen
Times = dict[Setting, dict[str, object]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Clocks:
    """The processes in which things are clocked and weighed, and for how long.

    one, all       : with one thread and with all;  weigher: gives freed memory back at once
    peers          : a process for each other program, by its name
    laps, budget_s : clock a setting so often, or for so many CPU seconds
    longest_s      : what takes longer is clocked once, on one thread, and not weighed
    """

    one: Worker
    all: Worker
    weigher: Worker
    peers: dict[str, Worker]
    laps: int
    budget_s: float
    longest_s: float

    def worker(self, setting: Setting, threads: int) -> Worker:
        """Return the process for a setting with one thread, or all (0)."""
        if setting.program != "camsim":
            return self.peers[setting.program]
        return self.one if threads == 1 else self.all

    def clock(self, psf: Psf, settings: Sequence[Setting], truth: F64, times: Times) -> Iterator[Setting]:
        """Fill ``times`` as figures come, and yield each setting when it is done.

        truth : (rows, cols) of the unshifted frame
        """
        for method in dict.fromkeys((s.program, s.method) for s in settings):
            first = next(s for s in settings if (s.program, s.method) == method)
            for worker in {self.worker(first, 1), self.worker(first, 0), self._weigher(first)}:
                worker.call(draw_window, psf, first, (0.0, 0.0))  # loads kernels, plans transforms
        long = self._laps(psf, settings, times)
        for setting in settings:
            ours = setting.program == "camsim"
            if ours:
                setup = self.one.call(clock_setup, psf, setting, SETUP_LAPS)
                times[setting] |= {"setup_wall_s": setup.wall_s, "setup_cpu_s": setup.cpu_s}
            if not ours or setting not in long:
                weighed = self._weigher(setting).call(weigh_frame, psf, setting)
                times[setting] |= {"peak_mb": weighed.peak_mb, "beyond_mb": weighed.beyond_mb}
                error = weighed.image - truth
                times[setting] |= {
                    "error_frame_max": float(np.abs(error).max()),
                    "error_frame_max_without_constant": float(np.abs(error - error.mean()).max()),
                }
            yield setting

    def _laps(self, psf: Psf, settings: Sequence[Setting], times: Times) -> set[Setting]:
        """Clock the frame, all settings in turn, so that a busy moment falls on all of them; return the long ones."""
        laps: dict[tuple[Setting, int], list[Lap]] = {}
        long: set[Setting] = set()
        for lap in range(1, self.laps + 1):
            for setting, threads in _lanes(settings):
                done = laps.setdefault((setting, threads), [])
                spent = sum(d.cpu_s for d in done)
                if setting in long or (len(done) >= FEWEST_LAPS and spent + spent / len(done) > self.budget_s):
                    continue
                done.append(self.worker(setting, threads).call(clock_frame, psf, setting, lap))
                times.setdefault(setting, {})["one_thread" if threads == 1 else "all_threads"] = _summary(done)
                if done[-1].cpu_s > self.longest_s:
                    long.add(setting)
        return long

    def _weigher(self, setting: Setting) -> Worker:
        return self.weigher if setting.program == "camsim" else self.peers[setting.program]


def _lanes(settings: Sequence[Setting]) -> Iterator[tuple[Setting, int]]:
    """Yield each setting with 1 thread, and camsim's with all (0): the other programs here use one."""
    for setting in settings:
        yield setting, 1
        if setting.program == "camsim":
            yield setting, 0


def _summary(laps: Sequence[Lap]) -> dict[str, float]:
    cpu = [lap.cpu_s for lap in laps]
    return {
        "wall_s": min(lap.wall_s for lap in laps),
        "cpu_s": min(cpu),
        "spread": statistics.median(cpu) / max(min(cpu), 1e-9) - 1.0,
        "laps": len(laps),
    }
