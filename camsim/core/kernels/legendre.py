"""Legendre polynomials at many places."""

from __future__ import annotations

import numpy as np

from camsim.core.arrays import F64
from camsim.core.kernels.dispatch import kernel

AT_ONCE = 64  # places: the recurrence's values stay in the L1 cache, and loops vectorise


@kernel(allocates=True, error_model="numpy")
def legendre(begin: int, stop: int, order: int, x: F64, value: F64, slope: F64) -> None:
    """Write P_n and P_n′ at places ``begin`` … ``stop`` within −1 … 1, by Bonnet's recurrence.

    >>> import numpy as np
    >>> x, value, slope = np.array([0.5]), np.empty(1), np.empty(1)
    >>> legendre(0, 1, 2, x, value, slope)
    >>> value, slope  # ½(3x² − 1), 3x
    (array([-0.125]), array([1.5]))
    """
    older, old, new = np.empty(AT_ONCE), np.empty(AT_ONCE), np.empty(AT_ONCE)
    for first in range(begin, stop, AT_ONCE):
        count = min(AT_ONCE, stop - first)
        place = x[first : first + count]
        for k in range(count):
            older[k], old[k] = 1.0, place[k]
        for n in range(2, order + 1):
            up, down, over = 2.0 * n - 1.0, n - 1.0, float(n)
            for k in range(count):
                new[k] = (up * place[k] * old[k] - down * older[k]) / over
            older, old, new = old, new, older
        for k in range(count):
            value[first + k] = old[k]
            slope[first + k] = order * (older[k] - place[k] * old[k]) / (1.0 - place[k] * place[k])
