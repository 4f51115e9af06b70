"""Pictures, gradients and points behind a lens with distortion.

The distortion maps the position of each sample, and its light scales with the local change of area. A sample's spline
gets axes along the map's derivatives, which vary little over a part of the frame; its transform is expanded to first
order about their mean. Samples are fine enough for this expansion and for the curvature of a spline to be negligible.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import F64, Complex, distinct
from camsim.core.cached import cached_property
from camsim.numerics.nonuniform import complex_type
from camsim.optics.protocols import Varies
from camsim.rendering.fields.points import PointLayer
from camsim.rendering.fields.samples import Splines, Support, splines_of
from camsim.rendering.waves.fields import FieldSource
from camsim.rendering.waves.levels import Lattice

COUNTED = 0.7  # cycles/pitch: above this, photosites pass little of a sample's spline
SECOND = 0.5  # error of the first order, over the square of an axis's change in cycles per sample
OF_PRECISION = 5.0  # error allowed to the first order, over that of a transform
FINEST_STEP, COARSEST_STEP = 0.5, 4.0  # pitches: limits of the refinement of samples that the first order needs
MOST_BLOCKS = 8  # along a side, of blocks of samples, each with its mean axes
SIDES = 64  # points along a layer's side whose images give its box
STEP_UM = 1.0  # of the differences for axes and area
SLOPE = 1e-4  # cycles: step of the difference for the slope of a spline's transform


@dataclass(frozen=True, kw_only=True, eq=False)
class BentSource(FieldSource):
    """A field, imaged with distortion.

    lens : gives the distortion
    """

    lens: Varies
    pitch_um: float

    @cached_property
    def box(self) -> tuple[F64, F64]:
        """Low and high corner (2,) of the bounding box, pitches."""
        corners = self.layer.corners
        share = np.arange(SIDES)[:, None] / SIDES
        sides = [a + share * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
        fallen = self._fallen(np.concatenate(sides))
        return fallen.min(axis=0), fallen.max(axis=0)

    def thinning(self, far: tuple[float, ...], support: Support) -> BentSource:
        """Return the source itself: all of its samples are needed at all frequencies."""
        return self

    def transform(self, lattice: Lattice, origin: tuple[float, float]) -> Complex | None:
        """Return the transform of each mixture of planes; None: no light in the lattice's box."""
        columns, rows = lattice.counts
        out = np.zeros((len(self.mixture), 2 * rows - 1, columns), complex_type(self.precision))
        if isinstance(self.layer, PointLayer):
            return out if self._add_points(out, *self._points, lattice, origin) else None
        there = False
        for block in self._blocks(lattice, origin):
            there |= self._add_block(out, block, lattice, origin)
        there |= self._add_points(out, *self._corrections, lattice, origin)
        return out if there else None

    def _fallen(self, places: F64) -> F64:
        """Return the distorted positions of places (n, 2), pitches."""
        fallen: F64 = self.lens.distorted(places * self.pitch_um) / self.pitch_um
        return fallen

    def _thrown(self, places: F64, light: F64) -> tuple[F64, F64]:
        """Return the distorted positions of points, and their light (kinds, n) there."""
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
        longest = math.sqrt(OF_PRECISION * self.precision / SECOND) / (COUNTED * max(self._changes, 1e-9))
        longest = min(max(longest, FINEST_STEP), COARSEST_STEP)
        found = splines_of(self.layer, cut=self.cut, allowed=self.precision, longest=longest)
        return found._replace(light=self._mixed(found.light), corrections=self._mixed(found.corrections))

    @cached_property
    def _changes(self) -> float:
        """Largest deviation of the axes from their mean, on a grid over the layer's box."""
        corners = self.layer.corners
        x, y = np.meshgrid(*(np.linspace(corners[:, k].min(), corners[:, k].max(), 9) for k in (0, 1)))
        places = np.stack([x.ravel(), y.ravel()], axis=1)
        axes = self._axes_at(places)
        return float(np.abs(axes - axes.mean(axis=0)).max())

    def _axes_at(self, places: F64) -> F64:
        """Return the images (n, 2, 2) of the unit vectors along x and y at places: the distortion's derivatives."""
        step = STEP_UM / self.pitch_um
        moves = np.array([step, 0.0]), np.array([0.0, step])
        return np.stack([(self._fallen(places + m) - self._fallen(places - m)) / (2.0 * step) for m in moves], axis=1)

    @cached_property
    def _bent(self) -> tuple[F64, F64, F64]:
        """Distorted positions (n, 2) and axes (n, 2, 2) of the samples, and their light (kinds, n)."""
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
        return fallen.reshape(-1, 2), axes, splines.light.reshape(len(splines.light), -1) * np.abs(area)

    def _blocks(self, lattice: Lattice, origin: tuple[float, float]) -> Iterator[np.ndarray]:
        """Yield the samples in the lattice's box, in blocks over which axes change little."""
        fallen, axes, _ = self._bent
        at = fallen - np.array(origin)
        inside = np.flatnonzero(((at >= np.array(lattice.low)) & (at <= np.array(lattice.high))).all(axis=1))
        if not inside.size:
            return
        changes = float(np.abs(axes[inside] - axes[inside].mean(axis=0)).max())
        left = SECOND * (self._splines.step * min(lattice.cut, COUNTED) * changes) ** 2
        count = max(1, min(MOST_BLOCKS, math.ceil(math.sqrt(left / (OF_PRECISION * self.precision)))))
        if count == 1:
            yield inside
            return
        low, high = at[inside].min(axis=0), at[inside].max(axis=0)
        cell = np.minimum((count * (at[inside] - low) / np.maximum(high - low, 1e-9)).astype(np.int64), count - 1)
        number = cell[:, 0] * count + cell[:, 1]
        for one in distinct(number).tolist():
            yield inside[number == one]

    def _add_block(self, out: Complex, block: np.ndarray, lattice: Lattice, origin: tuple[float, float]) -> bool:
        """Add samples, with their splines' transforms expanded to first order about the mean axes."""
        splines, (fallen, axes, light) = self._splines, self._bent
        places, light, mean = fallen[block], light[:, block], axes[block].mean(axis=0)
        columns, rows = lattice.counts
        f = np.arange(columns) / lattice.periods[0], np.arange(1 - rows, rows)[:, None] / lattice.periods[1]
        along = [f[0] * axis[0] + f[1] * axis[1] for axis in mean]
        passes = [splines.passes(one) for one in along]
        part = np.zeros_like(out)
        if not self._add_points(part, places, light, lattice, origin):
            return False
        out += part * (passes[0] * passes[1])
        changes = axes[block] - mean
        first = 2.0 * splines.step * min(lattice.cut, COUNTED) * np.abs(changes).max()
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
