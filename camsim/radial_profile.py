"""A round pattern along its radius: polynomials on quarters of its own length, which are right to 6e-14 of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64
from camsim.quadrature import chebyshev, interpolation

SAMPLES, CELLS = 20, 4  # points of a pattern on its own length: 7e-15; it is interpolated on quarters of that:
DEGREE = 11  # of the pattern on a quarter of its own length: 6e-14
MIDDLE = 0.5  # of a cell: what powers are taken about


class Profile(NamedTuple):
    """A function at nodes on every cell out to a radius.

    radius_um : (cells, DEGREE + 1);  values: (cells, DEGREE + 1, ...);  cell_um: how long one is
    """

    radius_um: F64
    values: F64
    cell_um: float

    @classmethod
    def of(cls, light: Callable[[F64], F64], length_um: float, outer_um: float) -> Profile:
        """Ask what is as smooth as a pattern of that length, as far as ``outer_um``: radii (n,) → (n, ...)."""
        outer_um = max(outer_um, length_um)
        lengths = math.ceil(outer_um / length_um)
        sampled, x = chebyshev(SAMPLES), chebyshev(DEGREE + 1)
        values = light(((np.arange(lengths)[:, None] + 0.5 * (1.0 + sampled)) * (outer_um / lengths)).ravel())
        values = values.reshape(lengths, SAMPLES, *values.shape[1:])
        within = (2.0 * np.arange(CELLS)[:, None] + 1.0 + x).ravel() / CELLS - 1.0
        values = np.einsum("fx,lx...->lf...", interpolation(sampled, within), values)
        count = CELLS * lengths
        radius_um = (np.arange(count)[:, None] + 0.5 * (1.0 + x)) * (outer_um / count)
        return cls(radius_um, values.reshape(count, DEGREE + 1, *values.shape[2:]), outer_um / count)

    @property
    def powers(self) -> F64:
        """Coefficients (cells, DEGREE + 1, ...) of powers of a radius, in cells from its own one's middle."""
        x = chebyshev(DEGREE + 1)
        # Not by matrix products: a BLAS with threads of its own would keep the cores from the kernels for milliseconds.
        powers: F64 = np.einsum("dx,cx...->cd...", np.linalg.inv(np.vander(MIDDLE * x, increasing=True)), self.values)
        return powers


def on_lattice(light: Callable[[F64], F64], length_um: float, x_um: F64, y_um: F64) -> tuple[F64, F64, F64]:
    """Return ``Profile.powers`` as far as a lattice about the middle goes, and its places along x and y, in cells."""
    along = Profile.of(light, length_um, math.hypot(float(np.abs(x_um).max()), float(np.abs(y_um).max())))
    return along.powers, x_um / along.cell_um, y_um / along.cell_um
