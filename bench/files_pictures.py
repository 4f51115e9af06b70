"""The pictures of docs/files.md: one DNG as five developers show it, and a pair with its truth.

python bench/files_pictures.py   (after make test-clients has installed the programs)
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

import camsim
from camsim.sensor.colour_matrix import as_shot_neutral

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "clients")]

XYZ_TO_SRGB = np.array(
    [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]]
)
WIDTH = 150


def srgb(xyz: np.ndarray) -> Image.Image:
    linear = np.clip(xyz @ XYZ_TO_SRGB.T, 0, 1)
    curve = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return Image.fromarray(np.rint(255 * curve).astype(np.uint8))


def labelled(pictures: dict[str, Image.Image]) -> Image.Image:
    """Return the pictures side by side, their names below."""
    height = max(picture.height for picture in pictures.values())
    sheet = Image.new("RGB", (len(pictures) * (WIDTH + 6) - 6, height + 16), "white")
    draw = ImageDraw.Draw(sheet)
    for k, (name, picture) in enumerate(pictures.items()):
        sheet.paste(picture, (k * (WIDTH + 6), 0))
        draw.text((k * (WIDTH + 6) + 2, height + 2), name, fill="black")
    return sheet


def developers() -> Image.Image:
    """Develop one ColorChecker with every program that develops."""
    from raw_programs import PROGRAMS

    from tests.colorchecker import chart

    pictures = {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.dng"
        camsim.save(chart(300, 446), path)
        for program in PROGRAMS:
            one = Path(folder) / program.name
            one.mkdir()
            xyz = program.picture(path, one)
            if xyz is not None:
                displayed = srgb(xyz)
                pictures[program.name] = displayed.resize((WIDTH, round(WIDTH * displayed.height / displayed.width)))
    return labelled(pictures)


def pair() -> Image.Image:
    """Show a noisy and a clean mosaic, and the truth, eight times enlarged or so."""
    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0))
    pitch_um = camera.pitch_um
    shapes = [
        camsim.Disc(radius_um=r * pitch_um, centre_um=(-4 * pitch_um, 2.0), reflectance=camsim.reflectance(name))
        for r, name in ((13, "orange"), (9, "blue sky"), (5, "yellow"), (2, "white 9.5"))
    ]
    settings = {
        "light": camsim.Light("D55", illuminance_lux=1500.0),
        "exposure": camsim.Exposure(time_s=0.02, iso=800.0),
        "region": camsim.Region(rows=25, cols=30),
        "products": ("mosaic", "truth"),
    }
    scene = camsim.Scene(background=0.2, shapes=shapes)
    noisy, clean = camera.expose(scene, **settings), camera.expose(scene, noise=False, **settings)
    white_e = noisy.electrons_per_dn * (noisy.white_level_dn - noisy.black_level_dn) / 3

    def displayed(linear: np.ndarray) -> Image.Image:
        grey = np.rint(255 * np.clip(linear, 0, 1) ** (1 / 2.2)).astype(np.uint8)
        return Image.fromarray(grey).convert("RGB").resize((WIDTH, 125), Image.Resampling.NEAREST)

    def codes(frame: camsim.Frame) -> np.ndarray:
        return frame.signal_e / white_e

    neutral = as_shot_neutral(noisy.colour)
    return labelled(
        {
            "noisy": displayed(codes(noisy)),
            "clean": displayed(codes(clean)),
            "truth": displayed(clean.truth / white_e / neutral),
        }
    )


def main() -> None:
    for name, picture in (("files-developers", developers()), ("files-pair", pair())):
        path = ROOT / "docs" / f"{name}.png"
        picture.save(path, optimize=True)
        print(f"{path.relative_to(ROOT)}: {path.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
