"""Brute force: the right answer by a road that camsim does not take. Imports nothing of camsim.

Lengths in any one unit; ``lambda_n`` is wavelength × f-number in it.
"""

from __future__ import annotations

import math

import numpy as np
from scipy import integrate, special


def airy_psf(r, lambda_n):
    """Irradiance of the Airy pattern of unit power, from its definition by Fraunhofer diffraction."""
    x = np.pi * np.asarray(r, float) / lambda_n
    safe = np.where(x == 0, 1.0, x)
    jinc = np.where(x == 0, 0.5, special.j1(safe) / safe)
    return np.pi / lambda_n**2 * jinc**2


def energy_by_integration(radius, lambda_n):
    """Power of the Airy pattern within a radius, by adding up rings."""
    return integrate.quad(
        lambda r: airy_psf(r, lambda_n) * 2 * np.pi * r, 0.0, radius, limit=2000, epsabs=1e-13, epsrel=1e-13
    )[0]


def rayleigh_energy(r, lambda_n):
    """Encircled energy in closed form (checked against ``energy_by_integration`` in the tests)."""
    x = np.pi * np.asarray(r, float) / lambda_n
    return 1.0 - special.j0(x) ** 2 - special.j1(x) ** 2


def coverage_by_rays(polygon, point, energy, nodes=40, advance=0.2):
    """Light that a point sample gets from a bright polygon: rays out of the point, (1/2π)∮ Σ ± E(r) dθ.

    Along each ray the light between entering and leaving the polygon is E(r_out) − E(r_in). The angles are cut where
    a ray meets a corner, and into panels on which the ray's end advances by ``advance`` along the edge.

    polygon : (n, 2), either direction round;  energy: r → encircled energy
    """
    polygon = np.asarray(polygon, float)
    a = polygon - point
    b = np.roll(a, -1, axis=0)
    area = 0.5 * np.sum(a[:, 0] * b[:, 1] - b[:, 0] * a[:, 1])
    total = 0.0
    x, w = np.polynomial.legendre.leggauss(nodes)
    for (ax, ay), (bx, by) in zip(a, b, strict=True):
        cross, dot = ax * by - ay * bx, ax * bx + ay * by
        if cross == 0.0:
            continue
        sweep = math.atan2(cross, dot)  # the angle under which the edge is seen, signed
        length = math.hypot(bx - ax, by - ay)
        h = abs(cross) / length
        along = ((bx - ax) * ax + (by - ay) * ay) / length
        first = math.atan2(along, h)  # angle from the foot of the perpendicular: r = h / cos
        cuts = _angles(first, first + abs(sweep), h, advance)
        low, high = cuts[:-1, None], cuts[1:, None]
        angle = 0.5 * (low + high) + 0.5 * (high - low) * x
        ring = energy(h / np.cos(angle))
        total += math.copysign(np.sum(0.5 * (high - low) * w * ring), sweep)
    return total / (2 * math.pi) * math.copysign(1.0, area)


def _angles(first, last, h, advance):
    s_first, s_last = h * math.tan(first), h * math.tan(last)
    pieces = max(2, math.ceil((s_last - s_first) / advance))
    return np.arctan2(np.linspace(s_first, s_last, pieces + 1), h)


def half_plane(distance, lambda_n):
    """Light at a distance inside a bright half-plane: the line spread integrated, itself integrated from the PSF."""

    def missing(x):  # strips of the PSF beyond x, by polar angle: 1 − E on every ray that crosses the edge
        return (
            integrate.quad(
                lambda t: 1.0 - rayleigh_energy(x / math.cos(t), lambda_n),
                0.0,
                math.pi / 2 - 1e-9,
                limit=4000,
                epsabs=1e-12,
            )[0]
            / math.pi
        )

    return 1.0 - missing(distance) if distance >= 0 else missing(-distance)
