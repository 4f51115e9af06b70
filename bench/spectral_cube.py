"""A spectral cube of 3008 × 2000 × 31 float32 written as EXR: time and peak memory, read back by OpenEXR.

python bench/spectral_cube.py [ROWS COLS]
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

MOST_MB = 400

WRITE = """
import resource, sys, time
import camsim
rows, cols, path = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0))
pitch_um = camera.pitch_um
shapes = [
    camsim.Rectangle(width_um=1200 * pitch_um, height_um=1200 * pitch_um, rotate_deg=4.0, reflectance=0.05),
    camsim.Disc(radius_um=300 * pitch_um, centre_um=(900 * pitch_um, 0.0), reflectance=camsim.reflectance("orange")),
]
began = time.perf_counter()
frame = camera.expose(
    camsim.Scene(background=0.9, shapes=shapes),
    light=camsim.Light("D55", illuminance_lux=5000.0),
    exposure=camsim.Exposure(time_s=0.01, iso=200.0),
    region=camsim.Region(rows=rows, cols=cols),
    products=("spectral",),
    tolerance=1e-4,
    noise=False,
)
exposed = time.perf_counter()
camsim.save(frame, path, product="spectral")
print(f"capture {exposed - began:.1f} s, cube {time.perf_counter() - exposed:.1f} s")
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6)
"""


def main() -> None:
    import numpy as np
    import OpenEXR

    rows, cols = (int(word) for word in sys.argv[1:3]) if len(sys.argv) > 2 else (2000, 3008)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "cube.exr"
        answer = subprocess.run(
            [sys.executable, "-c", WRITE, str(rows), str(cols), str(path)], capture_output=True, text=True, check=True
        )
        took, peak = answer.stdout.splitlines()
        began = time.perf_counter()
        channels = OpenEXR.File(str(path), separate_channels=True).channels()
        print(f"{rows} × {cols} × {len(channels)}: {took}; {path.stat().st_size / 1e6:.0f} MB on disk")
        print(f"read by OpenEXR in {time.perf_counter() - began:.1f} s")
        assert all(np.isfinite(channel.pixels).all() and channel.pixels.max() > 0 for channel in channels.values())
        print(f"peak memory {float(peak):.0f} MB (asked: {MOST_MB})")
        sys.exit(float(peak) > MOST_MB)


if __name__ == "__main__":
    main()
