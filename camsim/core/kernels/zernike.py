"""Sums of Zernike polynomials at many places."""

from __future__ import annotations

import numpy as np

from camsim.core.arrays import F64
from camsim.core.kernels.dispatch import kernel

AT_ONCE = 256  # places: the recurrence's values stay in the L1 cache, and loops vectorise


@kernel(allocates=True)
def fill_sum(values: F64, x: F64, y: F64, terms: F64, steps: F64) -> None:
    """Write Σ_m Σ_p (terms[m, 0, p]·cos mθ + terms[m, 1, p]·sin mθ)·r^m·P_p(r²) to ``values``.

    steps : (m, p, 3) a, b, c of P_p(s) = (a·s + b)·P_{p−1}(s) − c·P_{p−2}(s); P₀ = 1

    >>> import numpy as np
    >>> values, terms, steps = np.empty(1), np.zeros((3, 2, 2)), np.zeros((3, 2, 3))
    >>> terms[2, 1, 1], steps[2, 1] = 0.5, [1.0, 3.0, 0.0]
    >>> fill_sum(values, np.array([2.0]), np.array([1.0]), terms, steps)
    >>> values  # ½·(r² + 3)·2xy
    array([16.])
    """
    square, before, last, following = (np.empty(AT_ONCE), np.empty(AT_ONCE), np.empty(AT_ONCE), np.empty(AT_ONCE))
    real, other, turned = np.empty(AT_ONCE), np.empty(AT_ONCE), np.empty(AT_ONCE)
    for first in range(0, x.size, AT_ONCE):
        count = min(AT_ONCE, x.size - first)
        px, py, one = x[first : first + count], y[first : first + count], values[first : first + count]
        for i in range(count):
            square[i] = px[i] * px[i] + py[i] * py[i]
            one[i], real[i], other[i] = 0.0, 1.0, 0.0
        for m in range(len(terms)):
            if m > 0:
                for i in range(count):
                    turned[i] = real[i] * px[i] - other[i] * py[i]
                for i in range(count):
                    other[i] = real[i] * py[i] + other[i] * px[i]
                real, turned = turned, real
            degrees = terms.shape[2]
            while degrees > 0 and terms[m, 0, degrees - 1] == 0.0 and terms[m, 1, degrees - 1] == 0.0:
                degrees -= 1
            for i in range(count):
                before[i], last[i] = 0.0, 1.0
            for p in range(degrees):
                if p > 0:
                    a, b, c = steps[m, p]
                    for i in range(count):
                        following[i] = (a * square[i] + b) * last[i] - c * before[i]
                    before, last, following = last, following, before
                cosine, sine = terms[m, 0, p], terms[m, 1, p]
                if cosine != 0.0 or sine != 0.0:
                    for i in range(count):
                        one[i] += (cosine * real[i] + sine * other[i]) * last[i]
