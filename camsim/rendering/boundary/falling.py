"""The distance at which a sum of negative powers falls to a given value."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt


def falls_to(allowed: float, sizes: npt.ArrayLike, powers: npt.ArrayLike) -> float:
    """Return the distance r at which Σ sizes·r^−powers has fallen to ``allowed``; 0 for an empty or zero sum.

    The logarithm of the sum is decreasing and convex in log r. Newton's method starts where the largest term alone has
    fallen to ``allowed``, and never overshoots.

    >>> r = falls_to(1e-3, [1.0, 4.0], [2.0, 3.0])
    >>> round(r**-2 + 4.0 * r**-3, 15)
    0.001
    """
    size, power = np.asarray(sizes, np.float64), np.asarray(powers, np.float64)
    r = float(((size / allowed) ** (1.0 / power)).max(initial=0.0))
    step = math.inf if r > 0.0 else 0.0
    while step > 1e-15:
        left = size * r**-power
        total = float(left.sum())
        step = math.log(total / allowed) * total / float(np.einsum("i,i", power, left))
        r *= math.exp(max(step, 0.0))
    return r
