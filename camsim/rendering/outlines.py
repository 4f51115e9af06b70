"""The scene's outlines as edges: curved ones become polygons whose sides no photosite can tell from the curve."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from camsim.arrays import F64
from camsim.optics import OpticalSystem
from camsim.optics.protocols import Varies
from camsim.quadrature import gauss_legendre
from camsim.rendering.anchors import anchored
from camsim.rendering.bending import undistorted
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.grid import Grid
from camsim.scene import Arrangement, Primitive, Scene, arrange, flattened
from camsim.scene.outlines import has_curves
from camsim.scene.primitives import numbered
from camsim.scene.side_limits import SideLimits
from camsim.spectra.curve import spectrum_at

SLOPE_NODES = 96  # of a bound: a few per cent of it do not matter
DIRECTIONS = 64  # in which a photosite and an OLPF are asked, over half a turn
LOOKED_IN = ((1.0, 0.0), (0.0, 1.0), (math.sqrt(0.5), math.sqrt(0.5)), (math.sqrt(0.5), -math.sqrt(0.5)))
MOST_TURN = 2.0 * math.pi / 16.0  # of a side: what s²/8R leaves out of its height is half a per cent
WAVES = 24  # along an edge, frequencies that are asked; of a longer side the higher ones are as faint as 1/n²
SIDES = np.geomspace(1.0, 1e4, 81)  # in the shortest wave that passes


def arranged(
    scene: Scene, system: OpticalSystem, grid: Grid, seen_nm: F64, budget: ErrorBudget, *, textured: bool = False
) -> Arrangement:
    """Return the scene's edges, its curved outlines as polygons.

    seen_nm  : wavelengths that carry signal
    textured : frames of one colour stand for pictures, whose samples differ by any contrast and cut every outline
    """
    return anchored(_arranged(scene, system, grid, seen_nm, budget, textured=textured), grid, budget.tolerance)


def _arranged(
    scene: Scene, system: OpticalSystem, grid: Grid, seen_nm: F64, budget: ErrorBudget, *, textured: bool
) -> Arrangement:
    if isinstance(system.lens, Varies) and system.lens.distorts:
        grid = undistorted(grid, system.lens)
    primitives = flattened(scene.shapes)
    contrast = 1.0 if textured else _contrast(scene, primitives, seen_nm)
    if contrast == 0.0 or not has_curves(primitives):
        return arrange(scene, primitives=primitives)
    limits = _limits(system, float(seen_nm.min()), budget.allowed("outlines") / contrast)
    return arrange(scene, limits._replace(textured=textured), primitives=primitives)


def _contrast(scene: Scene, primitives: Sequence[Primitive], seen_nm: F64) -> float:
    """Return the most that two surfaces differ by at a wavelength that carries signal."""
    low = high = spectrum_at(scene.background, seen_nm)
    for spectrum in numbered([one.reflectance for one in primitives])[0]:
        there = spectrum_at(spectrum, seen_nm)
        low, high = np.minimum(low, there), np.maximum(high, there)
    return float(np.max(high - low))


def _limits(system: OpticalSystem, shortest_nm: float, allowed: float) -> SideLimits:
    """Return the limits of a curved outline's sides.

    Sides no longer than the inverse of the highest frequency that passes in any direction wobble at frequencies that
    the lens does not pass. Longer ones wobble by waves of s²/2π²n²R, n = 1, 2 …, and of a wave of frequency u along an
    edge a photosite is shown no more than its height times ∫|OTF(f, u)| df. What stays is of second order: half the
    mean square of the wobble times the slope of the line spread, which is no more than ∫2π|f|·|OTF| df along it. Where
    another shape cuts the outline, what is left of the last side counts at once: its area times the pattern's peak,
    which is half that slope. Where sides differ, what one lacks is made up for beside it: the moment counts, times the
    pattern's slope, at most ∫∫2π|f_x|·|OTF| d²f. And a strip between side and curve takes no more, however it is cut,
    than its width times the peak of the line spread.
    OLPF and photosite pass no more in any direction than in the one where they pass most.
    """
    highest = system.cutoff_per_um(shortest_nm)
    x, w = gauss_legendre(SLOPE_NODES)
    f, w = 0.5 * (1.0 + x) * highest, w * highest  # both ways from 0
    angle = np.arange(DIRECTIONS)[:, None] * math.pi / DIRECTIONS
    weight = np.abs(system.footprint_otf(f * np.cos(angle), f * np.sin(angle))).max(axis=0) * w
    passes = weight * np.stack([system.point_otf_size(f, direction, shortest_nm) for direction in LOOKED_IN])
    slope = 2.0 * math.pi * float((passes @ f).max())
    line_per_um = float(passes.sum(axis=1).max())
    steepest = 4.0 * math.pi * float((passes @ (f * f)).max())
    cut_um2 = 2.0 * allowed / slope
    # What waves of frequency u show, in the direction where they show most: that of f and u together.
    u = highest * np.arange(1, WAVES + 1) / WAVES
    most = np.maximum.accumulate(passes[:, ::-1].max(axis=0) / w[::-1])[::-1]
    shown = np.interp(np.hypot(f, u[:, None]), f, most, right=0.0) @ w
    side_um = SIDES / highest
    n = np.arange(1, WAVES + 1)[:, None]
    waves = np.interp(n / side_um, u, shown, left=line_per_um, right=0.0)
    radius_um = side_um**2 * (waves / n**2).sum(axis=0) / (2.0 * math.pi**2 * allowed)
    return SideLimits(
        segment_um=1.0 / highest,
        wobble_um=math.sqrt(cut_um2),
        cut_um2=cut_um2,
        moment_um3=allowed / steepest,
        off_um=allowed / line_per_um,
        turn_rad=MOST_TURN,
        longer_um=(radius_um, side_um),
    )
