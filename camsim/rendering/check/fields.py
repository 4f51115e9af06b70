"""Photosites of a picture computed again, by sums over its samples in the plane of the sensor.

Nothing is transformed: the pattern's irradiance is taken at nodes over every sample's square and over the photosite.
Beyond a distance its rings are averaged, and a square is its middle. A photosite behind an OLPF is the mean of several,
one at each spot, however far apart these are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.kept import cached_property
from camsim.kernels import shared
from camsim.optics import OpticalSystem
from camsim.optics.protocols import KnowsEnergy, Rectangular, Round
from camsim.quadrature import gauss_legendre, gauss_order
from camsim.quintics import quintic_cells
from camsim.rendering.check.field_kernels import (
    Far,
    Near,
    Patches,
    Rule,
    far_points_light,
    lattice_light,
    middles_light,
    points_light,
)
from camsim.rendering.check.scene_samples import LARGEST, Seen
from camsim.rendering.grid import Grid

LOOK_UP = 0.05  # of what may be wrong, that a look-up of the pattern by six points, 5e-3·(2π/cells)⁶, may be
SMALLEST, COARSEST = 1e-12, 1e-2  # of the rules
ZONES = 2.0  # times as far, from one zone to the next: rules may be wrong by more where the pattern is faint
FARTHER, LISTENED = 1.3, 64  # steps of the radius, and places where rings are listened to
RINGS = 4.0  # times an Airy pattern's, that those of others may have
NODE_SECONDS = 6e-9  # of one core, measured
FAR_SECONDS, PLACE_SECONDS = 8e-9, 1e-7


def at_spots(points: F64, spots: F64) -> F64:
    """Return points (n, 2) moved by every spot (k, 2), those of one point after the other (n·k, 2)."""
    moved: F64 = (points[:, None] + spots).reshape(-1, 2)
    return moved


@dataclass(frozen=True, kw_only=True, eq=False)
class DirectSums:
    """What sums.

    seen          : of every picture, see there
    density       : (planes, channels, n) of all their planes;  wavelength_nm: (n,)
    allowed       : what a sum may be wrong by;  moved: (2,) where the pattern's centre lies, pitches
    until         : as far as rings are heard in step, pitches
    """

    seen: tuple[Seen, ...]
    density: F64
    wavelength_nm: F64
    system: OpticalSystem
    grid: Grid
    allowed: float
    moved: F64
    until: float = 0.0

    @staticmethod
    def can(system: OpticalSystem) -> bool:
        """Whether a system's photosites can be summed directly: round lenses on rectangles."""
        lens = system.lens
        known = isinstance(lens, Round) and isinstance(lens, KnowsEnergy) and not system.more
        return known and isinstance(system.photosite, Rectangular)

    @cached_property
    def _blur(self) -> tuple[float, float]:
        """The shortest and the longest pattern's length, pitches."""
        lengths = self.system.blurs_um(self.wavelength_nm) / self.grid.pitch_um
        return float(lengths.min()), float(lengths.max())

    @cached_property
    def _sides(self) -> tuple[float, float]:
        """A photosite's width and height, pitches."""
        photosite = self.system.photosite
        assert isinstance(photosite, Rectangular)
        width, height = photosite.sides_um
        return width / self.grid.pitch_um, height / self.grid.pitch_um

    @cached_property
    def _spots(self) -> F64:
        """Where (n, 2) a photosite's images by the OLPF lie from it, pitches."""
        spots: F64 = self.system.spots_um() / self.grid.pitch_um
        return spots

    def footprint(self, more: float = 1.0) -> tuple[F64, F64]:
        """Nodes (m, 2) and weights (m,) over a photosite; ``more`` may be wrong by so many times more."""
        (x, wx), (y, wy) = (self._rule(side, more) for side in self._sides)
        return np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2), np.outer(wx, wy).ravel()

    def _rule(self, side: float, more: float = 1.0) -> tuple[F64, F64]:
        """Return a Gauss rule over a length, the weights adding up to 1, that follows the shortest wave."""
        allowed = min(max(self.allowed, SMALLEST) * more, COARSEST)
        order = gauss_order(math.pi * side / self._blur[0], allowed, least=2) if side else 1
        x, w = gauss_legendre(order)
        return 0.5 * side * x, 0.5 * w

    @cached_property
    def _farthest(self) -> float:
        """The largest distance of a photosite from anything that is seen, pitches."""
        x0, y0 = np.array(self.grid.first_centre) - self.moved
        x1, y1 = x0 + self.grid.cols - 1.0, y0 + self.grid.rows - 1.0
        corners = at_spots(np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)]), self._spots)
        return max(seen.farthest(corners) for seen in self.seen)

    @cached_property
    def radius(self) -> float:
        """The distance beyond which rings are averaged: where a random picture hears less of them than is allowed.

        A ring's light at r is L/π³r³, a pattern of both signs; that of independent samples adds up by squares.
        """
        largest = max(seen.step for seen in self.seen)
        blur = self._blur[1]
        heard = blur / math.pi**3 * max(largest, 1.0) * math.sqrt(0.5 * math.pi)
        fall = min(1.0, (blur / math.pi) ** 2)  # of the footprint's own mean over a ring, on most of it
        radius, extent = max(6.0 * blur, 8.0), 0.5 * max(self._sides) + 1.5 * min(largest, LARGEST)
        lengths = self.system.blurs_um(self.wavelength_nm) / self.grid.pitch_um
        # A point is heard by what is beside its own ring only, and all of it in step.
        lit = RINGS * blur / math.pi**3 * min(1.0, sum(seen.loud for seen in self.seen))
        while (heard_here := heard * fall / radius**2 + lit / radius**3) > self.allowed:
            # Wavelengths whose rings are out of step are heard less.
            places = radius * np.linspace(1.0, FARTHER, LISTENED)
            turns = np.exp(2j * np.pi * places[:, None] / lengths)
            sums = np.einsum("qj,rj->qr", self.density.reshape(-1, lengths.size).astype(complex), turns)
            if heard_here * min(1.0, float(np.abs(sums).max())) <= self.allowed:
                break
            radius *= FARTHER
        return min(max(radius, self.until), self._farthest) + extent

    @cached_property
    def zones(self) -> list[tuple[float, tuple[float, float]]]:
        """How many times more rules may be wrong by, from where to where: the pattern falls with distance³."""
        extent = 0.5 * max(self._sides) + LARGEST
        edges = [0.0]
        while edges[-1] < self.radius:
            edges.append(ZONES * edges[-1] if len(edges) > 1 else 2.0 * extent + 2.0 * self._blur[1])
        edges[-1] = self.radius
        return [(max(1.0, (max(low - extent, 0.0) / self._blur[1]) ** 3), (low, high)) for low, high in pairwise(edges)]

    @cached_property
    def seconds_each(self) -> float:
        """What one photosite is expected to take."""
        total = NODE_SECONDS
        for seen in self.seen:
            for more, (low, high) in self.zones:
                patches = min(math.pi * (high**2 - low**2) / seen.step**2, seen.whole.size)
                inner = len(self._rule(seen.step, more)[0]) ** 2 * len(self.footprint(more)[1])
                total += patches * inner * NODE_SECONDS * seen.planes
            total += seen.whole.size * FAR_SECONDS
            *near, far = seen.points_near(self.zones).tolist()
            for count, (more, _) in zip(near, self.zones, strict=True):
                total += count * (PLACE_SECONDS + len(self.footprint(more)[1]) * NODE_SECONDS * seen.planes)
            total += far * (PLACE_SECONDS + FAR_SECONDS * seen.planes)
        return total * len(self._spots)

    def values(self, rows: I64, cols: I64, sets: U8) -> F64:
        """Return what pictures add at photosites, each in its channel of ``sets`` (..., photosites)."""
        x0, y0 = self.grid.first_centre
        points = np.stack([x0 + cols, y0 + rows], axis=1).astype(float) - self.moved
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
        points = at_spots(points, self._spots)
        near, far = self._table(density), self._averaged(density, seen.farthest(points))
        zones = [(Rule(*self.footprint(more)), self._inner(seen, more), bounds) for more, bounds in self.zones]
        patches = Patches(seen.values, seen.whole, seen.degree, seen.corner, seen.axes * seen.step)
        out = np.zeros((channels, len(points)))

        def work(begin: int, end: int) -> None:
            for k in range(begin, end):
                point = points[k]
                for footprint, inner, bounds in zones:
                    out[:, k] += lattice_light(patches, point, footprint, inner, near, bounds)
                out[:, k] += middles_light(patches, point, far, self.radius)
                for places, light in seen.lit_near(point, self.zones):
                    for footprint, _, bounds in zones:
                        from_here = (bounds[0] if bounds[0] > 0.0 else -1.0, bounds[1])
                        out[:, k] += points_light(places, light, point, footprint, near, from_here)
                    out[:, k] += far_points_light(places, light, point, far, self.radius)

        shared(len(points), work)
        mean: F64 = out.reshape(channels, -1, len(self._spots)).mean(axis=2) * seen.step**2
        return mean

    def _inner(self, seen: Seen, more: float) -> Rule:
        """Return the rule over a patch's side, −1/2 … 1/2."""
        nodes, weights = self._rule(seen.step, more)
        return Rule(nodes / seen.step, weights)

    def _table(self, density: F64) -> Near:
        """Return the pattern of every plane and channel, per square pitch, out to the farthest node of what is near."""
        lens, pitch_um = self.system.lens, self.grid.pitch_um
        assert isinstance(lens, Round)
        cells = 2.0 * math.pi * (5e-3 / (LOOK_UP * max(self.allowed, SMALLEST))) ** (1.0 / 6.0)
        per_pitch = max(cells, 24.0) / self._blur[0]
        reach = self.radius + 0.5 * math.hypot(*self._sides) + LARGEST
        count = math.ceil(reach * per_pitch) + 2
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
