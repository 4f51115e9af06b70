"""Large frames straight into a DNG: seconds and peak memory of ``camsim capture``, a process of its own each.

``python -m bench.large_frames [chart] [photograph] [gradient] [large-photograph]`` takes 45 and 150 megapixels of each;
``--megapixels 6 45 150`` others, and ``--tolerance`` other than 1e-5. The photograph has 512² samples however large the
frame is, the large one a sample for every photosite, which takes memory of its own: it is the scene's, and is printed.
"""

from __future__ import annotations

import argparse
import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

PICTURE = Path(__file__).resolve().parents[1] / "docs" / "pictures" / "astronaut.jpg"
SCENE = """
camsim: scene/1
sensor: d40-like
lens: {{kind: airy, f_number: 8}}
light: {{illuminant: D55, illuminance_lux: 2000}}
exposure: {{time_s: auto, iso: 200}}
scene:
  unit: pixel
  background: {{reflectance: 0.2}}
  shapes: [{shape}]
"""
SHAPES = {
    "chart": "{{kind: chart, name: e-sfr, height: {height}}}",
    "photograph": "{{kind: picture, file: picture.png, width: {height}}}",
    "gradient": "{{kind: linear-gradient, width: {width}, height: {height}, low: 0.1, high: 0.9}}",
    "large-photograph": "{{kind: picture, file: picture.png, width: {width}}}",
}
FILLED = 0.95  # of the frame's height


def main() -> None:
    """Print a line for each kind and size."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kinds", nargs="*", default=list(SHAPES), help=", ".join(SHAPES))
    parser.add_argument("--megapixels", nargs="+", type=float, default=[45.0, 150.0])
    parser.add_argument("--tolerance", type=float, default=1e-5)
    options = parser.parse_args()
    for kind in options.kinds:
        for megapixels in options.megapixels:
            rows, cols = _size(megapixels)
            with tempfile.TemporaryDirectory() as folder:
                samples = _write(Path(folder), kind, rows, cols)
                seconds, peak_mb = _captured(Path(folder), rows, cols, options.tolerance)
            stated = f", samples {samples / 1e6:.0f} MB of 8 bits" if kind == "large-photograph" else ""
            print(
                f"{kind}, {megapixels:g} MP at {options.tolerance:g}: {seconds:.1f} CPU s, {peak_mb:.0f} MB{stated}",
                flush=True,
            )


def _size(megapixels: float) -> tuple[int, int]:
    """Return even rows and columns, 2 : 3."""
    rows = 2 * round(math.sqrt(megapixels * 1e6 / 1.5) / 2)
    return rows, 2 * round(1.5 * rows / 2)


def _write(folder: Path, kind: str, rows: int, cols: int) -> int:
    """Write the scene and its picture; return the bytes of the picture's samples."""
    shape = SHAPES[kind].format(height=FILLED * rows, width=FILLED * cols)
    (folder / "large.yaml").write_text(SCENE.format(shape=shape), encoding="utf-8")
    if "photograph" not in kind:
        return 0
    with Image.open(PICTURE) as image:
        size = (cols, rows) if kind.startswith("large") else (512, 512)
        samples = np.asarray(image.convert("RGB").resize(size))
    Image.fromarray(samples).save(folder / "picture.png")
    return samples.nbytes


def _captured(folder: Path, rows: int, cols: int, tolerance: float) -> tuple[float, float]:
    """Return the CPU seconds and the peak memory of one capture."""
    words = [
        sys.executable,
        "-m",
        "camsim",
        "capture",
        str(folder / "large.yaml"),
        "-q",
        "-o",
        str(folder / "large.dng"),
    ]
    sets = [f"sensor.frame.rows={rows}", f"sensor.frame.cols={cols}", f"render.tolerance={tolerance}"]
    words += [word for one in sets for word in ("--set", one)]
    process = subprocess.Popen(words)
    _, status, used = os.wait4(process.pid, 0)
    if status:
        sys.exit(f"camsim capture ended with {os.waitstatus_to_exitcode(status)}")
    return used.ru_utime + used.ru_stime, used.ru_maxrss / (1e3 if sys.platform == "linux" else 1e6)


if __name__ == "__main__":
    main()
