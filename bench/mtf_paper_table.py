"""The paper's Table II: MTF50 measured on edges of known blur, by the method that rendered them.

A Gaussian lens of MTF50 0.10–0.40 cycles/px on point photosites, an edge of 4°, 25 sub-pixel shifts, images rounded to
16 bits. Each entry is the mean |error| of MTF50 in per cent. The tool that made the paper's table measures its own
images to 0.1–3.4 %. ``closed form`` is the error function itself, made by no renderer.

    python bench/mtf_paper_table.py
"""

from __future__ import annotations

import argparse
import math
import os
import sys
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import numpy as np
from edges import gaussian_edge, gaussian_sigma

import camsim
from camsim.measure import Plane, Roi, measure_edge

MTF50S = (0.10, 0.15, 0.20, 0.25, 0.30, 0.35, 0.40)
METHODS = (
    ("uniform-pixel", None),
    ("uniform", None),
    ("importance", 121),
    ("importance", 2025),
    ("strips", None),
    ("boundary", None),
    ("closed form", None),
)
ROWS, COLS, ANGLE_DEG, DARK, BRIGHT = 96, 80, 4.0, 0.1, 0.9


def rendered(method: str, samples: int | None, mtf50: float, shift_px: float) -> np.ndarray:
    if method == "closed form":
        return gaussian_edge(ROWS, COLS, ANGLE_DEG, gaussian_sigma(mtf50), shift_px=shift_px, dark=DARK, bright=BRIGHT)
    far, turn = 4000.0, math.radians(ANGLE_DEG)
    reach = 0.5 * far + shift_px
    half_plane = camsim.Rectangle(
        width_um=far,
        height_um=2 * far,
        rotate_deg=ANGLE_DEG,
        centre_um=(reach * math.cos(turn), reach * math.sin(turn)),
        reflectance=BRIGHT,
    )
    return camsim.render(
        camsim.Scene(background=DARK, shapes=[half_plane]),
        [camsim.Gaussian.from_mtf50(mtf50), camsim.SquarePhotosite(side_um=0.0)],
        camsim.Grid(rows=ROWS, cols=COLS, pitch_um=1.0),
        wavelength_nm=550.0,
        method=method,
        samples=samples,
    ).image


def error_percent(image: np.ndarray, mtf50: float) -> float:
    codes = np.rint(65535.0 * np.clip(image, 0.0, 1.0)).astype(np.uint16)
    edge = measure_edge(Plane(name="Y", samples=codes), Roi(0, 0, ROWS, COLS))
    return 100.0 * abs(edge.figures.mtf50_cycles_per_pixel / mtf50 - 1.0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shifts", type=int, default=25)
    shifts = parser.parse_args().shifts
    print(
        f"mean |error| of MTF50 in %, {shifts} shifts".ljust(36)
        + "".join(f"{m:9.2f}" for m in MTF50S)
        + "     mean   seconds"
    )
    for method, samples in METHODS:
        began, means = time.perf_counter(), []
        for mtf50 in MTF50S:
            places = (np.arange(shifts) + 0.5) / shifts - 0.5
            means.append(np.mean([error_percent(rendered(method, samples, mtf50, p), mtf50) for p in places]))
        name = method if samples is None else f"{method}, {samples} samples"
        print(
            name.ljust(36)
            # What never falls to one half has no MTF50: edges on whole pixels are steps.
            + "".join(f"{m:9.4f}" if math.isfinite(m) else f"{'none':>9}" for m in means)
            + f"{np.mean(means):9.4f}{time.perf_counter() - began:9.1f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
