"""Squares of amplitudes."""

from __future__ import annotations

from camsim.arrays import C128, F64
from camsim.kernels.dispatch import kernel


@kernel(fastmath={"contract"})
def fill_squares(squares: F64, amplitude: C128, down: F64, across: F64, wanted: int, first: int, step: int) -> None:
    """Fill in |amplitude|² (y, x), each row and column multiplied by a number of its own.

    wanted : from which on amplitudes are taken;  first, step: of the columns that they belong to

    >>> import numpy as np
    >>> squares = np.zeros((1, 4))
    >>> fill_squares(squares, np.array([[0j, 1j, 1 + 1j]]), np.array([3.0]), np.array([1.0, 2.0]), 1, 0, 2)
    >>> squares
    array([[ 3.,  0., 12.,  0.]])
    """
    for row in range(len(amplitude)):
        for col in range(across.size):
            value = amplitude[row, wanted + col]
            square = value.real * value.real + value.imag * value.imag
            squares[row, first + step * col] = square * down[row] * across[col]
