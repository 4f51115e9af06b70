"""Acutance: the MTF weighted by the contrast sensitivity of the eye at a viewing distance.

After ISO 15781 and IEEE 1858 (CPIQ), with the contrast sensitivity CSF(ν) ∝ ν^0.8·exp(−0.2·ν), ν in cycles per degree:

    acutance = ∫ MTF·CSF dν / ∫ CSF dν
"""

from __future__ import annotations

import math

import numpy as np

from camsim.core.arrays import F64
from camsim.errors import InvalidValueError

DISTANCES_PICTURE_HEIGHTS = (1.0, 2.0, 4.0)
"""Viewing distances in reports."""

_POWER, _DECAY = 0.8, 0.2
_FINE = 4001
_ONE = 1e-3


def acutance(frequency_cycles_per_pixel: F64, mtf: F64, *, rows: int, distance_picture_heights: float) -> float:
    """Return the acutance of a picture ``rows`` high, at a viewing distance in picture heights; 1 is no loss.

    mtf : (n,) from frequency 0, where it is 1; taken as 0 above the last frequency

    >>> f = np.linspace(0.0, 1.0, 11)
    >>> round(acutance(f, np.ones(11), rows=2000, distance_picture_heights=2.0), 4)
    1.0
    """
    if not 0.0 < distance_picture_heights < math.inf or rows < 1:
        raise InvalidValueError("distance and rows must be above 0", key="distance_picture_heights")
    frequency_cycles_per_pixel, mtf = (np.asarray(each, np.float64) for each in (frequency_cycles_per_pixel, mtf))
    if frequency_cycles_per_pixel.ndim != 1 or frequency_cycles_per_pixel.shape != mtf.shape:
        raise InvalidValueError(
            f"{mtf.shape} of {frequency_cycles_per_pixel.shape} frequencies; give one for each", key="mtf"
        )
    if mtf.size < 2 or frequency_cycles_per_pixel[0] != 0.0 or not np.all(np.diff(frequency_cycles_per_pixel) > 0.0):
        raise InvalidValueError("must increase from 0", key="frequency_cycles_per_pixel")
    if not abs(mtf[0] - 1.0) < _ONE:
        raise InvalidValueError(f"{mtf[0]:g} at frequency 0; must be 1 there (no per cent)", key="mtf")
    # One pixel is height/rows; one degree is π/180 of the viewing distance.
    per_degree = rows * distance_picture_heights * math.pi / 180.0
    highest = float(frequency_cycles_per_pixel[-1]) * per_degree
    nu = np.linspace(0.0, highest, _FINE)
    sensitivity = nu**_POWER * np.exp(-_DECAY * nu)
    seen = np.interp(nu, frequency_cycles_per_pixel * per_degree, mtf) * sensitivity
    whole: float = math.gamma(_POWER + 1.0) / math.pow(_DECAY, _POWER + 1.0)
    return float(np.trapezoid(seen, nu)) / whole
