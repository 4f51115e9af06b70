"""Curves far larger or flatter than the frame, their rims through it: sides that are short there and long beyond."""

from __future__ import annotations

import math

import numpy as np

LARGE = range(5200, 20_300_000)  # seeds that draw them: dates too
LARGER = 0.5, 6.0  # powers of ten of the frame
KNOWN = 3e13  # blurs for each of the tolerance: corners of larger ones lie on too coarse a grid (2⁻⁴⁶ of them) for it
FLAT = 0.5, 4.0  # powers of ten, of which an ellipse's axes differ
KINDS = "disc", "ellipse", "ring", "sector"
LENSES = "airy", "annular", "gaussian", "curve"  # whose far light all truths know


def large_curves(rng, rows, cols, blur, tolerance):
    """Return one to three of them."""
    largest = math.log10(KNOWN * min(blur, 1.0) * tolerance / max(rows, cols, 4))
    sizes = LARGER[0], min(LARGER[1], max(largest, 2.0 * LARGER[0]))
    kinds = [str(rng.choice(KINDS, p=[0.35, 0.35, 0.15, 0.15])) for _ in range(_count(rng))]
    return [_through(rng, kind, rows, cols, sizes) for kind in kinds]


def _count(rng):
    return 1 + int(rng.choice([0, 0, 1, 2]))


def _through(rng, kind, rows, cols, sizes):
    """One whose rim runs within the frame, at times through a photosite's centre, at whatever angle."""
    size = max(rows, cols, 4)
    radius, angle = float(size * 10.0 ** rng.uniform(*sizes)), float(rng.uniform(0.0, 360.0))
    place = rng.uniform(-0.5, 0.5, 2) * [cols, rows]
    if rng.random() < 0.4:
        place, angle = np.round(2.0 * place) / 2.0, 90.0 * math.floor(angle / 90.0)
    out = np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
    if kind == "ellipse":
        # Its flat side, or its tip.
        other = radius * 10.0 ** -float(rng.uniform(*FLAT))
        tip = rng.random() < 0.3
        centre = place - (radius if tip else other) * out
        return {
            "kind": kind, "centre": centre.tolist(), "radii": [radius, other],
            "rotate_deg": angle if tip else angle + 90.0,
        }  # fmt: skip
    shape = {"kind": kind, "centre": (place - radius * out).tolist(), "radius": radius}
    if kind == "ring":
        shape["inner"] = max(radius - size * float(rng.uniform(0.1, 3.0)), 0.01 * radius)
    if kind == "sector":
        turn_deg = float(rng.choice([90.0, 180.0, rng.uniform(1.0, 300.0)]))
        shape |= {"inner": 0.0, "from_deg": angle - float(rng.uniform(0.0, 1.0)) * turn_deg, "turn_deg": turn_deg}
    return shape
