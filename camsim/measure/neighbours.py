"""Crosstalk in a channel: the share of neighbours' light in its photosites."""

from __future__ import annotations

import math

import numpy as np

from camsim.camera.body import Body
from camsim.core.arrays import C128, F64
from camsim.measure.picture import places_of
from camsim.sensor.stages.crosstalk import senders


def neighbours(camera: Body, channel: str) -> F64 | None:
    """Return (3, 3, channels): the light that photosites of ``channel`` receive from neighbours of each channel.

    Entry [1 + i, 1 + j] is the share from the neighbour i rows above and j columns to the left, the mean over the
    photosites of ``channel``; without crosstalk all is from the photosite itself. G1 and G2 are separate channels. None
    for a channel that the camera lacks.
    """
    one = places_of(channel, list(camera.cfa.pattern))
    if not one.any():
        return None
    alone = ((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.0))
    kernel = np.array(alone if camera.crosstalk is None else camera.crosstalk.kernel, np.float64)
    return kernel[..., None] * senders(camera.cfa, one)


def spread_otf(shares: F64, fx: F64, fy: F64) -> F64 | C128:
    """Transfer function of crosstalk for the light from each channel, (channels, …); ``shares`` as from ``neighbours``.

    Real if opposite neighbours contribute equally.
    """
    steps = np.arange(-1, 2)
    rows, cols = (np.exp(-2j * math.pi * np.multiply.outer(steps, f)) for f in (fy, fx))
    waves = np.einsum("ijc,i...,j...->c...", shares, rows, cols)
    return np.real_if_close(waves)
