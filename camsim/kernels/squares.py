"""Squares of amplitudes."""

from __future__ import annotations

from camsim.arrays import C128, F64
from camsim.kernels.dispatch import kernel


@kernel(fastmath={"contract"})
def fill_squares(squares: F64, amplitude: C128, down: F64, across: F64) -> None:
    """Fill in |amplitude|² (y, x), each row and column multiplied by a number of its own.

    >>> import numpy as np
    >>> squares = np.empty((1, 2))
    >>> fill_squares(squares[::1, ::1], np.array([[1j, 1 + 1j]]), np.array([3.0]), np.array([1.0, 2.0]))
    >>> squares
    array([[ 3., 12.]])
    """
    for row in range(len(amplitude)):
        for col in range(amplitude.shape[1]):
            value = amplitude[row, col]
            squares[row, col] = (value.real * value.real + value.imag * value.imag) * down[row] * across[col]
