"""What a channel's photosites hold of their neighbours' light: crosstalk, as a measured curve shows it."""

from __future__ import annotations

import math

import numpy as np

from camsim.camera.body import Body
from camsim.core.arrays import C128, F64
from camsim.measure.picture import places_of
from camsim.sensor.stages.crosstalk import senders


def neighbours(camera: Body, channel: str) -> F64 | None:
    """Return (3, 3, channels): of which channel a photosite holds what its neighbours send, the mean of its places.

    [1 + i, 1 + j] : what comes from i rows above and j columns to the left, and without crosstalk 1 of its own
    channel        : a plane's, G1 or G2 apart; None for one that the camera does not have
    """
    one = places_of(channel, list(camera.cfa.pattern))
    if not one.any():
        return None
    alone = ((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.0))
    kernel = np.array(alone if camera.crosstalk is None else camera.crosstalk.kernel, np.float64)
    return kernel[..., None] * senders(camera.cfa, one)


def spread_otf(shares: F64, fx: F64, fy: F64) -> F64 | C128:
    """Return (channels, …): what each channel's light has left, in a photosite that holds such shares, at frequencies.

    Real where neighbours on opposite sides send alike.
    """
    steps = np.arange(-1, 2)
    rows, cols = (np.exp(-2j * math.pi * np.multiply.outer(steps, f)) for f in (fy, fx))
    waves = np.einsum("ijc,i...,j...->c...", shares, rows, cols)
    return np.real_if_close(waves)
