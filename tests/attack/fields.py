"""Pictures and gradients among the shapes of a system: scale, angle, interpolation, what lies in front and behind."""

import math

import numpy as np

BLUR = 0.3, 4.0  # λN that truths of fields take a moment for
MOST = 16  # rows and columns


def add_fields(rng, system, paint, curves):
    """Give a system one field or two, between up to three of its shapes and curved ones; it is made small.

    paint, curves : what draws a surface, and a list of curved shapes
    """
    limit(system)
    grid = system["grid"]
    size = max(grid["rows"], grid["cols"], 4)
    shapes = system["shapes"][:3]
    between = int(rng.integers(0, len(shapes) + 1))
    shapes = [*shapes[:between], _field(rng, size, paint), *shapes[between:]]
    if rng.random() < 0.3:
        shapes.insert(int(rng.integers(0, len(shapes) + 1)), _field(rng, size, paint))
    system["shapes"] = shapes + (curves(rng, size) if rng.random() < 0.6 else [])


def limit(system):
    """Keep a system within what truths of fields take a moment for."""
    lens = system["lens"]
    lens["blur"] = float(np.clip(lens["blur"], *BLUR))
    if lens["kind"] == "curve":  # its pattern is an integral at every distance
        system["lens"] = {"kind": "airy", "blur": lens["blur"]}
    if system["method"] == "boundary":
        system["method"] = "auto"
    grid = system["grid"]
    grid["rows"], grid["cols"] = min(grid["rows"], MOST), min(grid["cols"], MOST)


def _field(rng, size, paint):
    middle = rng.uniform(-0.5, 0.5, 2) * size
    centre = (np.round(2.0 * middle) / 2.0 if rng.random() < 0.4 else middle).tolist()
    placed = {"centre": centre, "rotate_deg": float(rng.choice([0.0, 90.0, 180.0, 45.0, *rng.uniform(0.0, 360.0, 3)]))}
    kind = str(rng.choice(["picture", "linear-gradient", "radial-gradient", "sine-grating"], p=[0.7, 0.1, 0.1, 0.1]))
    if kind == "picture":
        rows, cols = (int(n) for n in rng.integers(1, 6, 2))
        step = size * 10.0 ** rng.uniform(-1.0, 0.0) / max(rows, cols) * 1.5
        step = max(round(2.0 * step), 1) / 2.0 if rng.random() < 0.4 else float(step)
        interpolation = str(rng.choice(["squares", "linear", "cubic"]))
        one = {"samples": rng.random((rows, cols)).tolist(), "step": step, "interpolation": interpolation}
        return {"kind": kind, **placed, **one, "reflectance": paint(rng)}
    low, high = rng.random(2).tolist()
    if kind == "radial-gradient":
        placed |= {"rotate_deg": 0.0, "radius": float(size * 10.0 ** rng.uniform(-0.7, 0.0))}
    else:
        width, height = (size * 10.0 ** rng.uniform(-0.7, 0.2, 2)).tolist()
        placed |= {"width": width, "height": height}
    if kind == "sine-grating":
        placed["period"] = float(10.0 ** rng.uniform(math.log10(0.4), 0.7))
    return {"kind": kind, **placed, "low": low, "high": high}
