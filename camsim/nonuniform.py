"""Sums of plane waves over points that lie anywhere, by finufft.

On several threads finufft spreads points onto its grid in the order in which the threads come, and the same capture
would give other last bits from run to run. One thread takes a fifth longer where points are many, less where few.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from camsim.arrays import C128, F64

COARSE = 1e-9  # sums to this precision may go by a grid of 25 % more on a side: left to itself, finufft doubles it


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

    finer = 1.25 if precision >= COARSE else 2
    total: C128 = finufft.nufft2d1(
        *phases, strengths, n_modes=shape, eps=precision, isign=sign, upsampfac=finer, nthreads=1
    )
    return total


def at_points(phases: tuple[F64, F64], coefficients: C128, *, precision: float, sign: Literal[-1, 1]) -> C128:
    """Return Σ_ji coefficients[j, i]·exp(±i(j·phases[0] + i·phases[1])) at the points (m,).

    Each point is a sum of its own, in one order whatever the threads.
    """
    import finufft

    total: C128 = finufft.nufft2d2(*phases, coefficients, eps=precision, isign=sign)
    return total


def lines_at(phases: F64, coefficients: C128, *, precision: float) -> C128:
    """Return Σ_j coefficients[n, j]·exp(i·j·phases) of each line n, j integers about 0: (lines, points).

    Each point is a sum of its own, on one thread.
    """
    import finufft

    total: C128 = finufft.nufft1d2(_less_turns(phases), coefficients, eps=precision, isign=1, nthreads=1)
    return total.reshape(len(coefficients), phases.size)


def _less_turns(phases: F64) -> F64:
    """Return phases less whole turns, −π to π: finufft takes them no farther."""
    turned: F64 = (phases + np.pi) % (2.0 * np.pi) - np.pi
    return turned
