"""What sees the light, as the check averages over it: a rectangle on every spot, or a point that stands for others."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camsim.arrays import F64
from camsim.optics.protocols import Rectangular
from camsim.rendering.envelope import Envelope
from camsim.rendering.job import Job


class Listener(NamedTuple):
    """A photosite's sides and the OLPF's spots (n, 2), pitches; of no rectangle a point's, and what waves it passes."""

    sides: tuple[float, float]
    spots: F64
    envelope: Envelope | None

    @classmethod
    def of(cls, job: Job, wavelength_nm: F64) -> Listener:
        """Return what sees a job's light of these wavelengths."""
        pitch_um, photosite = job.grid.pitch_um, job.system.photosite
        if not isinstance(photosite, Rectangular):
            highest = 1.0 / float(job.blur_at(wavelength_nm).min())
            return cls((0.0, 0.0), np.zeros((1, 2)), Envelope.of(job.system, pitch_um, highest))
        width_um, height_um = photosite.sides_um
        return cls((width_um / pitch_um, height_um / pitch_um), job.system.spots_um() / pitch_um, None)
