"""Five photographs captured and developed, beside the photographs themselves: docs/pictures/captured.jpg.

python bench/photographs.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

import camsim
from camsim.camera.frame import Frame

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "pictures"
NAMES = ("astronaut", "cat", "coffee", "rocket", "hubble")
HEIGHT, QUALITY = 240, 85  # of the page's pictures


def captured(path: Path) -> Frame:
    """Expose a photograph, a sample a photosite, through an f/8 lens and an OLPF, in daylight, with noise."""
    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0))
    with Image.open(path) as image:
        cols, rows = (size - size % 2 for size in image.size)
    picture = camsim.read_picture(path, width_um=camera.pitch_um * cols)
    return camera.expose(
        camsim.Scene(background=0.0, shapes=[picture]),
        light=camsim.Light("D65", illuminance_lux=1000.0),
        exposure=camsim.Exposure(time_s="auto", iso=200.0),
        region=camsim.Region(rows=rows, cols=cols),
        seed=1,
        tolerance=1e-4,
    )


def main() -> None:
    rows: list[list[Image.Image]] = [[], []]
    for name in NAMES:
        path = FOLDER / f"{name}.jpg"
        frame = captured(path)
        print(f"{name}: error {frame.report.error_estimate:.1e} of 1e-4")
        camsim.save(frame, FOLDER / f"{name}-again.png", force=True)
        with Image.open(path) as photograph, Image.open(FOLDER / f"{name}-again.png") as developed:
            for line, image in zip(rows, (photograph, developed), strict=True):
                size = round(image.width * HEIGHT / image.height), HEIGHT
                line.append(image.convert("RGB").resize(size, Image.Resampling.LANCZOS))
        (FOLDER / f"{name}-again.png").unlink()
    lines = [np.concatenate([np.asarray(image) for image in line], axis=1) for line in rows]
    width = min(line.shape[1] for line in lines)
    Image.fromarray(np.concatenate([line[:, :width] for line in lines])).save(
        FOLDER / "captured.jpg", quality=QUALITY, optimize=True
    )


if __name__ == "__main__":
    main()
