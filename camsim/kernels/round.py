"""A function of the radius on a lattice, from its quintics."""

from __future__ import annotations

import math

from camsim.arrays import F64
from camsim.kernels.dispatch import kernel


@kernel(fastmath={"contract"})
def add_round(total: F64, cells: F64, x: F64, y: F64) -> None:
    """Add to ``total`` (y, x) what quintics (n, 6; ``quadrature.quintic_cells``) give at the radius of every place.

    x, y : places about the centre, in cells

    >>> import numpy as np
    >>> square = np.zeros((1, 2))
    >>> add_round(square, np.array([[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]]), np.array([0.0, 0.3]), np.array([0.4]))
    >>> square.round(12)
    array([[0.16, 0.25]])
    """
    for row in range(y.size):
        for col in range(x.size):
            radius = math.sqrt(x[col] * x[col] + y[row] * y[row])
            cell = int(radius)
            t = radius - cell
            c = cells[cell]
            total[row, col] += c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))))
