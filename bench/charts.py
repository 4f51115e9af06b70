"""How long charts take, warm: ``python -m bench.charts [siemens-star] [dead-leaves]``; promised for 2 cores.

A star of 144 cycles at 1e-6 on 1024 × 1024 photosites, and dead leaves of 20 000 discs at 1e-4 on 3008 × 2000
photosites behind a Bayer filter.
"""

from __future__ import annotations

import argparse
import resource
import time
from collections.abc import Callable

import camsim

PITCH_UM = 4.88
LENS = camsim.Airy(f_number=5.6)


def siemens_star() -> str:
    star = camsim.charts.siemens_star(radius_um=500.0 * PITCH_UM, cycles=144, light=0.9)
    found = camsim.render(
        camsim.Scene(background=0.5, shapes=[star]),
        [LENS, camsim.SquarePhotosite(side_um=PITCH_UM)],
        camsim.Grid(rows=1024, cols=1024, pitch_um=PITCH_UM),
        wavelength_nm=550.0,
        tolerance=1e-6,
    )
    return f"{found.method}, error {found.error_estimate:.1e}"


def dead_leaves() -> str:
    camera = camsim.Camera.from_yaml("d40-like", lens=LENS)
    leaves = camsim.charts.dead_leaves(
        width_um=3008.0 * PITCH_UM,
        height_um=2000.0 * PITCH_UM,
        least_radius_um=8.0 * PITCH_UM,
        largest_radius_um=400.0 * PITCH_UM,
        discs=20_000,
        seed=1,
    )
    frame = camera.expose(
        camsim.Scene(background=0.35, shapes=[leaves]),
        light=camsim.Light("D65", illuminance_lux=2000.0),
        exposure=camsim.Exposure(time_s="auto", iso=200.0),
        tolerance=1e-4,
        seed=1,
    )
    return f"{frame.report.method}, error {frame.report.error_estimate:.1e}"


CASES: dict[str, Callable[[], str]] = {"siemens-star": siemens_star, "dead-leaves": dead_leaves}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", choices=[[], *CASES], help="only these")
    parser.add_argument("--runs", type=int, default=2, help="the first one compiles")
    chosen = parser.parse_args()
    for name in chosen.names or CASES:
        for _ in range(chosen.runs):
            began, worked = time.perf_counter(), time.process_time()
            said = CASES[name]()
            seconds, of_cores = time.perf_counter() - began, time.process_time() - worked
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
            print(f"{name:13} {seconds:7.2f} s, {of_cores:7.2f} s of all cores, peak {peak:.2f} GB; {said}", flush=True)


if __name__ == "__main__":
    main()
