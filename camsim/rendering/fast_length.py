"""Lengths for fast Fourier transforms, equal to SciPy's, without the import of SciPy."""

from __future__ import annotations

import functools


@functools.lru_cache(maxsize=4096)  # plans try the same few
def fast_length(least: int, *, real: bool = False) -> int:
    """Return the smallest length from ``least`` on with prime factors up to 11, or up to 5 for real transforms.

    >>> fast_length(4621), fast_length(4621, real=True)
    (4704, 4800)
    """
    odd = [1]
    for prime in (3, 5) if real else (3, 5, 7, 11):
        for product in odd:  # the list grows during the loop
            if product * prime < 2 * least:  # a power of two reaches that far
                odd.append(product * prime)
    return min(product << (-(-least // product) - 1).bit_length() for product in odd)
