"""A spectral cube of 3008 × 2000 × 31 float32 written as EXR by ``camsim capture``: time and peak memory, read back.

python bench/spectral_cube.py [ROWS COLS]

OpenEXR's Python module reads every channel; a plane rendered again must come back bit for bit, and exrheader (Debian's
openexr) must show the layout's attributes.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import OpenEXR

import camsim
from camsim.api import load

MOST_MB = 400
AGAIN_NM = (400.0, 550.0, 700.0)

SCENE = """\
camsim: scene/1
sensor: d40-like
lens: {{kind: airy, f_number: 8}}
light: {{illuminant: D55, illuminance_lux: 5000}}
exposure: {{time_s: 0.01, iso: 200}}
region: {{rows: {rows}, cols: {cols}}}
scene:
  unit: pixel
  background: {{reflectance: 0.9}}
  shapes:
    - {{kind: rectangle, width: 1200, height: 1200, rotate_deg: 4, reflectance: 0.05}}
    - {{kind: disc, radius: 300, centre: [900, 0], reflectance: orange}}
render: {{tolerance: 1e-4}}
"""


def peak_mb(command: list[str | Path]) -> float:
    """Run a command and return the most memory that it held."""
    pid = os.posix_spawn(command[0], [str(word) for word in command], os.environ)
    _, status, usage = os.wait4(pid, 0)
    if status:
        sys.exit(f"{' '.join(map(str, command))} failed")
    return usage.ru_maxrss * 1024 / 1e6


def wrong_planes(path: Path, scene: Path) -> list[float]:
    """Return the wavelengths whose channel is not, bit for bit, the plane as rendered again."""
    frame = load(scene, products=("spectral",)).rows(lambda codes: None, products=("spectral",))
    assert frame.spectral is not None
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    wrong = []
    for wavelength_nm in AGAIN_NM:
        plane, _ = frame.spectral.plane(frame.spectral.wavelength_nm.index(wavelength_nm))
        if not np.array_equal(channels[f"S0.{wavelength_nm:.0f},000000nm"].pixels, plane):
            wrong.append(wavelength_nm)
    return wrong


def main() -> None:
    rows, cols = (int(word) for word in sys.argv[1:3]) if len(sys.argv) > 2 else (2000, 3008)
    exrheader = shutil.which("exrheader")
    assert exrheader, "exrheader is missing: install Debian's package openexr"
    with tempfile.TemporaryDirectory() as folder:
        scene, path = Path(folder) / "cube.yaml", Path(folder) / "cube.exr"
        capture: list[str | Path] = [Path(sys.executable).with_name("camsim"), "capture"]
        # Once on a machine the kernels are compiled, which takes memory of its own.
        peak_mb([*capture, "slanted-edge", "-q", "-o", Path(folder) / "first.dng"])
        scene.write_text(SCENE.format(rows=rows, cols=cols))
        began = time.perf_counter()
        peak = peak_mb([*capture, scene, "-q", "-o", f"{path}:spectral"])
        print(f"{rows} × {cols}: {time.perf_counter() - began:.0f} s, {path.stat().st_size / 1e6:.0f} MB on disk")
        header = subprocess.run([exrheader, path], capture_output=True, text=True, check=True).stdout
        displayed = {
            "spectralLayoutVersion": 'spectralLayoutVersion (type string): "1.0"',
            "emissiveUnits": 'emissiveUnits (type string): "W.m^-2.sr^-1.nm^-1"',
            "record": "camsim:record (type string)",
            "channels": "S0.700,000000nm, 32-bit floating-point",
        }
        missing = [name for name, line in displayed.items() if line not in header]
        print(f"exrheader shows {len(displayed) - len(missing)} of {len(displayed)} attributes")
        wrong = wrong_planes(path, scene)
        print(f"OpenEXR reads back {len(AGAIN_NM) - len(wrong)} of {len(AGAIN_NM)} planes exactly")
        print(f"peak memory {peak:.0f} MB (asked: {MOST_MB}), camsim {camsim.__version__}")
        sys.exit(bool(missing or wrong or peak > MOST_MB))


if __name__ == "__main__":
    main()
