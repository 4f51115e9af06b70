"""Matrix products in pieces small enough for BLAS to compute on the calling thread.

For a larger product BLAS wakes its threads, which spin for milliseconds afterwards on cores that kernels need, and the
order of summation depends on the number of cores.
"""

from __future__ import annotations

import math
from typing import overload

import numpy as np

from camsim.core.arrays import C128, F64, Complex

_MOST = 2**18  # multiplications: OpenBLAS's own limit; with a vector 9216
_DEEP, _CUBE = 256, 64  # largest inner dimension of a piece; beyond it, the smaller one, to avoid thin pieces


def product(left: F64, right: F64) -> F64:
    """Return left @ right, of (m, k) and (k, n).

    >>> product(np.ones((2, 3)), np.eye(3)).tolist()
    [[1.0, 1.0, 1.0], [1.0, 1.0, 1.0]]
    """
    (m, k), n = left.shape, right.shape[1]
    if not (m and k and n):
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


@overload
def real_product(left: F64, right: F64) -> F64: ...
@overload
def real_product(left: F64, right: C128) -> C128: ...
def real_product(left: F64, right: F64 | C128) -> F64 | C128:
    """Return left @ right, of a real (m, k) and a real or complex (…, k, n).

    >>> real_product(np.array([[2.0]]), np.array([[1.0 + 1j]])).tolist()
    [[(2+2j)]]
    """
    parts = np.ascontiguousarray(right).view(np.float64)
    if parts.ndim == 2:
        found = product(left, parts)
        return found.view(np.complex128) if np.iscomplexobj(right) else found
    return np.stack([real_product(left, one) for one in right])


def complex_product(left: C128, right: Complex) -> C128:
    """Return left @ right, of complex (m, k) and (k, n), as two real products.

    >>> complex_product(np.array([[1j]]), np.array([[2.0 + 1j]])).tolist()
    [[(-1+2j)]]
    """
    both = np.concatenate([right, 1j * right]).astype(np.complex128, copy=False).view(np.float64)
    return product(np.concatenate([left.real, left.imag], axis=1), both).view(np.complex128)
