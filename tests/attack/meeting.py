"""Patterns about a place of the frame whose rings come there in step: targets, dashes, teeth and dots in circles."""

from __future__ import annotations

import math

import numpy as np

MEETING = range(5500, 20_300_000)  # seeds that draw them: dates too
AWAY = 1.0, 2.2  # powers of ten of λN
KINDS = "rings", "sectors", "dashes", "teeth", "dots"
STEPS = 1.0, 1.0, 2.0, 3.0, 0.5, 1.03  # of λN, from one circle to the next
MOST_SHAPES = 240


def meeting(rng, rows, cols, blur, surface):
    """Return shapes of one pattern, of one surface or of two in turns, about a photosite, a border, or anywhere."""
    kind = str(rng.choice(KINDS))
    radius, step = blur * 10.0 ** float(rng.uniform(*AWAY)), blur * float(rng.choice(STEPS))
    centre = rng.uniform(-0.5, 0.5, 2) * [cols - 1, rows - 1]
    if rng.random() < 0.7:
        centre = np.round(2.0 * centre) / 2.0
    members = int(rng.integers(12, 100))
    circles = int(rng.integers(1, 30 if kind in ("rings", "sectors") else 4))
    circles = max(1, min(circles, MOST_SHAPES // (2 if kind in ("rings", "sectors") else members)))
    turned = float(rng.uniform(0.0, 2.0 * math.pi))
    shapes = []
    for k in range(circles - 1, -1, -1):
        r = radius + k * step
        angles = turned + 2.0 * math.pi * np.arange(members) / members
        width = 2.0 * math.pi * r / members * float(rng.choice([0.3, 0.5, 0.7]))
        if kind in ("rings", "sectors"):
            for outer in (0.5 * step, 0.0):
                shape = {"kind": "disc", "centre": centre.tolist(), "radius": r + outer}
                if kind == "sectors":
                    shape |= {"kind": "sector", "inner": 0.0, "from_deg": math.degrees(turned), "turn_deg": 120.0}
                shapes.append(shape)
        elif kind == "teeth":
            if k == 0:
                half = 0.25 * 2.0 * math.pi / members
                corners = [(r + out, at + side) for at in angles for out, side in tooth(0.5 * step, half)]
                places = [centre + away * np.array([math.cos(at), math.sin(at)]) for away, at in corners]
                shapes.append({"kind": "polygon", "points": [place.tolist() for place in places]})
        else:
            for at in angles.tolist():
                middle = centre + (r + 0.25 * step) * np.array([math.cos(at), math.sin(at)])
                if kind == "dots":
                    shapes.append({"kind": "disc", "centre": middle.tolist(), "radius": 0.2 * min(step, width)})
                else:
                    shapes.append(
                        {
                            "kind": "rectangle", "width": 0.5 * step, "height": width, "centre": middle.tolist(),
                            "rotate_deg": math.degrees(at),
                        }
                    )  # fmt: skip
    surfaces = surface(rng), surface(rng)
    for number, shape in enumerate(shapes):
        shape["reflectance"] = surfaces[number % 2 if kind in ("rings", "sectors") else 0]
    return shapes


def tooth(height, half):
    return (0.0, -half), (height, -half), (height, half), (0.0, half)
