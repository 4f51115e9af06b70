"""How loud the check takes far places for: by a round lens's own light there, found otherwise than by the engines."""

from __future__ import annotations

import math

import numpy as np

from camsim.arrays import F64
from camsim.optics import RoundLens
from camsim.rendering.check.pattern import oscillation, smooth_powers
from camsim.rendering.job import Job
from camsim.scene.away import Away

NEAR = 8.0  # longest blurs: what is nearer is near
OCTAVES = 64
LISTENED = 6  # octaves in which rings are looked at; farther out they fall on
WAVES, PER_WAVE = 3, 8
LOUDER = 2.0  # times, than in any of these places
FALLS = 1.5  # at least this power of the distance is what rings fall with


def away_of(job: Job, wavelength_nm: F64) -> Away | None:
    """Return what is known of a job's light from far away: that of a round lens alone.

    Light is E's slope over 2πr: its powers' and its rings', which have no shorter wave.
    """
    lens = job.system.lens
    if job.pattern is None or job.bending is not None or not isinstance(lens, RoundLens):
        return None
    grid = job.grid
    highest = job.system.highest_per_um(wavelength_nm) * grid.pitch_um
    blur = np.unique(job.blur_at(np.array([wavelength_nm.min(), wavelength_nm.max()])))
    longest, each = float(blur.max()), np.eye(blur.size)
    distance = NEAR * longest * 2.0 ** np.arange(OCTAVES)
    heard = distance[:LISTENED, None] + longest / PER_WAVE * np.arange(WAVES * PER_WAVE)
    rings = np.abs(oscillation(lens, blur, each, heard.ravel(), job.tolerance))
    swing = np.empty(OCTAVES)
    swing[:LISTENED] = LOUDER * rings.reshape(blur.size, LISTENED, -1).max(axis=(0, 2))
    swing[LISTENED:] = swing[LISTENED - 1] * (distance[LISTENED:] / distance[LISTENED - 1]) ** -FALLS
    powers = np.abs(smooth_powers(lens, blur, each)[:, 1:])
    slopes = np.stack([n * distance ** -(n + 1.0) for n in (1, 3, 5)])
    light = ((powers @ slopes).max(axis=0) + math.tau * highest * swing) / (math.tau * distance)
    size = np.array([grid.cols - 1.0, grid.rows - 1.0])
    x, y = np.array(grid.first_centre) + 0.5 * size
    return Away(
        complex(x, y),
        0.5 * float(np.hypot(*size)) + job.extent,
        float(distance[0]),
        np.maximum.accumulate(light[::-1])[::-1],
    )
