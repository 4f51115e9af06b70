"""Groups and repeats taken apart: the shapes that are painted, where they come to lie, with what clips them."""

from __future__ import annotations

import math

import numpy as np


def flattened(shapes):
    """Plain shapes in the order in which they are painted; what clips one is a list of shapes in ``clips``."""
    found = []
    for shape in shapes:
        inner = flattened(shape["shapes"]) if "shapes" in shape else [shape]
        if shape["kind"] == "group":
            if shape["clip"] is not None:
                inner = [one | {"clips": [*one.get("clips", ()), shape["clip"]]} for one in inner]
            a = math.radians(shape["turn_deg"])
            x, y = shape["scale"]
            x, y = (-x if shape["mirror"] == "left-right" else x), (-y if shape["mirror"] == "up-down" else y)
            # Mirrored and scaled first, then turned (x towards y), then moved.
            matrix = np.array([[math.cos(a) * x, -math.sin(a) * y], [math.sin(a) * x, math.cos(a) * y]])
            inner = [_moved(one, matrix, np.array(shape["move"], float)) for one in inner]
        elif shape["kind"] == "repeat-on-grid":
            places = [
                np.array(shape["step"]) * (col - 0.5 * (shape["cols"] - 1), row - 0.5 * (shape["rows"] - 1))
                for row in range(shape["rows"])
                for col in range(shape["cols"])
            ]
            inner = [_moved(one, np.eye(2), place) for place in places for one in inner]
        elif shape["kind"] == "repeat-on-ring":
            centre = np.array(shape["centre"], float)
            turns = [2.0 * math.pi * copy / shape["count"] for copy in range(shape["count"])]
            turned = [np.array([[math.cos(t), -math.sin(t)], [math.sin(t), math.cos(t)]]) for t in turns]
            inner = [_moved(one, turn, centre - _mapped(turn, centre)) for turn in turned for one in inner]
        found += inner
    return found


def _moved(shape, matrix, by):
    """A plain shape mapped by x → matrix·x + by; only what has corners, points or half axes is scaled unevenly."""

    def at(points):
        return (_mapped(matrix, points) + by).tolist()

    kind, each = shape["kind"], dict(shape)
    if "clips" in shape:
        each["clips"] = [_moved(clip, matrix, by) for clip in shape["clips"]]
    if kind == "path":
        return each | {
            "outlines": [[at(start), *(at(segment) for segment in rest)] for start, *rest in shape["outlines"]]
        }
    if kind == "polygon":
        return each | {"points": at(shape["points"]), "holes": [at(hole) for hole in shape.get("holes", ())]}
    if kind == "rectangle":
        a = math.radians(shape.get("rotate_deg", 0.0))
        across = 0.5 * shape["width"] * np.array([math.cos(a), math.sin(a)])
        down = 0.5 * shape["height"] * np.array([-math.sin(a), math.cos(a)])
        corners = np.array(shape["centre"]) + np.array([-across - down, across - down, across + down, down - across])
        return each | {"kind": "polygon", "points": at(corners)}
    if kind == "ellipse":
        a = math.radians(shape["rotate_deg"])
        u, v = np.array([math.cos(a), math.sin(a)]), np.array([-math.sin(a), math.cos(a)])
        radii, turn = _half_axes(_mapped(matrix, shape["radii"][0] * u), _mapped(matrix, shape["radii"][1] * v))
        return each | {"centre": at(shape["centre"]), "radii": radii, "rotate_deg": math.degrees(turn)}
    (a, b), (c, d) = matrix
    scale, mirrored = math.hypot(a, c), a * d < b * c
    assert np.allclose([math.hypot(b, d), a * b + c * d], [scale, 0.0], atol=1e-12 * scale**2), "scaled unevenly"
    if kind == "capsule":
        return each | {"points": at(shape["points"]), "width": scale * shape["width"]}
    each |= {"centre": at(shape["centre"]), "radius": scale * shape["radius"]}
    if "inner" in shape:
        each["inner"] = scale * shape["inner"]
    if kind == "sector":
        # Where its first side comes to lie; mirrored, that is where it ends.
        first = math.radians(shape["from_deg"] + (shape["turn_deg"] if mirrored else 0.0))
        x, y = _mapped(matrix, (math.cos(first), math.sin(first)))
        each["from_deg"] = math.degrees(math.atan2(y, x))
    return each


def _mapped(matrix, points):
    """matrix · each point (…, 2), to the same bits wherever it stands and on every processor."""
    x, y = np.moveaxis(np.asarray(points, float), -1, 0)
    return np.stack([matrix[0, 0] * x + matrix[0, 1] * y, matrix[1, 0] * x + matrix[1, 1] * y], axis=-1)


def _half_axes(u, v):
    """Lengths of the half axes of an ellipse u·cos a + v·sin a, and the angle of the longer: of two circles that turn
    against each other it is the sum."""
    p = complex(u[0] + v[1], u[1] - v[0]) / 2.0
    q = complex(u[0] - v[1], u[1] + v[0]) / 2.0
    turn = 0.5 * (math.atan2(p.imag, p.real) + math.atan2(q.imag, q.real))
    return [abs(p) + abs(q), abs(abs(p) - abs(q))], turn
