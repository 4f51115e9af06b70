"""The paper's benchmark square: camsim against GalSim in one run, at a true error below the tolerance.

446 × 446 photosites of 4.88 µm, a black square of 250 px turned by 4°, Airy f/8 at 550 nm. Set-up and spot check are
included and every repetition has an f-number that no cache has seen; kernels are compiled before. The true error is
taken against an exact Fourier rendering that shares nothing with either program (tests/fourier_truth.py, to 1e-11).
GalSim lives in a process of its own, because importing it tells OpenMP to use one thread everywhere; it draws boxes
only, and is timed inside its process.

    python -m pip install galsim && python -m bench.paper_square
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from importlib.metadata import version
from multiprocessing import get_context

import numpy as np

import camsim
from tests.fourier_truth import white_with_a_black_polygon

PITCH_UM, SIDE_PX, SIZE, TURN_DEG, WAVELENGTH_NM, F_NUMBER = 4.88, 250.0, 446, 4.0, 550.0, 8.0


def ours(tolerance: float, *, olpf: bool, f_number: float) -> camsim.Rendering:
    square = camsim.Rectangle(
        width_um=SIDE_PX * PITCH_UM, height_um=SIDE_PX * PITCH_UM, rotate_deg=TURN_DEG, reflectance=0.0
    )
    optics = [camsim.Airy(f_number=f_number), camsim.SquarePhotosite(side_um=PITCH_UM)]
    if olpf:
        optics.append(camsim.FourSpotOlpf(split_um=0.75 * PITCH_UM))
    return camsim.render(
        camsim.Scene(background=1.0, shapes=[square]),
        optics,
        camsim.Grid(rows=SIZE, cols=SIZE, pitch_um=PITCH_UM),
        wavelength_nm=WAVELENGTH_NM,
        tolerance=tolerance,
    )


def exactly(*, olpf: bool) -> np.ndarray:
    angle, half = np.deg2rad(TURN_DEG), 0.5 * SIDE_PX
    across = half * np.array([np.cos(angle), np.sin(angle)])
    down = half * np.array([-np.sin(angle), np.cos(angle)])
    square = [-across - down, across - down, across + down, -across + down]
    lambda_n = WAVELENGTH_NM * 1e-3 * F_NUMBER / PITCH_UM
    return white_with_a_black_polygon(square, SIZE, SIZE, lambda_n, side=1.0, split=0.75 if olpf else 0.0)


def galsim_image(folding_threshold: float, f_number: float) -> np.ndarray:
    import galsim

    params = galsim.GSParams(folding_threshold=folding_threshold, maximum_fft_size=32768)
    lam_over_diam = WAVELENGTH_NM * 1e-3 * f_number / PITCH_UM
    square = galsim.Box(SIDE_PX, SIDE_PX, flux=SIDE_PX**2, gsparams=params).rotate(TURN_DEG * galsim.degrees)
    scene = galsim.Convolve(square, galsim.Airy(lam_over_diam=lam_over_diam, gsparams=params), gsparams=params)
    image = galsim.ImageD(SIZE, SIZE)
    scene.drawImage(image=image, scale=1.0, method="auto")
    return 1.0 - image.array


def clock(run: Callable[[float], object], f_number: float) -> tuple[float, float]:
    wall, cpu = time.perf_counter(), time.process_time()
    run(f_number)
    return time.perf_counter() - wall, time.process_time() - cpu


def clock_galsim(folding_threshold: float, f_number: float) -> tuple[float, float]:
    return clock(partial(galsim_image, folding_threshold), f_number)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeat", type=int, default=9)
    parser.add_argument("--tolerance", type=float, default=1e-6)
    parser.add_argument("--folding-threshold", type=float, default=2e-4)
    arguments = parser.parse_args()

    tolerance, threshold = arguments.tolerance, arguments.folding_threshold
    exact = {olpf: exactly(olpf=olpf) for olpf in (False, True)}
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as other:
        theirs = other.submit(galsim_image, threshold, F_NUMBER).result()
        errors = [
            np.abs(ours(tolerance, olpf=False, f_number=F_NUMBER).image - exact[False]).max(),
            np.abs(ours(tolerance, olpf=True, f_number=F_NUMBER).image - exact[True]).max(),
            np.abs(theirs - exact[False]).max(),
        ]
        runs: dict[str, Callable[[float], tuple[float, float]]] = {
            "camsim, box": lambda n: clock(lambda m: ours(tolerance, olpf=False, f_number=m), n),
            "camsim, box + OLPF": lambda n: clock(lambda m: ours(tolerance, olpf=True, f_number=m), n),
            f"GalSim {version('galsim')}, box": lambda n: other.submit(clock_galsim, threshold, n).result(),
        }
        laps: list[list[tuple[float, float]]] = [[] for _ in runs]
        for k in range(arguments.repeat):  # in turn, so that a busy moment falls on all of them
            for lap, run in zip(laps, runs.values(), strict=True):
                lap.append(run(F_NUMBER * (1 + (k + 1) * 1e-11)))
    wall, cpu = (np.array([[t[i] for t in lap] for lap in laps]) for i in (0, 1))
    rows = []
    for i, name in enumerate(runs):
        rows.append(
            {
                "program": name,
                "wall_s": np.median(wall[i]),
                "cpu_s": np.median(cpu[i]),
                "max_error": errors[i],
            }
        )
        print(
            f"{name:24}  wall {1e3 * np.median(wall[i]):8.1f} ms  CPU {1e3 * np.median(cpu[i]):8.1f} ms  "
            f"true error {errors[i]:.1e}"
        )
    ratio = {
        "faster than GalSim, wall": float(np.median(wall[2] / wall[0])),
        "faster than GalSim, CPU": float(np.median(cpu[2] / cpu[0])),
        "OLPF costs": float(np.median(wall[1] / wall[0])),
    }
    for name, value in ratio.items():
        print(f"{name:24}  {value:.2f} ×   (median of {arguments.repeat} pairs)")
    print(json.dumps({"rows": rows, "ratios": ratio}, default=float))


if __name__ == "__main__":
    main()
