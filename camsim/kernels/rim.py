"""What a circle of a pupil throws far away, by steepest paths (optics/rim_light.py)."""

from __future__ import annotations

import cmath
import math

import numpy as np

from camsim.arrays import C128, F64, I64
from camsim.kernels import kernel


@kernel(allocates=True, error_model="numpy", fastmath={"contract"})
def fill_amplitudes(
    out: C128,
    turns: F64,
    rules: tuple[F64, F64, F64, F64],
    series: C128,
    orders: I64,
    turned: C128,
    about: float,
    begin: int,
    stop: int,
) -> None:
    """Write amplitudes outward and back (2, n, directions), n from ``begin`` to ``stop``, of a circle of radius 1.

    turns  : (n,) πr;  rules: nodes and weights of a Gauss–Hermite rule along the circle and of a Gauss–Laguerre one
    series : (k, m), see ``Circle``;  turned: (m, directions) exp(imφ)
    """
    (along, along_w, inward, inward_w), directions = rules, turned.shape[1]
    real, imag = np.empty(directions), np.empty(directions)
    for n in range(begin, stop):
        out[:, n] = 0.0
        for h in range(len(along)):
            short = 1j * along[h] ** 2 / turns[n]
            root = cmath.sqrt(1.0 - 0.5 * short)
            v = along[h] * cmath.sqrt(2j / turns[n]) * root
            of_line = 1j / turns[n] * along_w[h] * cmath.sqrt(2j / turns[n]) * (1.0 - short) / root
            for q in range(len(inward)):
                t = 1.0 - short - 1j * inward[q] / turns[n]
                square = t * t + v * v
                angular, x = (t + 1j * v) / cmath.sqrt(square), (square - 1.0) / about
                real[:], imag[:] = 0.0, 0.0
                for m in range(len(orders)):
                    one, two = 0j, 0j  # Clenshaw's sums
                    for k in range(len(series) - 1, 0, -1):
                        one, two = series[k, m] + 2.0 * x * one - two, one
                    own = (series[0, m] + x * one - two) * angular ** orders[m]
                    for d in range(directions):
                        real[d] += own.real * turned[m, d].real - own.imag * turned[m, d].imag
                        imag[d] += own.real * turned[m, d].imag + own.imag * turned[m, d].real
                weight = of_line * inward_w[q]
                for d in range(directions):
                    size, angle = math.exp(-2.0 * math.pi * imag[d]), 2.0 * math.pi * real[d]
                    cosine, sine = math.cos(angle), math.sin(angle)
                    out[0, n, d] += weight * complex(size * cosine, size * sine)
                    out[1, n, d] += weight * complex(cosine / size, -sine / size)
