"""Lengths at which Fourier transforms are quick: SciPy's, which a plan that transforms nothing need not import."""

from __future__ import annotations

import functools


@functools.lru_cache(maxsize=4096)  # plans try the same few
def fast_length(least: int, *, real: bool = False) -> int:
    """Return the smallest length from ``least`` on whose prime factors are at most 11, of real transforms 5.

    >>> fast_length(4621), fast_length(4621, real=True)
    (4704, 4800)
    """
    odd = [1]
    for prime in (3, 5) if real else (3, 5, 7, 11):
        for product in odd:  # it grows by its multiples while it is walked
            if product * prime < 2 * least:  # there is a power of two up to there
                odd.append(product * prime)
    return min(product << (-(-least // product) - 1).bit_length() for product in odd)
