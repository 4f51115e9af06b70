"""One rendering in the form that the engines use: in pitches and in units of each channel's full scale."""

from __future__ import annotations

import copy
import dataclasses
from dataclasses import dataclass
from typing import TypedDict

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.core.cached import Caching, cached_property
from camsim.errors import UnsupportedError
from camsim.optics import OpticalSystem
from camsim.optics.pattern import Pattern
from camsim.rendering.bending import Bending
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.edges import Edges
from camsim.rendering.footprint import Footprint, pattern_of
from camsim.rendering.grid import Grid
from camsim.rendering.prune import LeftOut, equal_sides, far_outlines
from camsim.rendering.rings import Rings
from camsim.rendering.spectral import Signals, blur_of, different, fuse
from camsim.scene import Scene
from camsim.scene.arrange import Arrangement


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Nodes:
    """Wavelengths at which the optics are computed, and the weights of spectra there.

    wavelength_nm : (j,)
    density       : (spectra, channels, j) of every spectrum
    weights       : (pairs, channels, j) left minus right of every pair of spectra
    """

    wavelength_nm: F64
    density: F64
    weights: F64


@dataclass(frozen=True, kw_only=True, eq=False)
class Job(Caching):
    """What is to be rendered, before any engine or setting is chosen.

    scene, response, wavelength_nm : the inputs; the other attributes derive from them
    edges        : edges to render, pitches
    sides, pair  : (pairs, 2) left and right spectrum of every pair that meets, and (n,) the pair of each edge
    signals      : signal of each spectrum in each channel at each wavelength
    base         : (channels,) signal of the background
    left_out     : edges that need not be rendered
    pattern, footprint : of the lens, and of OLPF ⊗ photosite, for the boundary engine; None if it does not support
                   them, for the reason in ``unknown``
    bending      : the lens's distortion of edges (already applied to these); None if there is none
    """

    scene: Scene
    response: F64
    wavelength_nm: F64
    edges: Edges
    sides: I64
    pair: I64
    signals: Signals
    base: F64
    left_out: LeftOut
    system: OpticalSystem
    grid: Grid
    pattern: Pattern | None
    footprint: Footprint | None
    unknown: str
    tolerance: float
    bending: Bending | None = None

    @classmethod
    def of(
        cls,
        scene: Scene,
        arrangement: Arrangement,
        system: OpticalSystem,
        grid: Grid,
        *,
        response: F64,
        wavelength_nm: F64,
        tolerance: float,
        bending: Bending | None = None,
    ) -> Job:
        """Resolve a scene and its arrangement (``outlines.arranged``); the rest as in ``render_channels``."""
        pattern, footprint, unknown = None, None, ""
        try:
            footprint = Footprint.of(system, grid.pitch_um)
        except UnsupportedError as error:
            unknown = str(error)
        try:
            pattern = None if system.more else pattern_of(system.lens)
        except UnsupportedError as error:
            unknown = unknown or str(error)
        budget = ErrorBudget(tolerance)
        signals = Signals.of(arrangement, response, wavelength_nm)
        edges = Edges(
            start=arrangement.start_um / grid.pitch_um,
            end=arrangement.end_um / grid.pitch_um,
            left=arrangement.left,
            right=arrangement.right,
        )
        edges = edges.some(edges.length > 0.0)  # zero after rounding in pitches: without a direction
        unlike = edges.some(~(equal := equal_sides(edges, signals.density)))
        far, bound = np.zeros(len(unlike), bool), 0.0
        if pattern is not None and footprint is not None:
            far, bound = far_outlines(
                unlike,
                density=signals.density,
                pattern=pattern,
                longest=float(blur_of(system, signals.wavelength_nm, grid.pitch_um).max()),
                extent=footprint.extent,
                grid=grid,
                allowed=budget.allowed("dropped"),
            )
        return cls(
            scene=scene,
            response=response,
            wavelength_nm=wavelength_nm,
            **_paired(unlike.some(~far)),
            signals=signals,
            base=signals.density[0].sum(axis=1),
            left_out=LeftOut(
                sides=arrangement.sides,
                hidden=arrangement.hidden,
                edges=edges.some(np.concatenate([np.flatnonzero(equal), np.flatnonzero(~equal)[far]])),
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
            bending=bending,
        )

    def rest(self) -> Job:
        """Return a job that renders the edges left out of this one, on a background of zero."""
        return dataclasses.replace(self, **_paired(self.left_out.edges), base=np.zeros_like(self.base))

    def to(self, tolerance: float) -> Job:
        """Return the same job to another tolerance; what is known of its edges does not depend on it."""
        other = copy.copy(self)
        object.__setattr__(other, "tolerance", tolerance)
        return other

    @property
    def finest(self) -> float | None:
        """Smallest tolerance that the boundary engine's closed forms reach; None if they do not apply."""
        if self.footprint is None:
            return None
        return None if self.pattern is None else self.pattern.finest

    @property
    def budget(self) -> ErrorBudget:
        """Shares of the tolerance."""
        return ErrorBudget(self.tolerance)

    @cached_property
    def blur(self) -> F64:
        """Scale of the lens's PSF (λN) at every wavelength of ``signals``, pitches."""
        return self.blur_at(self.signals.wavelength_nm)

    @cached_property
    def span(self) -> float:
        """Largest distance of an edge's end from a point of a photosite's footprint, pitches."""
        return self.farthest + self.extent

    @cached_property
    def farthest(self) -> float:
        """Largest distance of a photosite's centre from an edge's end, pitches."""
        return self.edges.farthest(self.grid)

    @cached_property
    def rings(self) -> Rings | None:
        """Distances from a few places of the edges that face them perpendicularly; None without edges."""
        if not len(self.edges):
            return None
        light = self.signals.density.sum(axis=2)
        jump = light[self.sides[:, 0]] - light[self.sides[:, 1]]
        strongest = np.take_along_axis(jump, np.abs(jump).argmax(axis=1)[:, None], axis=1)[:, 0]
        highest = self.system.highest_per_um(self.signals.wavelength_nm) * self.grid.pitch_um
        return Rings.of(self.edges, self.grid, self.farthest, strongest[self.pair], float(self.blur.max()), highest)

    @cached_property
    def shares(self) -> F64:
        """Weights (k, n) of pairs and channels at all wavelengths; of proportional ones only the largest."""
        shares: F64 = self._difference(self.signals.density).reshape(-1, self.signals.wavelength_nm.size)
        return different(shares) if len(shares) else np.zeros((1, self.signals.wavelength_nm.size))

    @property
    def extent(self) -> float:
        """Upper bound, pitches, of how far the photosite, repeated at the OLPF's spots, reaches from its centre."""
        return self.system.extent_um / self.grid.pitch_um

    def blur_at(self, wavelength_nm: F64) -> F64:
        """Return the scale of the lens's PSF (λN) at wavelengths, pitches."""
        return blur_of(self.system, wavelength_nm, self.grid.pitch_um)

    def nodes(self, *, phase: float = 0.0, count: int | None = None) -> Nodes:
        """Fuse the wavelengths; see ``spectral.fuse``."""
        allowed = self.budget.allowed("wavelengths")
        wavelength_nm, density = fuse(self.signals, phase=phase, allowed=allowed, count=count)
        return Nodes(wavelength_nm=wavelength_nm, density=density, weights=self._difference(density))

    def nodes_like(self, nodes: Nodes) -> Nodes:
        """Return the same nodes with the weights of this job's pairs."""
        return dataclasses.replace(nodes, weights=self._difference(nodes.density))

    def _difference(self, density: F64) -> F64:
        difference: F64 = density[self.sides[:, 0]] - density[self.sides[:, 1]]
        return difference


class _Paired(TypedDict):
    edges: Edges
    sides: I64
    pair: I64


def _paired(edges: Edges) -> _Paired:
    """Return the attributes of a job that derive from its edges."""
    sides, pair = edges.pairs()
    return {"edges": edges, "sides": sides, "pair": pair}
