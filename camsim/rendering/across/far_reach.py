"""How far lines are heard of a lens of revolution at all: by what its rim sends, of any frequency."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from camsim.arrays import F64
from camsim.optics import OpticalSystem
from camsim.optics.airy import Airy
from camsim.optics.difference import Difference
from camsim.optics.placed import Revolves
from camsim.rendering.aberrated.settings import sighted
from camsim.rendering.across.bands import LEAST_REACH
from camsim.rendering.across.hardest import knots_within
from camsim.rendering.edges import Edges

WAVELENGTHS, RADII = 12, 3  # at which far light is bounded


def far_reach(
    lens: Revolves,
    system: OpticalSystem,
    wavelength_nm: F64,
    weights: F64,
    *,
    radii_um: tuple[float, float],
    pitch_um: float,
    edges: Edges,
    allowed: float,
) -> float:
    """Return how far lines are heard at all, by what the rim sends: pitches.

    weights : (sets, wavelengths) times the most that two sides differ by
    """
    cuts = np.linspace(0, wavelength_nm.size, min(WAVELENGTHS, wavelength_nm.size) + 1).round().astype(int)
    light = np.add.reduceat(np.abs(weights), cuts[:-1], axis=1)
    nm = [wavelength_nm[(a + b) // 2] for a, b in pairwise(cuts)]
    rings = system.ring_share(wavelength_nm)
    x = np.geomspace(0.5, 1e5, 400)
    heard = np.zeros(x.size)
    for radius in knots_within(lens, radii_um, RADII, float(nm[0])):
        rest = Difference(
            lens=lens.at(float(radius), 0.0), core=Airy(f_number=lens.f_number), obstruction=0.0, moved_um=(0.0, 0.0)
        )
        each = np.stack([rest.light_beyond(x * pitch_um, float(w), rings) for w in nm])
        heard = np.maximum(heard, np.einsum("sw,wx->sx", light, each).max(axis=0))

    def reach_of(lines: float) -> float:
        loud = np.flatnonzero(heard > allowed / lines)
        return max(LEAST_REACH, float(x[min(loud[-1] + 1, x.size - 1)]) if loud.size else 0.0)

    return sighted(edges, reach_of)
