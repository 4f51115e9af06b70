"""Non-uniform Fourier transforms, by finufft.

With several threads finufft spreads points onto its grid in an order that varies from run to run, and so do the last
bits of a capture. One thread takes a fifth longer for many points, less for few.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from camsim.core.arrays import C128, F64, Complex, Floats
from camsim.numerics.matrix_products import complex_product

# Upsampling factors by precision; finufft's default is 2. Along closed curves, 20² … 800² modes, errors are at most 3
# and 5 times the precision (50 times with a factor of 1.6 at 1e-13).
# In single precision a position is wrong by 3e-8 of the period: 3e-5 pitches for a thousand pitches.
SINGLE = 1.5e-5
SINGLE_SUMS = 1.5e-6  # for sums of finished transforms, which have no positions
FEW = 64  # points up to which the sum is computed directly
COARSE, FINER = 1e-9, ((1e-9, 1.25), (1e-12, 1.5), (0.0, 2.0))


def finer(precision: float) -> float:
    """Return the upsampling factor of the grid for a precision; with a smaller factor points spread over more cells."""
    return next(larger for finest, larger in FINER if precision >= finest)


def complex_type(precision: float, single: float = SINGLE_SUMS) -> type[np.complexfloating]:
    """Return the type of complex numbers in which sums of a relative precision are formed; ``SINGLE``: strengths."""
    return np.complex64 if precision >= single else np.complex128


def modes(
    phases: tuple[Floats, Floats],
    strengths: Complex,
    shape: tuple[int, int],
    *,
    precision: float,
    sign: Literal[-1, 1],
) -> Complex:
    """Return Σ_q strengths[n, q]·exp(±i(j·phases[0][q] + i·phases[1][q])), (j, i) integers about 0: (n, *shape).

    phases    : per row and per column, radians, (m,) each;  strengths: (n, m)
    precision : relative to the sum of the strengths' sizes
    """
    import finufft

    if strengths.shape[1] <= FEW:
        down, across = (
            np.exp(1j * sign * np.outer(np.arange(count) - count // 2, one))
            for count, one in zip(shape, phases, strict=True)
        )
        down = (strengths[:, None] * down).reshape(-1, strengths.shape[1])
        return complex_product(down, np.ascontiguousarray(across.T)).reshape(len(strengths), *shape)
    if precision >= SINGLE:
        # Products in double precision: those in single differ between processors, and sums of them by 1e-6.
        phases = phases[0].astype(np.float32, copy=False), phases[1].astype(np.float32, copy=False)
    strengths = np.ascontiguousarray(strengths, complex_type(precision, SINGLE))
    # For many points, a larger grid is better, since each point spreads over fewer cells.
    larger = finer(precision) if precision >= COARSE or strengths.shape[1] < shape[0] * shape[1] else 2.0
    total: Complex = finufft.nufft2d1(
        *phases, strengths, n_modes=shape, eps=precision, isign=sign, upsampfac=larger, nthreads=1
    )
    return total.reshape(len(strengths), *shape)


def modes_of_lines(phases: F64, strengths: C128, count: int, *, precision: float) -> C128:
    """Return Σ_q strengths[n, q]·exp(−i·j·phases[q]) of each line n, j integers about 0: (lines, count).

    precision : relative to the sum of the strengths' sizes
    """
    import finufft

    total: C128 = finufft.nufft1d1(
        _reduced(phases), strengths, n_modes=count, eps=precision, isign=-1, upsampfac=finer(precision), nthreads=1
    )
    return total.reshape(len(strengths), count)


def at_points(phases: tuple[F64, F64], coefficients: C128, *, precision: float, sign: Literal[-1, 1]) -> C128:
    """Return Σ_ji coefficients[j, i]·exp(±i(j·phases[0] + i·phases[1])) at the points (m,).

    Each point has a separate sum, whose order does not depend on the threads.
    """
    import finufft

    total: C128 = finufft.nufft2d2(*phases, coefficients, eps=precision, isign=sign)
    return total


def _reduced(phases: F64) -> F64:
    """Return phases reduced to −π … π, the range that finufft accepts."""
    turned: F64 = (phases + np.pi) % (2.0 * np.pi) - np.pi
    return turned
