"""Matrix products in pieces small enough for BLAS to compute on the calling thread.

For a larger product BLAS wakes its threads, which spin for milliseconds afterwards on cores that kernels need, and the
order of summation depends on the number of cores.
"""

from __future__ import annotations

import math

import numpy as np

from camsim.core.arrays import F64

_MOST = 2**18  # multiplications: OpenBLAS's own limit; with a vector 9216
_DEEP, _CUBE = 256, 64  # largest inner dimension of a piece; beyond it, the smaller one, to avoid thin pieces


def product(left: F64, right: F64) -> F64:
    """Return left @ right, of (m, k) and (k, n).

    >>> product(np.ones((2, 3)), np.eye(3)).tolist()
    [[1.0, 1.0, 1.0], [1.0, 1.0, 1.0]]
    """
    (m, k), n = left.shape, right.shape[1]
    if k == 0:
        return np.zeros((m, n))
    out: F64 = np.empty((m, n))
    deep = k if k <= _DEEP else _CUBE
    rows = min(m, max(math.isqrt(_MOST // deep), _MOST // (deep * n), 1))
    cols = min(n, max(_MOST // (deep * rows), 1))
    for first in range(0, m, rows):
        for begin in range(0, n, cols):
            part = out[first : first + rows, begin : begin + cols]
            np.matmul(left[first : first + rows, :deep], right[:deep, begin : begin + cols], out=part)
            for top in range(deep, k, deep):
                one = slice(top, top + deep)
                part += np.matmul(left[first : first + rows, one], right[one, begin : begin + cols])
    return out
