"""One rendering as the engines take it: whole, in pitches and in units of each channel's full scale."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TypedDict

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.core.cached import cached_property
from camsim.core.errors import UnsupportedError
from camsim.optics import OpticalSystem
from camsim.optics.pattern import Pattern
from camsim.rendering.bending import Bending
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.coherence import Waves
from camsim.rendering.edges import Edges
from camsim.rendering.footprint import Footprint, pattern_of
from camsim.rendering.grid import Grid
from camsim.rendering.prune import LeftOut, equal_sides, far_outlines
from camsim.rendering.ringing import RingingReach, counted
from camsim.rendering.spectral import Signals, blur_of, different, fuse
from camsim.scene import Scene
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


@dataclass(frozen=True, kw_only=True, eq=False)
class Job:
    """What is to be rendered, before any engine or setting is chosen.

    scene, response, wavelength_nm : as they came in; what follows was made of them
    edges        : that are to be rendered, pitches
    sides, pair  : (pairs, 2) left and right spectrum of every pair that meets, (n,) each edge's
    signals      : what each spectrum gives each channel at each wavelength
    base         : (channels,) the background
    left_out     : edges that need not be rendered
    pattern, footprint : of lens, and of OLPF ⊗ photosite, as the boundary engine knows them; None where it does not,
                   and ``unknown`` says why
    bending      : how the lens bends edges (those here are bent already); None where it does not
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
        edges = edges.some(edges.length > 0.0)  # shorter than rounding in pitches: no edge, and no direction
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
        """Return what was left out as a job of its own, on no background."""
        return dataclasses.replace(self, **_paired(self.left_out.edges), base=np.zeros_like(self.base))

    @property
    def finest(self) -> float | None:
        """The smallest tolerance that edges in closed form keep, None where they cannot be rendered so."""
        if self.footprint is None:
            return None
        return None if self.pattern is None else self.pattern.finest

    @property
    def budget(self) -> ErrorBudget:
        """Shares of the tolerance."""
        return ErrorBudget(self.tolerance)

    @cached_property
    def blur(self) -> F64:
        """The lens's own length at every wavelength of ``signals``, pitches; round lenses only."""
        return self.blur_at(self.signals.wavelength_nm)

    @cached_property
    def span(self) -> float:
        """Largest distance of an edge's end from where a photosite gathers light, pitches."""
        return self.farthest + self.extent

    @cached_property
    def farthest(self) -> float:
        """Largest distance of a photosite's centre from an edge's end, pitches."""
        return self.edges.farthest(self.grid)

    @cached_property
    def shares(self) -> F64:
        """Weights (k, n) of pairs and channels at all wavelengths; of those that are multiples the loudest alone."""
        shares: F64 = self._difference(self.signals.density).reshape(-1, self.signals.wavelength_nm.size)
        return different(shares) if len(shares) else np.zeros((1, self.signals.wavelength_nm.size))

    def waves(self, pattern: Pattern, footprint: Footprint) -> Waves:
        """Return the spectrum's rings as a footprint takes them, which may be part of the job's own."""
        return Waves(pattern=pattern, blur=self.blur, shares=self.shares, footprint=footprint)

    @cached_property
    def counted(self) -> RingingReach:
        """How far rings are heard; the pattern is known."""
        assert self.pattern is not None
        return counted(self.waves(self.pattern, self.counting), self.edges, self.grid, self.budget)

    @cached_property
    def counting(self) -> Footprint:
        """What hears rings: the footprint, or a point that lets as much of them pass where it is not known."""
        return self.footprint or Footprint.enveloped(self.system, self.grid.pitch_um, 1.0 / float(self.blur.min()))

    @property
    def extent(self) -> float:
        """Distance of the farthest point of OLPF ⊗ photosite from its centre, or more, pitches."""
        return self.system.extent_um / self.grid.pitch_um

    def blur_at(self, wavelength_nm: F64) -> F64:
        """Return the lens's own length at wavelengths, pitches."""
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
    """Return the fields of a job that its edges make."""
    sides, pair = edges.pairs()
    return {"edges": edges, "sides": sides, "pair": pair}
