"""Exact edges in closed form, for judging measurements without the renderer. Imports nothing of camsim."""

from __future__ import annotations

import math

import numpy as np
from scipy import special
from scipy.interpolate import CubicSpline


def gaussian_edge(
    rows, cols, angle_deg, sigma_px, *, dark=0.1, bright=0.9, shift_px=0.3, step=1, first=(0, 0), bend=0.0
):
    """Samples (rows/step, cols/step) of a straight edge blurred by a Gaussian, dark on the left at 0°.

    angle_deg turns the edge clockwise as displayed about the middle; bend is its curvature, 1/px.
    """
    y = first[0] + 0.5 + step * np.arange(-(-(rows - first[0]) // step))
    x = first[1] + 0.5 + step * np.arange(-(-(cols - first[1]) // step))
    x, y = np.meshgrid(x - 0.5 * cols, y - 0.5 * rows)
    turn = math.radians(angle_deg)
    across = x * math.cos(turn) + y * math.sin(turn) - shift_px
    along = y * math.cos(turn) - x * math.sin(turn)
    return dark + (bright - dark) * special.ndtr((across - 0.5 * bend * along**2) / sigma_px)


def gaussian_mtf(frequency, sigma_px):
    return np.exp(-2.0 * (np.pi * sigma_px * np.asarray(frequency)) ** 2)


def gaussian_limit(level, sigma_px):
    """Frequency at which the MTF is ``level``."""
    return math.sqrt(-math.log(level) / 2.0) / (math.pi * sigma_px)


def gaussian_sigma(mtf50):
    return math.sqrt(math.log(2.0) / 2.0) / (math.pi * mtf50)


def pupil_edge(size, angle_deg, transfer, cutoff_per_px, *, dark=0.05, bright=0.95, shift_px=-0.13):
    """Samples (size, size) of an edge by its transfer along the normal, (m,) cycles/px → complex, and its MTF50."""
    x, w = np.polynomial.legendre.leggauss(600)
    f = 0.5 * cutoff_per_px * (1.0 + x)
    otf, turn = transfer(f), math.radians(angle_deg)
    row, col = np.mgrid[:size, :size] + 0.5 - 0.5 * size
    d = np.linspace(-size, size, 64 * size + 1)
    turns = 2.0 * np.pi * np.multiply.outer(d, f)
    # ∫ Im(otf·exp(2πi·f·d))/πf: the integral over the line spread, less a half
    share = 0.5 + (np.sin(turns) * otf.real + np.cos(turns) * otf.imag) @ (w / (1.0 + x)) / np.pi
    across = col * math.cos(turn) + row * math.sin(turn) - shift_px
    fine = np.linspace(0.0, cutoff_per_px, 20_001)
    mtf = np.abs(CubicSpline(f, otf)(fine))
    k = int(np.argmax(mtf < 0.5))
    mtf50 = float(np.interp(0.5, mtf[[k, k - 1]], fine[[k, k - 1]]))
    return dark + (bright - dark) * CubicSpline(d, share)(across), mtf50


ABERRATED = {  # waves of Zernikes, which throw light far from an edge
    "defocus 0.3": {4: 0.3},
    "defocus 0.2, coma 0.15": {4: 0.2, 8: 0.15},
    "spherical 0.2, coma 0.1": {12: 0.2, 8: 0.1},
    "coma 0.2, astigmatism 0.2": {8: 0.2, 5: 0.2},
}


def drawn_edge(rng):
    """A sharp edge in a small region of one Bayer channel: samples, their first place, region, what is true of it."""
    rows, cols = (int(n) for n in 2 * rng.integers(10, 25, 2))
    angle = float(rng.uniform(1.0, 44.0) * rng.choice((-1.0, 1.0)))
    lying = bool(rng.integers(2))
    sigma, snr = gaussian_sigma(float(rng.uniform(0.25, 0.6))), float(np.exp(rng.uniform(math.log(20), math.log(1000))))
    first = int(rng.integers(2)), int(rng.integers(2))
    shift = float(rng.uniform(-2, 2))
    image = gaussian_edge(rows, cols, angle + 90.0 * lying, sigma, shift_px=shift, step=2, first=first)
    samples = image + rng.normal(0.0, 0.8 / snr, image.shape)
    # 2·1.2816·σ: a Gaussian's 10 and 90 % points.
    figures = {
        "angle_deg": angle,
        "mtf50_cycles_per_pixel": gaussian_limit(0.5, sigma),
        "rise_10_90_pixel": 2.5631 * sigma,
    }
    return samples, first, (rows, cols), figures | {"snr": snr}
