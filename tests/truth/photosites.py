"""Photosites and OLPFs of a specification: their outlines as nodes, their areas, their transfer."""

from __future__ import annotations

import functools
import math

import numpy as np


def spots(olpf):
    """Offsets (n, 2) of the equal images that an OLPF makes of a point."""
    if olpf is None:
        return np.zeros((1, 2))
    a = math.radians(olpf["rotate_deg"])
    along, across = np.array([math.cos(a), math.sin(a)]), np.array([-math.sin(a), math.cos(a)])
    x = [-0.5, 0.5] if olpf["split"] else [0.0]
    y = [-0.5, 0.5] if olpf["split_y"] else [0.0]
    return np.array([u * olpf["split"] * along + v * olpf["split_y"] * across for u in x for v in y])


def corners(photosite):
    """Corners of a photosite with straight sides, in the direction that has the inside on its left."""
    kind = photosite["kind"]
    if kind == "polygon":
        p = np.array(photosite["points"], float)
        q = np.roll(p, -1, axis=0)
        return p if np.sum(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]) > 0.0 else p[::-1]
    w, h = (photosite["side"],) * 2 if kind == "square" else (photosite["width"], photosite["height"])
    return 0.5 * np.array([(-w, -h), (w, -h), (w, h), (-w, h)], float)


def border(photosite, density, fewest=12):
    """Nodes (n, 2) on a photosite's outline, and the outward normal times the weight there.

    density : Gauss nodes per unit of length, besides ``fewest`` on every side
    """
    places, normals = [], []

    def side(a, b):
        length = float(np.hypot(*(b - a)))
        if length == 0.0:
            return
        t, w = unit_gauss(math.ceil(density * length) + fewest)
        places.append(a + t[:, None] * (b - a))
        e = (b - a) / length
        normals.append(np.outer(w * length, [e[1], -e[0]]))

    def arc(centre, radius, first, last):
        if radius == 0.0:
            return
        t, w = unit_gauss(math.ceil(density * radius * (last - first)) + 2 * fewest)
        angle = first + t * (last - first)
        out = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        places.append(np.array(centre) + radius * out)
        normals.append(out * (w * radius * (last - first))[:, None])

    kind = photosite["kind"]
    if kind == "circle":
        for k in range(4):
            arc((0.0, 0.0), 0.5 * photosite["diameter"], 0.5 * math.pi * k, 0.5 * math.pi * (k + 1))
    elif kind == "rounded":
        r = photosite["radius"]
        x, y = 0.5 * photosite["width"] - r, 0.5 * photosite["height"] - r
        for k, centre in enumerate([(x, y), (-x, y), (-x, -y), (x, -y)]):
            arc(centre, r, 0.5 * math.pi * k, 0.5 * math.pi * (k + 1))
        for a, b in (
            ((-x, -y - r), (x, -y - r)),
            ((x + r, -y), (x + r, y)),
            ((x, y + r), (-x, y + r)),
            ((-x - r, y), (-x - r, -y)),
        ):
            side(np.array(a), np.array(b))
    else:
        points = corners(photosite)
        for a, b in zip(points, np.roll(points, -1, axis=0), strict=True):
            side(a, b)
    return np.concatenate(places), np.concatenate(normals)


def area(photosite):
    """Area by the divergence theorem over the outline."""
    places, normals = border(photosite, 0.0)
    return 0.5 * float(np.sum(places * normals))


def reach(photosite):
    """Largest distance of a point of the photosite from its centre."""
    return 0.0 if photosite["kind"] == "point" else float(np.hypot(*border(photosite, 0.0)[0].T).max())


def inner_nodes(photosite, order=8):
    """Nodes (n, 2) over the area and weights that add up to 1: cones from the centre over the outline, signed."""
    if photosite["kind"] == "point":
        return np.zeros((1, 2)), np.ones(1)
    places, normals = border(photosite, 0.0, order)
    u, w = unit_gauss(order)
    cone = np.sum(places * normals, axis=1)
    nodes = (u[:, None, None] * places).reshape(-1, 2)
    weights = np.multiply.outer(w * u, cone).ravel()
    return nodes, weights / weights.sum()


def transfer(photosite, kx, ky):
    """Mean of exp(2πi k·a) over the area, on the lattice of ky (rows) and kx (columns)."""
    kind = photosite["kind"]
    if kind == "point":
        return np.ones((ky.size, kx.size))
    if kind in ("square", "rectangle"):
        w, h = (photosite["side"],) * 2 if kind == "square" else (photosite["width"], photosite["height"])
        return np.sinc(h * ky)[:, None] * np.sinc(w * kx)
    # ∫ exp(2πi k·a) da = ∮ (k·n)/(2πi k²)·exp(2πi k·a) dt
    highest = math.hypot(float(np.abs(kx).max()), float(np.abs(ky).max()))
    places, normals = border(photosite, 3.5 * highest, 24)
    across, down = np.exp(2j * np.pi * np.outer(places[:, 0], kx)), np.exp(2j * np.pi * np.outer(ky, places[:, 1]))
    total = (down * normals[:, 0]) @ across * kx + (down * normals[:, 1]) @ across * ky[:, None]
    square = kx**2 + ky[:, None] ** 2
    whole = 0.5 * float(np.sum(places * normals))
    safe = np.where(square == 0.0, 1.0, square)
    return np.where(square == 0.0, 1.0, total / (2j * np.pi * safe * whole))


def olpf_transfer(olpf, kx, ky):
    """Mean of exp(2πi k·d) over the spots, on the lattice of ky (rows) and kx (columns)."""
    places = spots(olpf)
    across, down = np.exp(2j * np.pi * np.outer(places[:, 0], kx)), np.exp(2j * np.pi * np.outer(ky, places[:, 1]))
    return (down @ across).real / len(places)


@functools.cache
def unit_gauss(order):
    """Gauss–Legendre nodes and weights on 0 … 1."""
    x, w = np.polynomial.legendre.leggauss(order)
    return 0.5 * (1.0 + x), 0.5 * w
