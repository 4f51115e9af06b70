"""Cubic splines through values at places."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence

import numpy as np
import scipy

from camsim.core.arrays import F64

MANY = 1000  # places from which a spline of its own is quicker than cardinal ones


def spline(places: tuple[float, ...], values: F64) -> Callable[..., F64]:
    """Return a cubic spline through values (n, …) at increasing places; through three a parabola, at one a constant.

    >>> spline((0.0, 1.0, 3.0), np.array([0.0, 1.0, 9.0]))(2.0).round(12).item()
    4.0
    """
    if len(places) == 1:
        return lambda place: np.broadcast_to(values[0], (*np.shape(place), *values.shape[1:]))

    cardinal, flat = _cardinal(places), values.reshape(len(places), -1)

    def at(place: F64, derivative: int = 0) -> F64:
        found: F64
        if np.size(place) > MANY:
            found = scipy.interpolate.CubicSpline(places, flat)(place, derivative)
        else:
            found = np.einsum("np,pv->nv", np.reshape(cardinal(place, derivative), (-1, len(places))), flat)
        return found.reshape((*np.shape(place), *values.shape[1:]))

    return at


def mirrored_spline(places: Sequence[float] | F64, values: F64, order: int = 0) -> Callable[..., F64]:
    """Return a spline through values (n, …) at places from 0 on, even about 0, or odd if ``order`` is odd."""
    array = np.array(places, float)
    mirrored = (-values if order % 2 else values)[:0:-1]
    return spline((*-array[:0:-1], *array), np.concatenate([mirrored, values]))


@functools.lru_cache(maxsize=64)
def _cardinal(places: tuple[float, ...]) -> Callable[..., F64]:
    """Return cardinal splines (…, n) that are 1 at one of n places and 0 at the others.

    Many places of a frame need splines through different values at the same wavelengths and heights. Cached cardinal
    splines avoid solving for each, which would also wake BLAS threads that spin on cores in use.
    """
    spline_through: Callable[..., F64] = scipy.interpolate.CubicSpline(places, np.eye(len(places)))
    return spline_through
