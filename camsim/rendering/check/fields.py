"""Photosites of a picture computed again, by sums over its samples in the plane of the sensor.

Nothing is transformed: the pattern's irradiance is taken at nodes over every sample's square and over the photosite.
Beyond a distance its rings are averaged, and a square is its middle.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.kernels import ONE_AT_A_TIME
from camsim.optics import OpticalSystem
from camsim.optics.protocols import KnowsEnergy, Rectangular, Round
from camsim.quadrature import gauss_error, gauss_legendre, quintic_cells
from camsim.rendering.check.field_kernels import (
    Far,
    Near,
    Patches,
    Rule,
    lattice_light,
    middles_light,
    points_light,
)
from camsim.rendering.check.scene_samples import Seen
from camsim.rendering.grid import Grid

CELLS_PER_BLUR = 24.0  # of the pattern's table: 5e-3·(2π/24)⁶ of its rings
SMALLEST, COARSEST = 1e-12, 1e-3  # of the rules
CLOSE, AWAY = 0.3, 100.0  # beyond a part of the radius, where the pattern is faint, rules may be wrong by more
NODE_SECONDS = 6e-9  # of one core, measured
FAR_SECONDS = 8e-9


@dataclass(frozen=True, kw_only=True, eq=False)
class DirectSums:
    """What sums.

    seen          : of every picture, see there
    density       : (planes, channels, n) of all their planes;  wavelength_nm: (n,)
    allowed       : what a sum may be wrong by
    """

    seen: tuple[Seen, ...]
    density: F64
    wavelength_nm: F64
    system: OpticalSystem
    grid: Grid
    allowed: float

    @staticmethod
    def can(system: OpticalSystem) -> bool:
        """Whether a system's photosites can be summed directly: round lenses on rectangles."""
        lens = system.lens
        known = isinstance(lens, Round) and isinstance(lens, KnowsEnergy) and not system.more
        return known and isinstance(system.photosite, Rectangular)

    @functools.cached_property
    def _blur(self) -> tuple[float, float]:
        """The shortest and the longest pattern's length, pitches."""
        lengths = self.system.blurs_um(self.wavelength_nm) / self.grid.pitch_um
        return float(lengths.min()), float(lengths.max())

    def footprint(self, more: float = 1.0) -> tuple[F64, F64]:
        """Nodes (m, 2) and weights (m,) over photosite and spots; ``more`` may be wrong by so many times more."""
        photosite = self.system.photosite
        assert isinstance(photosite, Rectangular)
        axes = [self._rule(side / self.grid.pitch_um, more) for side in photosite.sides_um]
        (x, wx), (y, wy) = axes
        square = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
        spots = self.system.spots_um() / self.grid.pitch_um
        nodes = (spots[:, None] + square).reshape(-1, 2)
        return nodes, np.tile(np.outer(wx, wy).ravel() / len(spots), len(spots))

    def _rule(self, side: float, more: float = 1.0) -> tuple[F64, F64]:
        """Return a Gauss rule over a length, the weights adding up to 1, that follows the shortest wave."""
        order = 1 if side == 0.0 else 2
        allowed = math.log(min(max(self.allowed, SMALLEST) * more, COARSEST))
        while side and gauss_error(order, math.pi * side / self._blur[0]) > allowed:
            order += 1
        x, w = gauss_legendre(order)
        return 0.5 * side * x, 0.5 * w

    @functools.cached_property
    def radius(self) -> float:
        """The distance beyond which rings are averaged: where a random picture hears less of them than is allowed.

        A ring's light at r is L/π³r³, a pattern of both signs; that of independent samples adds up by squares.
        """
        largest = max(seen.step for seen in self.seen)
        blur = self._blur[1]
        heard = blur / math.pi**3 * max(largest, 1.0) * math.sqrt(0.5 * math.pi)
        fall = min(1.0, (blur / math.pi) ** 2)  # of the footprint's own mean over a ring, on most of it
        quiet = math.sqrt(heard * fall / self.allowed)
        extent = float(np.abs(self.footprint()[0]).max()) + 1.5 * largest
        return max(quiet, 6.0 * blur, 8.0) + extent

    @functools.cached_property
    def seconds_each(self) -> float:
        """What one photosite is expected to take."""
        nodes, total = len(self.footprint()[1]), 0.0
        for seen in self.seen:
            near = min(math.pi * self.radius**2 / seen.step**2, seen.shape[0] * seen.shape[1])
            inner = len(self._rule(seen.step)[0]) ** 2 * nodes
            outer = len(self._rule(seen.step, AWAY)[0]) ** 2 * len(self.footprint(AWAY)[1])
            total += near * (CLOSE**2 * inner + outer) * NODE_SECONDS * seen.planes
            total += seen.shape[0] * seen.shape[1] * FAR_SECONDS
            total += seen.points_near(self.radius) * nodes * NODE_SECONDS * seen.planes
        return total

    def values(self, rows: I64, cols: I64, sets: U8) -> F64:
        """Return what pictures add at photosites, each in its channel of ``sets`` (..., photosites)."""
        x0, y0 = self.grid.first_centre
        points = np.stack([x0 + cols, y0 + rows], axis=1).astype(float)
        out = np.zeros(sets.shape)
        for channel in np.unique(sets):
            mine = sets == channel
            wanted = np.flatnonzero(mine.reshape(-1, rows.size).any(axis=0))
            light = np.zeros(rows.size)
            first = 0
            for seen in self.seen:
                own = self.density[first : first + seen.planes, channel : channel + 1]
                first += seen.planes
                light[wanted] += self._of(seen, own, points[wanted])[0]
            out[mine] = np.broadcast_to(light, sets.shape)[mine]
        return out

    def _of(self, seen: Seen, density: F64, points: F64) -> F64:
        """Return (channels, points) of one picture."""
        channels = density.shape[1]
        near, far = self._table(density), self._averaged(density, seen.farthest(points))
        zones = [
            (Rule(*self.footprint(more)), self._inner(seen, more), bounds)
            for more, bounds in ((1.0, (0.0, CLOSE * self.radius)), (AWAY, (CLOSE * self.radius, self.radius)))
        ]
        patches = Patches(seen.values, seen.whole, seen.degree, seen.corner, seen.axes * seen.step)
        out = np.zeros((channels, len(points)))
        with ONE_AT_A_TIME:
            for k, point in enumerate(points):
                for footprint, inner, bounds in zones:
                    out[:, k] += lattice_light(patches, point, footprint, inner, near, bounds)
                out[:, k] += middles_light(patches, point, far, self.radius)
                if seen.points.size:
                    out[:, k] += points_light(seen.points, seen.light, point, zones[0][0], near, far, self.radius)
        return out * seen.step**2

    def _inner(self, seen: Seen, more: float) -> Rule:
        """Return the rule over a patch's side, −1/2 … 1/2."""
        nodes, weights = self._rule(seen.step, more)
        return Rule(nodes / seen.step, weights)

    def _table(self, density: F64) -> Near:
        """Return the pattern of every plane and channel out to the radius, per square pitch."""
        lens, pitch_um = self.system.lens, self.grid.pitch_um
        assert isinstance(lens, Round)
        per_pitch = CELLS_PER_BLUR / self._blur[0]
        count = math.ceil((self.radius + 2.0) * per_pitch) + 2
        radius = (np.arange(-2, count + 3)) / per_pitch
        values = np.zeros((*density.shape[:2], radius.size))
        for j, nm in enumerate(self.wavelength_nm.tolist()):
            values += density[..., j, None] * lens.point_spread(np.abs(radius) * pitch_um, nm) * pitch_um**2
        return Near(np.ascontiguousarray(np.moveaxis(quintic_cells(values), 2, 0)), per_pitch)

    def _averaged(self, density: F64, farthest: float) -> Far:
        """Return r³ times the pattern's mean over a ring, on steps of log r."""
        lens, pitch_um = self.system.lens, self.grid.pitch_um
        assert isinstance(lens, KnowsEnergy)
        first, last = math.log(0.5 * self.radius), math.log(max(farthest, self.radius) + 2.0)
        log_r = np.linspace(first, last, 512)
        radius, total = np.exp(log_r), np.zeros((512, *density.shape[:2]))
        for j, nm in enumerate(self.wavelength_nm.tolist()):
            half = 0.5 * self.system.blur_um(nm) / pitch_um
            within = [lens.encircled_energy((radius + sign * half) * pitch_um, nm) for sign in (1.0, -1.0)]
            mean = (within[0] - within[1]) / (4.0 * math.pi * radius * half)
            total += (mean * radius**3)[:, None, None] * density[None, ..., j]
        return Far(total, first, 511.0 / (last - first))
