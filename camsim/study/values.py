"""The values of a key: listed, evenly spaced, or drawn at random."""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np

from camsim.config.schema.study import DRAWN, Values


def is_drawn(values: list[Any] | Values) -> bool:
    """Whether the values are random."""
    return isinstance(values, Values) and any(getattr(values, rule) is not None for rule in DRAWN)


def listed(values: list[Any] | Values) -> list[Any]:
    """Return values that are not random, in order; as integers if all are.

    >>> listed(Values(linear=(4.0, 16.0, 5))), listed(Values(log=(0.1, 10.0, 3)))
    ([4, 7, 10, 13, 16], [0.1, 1.0, 10.0])
    """
    if isinstance(values, list):
        return values
    if values.linear is not None:
        first, last, count = values.linear
        return _tidy(np.linspace(first, last, count))
    assert values.log is not None
    first, last, count = values.log
    return _tidy(np.geomspace(first, last, count))


def drawn(values: Values, *, seed: int, key: str, index: int) -> Any:
    """Return the value of a key in one capture: a function of seed, key and index alone."""
    rng = np.random.default_rng([seed, zlib.crc32(key.encode()), index])
    if values.choice is not None:
        return values.choice[int(rng.integers(len(values.choice)))]
    if values.integers is not None:
        return int(rng.integers(values.integers[0], values.integers[1], endpoint=True))
    if values.normal is not None:
        return float(rng.normal(*values.normal))
    if values.log_uniform is not None:
        return float(np.exp(rng.uniform(*np.log(values.log_uniform))))
    assert values.uniform is not None
    return float(rng.uniform(*values.uniform))


def _tidy(values: np.ndarray) -> list[float] | list[int]:
    """Return numbers without rounding residues of decimal fractions: 0.3, not 0.30000000000000004."""
    tidy = [float(f"{value:.14g}") for value in values.tolist()]
    # Seeds, rows and counts must be integers, not 1.0.
    return [int(value) for value in tidy] if all(map(float.is_integer, tidy)) else tidy
