"""What a sweep gains: against a process for each capture, and with more workers; what it costs against a loop.

``python -m bench.sweep`` on an idle machine takes four minutes.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import psutil

import camsim

REGION = {"rows": 256, "cols": 256}
LARGE = {"rows": 1024, "cols": 1024}


def main() -> None:
    """Print seconds and ratios; everything is warm, and medians of a few."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000, help="captures of 256² that differ in seed and ISO")
    parser.add_argument("--large", type=int, default=200, help="captures of 1024²; 0: none")
    parser.add_argument("--processes", type=int, default=5, help="camsim capture processes that are timed")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        _alike(Path(folder), options.count, options.processes)
        if options.large:
            _engine(Path(folder), min(options.large, 40))
            _workers(Path(folder), options.large)


def _alike(folder: Path, count: int, processes: int) -> None:
    words = [sys.executable, "-m", "camsim", "capture", "slanted-edge", "-q", "--force", "-o", str(folder / "one.dng")]
    words += ["--set", "region.rows=256", "--set", "region.cols=256"]
    each, each_cpu_s = [], []
    for number in range(processes + 1):
        begin, begin_cpu_s = time.perf_counter(), _of_all_s()
        subprocess.run([*words, "--set", f"noise.seed={number}"], check=True)
        each.append(time.perf_counter() - begin)
        each_cpu_s.append(_of_all_s() - begin_cpu_s)
    one, one_cpu_s = (sorted(seconds[1:])[processes // 2] for seconds in (each, each_cpu_s))
    vary = {"noise.seed": list(range(count // 2)), "exposure.iso": [200, 800]}
    begin, begin_cpu_s = time.perf_counter(), _of_all_s()
    camsim.sweep({"scene": "slanted-edge", "set": {"region": REGION}, "vary": vary}, folder / "alike")
    swept, swept_cpu_s = (time.perf_counter() - begin) / count, (_of_all_s() - begin_cpu_s) / count
    print(f"256², seed and ISO: {one:.2f} s a process, {1e3 * swept:.1f} ms in a sweep of {count}: {one / swept:.1f} ×")
    print(f"  CPU s: {one_cpu_s:.3f} and {swept_cpu_s:.4f}: {one_cpu_s / swept_cpu_s:.1f} ×")


def _engine(folder: Path, count: int) -> None:
    """Print CPU seconds of captures in a loop of one's own, and in a sweep in the same process."""
    numbers = np.linspace(4.0, 16.0, count + 1).tolist()
    began_s = 0.0
    for number, f_number in enumerate(numbers):  # the first one warms up
        began_s = time.process_time() if number == 1 else began_s
        overrides = [f"region.{key}={value}" for key, value in LARGE.items()] + [f"lens.f_number={f_number}"]
        frame = camsim.capture("slanted-edge", overrides=overrides)
        camsim.save(frame, folder / f"loop{number}.dng")
    loop = (time.process_time() - began_s) / count
    began_s = time.process_time()
    camsim.sweep(
        {"scene": "slanted-edge", "set": {"region": LARGE}, "vary": {"lens.f_number": numbers[1:]}},
        folder / "engine",
        workers=0,
    )
    swept = (time.process_time() - began_s) / count
    print(f"1024², CPU s a capture: {loop:.3f} in a loop, {swept:.3f} in a sweep: {100 * (swept / loop - 1):+.1f} %")


def _workers(folder: Path, count: int) -> None:
    """Print what two workers gain; CPU seconds tell on a busy machine too whether they hinder one another."""
    study = {"scene": "slanted-edge", "set": {"region": LARGE}, "vary": {"lens.f_number": {"linear": [4, 16, count]}}}
    seconds = {}
    for workers in (1, 2):
        begin, begin_cpu_s = time.perf_counter(), _of_all_s()
        swept = camsim.sweep(study, folder / f"by{workers}", workers=workers)
        seconds[workers] = time.perf_counter() - begin
        alone = sum(row["seconds"] for row in swept.rows)
        rest = seconds[workers] - alone / workers
        print(
            f"1024², {count} f-numbers, {workers} workers: {seconds[workers]:.1f} s, {rest:.1f} s of it around captures"
        )
        cpu_s = (_of_all_s() - begin_cpu_s) / count
        print(f"  CPU s a capture: {cpu_s:.3f}, the start of the workers among it")
    print(f"two workers: {seconds[1] / seconds[2]:.2f} × one (asked: 1.8 on two idle cores, for 200 captures)")


def _of_all_s() -> float:
    """Return the CPU seconds of this process, and of all that it has begun and that have ended."""
    times = psutil.Process().cpu_times()
    return float(times.user + times.system + times.children_user + times.children_system)


if __name__ == "__main__":
    main()
