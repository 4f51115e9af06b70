"""One rendering as the engines take it: whole, in pitches and in units of each channel's full scale."""

from __future__ import annotations

import dataclasses
import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from camsim.arrays import F64, I64
from camsim.errors import UnsupportedError
from camsim.optics import OpticalSystem
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.check.judge import Judge
from camsim.rendering.footprint import Footprint
from camsim.rendering.grid import Grid
from camsim.rendering.long_sides import LongSides
from camsim.rendering.patterns import Pattern, pattern_of
from camsim.rendering.prune import equal_sides, far_outlines
from camsim.rendering.quadrature import gauss_legendre
from camsim.rendering.spectral import Signals, blur_of, fuse
from camsim.scene import Disc, Scene, arrange
from camsim.scene.arrange import Arrangement


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Nodes:
    """Wavelengths at which the optics are computed, and what everything weighs there.

    wavelength_nm : (j,)
    density       : (spectra, channels, j) of every spectrum
    weights       : (pairs, channels, j) left minus right of every pair of spectra
    """

    wavelength_nm: F64
    density: F64
    weights: F64


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LeftOut:
    """Edges of the scene that a job leaves out.

    outline_edges : of all shapes, before one covers another
    start, end, left, right : as in ``Job``: those with equal sides first, then those far outside
    equal, far    : how many of each
    bound         : what the far ones together add to any photosite, at the most, relative to full scale
    """

    outline_edges: int
    start: F64
    end: F64
    left: I64
    right: I64
    equal: int
    far: int
    bound: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Job:
    """What is to be rendered, before any engine or setting is chosen.

    scene, response, wavelength_nm : as they came in; what follows was made of them
    start, end   : (n, 2) the edges, pitches
    left, right  : (n,) spectrum on either side (0: the background);  pair: (n,) index into ``sides``
    sides        : (pairs, 2) left and right spectrum of every pair
    signals      : what each spectrum gives each channel at each wavelength
    base         : (channels,) the background
    left_out     : edges that need not be rendered
    pattern, footprint : of lens, and of OLPF ⊗ photosite, as the boundary engine knows them; None when it does not,
                   and ``unknown`` says why
    """

    scene: Scene
    response: F64
    wavelength_nm: F64
    start: F64
    end: F64
    left: I64
    right: I64
    pair: I64
    sides: I64
    signals: Signals
    base: F64
    left_out: LeftOut
    system: OpticalSystem
    grid: Grid
    pattern: Pattern | None
    footprint: Footprint | None
    unknown: str
    tolerance: float

    @classmethod
    def of(
        cls,
        scene: Scene,
        system: OpticalSystem,
        grid: Grid,
        *,
        response: F64,
        wavelength_nm: F64,
        tolerance: float,
    ) -> Job:
        """Resolve a scene; arguments as in ``render_channels``."""
        pattern, footprint, unknown = None, None, ""
        try:
            pattern, footprint = pattern_of(system.lens), Footprint.of(system, grid.pitch_um)
        except UnsupportedError as error:
            unknown = str(error)
        budget = ErrorBudget(tolerance)
        seen_nm = wavelength_nm[np.any(response != 0.0, axis=0)]
        arrangement = _arranged(scene, system, grid, seen_nm, budget)
        signals = Signals.of(arrangement, response, wavelength_nm)
        start, end = arrangement.start_um / grid.pitch_um, arrangement.end_um / grid.pitch_um
        real = np.hypot(*(end - start).T) > 0.0  # shorter than rounding in pitches: no edge, and no direction
        start, end, left, right = start[real], end[real], arrangement.left[real], arrangement.right[real]
        equal = equal_sides(left, right, signals.density)
        far, bound = np.zeros_like(equal), 0.0
        if pattern is not None and footprint is not None:
            far[~equal], bound = far_outlines(
                start[~equal],
                end[~equal],
                left[~equal],
                right[~equal],
                density=signals.density,
                pattern=pattern,
                longest=float(blur_of(system, signals.wavelength_nm, grid.pitch_um).max()),
                extent=footprint.extent,
                grid=grid,
                allowed=budget.allowed("dropped"),
            )
        kept, out = ~(equal | far), np.concatenate([np.flatnonzero(equal), np.flatnonzero(far)])
        return cls(
            scene=scene,
            response=response,
            wavelength_nm=wavelength_nm,
            **_edges(start[kept], end[kept], left[kept], right[kept]),
            signals=signals,
            base=signals.density[0].sum(axis=1),
            left_out=LeftOut(
                outline_edges=arrangement.outline_edges,
                start=start[out],
                end=end[out],
                left=left[out],
                right=right[out],
                equal=int(np.count_nonzero(equal)),
                far=int(np.count_nonzero(far)),
                bound=bound,
            ),
            system=system,
            grid=grid,
            pattern=pattern,
            footprint=footprint,
            unknown=unknown,
            tolerance=tolerance,
        )

    def rest(self) -> Job:
        """Return what was left out as a job of its own, on no background."""
        out = self.left_out
        return dataclasses.replace(
            self, **_edges(out.start, out.end, out.left, out.right), base=np.zeros_like(self.base)
        )

    def of_edges(
        self,
        start: F64,
        end: F64,
        left: I64,
        right: I64,
        *,
        wavelength_nm: F64,
        density: F64,
        base: F64,
        tolerance: float,
    ) -> Job:
        """Return other edges with signals of their own behind the same optics, at another tolerance."""
        signals = Signals(wavelength_nm=wavelength_nm, density=density, scale=self.signals.scale)
        edges = _edges(start, end, left, right)
        return dataclasses.replace(self, **edges, signals=signals, base=base, tolerance=tolerance)

    @property
    def budget(self) -> ErrorBudget:
        """Shares of the tolerance."""
        return ErrorBudget(self.tolerance)

    @functools.cached_property
    def judge(self) -> Judge:
        """What recomputes photosites."""
        return Judge(self)

    @property
    def edges(self) -> int:
        """How many edges there are."""
        return len(self.start)

    @property
    def blur(self) -> F64:
        """The lens's own length at every wavelength of ``signals``, pitches; round lenses only."""
        return self.blur_at(self.signals.wavelength_nm)

    @property
    def span(self) -> float:
        """Largest distance of a photosite from an edge's end, pitches."""
        first = np.array(self.grid.first_centre)
        last = first + np.array([self.grid.cols - 1, self.grid.rows - 1])
        points = np.concatenate([self.start, self.end])
        gap = np.maximum(np.abs(points - first), np.abs(points - last))
        return float(np.hypot(gap[:, 0], gap[:, 1]).max(initial=0.0))

    @property
    def shares(self) -> F64:
        """Weights (pairs · channels, n) of every pair at every wavelength of ``signals``."""
        count = self.signals.wavelength_nm.size
        if not len(self.sides):
            return np.zeros((1, count))
        shares: F64 = self._difference(self.signals.density).reshape(-1, count)
        return shares

    def blur_at(self, wavelength_nm: F64) -> F64:
        """Return the lens's own length at wavelengths, pitches."""
        return blur_of(self.system, wavelength_nm, self.grid.pitch_um)

    def nodes(self, *, phase: float) -> Nodes:
        """Fuse the wavelengths; see ``spectral.fuse``."""
        wavelength_nm, density = fuse(self.signals, phase=phase, allowed=self.budget.allowed("wavelengths"))
        return Nodes(wavelength_nm=wavelength_nm, density=density, weights=self._difference(density))

    def nodes_like(self, nodes: Nodes) -> Nodes:
        """Return the same nodes with the weights of this job's pairs."""
        return dataclasses.replace(nodes, weights=self._difference(nodes.density))

    def _difference(self, density: F64) -> F64:
        difference: F64 = density[self.sides[:, 0]] - density[self.sides[:, 1]]
        return difference


