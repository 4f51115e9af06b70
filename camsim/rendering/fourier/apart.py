"""An image's parts: by distance, or by place."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np

from camsim.rendering.fourier.islands import islands
from camsim.rendering.fourier.shells import Shell, shells
from camsim.rendering.fourier.spikes import Spikes, spike_hem
from camsim.rendering.fourier.together import Part, Sum, pays

if TYPE_CHECKING:
    from camsim.rendering.fourier.image import FourierImage


def parts_of(image: FourierImage, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[Part, ...]:
    """Return the parts of an image that take less than all at once; none where there are no such."""
    ways = [way for way in (by_distance(image, origin, shape), by_place(image, origin, shape)) if way]
    if not ways:
        return ()
    best: tuple[Part, ...] = ()
    cost = image.at_once(origin, shape)[0]
    for way in ways:
        own = Sum(parts=way).expected(origin, shape)[0]
        if pays(own, cost, image.memory_limit_bytes):
            best, cost = way, own
    return best


def by_distance(image: FourierImage, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[Part, ...]:
    """Return shells of a round pattern; of a pupil with straight sides what is near, and its spikes."""
    (nm, density), edges = image.lit, image.edges.seen_from(origin)
    task = image.system, image.kernel, nm, image.pitch_um, edges, shape, image.tolerance
    hem = spike_hem(*task)
    own = shells(*task, image.quiet) if hem is None else (Shell(begin=None, end=hem, tapers=1),)
    base = np.zeros_like(image.base)
    parts = tuple(dataclasses.replace(image, base=base, shell=shell, whole=image) for shell in own)
    if hem is None:
        return parts
    system, pitch_um = image.system, image.pitch_um
    far = Spikes(edges=image.edges, density=density, wavelength_nm=nm, system=system, pitch_um=pitch_um, hem=hem)
    return *parts, far


def by_place(image: FourierImage, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[Part, ...]:
    """Return islands of the scene, of a lens whose pattern is sampled; an island has none."""
    if image.whole is not None or not image.kernel.sampled:
        return ()
    own = islands(image.edges, (origin, shape), image.kernel, image.lit[0].size, image.footprint)
    if len(own) < 2:
        return ()
    base = np.zeros_like(image.base)
    return tuple(dataclasses.replace(image, edges=one, base=base, whole=image, islands=len(own)) for one in own)
