"""The scene's outlines as edges: curves become polygons, fine enough for the tolerance at every photosite."""

from __future__ import annotations

import math

import numpy as np

from camsim.core.arrays import F64
from camsim.numerics.quadrature import gauss_legendre
from camsim.optics import OpticalSystem
from camsim.optics.protocols import KnowsSize, Round, Varies
from camsim.rendering.anchors import anchored
from camsim.rendering.bending import undistorted
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.grid import Grid
from camsim.scene import Arrangement, Scene, arrange, flattened
from camsim.scene.outlines import has_curves
from camsim.scene.side_limits import SideLimits
from camsim.spectra.curve import spectrum_at

SLOPE_NODES = 96  # quadrature nodes of a bound that need be right only to a few per cent
DIRECTIONS = 64  # over half a turn, in which the transfer of photosite and OLPF is sampled
_DIAGONAL = math.sqrt(0.5)
LOOKED_IN = ((1.0, 0.0), (0.0, 1.0), (_DIAGONAL, _DIAGONAL), (_DIAGONAL, -_DIAGONAL))  # directions of bounds
# Of lenses whose pattern may be long and narrow: a side ratio of 10 is followed to a tenth.
AROUND = tuple((math.cos(math.pi * k / 60), math.sin(math.pi * k / 60)) for k in range(60))
MOST_TURN = 2.0 * math.pi / 16.0  # of a side: up to here the sagitta is s²/8R to half a per cent
WAVES = 24  # frequencies along an edge; the harmonics of a longer side fall as 1/n²
SIDES = np.geomspace(1.0, 1e4, 81)  # lengths of sides, in the shortest wave that the lens passes


def arranged(
    scene: Scene, system: OpticalSystem, grid: Grid, seen_nm: F64, budget: ErrorBudget, *, textured: bool = False
) -> Arrangement:
    """Return the scene's edges, with curved outlines as polygons.

    seen_nm  : wavelengths that carry signal
    textured : frames of one colour represent pictures, whose samples may have any contrast and cut every outline
    """
    return anchored(_arranged(scene, system, grid, seen_nm, budget, textured=textured), grid, budget.tolerance)


def _arranged(
    scene: Scene, system: OpticalSystem, grid: Grid, seen_nm: F64, budget: ErrorBudget, *, textured: bool
) -> Arrangement:
    if isinstance(system.lens, Varies) and system.lens.distorts:
        grid = undistorted(grid, system.lens)
    primitives = flattened(scene.shapes)
    contrast = 1.0 if textured else _contrast(scene, seen_nm)
    if contrast == 0.0 or not has_curves(primitives):
        return arrange(scene, primitives=primitives)
    limits = _limits(system, float(seen_nm.min()), budget.allowed("outlines") / contrast)
    return arrange(scene, limits._replace(textured=textured), primitives=primitives)


def _contrast(scene: Scene, seen_nm: F64) -> float:
    """Return the largest difference of reflectance between two surfaces at a wavelength that carries signal."""
    low = high = spectrum_at(scene.background, seen_nm)
    for spectrum in scene.spectra:
        there = spectrum_at(spectrum, seen_nm)
        low, high = np.minimum(low, there), np.maximum(high, there)
    return float(np.max(high - low))


def _limits(system: OpticalSystem, shortest_nm: float, allowed: float) -> SideLimits:
    """Return the limits of a curved outline's sides.

    A polygon deviates from its curve periodically. If its sides are no longer than the inverse of the cut-off
    frequency, the lens does not pass this deviation. Longer sides deviate by harmonics of amplitude s²/2π²n²R,
    n = 1, 2 …; one of frequency u along an edge changes a photosite by at most its amplitude times ∫|OTF(f, u)| df.
    The remaining effect is of second order: half the mean square deviation times the slope of the line spread, at most
    ∫2π|f|·|OTF| df. Where another shape cuts the outline, the area left of the last side counts in full, times the peak
    of the PSF, which is half that slope. Where sides differ in length, the deficit of one is compensated next to it, so
    its first moment counts, times the slope of the PSF, at most ∫∫2π|f_x|·|OTF| d²f. In any case, the strip between
    side and curve contributes at most its width times the peak of the line spread.
    The transfer of OLPF and photosite is bounded by that in their strongest direction.
    """
    highest = system.cutoff_per_um(shortest_nm)
    x, w = gauss_legendre(SLOPE_NODES)
    f, w = 0.5 * (1.0 + x) * highest, w * highest  # over negative frequencies as well
    angle = np.arange(DIRECTIONS)[:, None] * math.pi / DIRECTIONS
    weight = np.abs(system.footprint_otf(f * np.cos(angle), f * np.sin(angle))).max(axis=0) * w
    looked_in = AROUND
    if isinstance(system.lens, Round | KnowsSize) and not system.more:
        looked_in = LOOKED_IN[:1] if isinstance(system.lens, Round) else LOOKED_IN
    passes = weight * np.stack([system.point_otf_size(f, direction, shortest_nm) for direction in looked_in])
    slope = 2.0 * math.pi * float((passes @ f).max())
    line_per_um = float(passes.sum(axis=1).max())
    steepest = 4.0 * math.pi * float((passes @ (f * f)).max())
    cut_um2 = 2.0 * allowed / slope
    # Bound for waves of frequency u, over all directions: the transfer at the frequency of f and u together.
    u = highest * np.arange(1, WAVES + 1) / WAVES
    most = np.maximum.accumulate(passes[:, ::-1].max(axis=0) / w[::-1])[::-1]
    displayed = np.interp(np.hypot(f, u[:, None]), f, most, right=0.0) @ w
    side_um = SIDES / highest
    n = np.arange(1, WAVES + 1)[:, None]
    waves = np.interp(n / side_um, u, displayed, left=line_per_um, right=0.0)
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
