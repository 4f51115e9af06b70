"""What the check sees of a gradient: points of light by Gauss's rule on cells of a pitch, from its own formula."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from camsim.arrays import F64
from camsim.quadrature import gauss_error, gauss_legendre
from camsim.rendering.check.scene_samples import Seen, Zone
from camsim.scene.gradients import Gradient
from camsim.scene.raster import Interpolation, Raster
from camsim.spectra.curve import Spectrum


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Cells(Raster):
    """Cells that cover a gradient; nothing is in them."""

    planes: F64
    spectra: tuple[Spectrum, ...]
    width_um: float
    centre_um: tuple[float, float]
    rotate_deg: float
    interpolation: Interpolation = "squares"

    @classmethod
    def over(cls, gradient: Gradient, pitch_um: float) -> Cells:
        """Return cells of about a pitch."""
        counts = [2 * math.ceil(half / pitch_um) for half in gradient.half_um]
        return cls(
            planes=np.zeros((len(gradient.spectra), counts[1], counts[0])),
            spectra=gradient.spectra,
            width_um=pitch_um * counts[0],
            centre_um=gradient.centre_um,
            rotate_deg=gradient.rotate_deg,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class SeenGradient(Seen):
    """One gradient, pitches; ``picture``: its cells.  highest: frequency of the lens, cycles/pitch; allowed: error."""

    gradient: Gradient
    highest: float
    allowed: float

    @property
    def whole(self) -> np.ndarray:
        """No patch is a sample's."""
        return np.zeros(self.shape, bool)

    def _nodes(self, highest: float, more: float = 1.0) -> int:
        """Return the order of a rule on a cell that may be wrong by so many times more."""
        phase = math.pi * (highest + self.gradient.cycles_per_um * self.pitch_um)
        order = 2
        while order < 60 and gauss_error(order, phase) > math.log(min(max(self.allowed, 1e-12) * more, 1e-2)):
            order += 1
        return order

    def lit_near(self, points: F64, zones: Sequence[Zone]) -> tuple[F64, F64]:
        """Return places and light of parts of cells, then of whole ones, finer where they lie near some point."""
        row, col = np.nonzero(self._states[0])
        middle = self.corner + self.step * np.einsum("na,ax->nx", np.stack([col, row], axis=1) + 0.5, self.axes)
        apart = np.full(len(middle), np.inf)
        for point in points:
            apart = np.minimum(apart, np.hypot(*(middle - point).T))
        places, lights = [self._parts[0]], [self._parts[1]]
        # Where the next zone begins a cell still is of the one before.
        begin = [-math.inf, *(low + 1.0 for _, (low, _) in zones[1:]), zones[-1][1][1] + 1.0, math.inf]
        orders = [self._nodes(self.highest, more) for more, _ in zones] + [self._nodes(0.0)]
        for order, (low, high) in zip(orders, pairwise(begin), strict=True):
            some = (apart > low) & (apart <= high)
            x, w = gauss_legendre(order)
            t = 0.5 * (1.0 + np.stack(np.meshgrid(x, x), axis=-1).reshape(-1, 2))
            at = (np.stack([col, row], axis=1)[some][:, None] + t).reshape(-1, 2)
            places.append(self.corner + self.step * np.einsum("na,ax->nx", at, self.axes))
            lights.append(self._at(at) * np.tile(0.25 * np.outer(w, w).ravel(), np.count_nonzero(some)))
        return np.concatenate(places), np.concatenate(lights, axis=1)

    def points_near(self, radius: float) -> float:
        """Return about how many points lie within a radius of a photosite."""
        cells = float(np.count_nonzero(self._states[0]))
        whole = self._nodes(self.highest) ** 2 * min(cells, math.pi * radius**2) + self._nodes(0.0) ** 2 * cells
        return whole + Seen.points_near(self, radius)

    def _field(self, row: int, col: int, places: F64) -> F64:
        return self._at(places + np.array([col, row]))

    def _at(self, cells: F64) -> F64:
        """Return (planes, n) the field at places (n, 2) in cells from the first one's corner."""
        rows, cols = self.shape
        x, y = (cells - 0.5 * np.array([cols, rows])).T * (self.step * self.pitch_um)
        planes = self.gradient.planes_at(x, y) - self.less[:, None]
        return np.concatenate([planes, np.ones((1, len(x)))]) if self.ones else planes
