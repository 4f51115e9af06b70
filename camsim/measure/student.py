"""Student's t distribution."""

from __future__ import annotations

import functools
import math

import numpy as np


@functools.cache
def student(freedom: int, beyond: float) -> float:
    """Return the t that |t| exceeds with the probability ``beyond``, at most 0.3; freedom: degrees, at least 2.

    By Newton's method from below, on the finite sums of M. Abramowitz and I. Stegun, "Handbook of mathematical
    functions" (1964), 26.7.3 and 26.7.4. To import SciPy's functions would take longer than measuring an edge.

    >>> round(student(10, 0.05), 4)  # any table
    2.2281
    """
    odd = freedom % 2
    n = np.arange(1 + odd, freedom - 1, 2)
    log_peak = math.lgamma(0.5 * (freedom + 1)) - math.lgamma(0.5 * freedom) - 0.5 * math.log(freedom * math.pi)
    t, change = 1.0, 1.0
    while change > 1e-12 * t:
        angle = math.atan(t / math.sqrt(freedom))
        cosine = math.cos(angle)
        within = math.sin(angle) * (1.0 + float(np.cumprod(n / (n + 1) * cosine**2).sum()))
        if odd:
            within = 2.0 / math.pi * (angle + cosine * within)
        density = 2.0 * math.exp(log_peak - 0.5 * (freedom + 1) * math.log1p(t * t / freedom))
        change = (1.0 - within - beyond) / density
        t += change
    return t
