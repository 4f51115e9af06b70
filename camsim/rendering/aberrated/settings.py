"""How far the difference reaches, and the windows that it is transformed on; lengths in pitches.

The difference is cut off by a taper that is 1 out to ``reach``, where a straight edge shows no more than its share of
the tolerance, and 0 from ``outer`` on. Scenery farther than ``reach`` from a window is clamped to a box about it, as in
fourier/plan.py, so its period is about its side and twice the reach: whatever the scene, whatever the frame.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from camsim.optics.airy import AIRY
from camsim.optics.difference import Difference
from camsim.quadrature import SIX_POINTS
from camsim.rendering.edges import Edges
from camsim.rendering.fast_length import fast_length
from camsim.rendering.fourier.taper import taper_margin
from camsim.rendering.fourier.tile import Tile
from camsim.rendering.heard import crowding, smooth_corners
from camsim.rendering.job import Job

CORNER = 0.5  # lines more in sight of a photosite for every corner nearby
ALL_ROUND = 1.5 * math.pi  # what a whole circle shows beyond its radius, over what a line at that distance does
GENTLE = 8.0  # times the reach: a curve of such a radius shows no more than a line, as one that distortion bends
HEARD = 8.0  # times what a line shows, that a taper's hem works on
COARSEST_RESPONSE = 0.15  # step, blurs
FINEST_GRAIN = 2  # photosites


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Settings of one difference.

    reach    : as far as the pattern is kept;  extent: of the footprint;  outer: where the taper is 0
    cut      : highest frequency, cycles/pitch;  sharpness: of the taper
    step     : of a line's response
    grain    : photosites along a cell of the map on which windows are placed
    side, period : of a window, photosites
    """

    reach: float
    extent: float
    outer: float
    cut: float
    sharpness: float
    step: float
    grain: int
    side: int
    period: int

    @property
    def near(self) -> float:
        """Distance of a photosite from what it may see."""
        return self.reach + self.extent

    def tile(self, row: int, col: int, rows: int, cols: int) -> Tile:
        """Return a window as the transforms take it."""
        place = row, col, rows, cols
        return Tile.square(place, inner=self.reach, outer=self.outer, period=self.period, cut=self.cut, near=self.near)


def sighted(edges: Edges, reach_of: Callable[[float], float]) -> float:
    """Return the reach for as many lines as a photosite may have in sight; reach_of: lines → distance, pitches."""
    alone = reach_of(1.0)
    if smooth_corners(edges, alone, GENTLE * alone):
        return reach_of(ALL_ROUND)
    return reach_of(min(1.0 + CORNER * crowding(edges, 2.0 * alone), ALL_ROUND))


def settings_of(job: Job, rest: Difference, extent: float, times: float) -> Settings:
    """Choose the settings of windows ``times`` the reach and more along a side, as far as the frame is that large."""
    pitch_um, blur, budget = job.grid.pitch_um, job.blur, job.budget
    ends_nm = {float(job.signals.wavelength_nm.min()), float(job.signals.wavelength_nm.max())}
    allowed, rings = budget.allowed("cut"), job.system.ring_share(job.signals.wavelength_nm)

    def reach_of(lines: float) -> float:
        return max(rest.reach_um(allowed / lines, nm, rings) for nm in ends_nm) / pitch_um

    reach = min(max(sighted(job.edges, reach_of), job.rings_until), job.span)
    beyond = max(float(rest.light_beyond(np.array(reach * pitch_um), nm, rings)) for nm in ends_nm)
    margin, sharpness = taper_margin(min(max(budget.allowed("hem") / (HEARD * beyond), 1e-14), 1.0))
    grain = max(FINEST_GRAIN, round(0.125 * (reach + extent)))
    side = min(math.floor(times * (reach + extent)) + 1, max(job.grid.rows, job.grid.cols))
    shortest, cutoff = float(blur.min()), rest.cutoff_per_um(min(ends_nm)) * pitch_um
    least = side + 2.0 * (reach + extent)
    width = max(math.sqrt(margin * least / cutoff), margin * shortest / 8.0)
    period = fast_length(math.ceil(least + width), real=True)
    width = period - least
    turn = (math.pi * 0.5 * budget.allowed("short lines") / SIX_POINTS / AIRY.moment(5)) ** (1.0 / 6.0)
    return Settings(
        reach=reach,
        extent=extent,
        outer=reach + width,
        cut=cutoff + margin / width,
        sharpness=sharpness,
        step=shortest * min(COARSEST_RESPONSE, turn / (2.0 * math.pi)),
        grain=grain,
        side=side,
        period=period,
    )
