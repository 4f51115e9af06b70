"""Two checkouts in turns: what a change did to the speed, as ratios of CPU seconds with their spread.

``python bench/turns.py OTHER_CHECKOUT [TURNS]``: the other one is "before". Each has a process of its own that stays;
in every turn a case is taken by both, the quicker of several laps each, so that a busy machine is busy for both. Only
public names are used. A ratio is after over before: below 1 is quicker.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

LAPS = 3
SCENES = ("slanted-edge", "colorchecker", "flat-field", "knife-edge", "paper-square")
WINDOW = ("region.rows=446", "region.cols=446", "region.origin=null")


def cases() -> dict[str, Callable[[], Any]]:
    """Return what is clocked, by name."""
    import numpy as np

    import camsim

    box, pitch_um = camsim.SquarePhotosite(side_um=4.88), 4.88
    olpf = camsim.FourSpotOlpf(split_um=3.66)
    square = camsim.Rectangle(width_um=200 * pitch_um, height_um=200 * pitch_um, rotate_deg=4.0, reflectance=0.0)
    rng = np.random.default_rng(3)
    places, sides = rng.uniform(-1200.0, 1200.0, (2000, 2)), rng.uniform(5.0, 20.0, 2000)
    crowd = [
        camsim.Rectangle(width_um=side, height_um=side, centre_um=(x, y), rotate_deg=90.0 * k / 2000, reflectance=0.2)
        for k, ((x, y), side) in enumerate(zip(places.tolist(), sides.tolist(), strict=True))
    ]
    disc = camsim.Disc(radius_um=100 * pitch_um, reflectance=0.0)

    def rendering(lens: Any, tolerance: float, method: str = "auto", size: int = 446, **more: Any) -> Callable[[], Any]:
        scene = camsim.Scene(background=1.0, shapes=more.get("shapes", [square]))
        optics = [lens, *more.get("more", ()), more.get("photosite", box)]
        grid = camsim.Grid(rows=size, cols=more.get("cols", size), pitch_um=pitch_um)
        nm = more.get("nm", 550.0)
        return lambda: camsim.render(scene, optics, grid, wavelength_nm=nm, tolerance=tolerance, method=method)

    airy = camsim.Airy(f_number=8.0)
    found = {
        **{f"square, f/8, boundary {t:g}": rendering(airy, t, "boundary") for t in (1e-4, 1e-6, 1e-9)},
        **{f"square, f/8, fourier {t:g}": rendering(airy, t, "fourier") for t in (1e-6, 1e-9)},
        "square, f/8, OLPF 1e-6": rendering(airy, 1e-6, more=[olpf]),
        "square, f/2 1e-6": rendering(camsim.Airy(f_number=2.0), 1e-6),
        "square, Gaussian 1e-6": rendering(camsim.Gaussian(sigma_um=4.0), 1e-6),
        "square, annular 1e-6": rendering(camsim.AnnularAiry(f_number=8.0, obstruction=0.3), 1e-6),
        "square, round photosite 1e-6": rendering(airy, 1e-6, photosite=camsim.CircularPhotosite(diameter_um=4.88)),
        "square, three wavelengths 1e-6": rendering(airy, 1e-6, nm=[450.0, 550.0, 650.0]),
        "disc, f/8 1e-6": rendering(airy, 1e-6, shapes=[disc]),
        "2000 squares, f/8 1e-5": rendering(airy, 1e-5, shapes=crowd, size=512),
        "square, wavefront 64 × 64 1e-4": rendering(
            camsim.Wavefront(f_number=8.0, zernike_waves=((12, 0.1),)), 1e-4, size=64
        ),
        "square, 3008 × 2000 1e-6": rendering(airy, 1e-6, size=2000, cols=3008),
    }
    for scene in SCENES:
        found[f"capture {scene}"] = lambda scene=scene: camsim.capture(scene, overrides=list(WINDOW))
    return found


def worker() -> None:
    """Take orders: a case's name a line; say its CPU seconds."""
    known = cases()
    for line in sys.stdin:
        work, seconds = known[line.strip()], []
        for _ in range(LAPS):
            begun = time.process_time()
            work()
            seconds.append(time.process_time() - begun)
        print(json.dumps(min(seconds)), flush=True)


def begin(checkout: Path) -> subprocess.Popen[str]:
    """Start a worker that imports camsim from a checkout."""
    environment = os.environ | {"PYTHONPATH": str(checkout), "OMP_WAIT_POLICY": "PASSIVE"}
    return subprocess.Popen(
        [sys.executable, __file__, "--worker"],
        cwd=checkout,
        env=environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


def seconds_of(process: subprocess.Popen[str], name: str) -> float:
    """Have a case taken."""
    assert process.stdin is not None
    assert process.stdout is not None
    print(name, file=process.stdin, flush=True)
    return float(json.loads(process.stdout.readline()))


def main() -> None:
    """Print a line for every case: seconds before and after, the median of the ratios, the least and the largest."""
    here, other = Path(__file__).resolve().parents[1], Path(sys.argv[1]).resolve()
    turns = int(sys.argv[2]) if len(sys.argv) > 2 else 5
    before, after = begin(other), begin(here)
    print("| case | before, CPU s | after | after / before | spread |\n|---|---|---|---|---|")
    for name in cases():
        seconds_of(before, name), seconds_of(after, name)  # kernels are there from now on
        pairs = [(seconds_of(before, name), seconds_of(after, name)) for _ in range(turns)]
        ratios = [b / a for a, b in pairs]
        least, most = (min(column) for column in zip(*pairs, strict=True))
        print(
            f"| {name} | {least:.3g} | {most:.3g} | {statistics.median(ratios):.2f} | "
            f"{min(ratios):.2f} … {max(ratios):.2f} |",
            flush=True,
        )


if __name__ == "__main__":
    worker() if "--worker" in sys.argv else main()
