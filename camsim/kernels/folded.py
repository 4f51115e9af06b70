"""Samples of a pattern added to those of a period."""

from __future__ import annotations

from camsim.arrays import F64
from camsim.kernels.dispatch import kernel


@kernel()
def add_folded(
    total: F64, values: F64, down: F64, across: F64, share: float, first_row: int, first_column: int, step: int
) -> None:
    """Add a share of samples (rows, columns), each row and column times a number of its own, modulo a period's sides.

    first_row, first_column : of the period, where the first sample falls, any integers
    step                    : from one row to the next

    >>> import numpy as np
    >>> total = np.zeros((1, 2))
    >>> add_folded(total, np.array([[1.0, 2.0, 4.0]]), np.array([3.0]), np.ones(3), 0.5, 0, -1, 1)
    >>> total
    array([[3. , 7.5]])
    """
    height, width = total.shape
    for row in range(len(values)):
        place = (first_row + step * row) % height
        done, column = 0, first_column % width
        while done < across.size:
            count = min(width - column, across.size - done)
            # Views begin at 0: no number may be one from the end, and several are added at once.
            own, of_columns = values[row, done : done + count], across[done : done + count]
            into = total[place, column : column + count]
            for k in range(count):
                into[k] += share * (own[k] * of_columns[k] * down[row])
            done, column = done + count, 0
