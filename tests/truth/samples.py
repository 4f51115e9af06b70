"""Photosites behind a picture by brute force: Gauss nodes over every half sample, over the photosite and its spots, and
between all of them the Airy pattern. Splines are made by solving for them; nothing of camsim is imported.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy import special


def light_of_picture(samples, *, interpolation, step, centre, rotate_deg, nodes):
    """Return places x, y and light of Gauss nodes over the picture; lengths as ``step``, the distance of samples."""
    rows, cols = samples.shape
    u, wu = _axis(cols, nodes)
    v, wv = _axis(rows, nodes)
    field = spline(rows, v, interpolation) @ samples @ spline(cols, u, interpolation).T
    across, down = step * (u - 0.5 * cols), step * (v - 0.5 * rows)
    c, s = np.cos(np.radians(rotate_deg)), np.sin(np.radians(rotate_deg))
    x = centre[0] + across[None] * c - down[:, None] * s
    y = centre[1] + across[None] * s + down[:, None] * c
    return x.ravel(), y.ravel(), (field * wv[:, None] * wu[None] * step**2).ravel()


def light_of_ring(value, *, radius, inner, nodes):
    """Return places and light of a field value(x, y) between two circles: Gauss nodes outwards, even ones around."""
    t, w = leggauss(nodes)
    r = inner + 0.5 * (radius - inner) * (1.0 + t)
    turn = 2.0 * np.pi * (np.arange(4 * nodes) + 0.5) / (4 * nodes)
    x, y = r[:, None] * np.cos(turn), r[:, None] * np.sin(turn)
    share = (0.5 * (radius - inner) * w * r)[:, None] * (2.0 * np.pi / turn.size)
    return x.ravel(), y.ravel(), (value(x, y) * share).ravel()


def light_of_rectangle(value, *, width, height, rotate_deg, nodes):
    """Return places and light of a field value(u, v) along a rectangle's own sides."""
    t, w = leggauss(nodes)
    u, v = np.meshgrid(0.5 * width * t, 0.5 * height * t)
    c, s = np.cos(np.radians(rotate_deg)), np.sin(np.radians(rotate_deg))
    light = value(u, v) * np.outer(w, w) * 0.25 * width * height
    return (u * c - v * s).ravel(), (u * s + v * c).ravel(), light.ravel()


def photosites(light, *, centres, blur, side, spots, nodes):
    """Return the light at photosites: squares of ``side`` about ``centres``, with every spot of a low-pass filter."""
    x, y, power = light
    g, w = leggauss(nodes)
    values = []
    for px, py in centres:
        total = 0.0
        for sx, sy in spots:
            for a, wa in zip(g, w, strict=True):
                for b, wb in zip(g, w, strict=True):
                    r = np.hypot(x - px - sx - 0.5 * side * a, y - py - sy - 0.5 * side * b)
                    total += 0.25 * wa * wb / len(spots) * np.sum(power * airy(r, blur))
        values.append(total)
    return np.array(values)


def airy(r, blur):
    """Irradiance of a point of unit power behind a lens of cut-off 1/blur."""
    x = np.maximum(np.pi * r / blur, 1e-8)
    return np.pi / blur**2 * (special.j1(x) / x) ** 2


def _axis(count, nodes):
    x, w = leggauss(nodes)
    begin = 0.5 * np.arange(2 * count)
    return (begin[:, None] + 0.25 * (1.0 + x)).ravel(), np.tile(0.25 * w, 2 * count)


def spline(count, t, interpolation):
    """Return (places, samples): what each sample, mirrored at both ends for ever, weighs at places."""
    if interpolation == "squares":
        return (np.floor(t)[:, None] == np.arange(count)).astype(float)
    period = 2 * count
    bump = _tent if interpolation == "linear" else _cubic
    knots = np.arange(period) + 0.5

    def weights(places):
        return sum(bump(places[:, None] - knots + m * period) for m in range(-5, 6))

    whole = weights(t) @ np.linalg.inv(weights(knots))
    return whole[:, :count] + whole[:, : count - 1 : -1]


def _tent(z):
    return np.maximum(1.0 - np.abs(z), 0.0)


def _cubic(z):
    z = np.abs(z)
    return np.where(z < 1.0, (4.0 - 6.0 * z**2 + 3.0 * z**3) / 6.0, np.maximum(2.0 - z, 0.0) ** 3 / 6.0)
