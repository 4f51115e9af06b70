"""The light of pictures and gradients that shapes in front of them leave to be seen, as nodes with weights.

A picture is cut into patches on which its field is a polynomial, each a shape of its own among all others: the outline
of what is seen of a patch is what ``picture.pieces`` finds between it and anything else. Over a patch light is summed
on cones from its middle to the pieces of that outline, of either sign. Nothing of camsim is imported.
"""

from __future__ import annotations

import math

import numpy as np

from tests.truth import samples
from tests.truth.photosites import unit_gauss

KINDS = ("picture", "linear-gradient", "radial-gradient", "sine-grating")


def is_field(shape):
    return shape["kind"] in KINDS


def parted(shapes):
    """Shapes with the patches of every field in its place, and of each whose field it is part of: −1 of none."""
    found, owner = [], []
    for number, shape in enumerate(shapes):
        one = _patches(shape) if is_field(shape) else [shape]
        found += one
        owner += [number if is_field(shape) else -1] * len(one)
    return found, owner


def light_of(shapes, pieces, owner, number, *, cutoff, more):
    """Places (n, 2) and light (n,) of what is seen of field ``number`` of ``shapes``.

    pieces, owner : of ``parted`` shapes;  cutoff: highest frequency that is looked at;  more: nodes on every line
    """
    places, light = [np.empty((0, 2))], [np.empty(0)]
    patches = _patches(shapes[number])
    first = owner.index(number)
    highest = cutoff + _cycles(shapes[number])
    for k, patch in enumerate(patches, first):
        middle = np.array(patch["centre"])
        for piece in pieces:
            if k not in (piece.left, piece.right):
                continue
            sign = 1.0 if piece.left == k else -1.0
            y, step = _along(piece, highest, more)
            # Pieces have what is on their left where cross(direction, x − start) > 0: round it the positive way.
            cone = sign * ((y - middle)[:, 0] * step[:, 1] - (y - middle)[:, 1] * step[:, 0])
            size = float(np.hypot(*(y - middle).T).max())
            t, w = unit_gauss(_order(highest * size) + more)
            places.append((middle + t[:, None, None] * (y - middle)).reshape(-1, 2))
            light.append(np.multiply.outer(w * t, cone).ravel())
    places, light = np.concatenate(places), np.concatenate(light)
    return places, light * value(shapes[number], places)


def value(shape, places):
    """The field (n,) at places."""
    c, s = math.cos(math.radians(shape["rotate_deg"])), math.sin(math.radians(shape["rotate_deg"]))
    d = places - np.array(shape["centre"])
    x, y = d[:, 0] * c + d[:, 1] * s, d[:, 1] * c - d[:, 0] * s
    if shape["kind"] == "linear-gradient":
        share = 0.5 + x / shape["width"]
    elif shape["kind"] == "radial-gradient":
        share = 1.0 - (x * x + y * y) / shape["radius"] ** 2
    elif shape["kind"] == "sine-grating":
        share = 0.5 + 0.5 * np.cos(2.0 * np.pi * x / shape["period"])
    else:
        one = np.array(shape["samples"])
        rows, cols = one.shape
        how = shape["interpolation"]
        u, v = np.clip(x / shape["step"] + 0.5 * cols, 1e-12, cols - 1e-12), y / shape["step"] + 0.5 * rows
        across = samples.spline(cols, u, how)
        return np.einsum("ni,ij,nj->n", samples.spline(rows, np.clip(v, 1e-12, rows - 1e-12), how), one, across)
    return shape["low"] + (shape["high"] - shape["low"]) * share


def _cycles(shape):
    return 1.0 / shape["period"] if shape["kind"] == "sine-grating" else 0.0


def _patches(shape):
    """Rectangles, or a disc, on each of which the field is smooth."""
    if shape["kind"] == "radial-gradient":
        return [{"kind": "disc", "centre": shape["centre"], "radius": shape["radius"]}]
    if shape["kind"] != "picture":
        return [{name: shape[name] for name in ("centre", "width", "height", "rotate_deg")} | {"kind": "rectangle"}]
    rows, cols = np.array(shape["samples"]).shape
    down, across = (_knots(count, shape["interpolation"]) for count in (rows, cols))
    a = math.radians(shape["rotate_deg"])
    x, y = np.array([math.cos(a), math.sin(a)]), np.array([-math.sin(a), math.cos(a)])
    origin = np.array(shape["centre"]) - shape["step"] * 0.5 * (cols * x + rows * y)
    grid = [[origin + shape["step"] * (u * x + v * y) for u in across] for v in down]
    return [
        {
            "kind": "polygon",
            "points": [grid[i][j], grid[i][j + 1], grid[i + 1][j + 1], grid[i + 1][j]],
            "centre": (0.25 * (grid[i][j] + grid[i][j + 1] + grid[i + 1][j + 1] + grid[i + 1][j])).tolist(),
        }
        for i in range(len(down) - 1)
        for j in range(len(across) - 1)
    ]


def _knots(count, interpolation):
    """Where splines over 0 … count have knots, both ends among them."""
    if interpolation == "squares":
        return [float(k) for k in range(count + 1)]
    return [0.0, *(k + 0.5 for k in range(count)), float(count)]


def _along(piece, highest, more):
    """Nodes (n, 2) along a piece, and the steps there."""
    a, b = np.array(piece.start), np.array(piece.end)
    if piece.centre is None:
        t, w = unit_gauss(_order(highest * float(np.hypot(*(b - a)))) + more)
        return a + t[:, None] * (b - a), w[:, None] * (b - a)
    turn = piece.last - piece.first
    parts = math.ceil(2.0 * turn)
    t, w = unit_gauss(_order(highest * piece.largest * turn / parts) + more + 4)
    angle = piece.first + turn * ((np.arange(parts)[:, None] + t) / parts).ravel()
    u, v, w = np.array(piece.u), np.array(piece.v), np.tile(w * turn / parts, parts)
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return np.array(piece.centre) + u * cos + v * sin, w[:, None] * (v * cos - u * sin)


def _order(cycles):
    """Nodes of a Gauss rule over so many waves: π/2 of each, and what the step from wrong to right takes."""
    return math.ceil(0.5 * math.pi * cycles + 2.0 * cycles ** (1.0 / 3.0))
