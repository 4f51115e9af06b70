"""The footprint: photosite ⊗ OLPF spots, in pitches; its moments and its transfer at one frequency."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64
from camsim.optics import OpticalSystem
from camsim.rendering.quadrature import gauss_legendre


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Footprint:
    """A square of ``side`` on every spot.

    side   : pitches; 0 is a point
    spots  : (n, 2) offsets, pitches
    shifts : distinct offsets along one axis (the spots are all their pairs)
    sigma2 : second moment per axis; m22 = ⟨|ζ|⁴⟩, m4 = ⟨ζ⁴⟩ (real: mirror symmetry), m6 = ⟨|ζ|⁶⟩, m8 = |⟨ζ⁸⟩|
    """

    side: float
    spots: F64
    shifts: F64
    sigma2: float
    m22: float
    m4: float
    m6: float
    m8: float

    @classmethod
    def of(cls, system: OpticalSystem, pitch_um: float) -> Footprint:
        """Measure the system's footprint in pitches; a 5-point Gauss rule is exact for every moment used."""
        side = system.photosite.side_um / pitch_um
        spots = system.spots_um() / pitch_um
        zeta, weight = footprint_rule(side, spots, 5)
        z = zeta[:, 0] + 1j * zeta[:, 1]
        return cls(
            side=side,
            spots=spots,
            shifts=np.unique(spots[:, 0]),
            sigma2=float(weight @ zeta[:, 0] ** 2),
            m22=float(weight @ np.abs(z) ** 4),
            m4=float((weight @ z**4).real),
            m6=float(weight @ np.abs(z) ** 6),
            m8=float(abs(weight @ z**8)),
        )

    @property
    def extent(self) -> float:
        """Distance of its farthest point from its centre, pitches."""
        return float(np.hypot(*(np.abs(self.spots) + 0.5 * self.side).T).max())

    def transfer(self, frequency: F64) -> F64:
        """OTF (directions, n), signed, at each radial frequency (cycles/pitch) from 0° to 45°, its octant."""
        # One wavelength has narrow lobes where the footprint is many λN wide; a spectrum smears them.
        angle = np.linspace(0.0, np.pi / 4, 33 if frequency.size == 1 else 9)
        fx, fy = np.outer(np.cos(angle), frequency), np.outer(np.sin(angle), frequency)
        spots = np.mean([np.cos(2 * np.pi * (fx * sx + fy * sy)) for sx, sy in self.spots], axis=0)
        otf: F64 = np.sinc(self.side * fx) * np.sinc(self.side * fy) * spots
        return otf


def rule_order(phase: float, allowed: float) -> int:
    """Return the order of a Gauss rule that integrates cos(phase·x) over −1 … 1 to ``allowed``."""
    order = 3
    log_phase = math.log(max(phase, 1e-3))
    while True:
        error = (
            (2 * order + 1) * math.log(2.0)
            + 4 * math.lgamma(order + 1)
            - math.log(2 * order + 1)
            - 3 * math.lgamma(2 * order + 1)
            + 2 * order * log_phase
        )
        if error < math.log(allowed):
            return order
        order += 1


def footprint_rule(side: float, spots: F64, order: int) -> tuple[F64, F64]:
    """Return nodes (m, 2) and weights (m,) of a Gauss product rule over the square, on every spot."""
    if side == 0.0:
        return spots, np.full(len(spots), 1.0 / len(spots))
    x, w = gauss_legendre(order)
    grid = 0.5 * side * np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2)
    weight = np.outer(w, w).ravel() / 4.0
    nodes = (spots[:, None, :] + grid[None]).reshape(-1, 2)
    return nodes, np.tile(weight, len(spots)) / len(spots)
