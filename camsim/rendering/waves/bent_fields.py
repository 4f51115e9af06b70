"""Pictures, gradients and points as a lens with distortion throws them.

Samples fall where the distortion throws their places, and light of as much more or less as it stretches area. A
sample's spline becomes one along bent axes, which change little over a part of the frame: about their mean its
transform is taken to the first order. Samples are fine enough for that, and for a spline to bend no further.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from camsim.arrays import C128, F64
from camsim.kept import cached_property
from camsim.optics.protocols import Varies
from camsim.rendering.fields.points import PointLayer
from camsim.rendering.fields.samples import Splines, splines_of
from camsim.rendering.waves.fields import FieldSource
from camsim.rendering.waves.levels import Lattice

HEARD = 0.7  # cycles/pitch: beyond, photosites pass little of what a sample's spline has
SECOND = 0.5  # of the square of what an axis changes by, in cycles of a sample: what the first order leaves
OF_PRECISION = 5.0  # times a transform's: what the first order may leave
FINEST_STEP, COARSEST_STEP = 0.5, 4.0  # pitches, between which samples are refined until it leaves no more
MOST_BLOCKS = 8  # along a side, of samples whose axes are taken about a mean of their own
SIDES = 64  # points along a layer's side, whose places make its box
STEP_UM = 1.0  # about a point, over which area is taken
SLOPE = 1e-4  # cycles, over which a spline's transform is


@dataclass(frozen=True, kw_only=True, eq=False)
class BentSource(FieldSource):
    """A field, seen through a distortion.

    lens : that distorts
    """

    lens: Varies
    pitch_um: float

    @cached_property
    def box(self) -> tuple[F64, F64]:
        """Low and high corners."""
        corners = self.layer.corners
        share = np.arange(SIDES)[:, None] / SIDES
        sides = [a + share * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
        fallen = self._fallen(np.concatenate(sides))
        return fallen.min(axis=0), fallen.max(axis=0)

    def transform(self, lattice: Lattice, origin: tuple[float, float]) -> C128 | None:
        """Return the transform of each mixture of planes."""
        columns, rows = lattice.counts
        out = np.zeros((len(self.mixture), 2 * rows - 1, columns), complex)
        if isinstance(self.layer, PointLayer):
            return out if self._add_points(out, *self._points, lattice, origin) else None
        there = False
        for block in self._blocks(lattice, origin):
            there |= self._add_block(out, block, lattice, origin)
        there |= self._add_points(out, *self._corrections, lattice, origin)
        return out if there else None

    def _fallen(self, places: F64) -> F64:
        """Return where places (n, 2) fall, pitches."""
        fallen: F64 = self.lens.distorted(places * self.pitch_um) / self.pitch_um
        return fallen

    def _thrown(self, places: F64, light: F64) -> tuple[F64, F64]:
        """Return where points fall, and their light (kinds, n) there."""
        step = STEP_UM / self.pitch_um
        (ax, ay), (bx, by) = (
            (self._fallen(places + move) - self._fallen(places - move)).T / (2.0 * step)
            for move in (np.array([step, 0.0]), np.array([0.0, step]))
        )
        return self._fallen(places), light * (ax * by - bx * ay)

    @cached_property
    def _points(self) -> tuple[F64, F64]:
        assert isinstance(self.layer, PointLayer)
        return self._thrown(self.layer.at, self._mixed(self.layer.light))

    @cached_property
    def _corrections(self) -> tuple[F64, F64]:
        return self._thrown(self._splines.points, self._splines.corrections)

    @cached_property
    def _splines(self) -> Splines:
        assert not isinstance(self.layer, PointLayer)
        longest = math.sqrt(OF_PRECISION * self.precision / SECOND) / (HEARD * max(self._changes, 1e-9))
        longest = min(max(longest, FINEST_STEP), COARSEST_STEP)
        found = splines_of(self.layer, cut=self.cut, allowed=self.precision, longest=longest)
        return found._replace(light=self._mixed(found.light), corrections=self._mixed(found.corrections))

    @cached_property
    def _changes(self) -> float:
        """By how much axes change over a part of the frame about the layer's middle and corners."""
        corners = self.layer.corners
        x, y = np.meshgrid(*(np.linspace(corners[:, k].min(), corners[:, k].max(), 9) for k in (0, 1)))
        places = np.stack([x.ravel(), y.ravel()], axis=1)
        axes = self._axes_at(places)
        return float(np.abs(axes - axes.mean(axis=0)).max())

    def _axes_at(self, places: F64) -> F64:
        """Return what unit vectors along x and y become at places: (n, 2, 2)."""
        step = STEP_UM / self.pitch_um
        moves = np.array([step, 0.0]), np.array([0.0, step])
        return np.stack([(self._fallen(places + m) - self._fallen(places - m)) / (2.0 * step) for m in moves], axis=1)

    @cached_property
    def _bent(self) -> tuple[F64, F64, F64]:
        """Where samples (n, 2) fall, what their axes (n, 2, 2) become, and their light (kinds, n)."""
        splines, layer = self._splines, self.layer
        assert not isinstance(layer, PointLayer)
        rows, cols = splines.places.shape[:2]
        fallen = self._fallen(splines.places.reshape(-1, 2)).reshape(rows, cols, 2)
        if min(rows, cols) > 2:
            across, down = (np.gradient(fallen, splines.step, axis=axis, edge_order=2) for axis in (1, 0))
            axes = np.stack([across, down], axis=2).reshape(-1, 2, 2)
        else:
            axes = np.einsum("ax,nxy->nay", layer.axes, self._axes_at(splines.places.reshape(-1, 2)))
        area = axes[:, 0, 0] * axes[:, 1, 1] - axes[:, 0, 1] * axes[:, 1, 0]
        light = splines.light.reshape(len(splines.light), -1) * np.abs(area)
        there = light.any(axis=0)
        return fallen.reshape(-1, 2)[there], axes[there], light[:, there]

    def _blocks(self, lattice: Lattice, origin: tuple[float, float]) -> Iterator[np.ndarray]:
        """Yield samples in sight, in blocks over which axes change little."""
        fallen, axes, _ = self._bent
        at = fallen - np.array(origin)
        inside = np.flatnonzero(((at >= np.array(lattice.low)) & (at <= np.array(lattice.high))).all(axis=1))
        if not inside.size:
            return
        changes = float(np.abs(axes[inside] - axes[inside].mean(axis=0)).max())
        left = SECOND * (self._splines.step * min(lattice.cut, HEARD) * changes) ** 2
        count = max(1, min(MOST_BLOCKS, math.ceil(math.sqrt(left / (OF_PRECISION * self.precision)))))
        if count == 1:
            yield inside
            return
        low, high = at[inside].min(axis=0), at[inside].max(axis=0)
        cell = np.minimum((count * (at[inside] - low) / np.maximum(high - low, 1e-9)).astype(np.int64), count - 1)
        number = cell[:, 0] * count + cell[:, 1]
        for own in np.unique(number).tolist():
            yield inside[number == own]

    def _add_block(self, out: C128, block: np.ndarray, lattice: Lattice, origin: tuple[float, float]) -> bool:
        """Add samples, their splines' transforms to the first order about those along their mean axes."""
        splines, (fallen, axes, light) = self._splines, self._bent
        places, light, mean = fallen[block], light[:, block], axes[block].mean(axis=0)
        columns, rows = lattice.counts
        f = np.arange(columns) / lattice.periods[0], np.arange(1 - rows, rows)[:, None] / lattice.periods[1]
        along = [f[0] * axis[0] + f[1] * axis[1] for axis in mean]
        passes = [splines.passes(own) for own in along]
        part = np.zeros_like(out)
        if not self._add_points(part, places, light, lattice, origin):
            return False
        out += part * (passes[0] * passes[1])
        changes = axes[block] - mean
        first = 2.0 * splines.step * min(lattice.cut, HEARD) * np.abs(changes).max()
        if first <= OF_PRECISION * self.precision:
            return True
        for k in (0, 1):
            steeper = (splines.passes(along[k] + SLOPE) - splines.passes(along[k] - SLOPE)) / (2.0 * SLOPE)
            times = steeper * passes[1 - k]
            for c in (0, 1):
                part[:] = 0.0
                self._add_points(part, places, light * changes[:, k, c], lattice, origin)
                out += part * (times * f[c])
        return True
