"""Products of matrices in pieces that BLAS does on the thread that asks.

For a larger one it wakes threads of its own, which spin for milliseconds afterwards on cores that kernels want, and add
up in another order on another number of cores.
"""

from __future__ import annotations

import math

import numpy as np

from camsim.arrays import F64

_MOST = 2**18  # multiplications: OpenBLAS's own limit; with a vector 9216


def product(left: F64, right: F64) -> F64:
    """Return left @ right, of (m, k) and (k, n).

    >>> product(np.ones((2, 3)), np.eye(3)).tolist()
    [[1.0, 1.0, 1.0], [1.0, 1.0, 1.0]]
    """
    (m, k), n = left.shape, right.shape[1]
    out: F64 = np.empty((m, n))
    rows = min(m, max(math.isqrt(_MOST // k), _MOST // (k * n), 1))
    cols = min(n, max(_MOST // (k * rows), 1))
    for first in range(0, m, rows):
        part = slice(first, first + rows)
        for begin in range(0, n, cols):
            np.matmul(left[part], right[:, begin : begin + cols], out=out[part, begin : begin + cols])
    return out
