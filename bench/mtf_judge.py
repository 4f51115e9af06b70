"""Another program as judge: quickMTF (from Carl Asplund's sfr) beside ours and theory, on the same noise-free images.

    python -m pip install quickMTF matplotlib && python bench/mtf_judge.py

quickMTF bins the projected photosites at 4 × oversampling, differentiates, and multiplies the line spread by a narrow
Hann window. The window narrows every line spread, the more the wider it is (it reads high on blurred edges, most of all
on an Airy pattern's far tail at large f-numbers); the bins' own width, which it does not correct, lowers sharp ones.
``no tail`` is our figure without the tail's correction.
"""

from __future__ import annotations

import math

import numpy as np
from quickMTF.SFR_MTF import sfr_mtfcal

import camsim
from camsim.measure import Plane, Roi, measure_edge

ROWS, COLS, ANGLE_DEG = 128, 96, 5.0
PITCH_UM, WAVELENGTH_NM = 4.88, 550.0


def edge_image(lens: camsim.Airy | camsim.Gaussian) -> np.ndarray:
    far, turn = 1e5, math.radians(ANGLE_DEG)
    half_plane = camsim.Rectangle(
        width_um=far,
        height_um=4 * far,
        rotate_deg=ANGLE_DEG,
        centre_um=(0.5 * far * math.cos(turn), 0.5 * far * math.sin(turn)),
        reflectance=0.9,
    )
    return camsim.render(
        camsim.Scene(background=0.05, shapes=[half_plane]),
        [lens, camsim.SquarePhotosite(side_um=PITCH_UM)],
        camsim.Grid(rows=ROWS, cols=COLS, pitch_um=PITCH_UM),
        wavelength_nm=WAVELENGTH_NM,
    ).image


def mtf50_of(frequency: np.ndarray, mtf: np.ndarray) -> float:
    first = int(np.argmax(mtf < 0.5))
    return float(np.interp(0.5, mtf[first - 1 : first + 1][::-1], frequency[first - 1 : first + 1][::-1]))


def theory_mtf50(lens: camsim.Airy | camsim.Gaussian) -> float:
    frequency = np.linspace(0.0, 1.0, 100_001)
    fx = frequency / PITCH_UM * math.cos(math.radians(ANGLE_DEG))
    fy = frequency / PITCH_UM * math.sin(math.radians(ANGLE_DEG))
    photosite = camsim.SquarePhotosite(side_um=PITCH_UM)
    return mtf50_of(frequency, np.abs(lens.otf(fx, fy, WAVELENGTH_NM) * photosite.otf(fx, fy, WAVELENGTH_NM)))


def main() -> None:
    lenses = {
        "Gaussian, MTF50 0.2": camsim.Gaussian.from_mtf50(0.2 / PITCH_UM),
        **{f"Airy f/{n:g}": camsim.Airy(f_number=n) for n in (2.8, 5.6, 8.0, 16.0, 32.0)},
    }
    print(f"{'lens':20} {'theory':>8} {'ours':>9} {'no tail':>9} {'quickMTF':>9}   (MTF50, off theory by %)")
    for name, lens in lenses.items():
        image, theory = edge_image(lens), theory_mtf50(lens)
        plane, roi = Plane(name="Y", samples=image), Roi(0, 0, ROWS, COLS)
        ours = measure_edge(plane, roi).figures.mtf50_cycles_per_pixel
        plain = measure_edge(plane, roi, tail=False).figures.mtf50_cycles_per_pixel
        table, _ = sfr_mtfcal().calc_sfr(image, oversampling=4)
        other = mtf50_of(table[:, 0], table[:, 1])
        off = [f"{100 * (value / theory - 1):+9.3f}" for value in (ours, plain, other)]
        print(f"{name:20} {theory:8.4f} {' '.join(off)}")


if __name__ == "__main__":
    main()
