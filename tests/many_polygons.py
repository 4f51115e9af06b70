"""Random scenes of several polygons that overlap, sheer past the frame and have spectra; the same for every test."""

from __future__ import annotations

import numpy as np

import camsim

OUTLINES = (
    [(-1, -1), (1, -1), (1, 1), (-1, 1)],
    [(-1, -0.7), (1.2, -0.5), (0.1, 0.9)],
    [(-1, -0.8), (1, 0), (-1, 0.8), (-0.3, 0)],
    [(-1, -0.02), (1, 0), (-1, 0.03)],
)


def random_scene(rng: np.random.Generator, *, size_um: float, spectral: bool) -> camsim.Scene:
    """Background and polygons about a frame of ``size_um``: three to six grey ones, or two with curves of their own."""

    def surface() -> float | camsim.Curve:
        if not spectral:
            return float(rng.uniform())
        return camsim.Curve((400.0, 550.0, 700.0), tuple(rng.uniform(size=3)), outside="hold")

    shapes = []
    for _ in range(2 if spectral else rng.integers(3, 7)):
        outline = np.array(OUTLINES[rng.integers(len(OUTLINES))]) * size_um * 10 ** rng.uniform(-1.3, -0.2)
        angle = rng.uniform(0, 2 * np.pi)
        outline = outline @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        points = outline + rng.uniform(-0.6, 0.6, 2) * size_um
        shapes.append(camsim.Polygon(points_um=tuple(map(tuple, points.tolist())), reflectance=surface()))
    return camsim.Scene(background=surface(), shapes=shapes)


def three_channels(wavelength_nm: np.ndarray) -> np.ndarray:
    """(3, n) made-up sensitivities, the sum of each 1."""
    centres, widths = np.array([[620.0], [540.0], [460.0]]), np.array([[40.0], [45.0], [35.0]])
    response = np.exp(-(((wavelength_nm - centres) / widths) ** 2))
    return response / response.sum(axis=1, keepdims=True)


def bayer(rows: int, cols: int) -> np.ndarray:
    """Channel index of every photosite, RGGB."""
    return np.tile(np.array([[0, 1], [1, 2]], np.uint8), (rows // 2 + 1, cols // 2 + 1))[:rows, :cols].copy()
