"""Sums of plane waves over points that lie anywhere, by finufft.

On several threads finufft spreads points onto its grid in the order in which the threads come, and the same capture
would give other last bits from run to run. One thread takes a fifth longer where points are many, less where few.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from camsim.core.arrays import C128, F64
from camsim.numerics.matrix_products import product

# By how much a grid is larger than what is transformed, from a precision on: left to itself, finufft doubles it.
# Along closed curves, 20² … 800² modes, errors are at most 3 and 5 times as large as that (1.6 at 1e-13: 50 times).
# In single precision a place is off by 3e-8 of the period: of a thousand pitches 3e-5 of one.
SINGLE = 1.5e-5
FEW = 64  # points, whose plane waves are added up one by one
COARSE, FINER = 1e-9, ((1e-9, 1.25), (1e-12, 1.5), (0.0, 2.0))


def finer(precision: float) -> float:
    """Return by how much a grid is larger, each way, than what is transformed: if by less, points take more cells."""
    return next(larger for finest, larger in FINER if precision >= finest)


def modes(
    phases: tuple[F64, F64],
    strengths: C128,
    shape: tuple[int, int],
    *,
    precision: float,
    sign: Literal[-1, 1],
) -> C128:
    """Return Σ_q strengths[q]·exp(±i(j·phases[0][q] + i·phases[1][q])), (j, i) integers about 0: (shape).

    phases    : per row and per column, radians, (m,) each
    precision : relative to the sum of the strengths' sizes
    """
    import finufft

    if strengths.size <= FEW:
        down, across = (
            np.exp(1j * sign * np.outer(np.arange(count) - count // 2, one))
            for count, one in zip(shape, phases, strict=True)
        )
        down, across = down * strengths, np.ascontiguousarray(across.T)
        both = np.concatenate([across, 1j * across]).view(np.float64)
        return product(np.concatenate([down.real, down.imag], axis=1), both).view(np.complex128)
    if precision >= SINGLE:
        phases = phases[0].astype(np.float32), phases[1].astype(np.float32)
        strengths = strengths.astype(np.complex64)
    # Where points are many, they had better take few cells each.
    larger = finer(precision) if precision >= COARSE or strengths.size < shape[0] * shape[1] else 2.0
    total: C128 = finufft.nufft2d1(
        *phases, strengths, n_modes=shape, eps=precision, isign=sign, upsampfac=larger, nthreads=1
    )
    return total


def modes_of_lines(phases: F64, strengths: C128, count: int, *, precision: float) -> C128:
    """Return Σ_q strengths[n, q]·exp(−i·j·phases[q]) of each line n, j integers about 0: (lines, count).

    precision : relative to the sum of the strengths' sizes
    """
    import finufft

    total: C128 = finufft.nufft1d1(
        _less_turns(phases), strengths, n_modes=count, eps=precision, isign=-1, upsampfac=finer(precision), nthreads=1
    )
    return total.reshape(len(strengths), count)


def at_points(phases: tuple[F64, F64], coefficients: C128, *, precision: float, sign: Literal[-1, 1]) -> C128:
    """Return Σ_ji coefficients[j, i]·exp(±i(j·phases[0] + i·phases[1])) at the points (m,).

    Each point is a sum of its own, in one order whatever the threads.
    """
    import finufft

    total: C128 = finufft.nufft2d2(*phases, coefficients, eps=precision, isign=sign)
    return total


def _less_turns(phases: F64) -> F64:
    """Return phases less whole turns, −π to π: finufft takes them no farther."""
    turned: F64 = (phases + np.pi) % (2.0 * np.pi) - np.pi
    return turned
