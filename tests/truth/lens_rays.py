"""Rays through surfaces of revolution, and the transfer of their pupil; imports nothing of camsim's.

A lens is rows of (curvature 1/mm, conic, {power: coefficient}, thickness mm, index of the wavelength in µm or "mirror",
rim mm). Rays are sent in on a fine lattice, and those count that fall into the stop's circle: nothing is aimed.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CloughTocher2DInterpolator, LinearNDInterpolator
from scipy.spatial import Delaunay

AIR = lambda um: 1.0  # noqa: E731


def sellmeier(*terms):
    """Index by Sellmeier's formula, of pairs (B, C µm²)."""
    return lambda um: math.sqrt(1.0 + sum(b * um**2 / (um**2 - c) for b, c in terms))


N_BK7 = sellmeier((1.03961212, 0.00600069867), (0.231792344, 0.0200179144), (1.01046945, 103.560653))
N_SK16 = sellmeier((1.34317774, 0.00704687339), (0.241144399, 0.0229005), (0.994317969, 92.7508526))
F2 = sellmeier((1.34533359, 0.00997743871), (0.209073176, 0.0470450767), (0.937357162, 111.886764))


def sag(row, r2):
    c, k, powers = row[:3]
    depth = c * r2 / (1.0 + np.sqrt(1.0 - (1.0 + k) * c * c * r2))
    return depth + sum(a * r2 ** (p / 2) for p, a in powers.items())


def trace(rows, stop, angle, x, y, um):
    """Rays from the vertex's plane: places and directions at the image, paths, places in the stop, shares of rims."""
    at = np.stack([x, y, 0.0 * x])
    way = np.stack([np.full_like(x, math.sin(angle)), 0.0 * x, np.full_like(x, math.cos(angle))])
    path, index, met, in_stop = math.sin(angle) * x, 1.0, np.zeros(x.shape), None
    for number, row in enumerate(rows):
        length = -at[2] / way[2]
        for _ in range(60):  # secant-free: the surface's own slope, by small differences
            here = at + length * way
            r2 = here[0] ** 2 + here[1] ** 2
            step = 1e-6
            slope = (sag(row, r2 + step) - sag(row, np.maximum(r2 - step, 0.0))) / (
                r2 + step - np.maximum(r2 - step, 0.0)
            )
            normal = np.stack([-2.0 * here[0] * slope, -2.0 * here[1] * slope, np.ones_like(x)])
            missed = (here[2] - sag(row, r2)) / (normal * way).sum(axis=0)
            length = length - missed
            if np.nan_to_num(np.abs(missed)).max() < 1e-12:
                break
        at, path = at + length * way, path + index * length
        normal = normal / np.sqrt((normal**2).sum(axis=0))
        cos = (normal * way).sum(axis=0)
        if row[4] == "mirror":
            way = way - 2.0 * cos * normal
        else:
            behind = row[4](um)
            ratio = index / behind
            root = np.sqrt(1.0 - ratio**2 * (1.0 - cos**2))
            way, index = ratio * way + (np.sign(cos) * root - ratio * cos) * normal, behind
        met = np.fmax(met, np.hypot(at[0], at[1]) / row[5])
        if number == stop:
            in_stop = at[:2].copy()
        at[2] -= row[3]
    length = -at[2] / way[2]
    return at + length * way, way, path + index * length, in_stop, met


def chief_mm(rows, stop, angle, um):
    """Where the ray through the stop's middle falls."""
    entry = np.linspace(-60.0, 60.0, 2001)
    for _ in range(9):
        with np.errstate(all="ignore"):
            fallen, _, _, in_stop, _ = trace(rows, stop, angle, entry, 0.0 * entry, um)
        best = int(np.nanargmin(np.abs(in_stop[0])))
        reach = entry[1] - entry[0]
        found = entry[best], fallen[0, best]
        entry = np.linspace(entry[best] - reach, entry[best] + reach, 61)
    return found


class Ellipse(NamedTuple):
    """Where a pupil is open: in the stop, or in the first vertex's plane; mm, along the field and across it."""

    in_stop: bool
    middle: float
    along: float
    across: float


def mtf(rows, stop, stop_mm, angle, um, per_mm):
    """MTF along x (the field) and along y at frequencies; the pupil is where rays fall into the stop."""
    chief = chief_mm(rows, stop, angle, um)
    reach = 1.6 * stop_mm if abs(chief[0]) < 1e-9 else 2.2 * stop_mm
    return mtf_through(rows, stop, Ellipse(True, 0.0, stop_mm, stop_mm), angle, um, per_mm, chief, reach, 80.0)


def mtf_through(rows, stop, pupil, angle, um, per_mm, chief, reach, radius, across=161):
    """Likewise through an ellipse; chief: where a ray of its middle enters and falls; radius: of the sphere, mm."""
    entry, height = chief
    axis = np.linspace(-reach, reach, across)
    x, y = (one.ravel() for one in np.meshgrid(entry + axis, axis))
    with np.errstate(all="ignore"):
        at, way, path, in_stop, met = trace(rows, stop, angle, x, y, um)
    place = in_stop if pupil.in_stop else np.stack([x, y])
    share = np.fmax(np.hypot((place[0] - pupil.middle) / pupil.along, place[1] / pupil.across), met)
    off = at - np.array([[height], [0.0], [0.0]])
    along = (off * way).sum(axis=0)
    back = along + np.sqrt(along**2 - (off**2).sum(axis=0) + radius**2)
    p = (off - back * way)[:2] / radius
    path = path - back
    good = np.isfinite(path) & (share < 1.3)
    return overlaps(p[:, good], path[good] / (um * 1e-3), share[good], um, per_mm)


def overlaps(cosines, waves, share, um, per_mm, lattice=200):
    """MTF along x and y: a pupil over itself, moved by what each frequency asks for; share: up to 1 it is open."""
    seen = cosines[:, share <= 1.0]
    low, high = seen.min(axis=1), seen.max(axis=1)
    scale = (high - low).max()
    points = Delaunay(((cosines - low[:, None]) / scale).T)
    path, rim = CloughTocher2DInterpolator(points, waves), LinearNDInterpolator(points, share)
    steps = [(np.arange(lattice) + 0.5) / lattice * 1.04 * side / scale - 0.02 for side in high - low]
    x, y = np.meshgrid(*steps)
    area = (rim(x, y) <= 1.0).sum()
    found = np.empty((2, len(per_mm)))
    for k, frequency in enumerate(per_mm):
        half = 0.5 * frequency * um * 1e-3 / scale
        for direction, (dx, dy) in enumerate(((half, 0.0), (0.0, half))):
            both = np.maximum(rim(x - dx, y - dy), rim(x + dx, y + dy)) <= 1.0
            at, to = (path(x[both] + side * dx, y[both] + side * dy) for side in (-1.0, 1.0))
            found[direction, k] = abs(np.exp(2j * np.pi * (to - at)).sum()) / area
    return found
