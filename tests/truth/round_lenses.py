"""Round lenses from their definitions: pattern, encircled energy, transfer; radii in the unit of ``blur``."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy import interpolate, special


def _jinc(x):
    safe = np.where(np.abs(x) < 1e-5, 1.0, x)
    return np.where(np.abs(x) < 1e-5, 0.5 - x * x / 16.0, special.j1(safe) / safe)


@dataclass(frozen=True)
class Airy:
    """Circle, or ring with an obstruction of ``e`` of the diameter; blur is λN."""

    blur: float
    e: float = 0.0

    @property
    def cutoff(self):
        return 1.0 / self.blur

    @property
    def beat(self):
        """How much slower the slowest thing in it oscillates than the fastest: both rims against each other."""
        return 1.0 / (1.0 - self.e) if self.e else 1.0

    def pattern(self, r):
        x = np.pi * np.asarray(r, float) / self.blur
        amplitude = _jinc(x) - self.e**2 * _jinc(self.e * x)
        return np.pi / (self.blur**2 * (1.0 - self.e**2)) * amplitude**2

    def energy_far(self, r):
        """Encircled energy; None where only the pattern is known in closed form."""
        if self.e:
            return None
        x = np.pi * np.asarray(r, float) / self.blur
        return 1.0 - special.j0(x) ** 2 - special.j1(x) ** 2

    @property
    def powers(self):
        """c1, c3 of 1 − E ≈ c1/r + c3/r³ without what oscillates, from the transfer's odd powers at 0."""
        e, b = self.e, self.blur
        slope = -4.0 / (math.pi * (1.0 - e))
        cubic = 2.0 / (3.0 * math.pi) * (1.0 if e == 0.0 else (1.0 + 1.0 / e) / (1.0 - e * e))
        return -slope * b / (2.0 * math.pi), 3.0 * cubic * (b / (2.0 * math.pi)) ** 3


@dataclass(frozen=True)
class Gauss:
    """Round Gaussian; blur is σ."""

    blur: float

    @property
    def cutoff(self):
        return 1.37 / self.blur

    def pattern(self, r):
        return np.exp(-0.5 * (np.asarray(r, float) / self.blur) ** 2) / (2.0 * np.pi * self.blur**2)

    def energy_far(self, r):
        return -np.expm1(-0.5 * (np.asarray(r, float) / self.blur) ** 2)

    @property
    def powers(self):
        return 0.0, 0.0


class Curve:
    """A transfer given at frequencies, monotone cubics (PCHIP) in between."""

    def __init__(self, frequency, values):
        self.frequency = np.array(frequency, float)
        self.cubic = interpolate.PchipInterpolator(self.frequency, values)
        self.cutoff = float(self.frequency[-1])
        self.blur = 1.0 / self.cutoff

    def pattern(self, r):
        """2π ∫ T(f)·J0(2πfr)·f df by Gauss panels of half a turn of the largest radius."""
        return self._hankel(r, lambda f, r: special.j0(2.0 * np.pi * f * r) * f)

    def energy_far(self, r):
        return np.asarray(r, float) * self._hankel(r, lambda f, r: special.j1(2.0 * np.pi * f * r))

    def _hankel(self, r, kernel):
        r = np.asarray(r, float)
        flat, out = r.ravel(), np.empty(r.size)
        order = np.argsort(flat)
        x, w = np.polynomial.legendre.leggauss(16)
        for some in np.array_split(order, max(1, r.size // 500)):
            longest = float(flat[some].max())
            nodes, weights = [], []
            for low, high in pairwise(self.frequency):
                panels = max(1, math.ceil((high - low) * longest * 0.5))
                edges = np.linspace(low, high, panels + 1)
                half = 0.5 * np.diff(edges)[:, None]
                nodes.append((0.5 * (edges[:-1] + edges[1:])[:, None] + half * x).ravel())
                weights.append((half * w).ravel())
            f, share = np.concatenate(nodes), np.concatenate(weights)
            out[some] = kernel(f[:, None], flat[some]).T @ (2.0 * np.pi * share * self.cubic(f))
        return out.reshape(r.shape)

    @property
    def powers(self):
        slope, cubic = float(self.cubic.c[2, 0]), float(self.cubic.c[0, 0])
        return -slope / (2.0 * math.pi), 3.0 * cubic / (2.0 * math.pi) ** 3
