"""What differs from the perfect lens, in two bands of frequencies: fine and short, smooth and far.

A pattern's tail comes from the corner that its transfer has at frequency 0. A smooth window takes that part out,
exp(−q)·(1 + q + q²/2), q = (f/σ)²: what it leaves is as flat there as its sixth power, and short; what it takes goes
on for hundreds of photosites, and needs few frequencies.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy

from camsim.arrays import F64
from camsim.optics import OpticalSystem
from camsim.optics.airy import Airy
from camsim.optics.difference import Difference
from camsim.optics.placed import Revolves
from camsim.rendering.aberrated.settings import sighted
from camsim.rendering.across.transfers import Transfers
from camsim.rendering.edges import Edges
from camsim.rendering.fast_length import fast_length
from camsim.rendering.fourier.blocks import Tile

SIGMA = 0.22  # cycles/pitch
SMOOTH_CUT = 6.0  # σ, where nothing is left: 1e-13
DIRECTIONS = 16  # in which lines are looked at
LINE = 4096  # points of what one shows
TIMES = {"near": 5.0, "far": 4.0}  # the reach: sides of tiles
LEAST_SIDE, LEAST_REACH = 48, 1.0  # pitches
WAVELENGTHS, RADII = 12, 3  # at which far light is bounded


def smooth(frequency: F64) -> F64:
    """Return the window of the far band."""
    q = np.square(frequency / SIGMA)
    window: F64 = np.exp(-q) * (1.0 + q + 0.5 * q * q)
    return window


@dataclass(frozen=True, slots=True, kw_only=True)
class Band:
    """One of the two, and how it is transformed.

    name   : "near" or "far";  reach: as far as a line is heard, footprint included, pitches
    sight  : as far as there are edges to be heard;  from a period on, less this, all must be quiet
    side   : of a tile, photosites;  period: photosites;  cut: cycles/pitch
    group  : tiles along a side of what has places in common
    """

    name: str
    reach: float
    sight: float
    side: int
    period: int
    cut: float
    group: int

    def window(self, frequency: F64) -> F64:
        """Return what the band takes of frequencies."""
        return smooth(frequency) if self.name == "far" else 1.0 - smooth(frequency)

    def tile(self, row: int, col: int, rows: int, cols: int) -> Tile:
        """Return photosites as the transforms take them."""
        place, reach = (row, col, rows, cols), self.reach
        return Tile.square(place, inner=reach, outer=reach, period=self.period, cut=self.cut, near=self.sight)


def band_of(name: str, reach: float, span: float, shape: tuple[int, int], cut: float, group: int) -> Band:
    """Return a band for a window of (rows, cols); span: the farthest that an edge is from any of its photosites."""
    side = max(LEAST_SIDE, math.ceil(TIMES[name] * reach))
    longest = max(shape)
    if side * 1.3 > longest:
        side, group = longest, 1
    sight = min(reach, span)
    period = fast_length(math.ceil(side + reach + sight), real=True)
    return Band(name=name, reach=reach, sight=sight, side=side, period=period, cut=cut, group=group)


def near_reach(transfers: Transfers, contrast: F64, edges: Edges, allowed: float) -> float:
    """Return how far what the near band takes of lines is heard: measured on all radii, pitches.

    contrast : (sets,) the most that two sides differ by
    """
    count, most = transfers.harmonics.shape[2], transfers.most
    frequency: F64 = transfers.step * np.arange(count, dtype=np.float64)
    angle = math.pi * np.arange(DIRECTIONS) / DIRECTIONS
    around = np.exp(1j * np.multiply.outer(np.arange(-most, most + 1), angle))
    weight = np.zeros(count)
    weight[1:] = (1.0 - smooth(frequency[1:])) * transfers.step / frequency[1:]
    heard = np.zeros(LINE)
    for radius in transfers.harmonics:
        for own, loud in zip(radius, contrast, strict=True):
            line = np.einsum("fm,ma->af", own, around) * (weight * loud / (2j * math.pi))
            heard = np.maximum(heard, np.abs(scipy.fft.irfft(line, n=LINE, axis=1, norm="forward")).max(axis=0))
    both = np.maximum(heard[: LINE // 2], heard[:0:-1][: LINE // 2])
    beyond = np.maximum.accumulate(both[::-1])[::-1]
    place = np.arange(LINE // 2) / (LINE * transfers.step)

    def reach_of(lines: float) -> float:
        heard_there = np.flatnonzero(beyond > allowed / lines)
        return max(LEAST_REACH, float(place[min(heard_there[-1] + 1, place.size - 1)]) if heard_there.size else 0.0)

    return sighted(edges, reach_of)


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
    for radius in np.unique(np.linspace(*radii_um, RADII)):
        rest = Difference(
            lens=lens.at(float(radius), 0.0), core=Airy(f_number=lens.f_number), obstruction=0.0, moved_um=(0.0, 0.0)
        )
        each = np.stack([rest.light_beyond(x * pitch_um, float(w), rings) for w in nm])
        heard = np.maximum(heard, np.einsum("sw,wx->sx", light, each).max(axis=0))

    def reach_of(lines: float) -> float:
        loud = np.flatnonzero(heard > allowed / lines)
        return max(LEAST_REACH, float(x[min(loud[-1] + 1, x.size - 1)]) if loud.size else 0.0)

    return sighted(edges, reach_of)
