"""Edges as charts have them, rendered, with their theory: blocks, near neighbours, tilted light, noise."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

import camsim
from camsim.measure import Plane, Roi

_PITCH_UM, _WAVELENGTH_NM, _PIXELS = 4.88, 550.0, 96


class Drawn(NamedTuple):
    """An edge drawn: a channel, a region with one side of a block in it, what is true of it, and how it was drawn."""

    plane: Plane
    roi: Roi
    angle_deg: float
    mtf50_cycles_per_pixel: float
    how: str


def drawn_edge_of_a_chart(rng: np.random.Generator) -> Drawn:
    """Draw an edge of Airy f/2.8 … 16, OLPF or none, mono or one Bayer channel, 25 to 60 px long or endless."""
    f_number = float(rng.choice([2.8, 4.0, 5.6, 8.0, 11.0, 16.0]))
    stages = [camsim.Airy(f_number=f_number), camsim.SquarePhotosite(side_um=_PITCH_UM)]
    if olpf := bool(rng.integers(2)):
        stages.insert(1, camsim.FourSpotOlpf(split_um=0.75 * _PITCH_UM))
    step = int(rng.integers(1, 3))
    first = (int(rng.integers(step)), int(rng.integers(step)))
    kind = str(rng.choice(["half-plane", "block", "row of blocks"]))
    length, depth, gap = (float(rng.uniform(25.0, 60.0)) for _ in range(3))
    if kind == "half-plane":
        length = depth = gap = 1e5
    angle = float(rng.uniform(3.0, 42.0) * rng.choice((-1.0, 1.0)))
    turn = math.radians(angle + 90.0 * float(rng.integers(4)))
    normal, along = np.array([math.cos(turn), math.sin(turn)]), np.array([-math.sin(turn), math.cos(turn)])
    # The side measured goes through ``point``; the block lies on the side that its normal points to.
    point = rng.uniform(-0.5, 0.5, 2)
    dark, bright = float(rng.uniform(0.03, 0.2)), float(rng.uniform(0.5, 0.9))
    inside, outside = (bright, dark) if rng.integers(2) else (dark, bright)
    places = [(0.5 * depth, 0.0, depth, length)]
    if kind == "row of blocks":
        places += [(0.5 * depth, side * (length + gap), depth, length) for side in (-1.0, 1.0)]
        places += [(-gap - 0.5 * depth, side * (length + gap), depth, length) for side in (-1.0, 0.0, 1.0)]
    blocks = [
        camsim.Rectangle(
            width_um=wide * _PITCH_UM,
            height_um=high * _PITCH_UM,
            rotate_deg=math.degrees(turn),
            centre_um=tuple(((point + across * normal + aside * along) * _PITCH_UM).tolist()),
            reflectance=inside,
        )
        for across, aside, wide, high in places
    ]
    grid = camsim.Grid(rows=_PIXELS, cols=_PIXELS, pitch_um=_PITCH_UM)
    scene = camsim.Scene(background=outside, shapes=blocks)
    image = camsim.render(scene, stages, grid, wavelength_nm=_WAVELENGTH_NM).image
    free = min(depth, gap if kind == "row of blocks" else 1e5, 32.0 + 8.0)
    margin = float(rng.uniform(5.0, 10.0))
    roi = _region(turn, point, along=min(0.5 * length, 40.0) - margin, across=free - margin)
    if min(roi.rows, roi.cols) < 8 * step:
        return drawn_edge_of_a_chart(rng)
    tilt = rng.uniform(-0.15, 0.15, 2) if (tilted := bool(rng.integers(2))) else np.zeros(2)
    y, x = np.mgrid[:_PIXELS, :_PIXELS] + 0.5
    light = 1.0 + tilt[0] * (2.0 * (x - roi.col) / roi.cols - 1.0) + tilt[1] * (2.0 * (y - roi.row) / roi.rows - 1.0)
    image = image * np.clip(light, 0.4, 1.6)
    full_e = math.inf if rng.integers(2) else float(10.0 ** rng.uniform(3.0, 5.0))
    if math.isfinite(full_e):
        image = (rng.poisson(image * full_e) + rng.normal(0.0, 3.0, image.shape)) / full_e
    how = (
        f"f/{f_number:g}, {'OLPF, ' if olpf else ''}{'Bayer' if step == 2 else 'mono'}, {kind} {length:.0f} × "
        f"{depth:.0f} px, {roi.rows} × {roi.cols}, {angle:.1f}°{', tilted' if tilted else ''}, {full_e:.0f} e⁻"
    )
    return Drawn(
        Plane(name="Y", samples=image[first[0] :: step, first[1] :: step], step=(step, step), first=first),
        roi,
        angle,
        _mtf50(stages, normal),
        how,
    )


def _region(turn: float, point: np.ndarray, *, along: float, across: float) -> Roi:
    """Return a region about a side's middle in which the edge reaches so far and nothing else lies."""
    lying = abs(math.sin(turn)) > abs(math.cos(turn))
    slant, lead = sorted((abs(math.cos(turn)), abs(math.sin(turn))))
    # Its corners reach half·lead + long·slant across and long·lead + half·slant along: the largest such rectangle.
    half, long = across / (2.0 * lead), across / (2.0 * slant)
    if long * lead + half * slant > along:
        half, long = along / (2.0 * slant), along / (2.0 * lead)
    if half * lead + long * slant > across:
        half, long = (np.array([[lead, -slant], [-slant, lead]]) @ (across, along)) / (lead**2 - slant**2)
    rows, cols = (half, long) if lying else (long, half)
    middle = point + 0.5 * _PIXELS
    row, col = math.ceil(middle[1] - rows), math.ceil(middle[0] - cols)
    return Roi(row, col, math.floor(middle[1] + rows) - row, math.floor(middle[0] + cols) - col)


def _mtf50(stages: list, normal: np.ndarray) -> float:
    frequency = np.linspace(0.0, 1.0, 20_001)
    fx, fy = (frequency / _PITCH_UM * part for part in normal)
    mtf = np.abs(math.prod(stage.otf(fx, fy, _WAVELENGTH_NM) for stage in stages))
    first = int(np.argmax(mtf < 0.5))
    return float(np.interp(0.5, mtf[[first, first - 1]], frequency[[first, first - 1]]))
