"""A ColorChecker photographed by a camera whose sensitivities are known: plain NumPy, tables of colour-science."""

from __future__ import annotations

import functools

import numpy as np

from camsim.measure.picture import Picture, mosaic_planes
from tests.colour_data import aligned, patches

NODES_NM = np.arange(380.0, 781.0, 5.0)
BLACK_DN, WHITE_DN, FULL_E = 512, 15512, 20_000.0
PATCH = 0.42
"""Half a patch's side, in distances between patches."""


def bells(*middles_nm: tuple[float, float, float]) -> np.ndarray:
    """Return (81, 3) curves, each a sum of one or two bells: a camera that nobody ships."""
    return np.stack([np.exp(-0.5 * ((NODES_NM - at) / width) ** 2) * high for at, width, high in middles_nm], axis=1)


CAMERA = bells((600.0, 32.0, 0.8), (535.0, 38.0, 1.0), (460.0, 28.0, 0.75))


def channels(sensitivities: np.ndarray, light: str) -> tuple[np.ndarray, np.ndarray]:
    """Return (24, 3) of the patches and (3,) of a perfect diffuser."""
    power = aligned("light", light)
    return (patches() * power) @ sensitivities, power @ sensitivities


def place(across: float, down: float, shape: tuple[int, int], turn_deg: float, width: float, tilt: float) -> np.ndarray:
    """Return row and column of a place in the chart, which ``photographed`` puts there."""
    angle, pitch = np.radians(turn_deg), width * shape[1] / 6.3
    u, v = (across - 3.0) * pitch, (down - 2.0) * pitch
    # z = 1 + tilt (x/cols + y/2rows) on the picture: solved for x and y.
    c, s = np.cos(angle), np.sin(angle)
    x, y = c * u - s * v, s * u + c * v
    z = 1.0 / (1.0 - tilt * (x / shape[1] + 0.5 * y / shape[0]))
    return np.array([y * z + shape[0] / 2, x * z + shape[1] / 2])


@functools.cache
def photographed(
    *,
    camera: str = "",
    light: str = "D55",
    shape: tuple[int, int] = (600, 900),
    turn_deg: float = 8.0,
    width: float = 0.5,
    tilt: float = 0.0,
    unevenness: float = 0.0,
    seed: int = 1,
) -> Picture:
    """Return codes of a Bayer array: a chart in a black frame before a wall, with shot and read noise.

    camera : of colour-science's measured ones; "" for ``CAMERA``
    width  : of the chart, in parts of the picture's;  unevenness: what each patch is off by, in parts
    """
    rng = np.random.default_rng(seed)
    sensitivities = np.maximum(aligned("camera", camera), 0.0) if camera else CAMERA
    seen, white = channels(sensitivities, light)
    seen = seen * (1.0 + unevenness * rng.standard_normal(seen.shape))
    rows, cols = shape
    y, x = np.mgrid[0:rows, 0:cols] + 0.5
    dx, dy = x - cols / 2, y - rows / 2
    z = 1.0 + tilt * (dx / cols + 0.5 * dy / rows)
    angle, pitch = np.radians(turn_deg), width * cols / 6.3
    u = (np.cos(angle) * dx + np.sin(angle) * dy) / pitch / z + 3.0
    v = (np.cos(angle) * dy - np.sin(angle) * dx) / pitch / z + 2.0
    col, row = np.floor(u).astype(int), np.floor(v).astype(int)
    on_patch = (col >= 0) & (col < 6) & (row >= 0) & (row < 4)
    on_patch &= (np.abs(u - col - 0.5) < PATCH) & (np.abs(v - row - 0.5) < PATCH)
    on_chart = (u > -0.2) & (u < 6.2) & (v > -0.2) & (v < 4.2)
    channel = np.array([[0, 1], [1, 2]])[(y % 2).astype(int), (x % 2).astype(int)]
    wall = 0.2 * (1.0 + 0.3 * np.sin(x / 90) * np.cos(y / 70))
    light_e = white[channel] * np.where(on_chart, 0.04, wall)
    patch = np.clip(row, 0, 3) * 6 + np.clip(col, 0, 5)
    light_e = np.where(on_patch, seen[patch, channel], light_e) * 0.8 * FULL_E / white.max()
    electrons = rng.poisson(light_e) + rng.normal(0.0, 5.0, shape)
    codes = np.clip(np.rint(BLACK_DN + electrons * (WHITE_DN - BLACK_DN) / FULL_E), 0, 16383).astype(np.uint16)
    planes = mosaic_planes(codes, ("RG", "GB"), black=float(BLACK_DN), white=float(WHITE_DN), lowest=0.0)
    return Picture(name="chart", shape=shape, planes=planes)
