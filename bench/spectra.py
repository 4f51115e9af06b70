"""What integrating spectra costs and changes: shipped scenes with another checkout of camsim and with this one.

python bench/spectra.py OTHER_CHECKOUT [--pairs 5]

Prints, for every shipped scene, the seconds of a capture in both checkouts (of one core's own time; interleaved, the
quickest of each process, the median of the ratios of neighbours) and by how much its mean electrons differ, channel by
channel. Then what narrow curves take here.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import camsim
from camsim.api import load

SCENES = ("slanted-edge", "colorchecker", "flat-field", "knife-edge", "paper-square", "edge-chart")
WINDOW = ("region.rows=446", "region.cols=446", "region.origin=null", "noise.enabled=false")
LAPS = 5


def worker() -> None:
    """Print seconds and mean electrons of every scene, of the camsim that is imported."""
    found = {}
    for scene in SCENES:
        setup = load(scene, overrides=WINDOW)
        take = getattr(setup, "frame", None) or setup.expose  # as older checkouts have it
        frame, seconds = take(), []
        for _ in range(LAPS):
            begun = time.process_time()
            take()
            seconds.append(time.process_time() - begun)
        found[scene] = {"seconds": min(seconds), "mean_e": [signal.mean_e for signal in frame.report.signal]}
    print(json.dumps(found))


def run(checkout: Path) -> dict[str, dict[str, object]]:
    environment = os.environ | {"PYTHONPATH": str(checkout), "NUMBA_NUM_THREADS": "1"}
    command = [sys.executable, str(Path(__file__).resolve()), "--worker"]
    done = subprocess.run(command, env=environment, cwd=checkout, check=True, stdout=subprocess.PIPE, text=True)
    return json.loads(done.stdout)


def narrow() -> None:
    """Time captures with curves of very many points, whose nodes are lumped before anything is rendered."""
    rng = np.random.default_rng(0)
    for points in (41, 401, 4_001, 10_000, 40_001):
        nm = np.linspace(380.0, 780.0, points)
        surface = camsim.Curve(tuple(nm), tuple(0.5 + 0.1 * rng.uniform(-1.0, 1.0, points)))
        square = camsim.Rectangle(width_um=1220.0, height_um=1220.0, rotate_deg=4.0, reflectance=0.05)
        camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0))
        how = {
            "light": camsim.Light("D55", illuminance_lux=5000.0),
            "exposure": camsim.Exposure(time_s=0.01, iso=200.0),
            "region": camsim.Region(rows=446, cols=446),
        }
        scene, seconds = camsim.Scene(background=surface, shapes=[square]), []
        for _ in range(3):
            begun = time.process_time()
            frame = camera.expose(scene, **how)
            seconds.append(time.process_time() - begun)
        print(f"reflectance of {points} points: {min(seconds):.3f} s ({frame.report.wavelengths})")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("other", nargs="?", type=Path)
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--worker", action="store_true")
    given = parser.parse_args()
    if given.worker:
        worker()
        return
    if given.other is None:
        parser.error("name another checkout of camsim to compare with")
    here = Path(__file__).resolve().parents[1]
    runs = [(run(given.other.resolve()), run(here)) for _ in range(given.pairs)]
    for scene in SCENES:
        before, after = ([pair[k][scene] for pair in runs] for k in (0, 1))
        ratio = statistics.median(b["seconds"] / a["seconds"] for a, b in zip(before, after, strict=True))
        change = ", ".join(f"{b / a - 1:+.1e}" for a, b in zip(before[0]["mean_e"], after[0]["mean_e"], strict=True))
        quickest = [min(r["seconds"] for r in side) for side in (before, after)]
        print(f"{scene}: {quickest[0]:.4f} s → {quickest[1]:.4f} s, ratio {ratio:.3f}; mean electrons {change}")
    narrow()


if __name__ == "__main__":
    main()
