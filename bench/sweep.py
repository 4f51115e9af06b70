"""What a sweep gains: against a process for each capture, and with more workers. ``python -m bench.sweep``."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import camsim

REGION = {"rows": 256, "cols": 256}
LARGE = {"rows": 1024, "cols": 1024}


def main() -> None:
    """Print seconds and ratios; everything is warm, and medians of a few."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=200, help="captures of 256² that differ in seed and ISO")
    parser.add_argument("--large", type=int, default=40, help="captures of 1024²")
    parser.add_argument("--processes", type=int, default=5, help="camsim capture processes that are timed")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        _alike(Path(folder), options.count, options.processes)
        _workers(Path(folder), options.large)


def _alike(folder: Path, count: int, processes: int) -> None:
    words = [sys.executable, "-m", "camsim", "capture", "slanted-edge", "-q", "--force", "-o", str(folder / "one.dng")]
    words += ["--set", "region.rows=256", "--set", "region.cols=256"]
    each = []
    for number in range(processes + 1):
        begin = time.perf_counter()
        subprocess.run([*words, "--set", f"noise.seed={number}"], check=True)
        each.append(time.perf_counter() - begin)
    one = sorted(each[1:])[processes // 2]
    vary = {"noise.seed": list(range(count // 2)), "exposure.iso": [200, 800]}
    begin = time.perf_counter()
    camsim.sweep({"scene": "slanted-edge", "set": {"region": REGION}, "vary": vary}, folder / "alike")
    swept = (time.perf_counter() - begin) / count
    print(f"256², seed and ISO: {one:.2f} s a process, {1e3 * swept:.1f} ms in a sweep of {count}: {one / swept:.1f} ×")


def _workers(folder: Path, count: int) -> None:
    study = {"scene": "slanted-edge", "set": {"region": LARGE}, "vary": {"lens.f_number": {"linear": [4, 16, count]}}}
    seconds = {}
    for workers in (1, min(2, os.cpu_count() or 1)):
        begin = time.perf_counter()
        swept = camsim.sweep(study, folder / f"by{workers}", workers=workers)
        seconds[workers] = time.perf_counter() - begin
        print(f"1024², {count} f-numbers, {workers} workers: {seconds[workers]:.1f} s")
        alone = sum(row["seconds"] for row in swept.rows)
        print(f"  in captures {alone:.1f} s: overhead {100 * (seconds[workers] * workers / alone - 1):.1f} %")
    print(f"two workers: {seconds[1] / seconds[max(seconds)]:.2f} × one")


if __name__ == "__main__":
    main()
