"""A function of the radius on a lattice, from polynomials on cells of it."""

from __future__ import annotations

import math

from camsim.arrays import F64
from camsim.kernels.dispatch import kernel


@kernel(fastmath={"contract"})
def add_round(total: F64, powers: F64, middle: float, x: F64, y: F64) -> None:
    """Add to ``total`` (y, x) what a function of the radius is at every place.

    powers : (cells, degree + 1) coefficients, the lowest first;  middle: of a cell, what they are of powers about
    x, y   : places about the centre, in cells

    >>> import numpy as np
    >>> square = np.zeros((1, 2))
    >>> add_round(square, np.array([[0.0, 0.0, 1.0]]), 0.0, np.array([0.0, 0.3]), np.array([0.4]))
    >>> square.round(12)
    array([[0.16, 0.25]])
    """
    highest, last = powers.shape[1] - 1, len(powers) - 1
    for row in range(y.size):
        for col in range(x.size):
            radius = math.sqrt(x[col] * x[col] + y[row] * y[row])
            cell = min(int(radius), last)
            t = radius - cell - middle
            value = powers[cell, highest]
            for d in range(highest - 1, -1, -1):
                value = value * t + powers[cell, d]
            total[row, col] += value
