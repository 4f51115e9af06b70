"""Paths of Bézier curves; groups, moved, turned, scaled, mirrored and clipped; repeats on grids and rings."""

import math

import numpy as np

MIRRORS = (None, None, "left-right", "up-down")


def add_drawings(rng, system, plain, paint):
    """Give a system one to three drawn things, over its other shapes, under them or in their place.

    plain, paint : what draws a list of shapes within a size, and a surface
    """
    size = max(system["grid"]["rows"], system["grid"]["cols"], 4)
    drawn = [_KINDS[rng.integers(len(_KINDS))](rng, size, plain) for _ in range(rng.integers(1, 4))]
    for shape in leaves(drawn):
        shape["reflectance"] = paint(rng)
    place, others = rng.random(), system["shapes"][:4]
    system["shapes"] = drawn if place < 0.5 else drawn + others if place < 0.7 else others + drawn


def leaves(shapes):
    """Yield what is painted: groups and repeats paint nothing of their own."""
    for shape in shapes:
        yield from leaves(shape["shapes"]) if "shapes" in shape else [shape]


def _place(rng, size):
    place = rng.uniform(-0.5, 0.5, 2) * size
    return np.round(2.0 * place) / 2.0 if rng.random() < 0.4 else place


def _angle(rng):
    return float(rng.choice([0.0, 90.0, 45.0, *rng.uniform(0.0, 360.0, 3)]))


def _path(rng, size, plain=None):
    """One outline or two, each a blob, a leaf, or curves through points anywhere, which cross themselves."""
    middle, radius = _place(rng, size), size * 10.0 ** rng.uniform(-1.0, 0.1)
    draw = (_blob, _leaf, _wild)[rng.integers(3)]
    outlines = [draw(rng, middle, radius)]
    if rng.random() < 0.4:
        outlines.append((_blob, _leaf)[rng.integers(2)](rng, middle, radius * float(rng.uniform(0.1, 0.9))))
    return {"kind": "path", "rule": str(rng.choice(["nonzero", "evenodd"])), "outlines": outlines}


def _blob(rng, middle, radius):
    """Round a middle through three to six places, smoothly at some of them."""
    count = int(rng.integers(3, 7))
    angle = 2.0 * math.pi * (np.arange(count) + rng.uniform(-0.3, 0.3, count)) / count * float(rng.choice([-1.0, 1.0]))
    out, along = (np.stack([f(angle), g(angle)], axis=1) for f, g in ((np.cos, np.sin), (lambda a: -np.sin(a), np.cos)))
    knots = middle + radius * rng.uniform(0.5, 1.0, count)[:, None] * out
    if rng.random() < 0.3:
        knots = np.round(2.0 * knots) / 2.0
    reach = np.sign(angle[1] - angle[0]) * radius * rng.uniform(0.1, 0.9, (2, count))[..., None] * along
    outline = [knots[0].tolist()]
    for k in range(count):
        after = (k + 1) % count
        handles = [knots[k] + reach[0, k], knots[after] - reach[rng.integers(2), after]]
        few = rng.choice([0, 1, 2, 2, 2])
        outline.append([*(h.tolist() for h in handles[:few]), knots[after].tolist()])
    return outline


def _leaf(rng, middle, radius):
    """Two curves from one tip to another."""
    angle = math.radians(_angle(rng))
    tip, across = (
        radius * np.array([math.cos(angle), math.sin(angle)]),
        radius * np.array([-math.sin(angle), math.cos(angle)]),
    )
    bend = rng.uniform(-1.5, 1.5, 2)
    quadratic = rng.random() < 0.5
    outline = [(middle - tip).tolist()]
    for sign, one in ((1.0, bend[0]), (-1.0, bend[1])):
        handle = middle + one * across
        handles = [handle] if quadratic else [handle - 0.4 * sign * tip, handle + 0.7 * sign * tip]
        outline.append([*(h.tolist() for h in handles), (middle + sign * tip).tolist()])
    return outline


def _wild(rng, middle, radius):
    """Two to four curves between points anywhere."""
    knots = [middle + radius * rng.uniform(-1.0, 1.0, 2) for _ in range(rng.integers(2, 5))]
    outline = [knots[0].tolist()]
    for end in [*knots[1:], knots[0]]:
        handles = [(middle + radius * rng.uniform(-1.2, 1.2, 2)).tolist() for _ in range(rng.integers(1, 3))]
        outline.append([*handles, end.tolist()])
    return outline


def _group(rng, size, plain):
    """One to three shapes; those that stay what they are only if scaled alike both ways are."""
    alike = rng.random() < 0.5
    shapes = []
    for _ in range(rng.integers(1, 4)):
        shapes += plain(rng, size) if alike and rng.random() < 0.6 else [_path(rng, size)]
    scale = 10.0 ** rng.uniform(-0.4, 0.4, 2)
    group = {
        "kind": "group",
        "shapes": shapes[:4],
        "mirror": MIRRORS[rng.integers(len(MIRRORS))],
        "scale": [float(scale[0]), float(scale[0] if alike else scale[1])],
        "turn_deg": _angle(rng),
        "move": _place(rng, size).tolist(),
        "clip": None,
    }
    if rng.random() < 0.6:
        group["clip"] = _clip(rng, size, alike)
    return group


def _clip(rng, size, alike):
    middle, radius = _place(rng, size), size * float(rng.uniform(0.1, 0.6))
    if alike and rng.random() < 0.4:
        return {"kind": "disc", "centre": middle.tolist(), "radius": radius}
    if rng.random() < 0.5:
        turn = math.radians(_angle(rng)) + 2.0 * math.pi * np.arange(int(rng.integers(3, 6))) / 5.0
        return {
            "kind": "polygon",
            "points": (middle + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)).tolist(),
        }
    return _path(rng, size)


def _repeat(rng, size, plain):
    """Copies of a shape or two, or of a group, side by side or round a centre; they may overlap."""
    few = [_group(rng, 0.4 * size, plain)] if rng.random() < 0.3 else [_path(rng, 0.5 * size)]
    if rng.random() < 0.4:
        few += plain(rng, 0.4 * size)[:1]
    if rng.random() < 0.5:
        step = size * rng.uniform(0.2, 0.6, 2)
        step = np.maximum(np.round(2.0 * step), 1.0) / 2.0 if rng.random() < 0.4 else step
        rows, cols = (int(n) for n in rng.integers(1, 4, 2))
        return {"kind": "repeat-on-grid", "shapes": few, "rows": rows, "cols": cols, "step": step.tolist()}
    centre = _place(rng, size).tolist()
    return {"kind": "repeat-on-ring", "shapes": few, "count": int(rng.integers(2, 7)), "centre": centre}


_KINDS = (_path, _path, _group, _repeat)
