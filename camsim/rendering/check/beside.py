"""Photosites that see an aberrated lens's difference beside whole straight lines only: looked up, not transformed.

The edge of a half plane, a distance h away, shows S(h) = ∫ T(f·n)·exp(2πi·f·h)/(2πi·f) df, n its normal towards the
half plane: the running integral of the line spread, 0 far away on either side, as there is no light in a difference.
With a sum in place of the integral, f = k/P, the same line lies at every multiple of P, farther than anything that is
looked at; the sum's constant goes with what is seen half a period away, where there is nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, U8
from camsim.kept import cached_property
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.check.overlap import Fused, Overlapping
from camsim.rendering.check.scenery import Pieces
from camsim.rendering.check.whereabouts import Whereabouts
from camsim.rendering.job import Job
from camsim.rendering.modes import mixed

PERIOD = 4.0  # reaches: other lines lie three of them away
OF_TAPER = 0.25  # of a taper's share, where there is none: what the transfers may be wrong by
OF_WAVELENGTHS = 1e-3  # of their share: what is left of a weight that few modes describe


@dataclass(frozen=True, kw_only=True, eq=False)
class Beside:
    """A difference beside lines; lengths in pitches.

    job           : whose optics it has;  lens: what follows its transfers
    wavelength_nm : (j,);  density: (spectra, channels, j)
    budget        : of what may be wrong
    """

    job: Job
    lens: Overlapping
    pieces: Pieces
    where: Whereabouts
    wavelength_nm: F64
    density: F64
    budget: ErrorBudget

    @cached_property
    def reach(self) -> float:
        """Distance from a photosite's middle beyond which nothing is looked at."""
        system, nm = self.job.system, self.wavelength_nm
        lost, rings = self.budget.allowed("reach"), system.ring_share(nm)
        reach_um = max(self.lens.reach_um(lost, own, rings) for own in (float(nm.min()), float(nm.max())))
        extent_um = system.extent_um
        return max(reach_um / self.job.grid.pitch_um, self.job.rings_until) + extent_um / self.job.grid.pitch_um

    def alone(self, points: F64) -> bool:
        """Return whether points (n, 2) see whole straight lines, if anything."""
        o = self.pieces.outlines
        straight = o.turn_rad == 0.0
        # A Bézier curve lies no farther from its chord than this is long.
        short = np.where(self.pieces.bezier >= 0, self.where.length, 0.0)
        for places in self.where.some_of(points):
            x, y = o.x - places[:, :1], o.y - places[:, 1:]
            first = np.hypot(x, y)
            # No part of a round piece lies nearer than its circle.
            nearer_end = np.minimum(first, np.hypot(x + o.dx, y + o.dy))
            gaps = np.where(straight, nearer_end - short, np.abs(first - o.dx))
            if (gaps < self.reach).any():
                return False
        return True

    @property
    def seconds(self) -> float:
        """What the transfers are expected to take; to look lines up takes a moment."""
        _, channels, wavelengths = self.density.shape
        return self.lens.sizes.seconds(wavelengths, channels)

    def values(self, points: F64, sets: U8) -> F64:
        """Return the light at points (n, 2) that are ``alone``, each in its channel of ``sets`` (..., n)."""
        values = np.zeros(sets.shape)
        distance, beside = self.where.feet(points)
        seen = beside & (np.abs(distance) < self.reach)
        which = np.flatnonzero(seen.any(axis=0))
        if not which.size:
            return values
        o, pieces, nm = self.pieces.outlines, self.pieces, self.wavelength_nm
        contrast = self.density[pieces.left[which]] - self.density[pieces.right[which]]
        off = OF_WAVELENGTHS * self.budget.allowed("wavelengths") / nm.size
        modes, mixture = mixed(contrast.reshape(-1, nm.size), off)
        fused = self.lens.fused(nm, modes, OF_TAPER * self.budget.allowed("taper"))
        times = mixture.reshape(len(modes), *contrast.shape[:2])
        normals = np.stack([-o.dy[which], o.dx[which]], axis=1) / self.where.length[which][:, None]
        for n, piece in enumerate(which.tolist()):
            there = np.flatnonzero(seen[:, piece])
            shown = np.einsum("mc,mp->cp", times[:, n], self._shown(fused, normals[n], distance[there, piece]))
            values[..., there] += shown[sets[..., there], np.arange(there.size)]
        return values

    def _shown(self, fused: Fused, normal: F64, distance: F64) -> F64:
        """Return what a half plane shows (modes, distances)."""
        system, pitch_um = self.job.system, self.job.grid.pitch_um
        period = PERIOD * self.reach
        highest = self.lens.cutoff_per_um(float(self.wavelength_nm.min())) * pitch_um
        k = np.arange(1.0, math.ceil(period * highest))
        fx, fy = np.multiply.outer(normal, k / (period * pitch_um))
        waves = fused.at(fx, fy) * system.footprint_otf(fx, fy) / (1j * np.pi * k)
        turns = np.exp(2j * np.pi * np.multiply.outer(k, distance / period)) - np.where(k % 2.0, -1.0, 1.0)[:, None]
        shown: F64 = np.einsum("mk,kp->mp", waves, turns, optimize=False).real
        return shown
