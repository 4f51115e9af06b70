"""Wavelengths that a spectrum is transformed at, and from where on its rings are heard no more."""

from __future__ import annotations

import math

from camsim.optics.airy import AIRY
from camsim.optics.protocols import KnowsTail
from camsim.rendering.fourier.spread import kernel_of
from camsim.rendering.heard import followed
from camsim.rendering.job import Job, Nodes
from camsim.rendering.quiet import Waves
from camsim.rendering.spectral import wavefront_phase


def heard_from(job: Job) -> float:
    """Return from where on a scene's rings, and what is past three powers of 1/r, are within their shares.

    A footprint that is no rectangle stands for a point that lets as much pass, and hears as far as it reaches farther.
    """
    found = job.heard
    return max(found.line, followed(found.foci)) + (0.0 if job.footprint is not None else job.extent)


def nodes_of(job: Job) -> Nodes:
    """Return wavelengths that follow the rings of the spectrum as far as these are heard.

    Farther out they need not be right, but must be as quiet: a few wavelengths come back into step where the spectrum
    does not, and then more are taken. A lens that is not round is taken for an Airy pattern of the same width: no
    pupil's rings exceed those by much. Photosites that are no rectangles are points that let as much pass.
    """
    blur, span, allowed = job.blur, job.span, job.budget.allowed("rings")
    own_phase = wavefront_phase(job.system, job.signals.wavelength_nm)
    if isinstance(job.system.lens, KnowsTail):
        known = kernel_of(job.system, job.signals.wavelength_nm[[0, -1]], job.grid.pitch_um, job.tolerance)
        span = min(span, max(known.reach, job.rings_until))
    pattern, footprint = job.pattern or AIRY, job.hearing
    waves = job.waves(pattern, footprint)
    spread = 2.0 * math.pi * float(1.0 / blur.min() - 1.0 / blur.max())
    followed = waves.quiet_distance(allowed, front="line", within=span)
    while True:
        nodes = job.nodes(phase=spread * followed + own_phase)
        count = nodes.wavelength_nm.size
        if count == blur.size or followed >= span:
            return nodes
        few = Waves(
            pattern=pattern,
            blur=job.blur_at(nodes.wavelength_nm),
            shares=nodes.weights.reshape(-1, count),
            footprint=footprint,
        )
        heard = few.quiet_distance(allowed, front="line", within=span)
        if heard <= followed:
            return nodes
        followed = min(1.4 * followed, span)
