"""Piecewise-linear companding: many data numbers in few codes, with larger steps at high signal."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from camsim.core.arrays import F64, I64, U16

LARGEST = 65535
"""Largest code and data number."""

Points: TypeAlias = Sequence[tuple[int, int]]
"""(data number, code), both increasing; piecewise linear."""


@functools.lru_cache(maxsize=8)
def encoding(points: Points) -> U16:
    """Return (n,) the codes of data numbers 0, 1, …, rounded half to even.

    >>> encoding(((0, 0), (4, 4), (12, 6))).tolist()
    [0, 1, 2, 3, 4, 4, 4, 5, 5, 5, 6, 6, 6]
    """
    return _between(points)


def data_numbers(points: Points, codes: NDArray[Any]) -> NDArray[Any]:
    """Return the data numbers of codes (any shape); without points they are equal."""
    if not points:
        return codes
    table = decoding(tuple(points))
    linear: NDArray[Any] = table[np.minimum(codes, len(table) - 1)]
    return linear


def steps_dn(points: Points, dn: F64) -> F64:
    """Return the distance between neighbouring codes, in data numbers, at data numbers (any shape).

    >>> steps_dn(((0, 0), (55, 55), (255, 80)), np.array([20.0, 200.0])).tolist()
    [1.0, 8.0]
    """
    if not points:
        return np.ones_like(dn)
    known, codes = np.array(points).T
    steps: F64 = (np.diff(known) / np.diff(codes))[np.clip(np.searchsorted(known, dn, "right") - 1, 0, len(known) - 2)]
    return steps


def are_points(given: Any) -> bool:
    """Whether the argument is two or more points whose data numbers and codes increase within 0..65535."""
    if not isinstance(given, list | tuple) or len(given) < 2:
        return False
    if not all(isinstance(point, list | tuple) and len(point) == 2 for point in given):
        return False
    known, codes = zip(*given, strict=True)
    if not all(isinstance(number, int) for number in (*known, *codes)):
        return False
    rising = all(after > before for numbers in (known, codes) for before, after in pairwise(numbers))
    return rising and min(known[0], codes[0]) >= 0 and max(known[-1], codes[-1]) <= LARGEST


def points_of(linear_dn: Sequence[int]) -> Points:
    """Return few points whose piecewise-linear curve gives the data numbers of codes 0, 1, … (n,) within 0.5.

    Codes after the first with the largest number are ignored. Empty if the numbers do not increase from 0.

    >>> points_of([0, 1, 2, 3, 4, 8, 12, 12])
    ((0, 0), (4, 4), (12, 6))
    """
    table = list(linear_dn[: linear_dn.index(max(linear_dn)) + 1]) if linear_dn else []
    if len(table) < 2 or table[0] != 0 or any(after <= before for before, after in pairwise(table)):
        return ()
    points, here = [(0, 0)], 0
    while here < len(table) - 1:
        low, high, best = -math.inf, math.inf, here + 1
        for code in range(here + 1, len(table)):
            run, rise = code - here, table[code] - table[here]
            if low <= rise / run <= high:
                best = code
            low, high = max(low, (rise - 0.5) / run), min(high, (rise + 0.5) / run)
            if low > high:
                break
        here = best
        points.append((table[here], here))
    return tuple(points)


def stated_points(points: Sequence[tuple[int, int]]) -> str:
    """Return a text that lists the points.

    >>> stated_points(((0, 0), (512, 512), (4095, 1023)))
    '0, 512, 4095 DN are the codes 0, 512, 1023'
    """
    known, codes = (", ".join(map(str, part)) for part in zip(*points, strict=True))
    return f"{known} DN are the codes {codes}"


@functools.lru_cache(maxsize=8)
def decoding(points: Points) -> U16:
    """Return (n,) the data numbers of codes 0, 1, …: for each code, the middle of the data numbers that share it.

    >>> decoding(((0, 0), (4, 4), (12, 6))).tolist()
    [0, 1, 2, 3, 4, 8, 12]
    """
    return _between(tuple((code, dn) for dn, code in points))


def _between(points: Points) -> U16:
    """Return (n,) the integer interpolation at 0, 1, … up to the last point; identical on every processor."""
    known, value = (np.array(part, np.int64) for part in zip(*points, strict=True))
    at: I64 = np.arange(known[-1] + 1)
    piece = np.clip(np.searchsorted(known, at, side="right") - 1, 0, len(known) - 2)
    rise, run = np.diff(value)[piece], np.diff(known)[piece]
    whole, rest = np.divmod(np.maximum(at - known[piece], 0) * rise, run)
    whole += (2 * rest > run) | ((2 * rest == run) & ((value[piece] + whole) % 2 == 1))
    table: U16 = (value[piece] + whole).astype(np.uint16)
    table.flags.writeable = False
    return table
