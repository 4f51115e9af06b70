"""The scene's outlines as edges: curved ones become polygons whose sides no photosite can tell from the curve."""

from __future__ import annotations

import contextlib
import functools
import math
from collections.abc import Sequence

import numpy as np

from camsim.arrays import F64
from camsim.kernels.threads import meanwhile
from camsim.optics import OpticalSystem
from camsim.optics.protocols import Varies
from camsim.quadrature import gauss_legendre
from camsim.rendering.across.bending import undistorted
from camsim.rendering.anchors import anchored
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.grid import Grid
from camsim.rendering.long_sides import LongSides
from camsim.scene import Arrangement, Primitive, Scene, arrange, flattened
from camsim.scene.outlines import has_curves
from camsim.scene.side_limits import SideLimits
from camsim.spectra.curve import spectrum_at

MANY = 1000  # primitives: of fewer, sides that grow are found in a moment
SLOPE_NODES = 96  # of a bound: a few per cent of it do not matter
DIRECTIONS = 64  # in which a photosite and an OLPF are asked, over half a turn


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
    shortest_nm, longest_nm = float(seen_nm.min()), float(seen_nm.max())
    allowed = budget.allowed("outlines") / contrast
    limits, line_per_um = _limits(system, shortest_nm, allowed)
    longer = functools.partial(
        LongSides.of,
        primitives,
        limits=limits,
        system=system,
        grid=grid,
        blur_um=(system.blur_um(shortest_nm), system.blur_um(longest_nm)),
        line_per_um=line_per_um,
        allowed=allowed,
        quiet=budget.allowed("powers"),
    )
    with meanwhile(longer) if len(primitives) > MANY else contextlib.nullcontext(functools.cache(longer)) as long:
        # Which shapes meet is found before any side is asked for.
        own = limits._replace(longer=lambda *curves: long().along(*curves), textured=textured)
        return arrange(scene, own, apart=lambda *curves: long().apart(*curves), primitives=primitives)


def _contrast(scene: Scene, primitives: Sequence[Primitive], seen_nm: F64) -> float:
    """Return the most that two surfaces differ by at a wavelength that carries signal."""
    low = high = spectrum_at(scene.background, seen_nm)
    for spectrum in dict.fromkeys(one.reflectance for one in primitives):
        there = spectrum_at(spectrum, seen_nm)
        low, high = np.minimum(low, there), np.maximum(high, there)
    return float(np.max(high - low))


def _limits(system: OpticalSystem, shortest_nm: float, allowed: float) -> tuple[SideLimits, float]:
    """Return the limits of a curved outline's sides, and the peak of the line spread, 1/µm.

    Sides no longer than the inverse of the highest frequency that passes in any direction wobble at frequencies that
    the lens does not pass. What stays is of second order: half the mean square of the wobble times the slope of the
    line spread, which is no more than ∫2π|f|·|OTF| df along it. Where another shape cuts the outline, what is left of
    the last side counts at once: its area times the pattern's peak, which is half that slope. Where sides differ,
    what one lacks is made up for beside it: the moment counts, times the pattern's slope, at most ∫∫2π|f_x|·|OTF| d²f.
    OLPF and photosite pass no more in any direction than in the one where they pass most.
    """
    highest = system.cutoff_per_um(shortest_nm)
    x, w = gauss_legendre(SLOPE_NODES)
    f = 0.5 * (1.0 + x) * highest
    angle = np.arange(DIRECTIONS)[:, None] * math.pi / DIRECTIONS
    weight = np.abs(system.footprint_otf(f * np.cos(angle), f * np.sin(angle))).max(axis=0) * w * highest
    passes = [
        system.point_otf_size(f, direction, shortest_nm) * weight
        for direction in ((1.0, 0.0), (0.0, 1.0), (math.sqrt(0.5), math.sqrt(0.5)), (math.sqrt(0.5), -math.sqrt(0.5)))
    ]
    slope = max(2.0 * math.pi * float(np.sum(f * otf)) for otf in passes)
    line_per_um = max(float(np.sum(otf)) for otf in passes)
    steepest = 4.0 * math.pi * max(float(np.sum(f * f * otf)) for otf in passes)
    cut_um2, moment_um3 = 2.0 * allowed / slope, allowed / steepest
    shift_um = allowed / line_per_um
    return SideLimits(1.0 / highest, math.sqrt(cut_um2), cut_um2, moment_um3, shift_um), line_per_um
