"""Results of measurements of a star or a texture."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any, Literal, TypeAlias

import numpy as np

from camsim.core.arrays import F64
from camsim.measure.crossings import falls_to
from camsim.measure.full_frame import NYQUIST_OF_SENSOR_CYCLES_PER_PIXEL, FullFrame

Method: TypeAlias = Literal["star", "texture"]

_MOST_ERROR = 1.0
"""Standard error from which a point is dropped: as large as the MTF itself."""

_NEAR = 0.2
_LEAST_NEAR = 4
_FINE = 2001


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TargetMtf:
    """The MTF of one channel, the mean over all directions.

    frequency_cycles_per_pixel : (n,);  mtf, mtf_error: (n,) and its standard error
    mtf50_cycles_per_pixel, mtf50_error : where it falls to 50 %; NaN if it does not within the curve
    nyquist_cycles_per_pixel   : Nyquist frequency of the channel's lattice; the sensor's is 0.5
    theory, theory_mtf50_cycles_per_pixel : theory of lens, OLPF, photosite and crosstalk; None if unknown
    """

    channel: str
    frequency_cycles_per_pixel: F64
    mtf: F64
    mtf_error: F64
    mtf50_cycles_per_pixel: float
    mtf50_error: float
    nyquist_cycles_per_pixel: float
    theory: F64 | None
    theory_mtf50_cycles_per_pixel: float | None

    def as_dict(self) -> dict[str, Any]:
        """Return the result as plain values for JSON."""
        tree = {}
        for each in fields(self):
            value = getattr(self, each.name)
            value = value.tolist() if isinstance(value, np.ndarray) else value
            tree[each.name] = None if isinstance(value, float) and not math.isfinite(value) else value
        return tree


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TargetReport:
    """All channels of one picture of a star or a texture."""

    file: str
    method: Method
    full_frame: FullFrame
    channels: tuple[TargetMtf, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return the result as plain values for JSON."""
        sensor = self.full_frame.in_units(NYQUIST_OF_SENSOR_CYCLES_PER_PIXEL)
        stated = []
        for channel in self.channels:
            half = self.full_frame.in_units(channel.mtf50_cycles_per_pixel)
            more = {f"mtf50_{unit}": value if math.isfinite(value) else None for unit, value in half.items()}
            stated.append(channel.as_dict() | more)
        nyquist = {unit: value if math.isfinite(value) else None for unit, value in sensor.items()}
        return {"file": self.file, "method": self.method, "nyquist_of_sensor": nyquist, "channels": stated}


def half_of(frequency: F64, mtf: F64, error: F64) -> tuple[float, float]:
    """Return the frequency at which a curve falls to 50 %, and its standard error; NaN if the curve does not.

    A parabola through the points within 0.2 of it, weighted by their errors, is more precise than two neighbours.

    >>> f = np.linspace(0.0, 1.0, 21)
    >>> [round(value, 6) for value in half_of(f, 1.0 - f, np.full(21, 1e-3))]
    [0.5, 0.000529]
    """
    first = falls_to(frequency, mtf, 0.5)
    if math.isnan(first):
        return math.nan, math.nan
    near = np.abs(mtf - 0.5) < _NEAR
    # One piece around the first crossing: later ones may be on the other side of a null.
    middle = int(np.searchsorted(frequency, first))
    low, high = middle, middle
    while low > 0 and near[low - 1]:
        low -= 1
    while high < near.size and near[high]:
        high += 1
    if high - low < _LEAST_NEAR:
        return first, math.nan
    f, m, e = frequency[low:high] - first, mtf[low:high], np.maximum(error[low:high], 1e-9)
    basis = np.stack([np.ones_like(f), f, f * f], axis=1) / e[:, None]
    inverse = np.linalg.pinv(np.einsum("ni,nj->ij", basis, basis))
    c = np.einsum("ij,nj,n->i", inverse, basis, m / e)
    fine = np.linspace(f[0], f[-1], _FINE)
    found = falls_to(fine, c[0] + c[1] * fine + c[2] * fine**2, 0.5)
    if math.isnan(found):
        return first, math.nan
    row = np.array([1.0, found, found * found])
    sigma = math.sqrt(float(np.einsum("i,ij,j->", row, inverse, row))) / abs(c[1] + 2.0 * c[2] * found)
    return float(first + found), float(sigma)


def curve(channel: str, frequency: F64, mtf: F64, error: F64, nyquist: float, theory: F64 | None) -> TargetMtf | None:
    """Return a channel's curve with its MTF50 and the theory's; None if noise leaves no point of the curve."""
    stated = np.isfinite(mtf) & (error < _MOST_ERROR)
    if not stated.any():
        return None
    frequency, mtf, error = frequency[stated], mtf[stated], error[stated]
    theory = None if theory is None else theory[stated]
    half, half_error = half_of(frequency, mtf, error)
    return TargetMtf(
        channel=channel,
        frequency_cycles_per_pixel=frequency,
        mtf=mtf,
        mtf_error=error,
        mtf50_cycles_per_pixel=half,
        mtf50_error=half_error,
        nyquist_cycles_per_pixel=nyquist,
        theory=theory,
        theory_mtf50_cycles_per_pixel=None if theory is None else half_of(frequency, theory, 0.0 * theory)[0],
    )