def _edges(start: F64, end: F64, left: I64, right: I64) -> dict[str, Any]:
    """Return the edges' fields of a job, pairs of spectra counted."""
    sides, pair = np.unique(np.stack([left, right], axis=1), axis=0, return_inverse=True)
    return {"start": start, "end": end, "left": left, "right": right, "sides": sides, "pair": pair.ravel()}


def _arranged(scene: Scene, system: OpticalSystem, grid: Grid, seen_nm: F64, budget: ErrorBudget) -> Arrangement:
    """Return the scene's edges, its round outlines as polygons."""
    discs = [shape for shape in scene.shapes if isinstance(shape, Disc)]
    if not discs or not seen_nm.size:
        return arrange(scene, max_segment_um=math.inf)
    shortest_nm, longest_nm = float(seen_nm.min()), float(seen_nm.max())
    allowed = budget.allowed("outlines")
    segment_um, wobble_um, cut_um2, line_per_um = _outline_limits(system, shortest_nm, allowed)
    long = LongSides.of(
        discs,
        limits_um=(segment_um, wobble_um, cut_um2),
        system=system,
        grid=grid,
        blur_um=(system.blur_um(shortest_nm), system.blur_um(longest_nm)),
        line_per_um=line_per_um,
        budget=budget,
    )
    return arrange(scene, max_segment_um=segment_um, max_wobble_um=wobble_um, max_cut_um2=cut_um2, longer=long.along)


def _outline_limits(system: OpticalSystem, shortest_nm: float, allowed: float) -> tuple[float, float, float, float]:
    """Return the longest side of a curved outline's polygon and its largest wobble, µm, its largest cut, µm², and the
    peak of the line spread, 1/µm.

    Sides no longer than the inverse of the highest frequency that passes in any direction wobble at frequencies that
    the lens does not pass. What stays is of second order: half the mean square of the wobble times the slope of the
    line spread, which is no more than ∫2π|f|·|OTF| df along it. Where another shape cuts the outline, what is left of
    the last side counts at once: its area times the pattern's peak, which is half that slope.
    """
    highest = system.cutoff_per_um(shortest_nm)
    x, w = gauss_legendre(SLOPE_NODES)
    f = 0.5 * (1.0 + x) * highest
    passes = [
        np.abs(system.point_otf(f * cx, f * cy, shortest_nm)) * w * highest
        for cx, cy in ((1.0, 0.0), (0.0, 1.0), (math.sqrt(0.5), math.sqrt(0.5)), (math.sqrt(0.5), -math.sqrt(0.5)))
    ]
    slope = max(2.0 * math.pi * float(np.sum(f * otf)) for otf in passes)
    line_per_um = max(float(np.sum(otf)) for otf in passes)
    return 1.0 / highest, math.sqrt(2.0 * allowed / slope), 2.0 * allowed / slope, line_per_um


SLOPE_NODES = 24  # of a bound: a few per cent of it do not matter
