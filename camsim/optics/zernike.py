"""Zernike polynomials by OSA/ANSI index, of unit root mean square over the unit circle.

Source: ANSI Z80.28 (OSA/VSIA report of Thibos et al., 2002): j = (n(n + 2) + m)/2; cos(mθ) for m ≥ 0, sin(|m|θ) for
m < 0; θ from x towards y (y is down here, as everywhere in camsim).
"""

from __future__ import annotations

import math

import numpy as np

from camsim.arrays import F64

LARGEST_INDEX = 230  # order 20


def orders(index: int) -> tuple[int, int]:
    """Return n and m of an OSA/ANSI index.

    >>> [orders(j) for j in (0, 1, 2, 3, 4, 7, 8, 12)]
    [(0, 0), (1, -1), (1, 1), (2, -2), (2, 0), (3, -1), (3, 1), (4, 0)]
    """
    n = math.ceil(0.5 * (math.sqrt(9.0 + 8.0 * index) - 3.0))
    return n, 2 * index - n * (n + 2)


def radial_powers(index: int) -> F64:
    """Return the polynomial in r², highest power first, that r^m·cos mθ or r^m·sin mθ is multiplied by.

    >>> radial_powers(4).round(4)  # defocus: √3·(2r² − 1)
    array([ 3.4641, -1.7321])
    """
    return _norm(index) * _factors(index)


def _factors(index: int) -> F64:
    """Return the same of R(r), which is 1 at the rim."""
    n, m = orders(index)
    k = abs(m)
    return np.array(
        [
            (-1.0) ** s
            * math.factorial(n - s)
            / (math.factorial(s) * math.factorial((n + k) // 2 - s) * math.factorial((n - k) // 2 - s))
            for s in range((n - k) // 2 + 1)
        ]
    )


def _norm(index: int) -> float:
    n, m = orders(index)
    return math.sqrt((2 if m else 1) * (n + 1))


def zernike(index: int, x: F64, y: F64) -> F64:
    """Return the polynomial at (x, y), in units of the circle's radius.

    >>> zernike(4, np.array([0.0, 1.0]), np.zeros(2)).round(4)  # defocus: √3·(2r² − 1)
    array([-1.7321,  1.7321])
    """
    # Who reads a lens from a file needs no compiler.
    from camsim.kernels.zernike import fill_zernike

    # The radial polynomial over r^k in powers of r², and r^k·cos, r^k·sin by turning k times: no angle, no root.
    _, m = orders(index)
    values = np.empty(np.broadcast_shapes(np.shape(x), np.shape(y)))
    # Copies: what is read-only is another type, for which all would be compiled once more.
    x, y = (np.array(own, float).ravel() for own in np.broadcast_arrays(x, y))
    fill_zernike(values.reshape(-1), x, y, _factors(index), abs(m), m < 0, _norm(index))
    return values
