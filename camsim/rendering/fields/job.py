"""The pictures, gradients and points of a scene, with their visible parts and their signals in every channel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import F64
from camsim.errors import InvalidValueError
from camsim.optics import OpticalSystem
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.engine import FINEST
from camsim.rendering.fields.gradient import sampled
from camsim.rendering.fields.layer import Layer, Rings
from camsim.rendering.fields.points import PointLayer, layer_of, seen_of
from camsim.rendering.grid import Grid
from camsim.rendering.outlines import arranged
from camsim.rendering.spectral import carrying, multiplied
from camsim.scene import Picture, PointSource, Scene
from camsim.scene.gradients import Gradient
from camsim.scene.raster import Field, Raster
from camsim.spectra.component import Component
from camsim.spectra.curve import Curve, Spectrum

POINT_ROOM = 3.0  # light of a point, in photosites of a diffuser, up to which the tolerance is not tightened
OF_ALIASES = (
    2.0  # of the tolerance, for the bound on aliases at a rim; behind full photosites a tenth of it was measured
)
TAILS = 0.02  # of the tolerance: light at either end of the spectrum that may be moved to another wavelength


@dataclass(frozen=True, kw_only=True, eq=False)
class FieldJob:
    """Pictures, gradients and points of a scene.

    layers        : the visible ones, all points as the last one
    wavelength_nm : (n,);  density: (planes, channels, n) of all layers' planes, relative to full scale
    tolerance     : share of the tolerance for pictures, gradients and points
    brighter      : factor by which that tolerance was tightened for bright points
    """

    layers: tuple[Layer | PointLayer, ...]
    wavelength_nm: F64
    density: F64
    system: OpticalSystem
    grid: Grid
    tolerance: float
    brighter: float = 1.0

    @classmethod
    def of(
        cls,
        scene: Scene,
        system: OpticalSystem,
        grid: Grid,
        *,
        response: F64,
        wavelength_nm: F64,
        scale: F64,
        tolerance: float,
    ) -> FieldJob:
        """Find the visible parts of all pictures and points; ``scale``: (channels,) of the edges' signals."""
        seen_nm = wavelength_nm[carrying(response)]
        layers: list[Layer | PointLayer] = []
        spectra: list[Spectrum | Component] = []
        for number, shape in enumerate(scene.shapes):
            if not isinstance(shape, Field) or isinstance(shape, PointSource):
                continue
            outline = _seen(scene, number, system, grid, seen_nm, ErrorBudget(tolerance))
            if outline is not None and not len(outline[0]):
                continue
            hidden = number + 1 < len(scene.shapes)
            raster = _raster(shape, system, seen_nm, ErrorBudget(tolerance), grid.pitch_um, hidden)
            layer = Layer.of(raster, scene.background, grid.pitch_um, outline)
            layers.append(layer)
            spectra.extend(raster.spectra)
            if layer.ones:
                spectra.append(Component.less(scene.background))
        points, brighter = seen_of(scene), 1.0
        colours = list(dict.fromkeys(one.reflectance for one in points))
        nodes, density = multiplied([*spectra, *colours] or [0.0], response, wavelength_nm)
        if points:
            exposed = layer_of(points, grid.pitch_um, colours)
            layers.append(exposed)
            # A photosite facing a diffuser receives all light from beyond R, one near a point 1/2πR² of it. With this
            # allowance the error was a hundredth of the allowed one; 0.13 for point photosites and λN of 0.1 pitches.
            brighter = max(1.0, exposed.strength / POINT_ROOM)
            tolerance = _beside_points(tolerance, brighter)
        nodes, density = _without_tails(nodes, density / scale[:, None], TAILS * tolerance)
        return cls(
            layers=tuple(layers),
            wavelength_nm=nodes,
            density=density,
            system=system,
            grid=grid,
            tolerance=tolerance,
            brighter=brighter,
        )


def _beside_points(tolerance: float, brighter: float) -> float:
    """Return the tolerance for light far from points; raises InvalidValueError if it is too fine."""
    if tolerance / brighter < FINEST:
        message = (
            f"{tolerance:g} of a diffuser beside a point of light takes {tolerance / brighter:.2g} of the point's own, "
            f"and {FINEST:g} is the finest; ask for {FINEST * brighter:.1g} or more, or for a fainter point"
        )
        raise InvalidValueError(message, key="tolerance")
    return tolerance / brighter


def _without_tails(wavelength_nm: F64, density: F64, allowed: float) -> tuple[F64, F64]:
    """Return fewer wavelengths: at either end, those that sum to at most ``allowed`` are merged into the next one.

    The shortest wavelength determines the number of frequencies.
    """
    size = np.abs(density).sum(axis=0).max(axis=0)
    first = int(np.searchsorted(np.cumsum(size), allowed, side="right"))
    stop = size.size - int(np.searchsorted(np.cumsum(size[::-1]), allowed, side="right"))
    if first >= stop:
        return wavelength_nm, density
    retained = density[..., first:stop].copy()
    retained[..., 0] += density[..., :first].sum(axis=-1)
    retained[..., -1] += density[..., stop:].sum(axis=-1)
    return wavelength_nm[first:stop], retained


def _raster(
    field: Field, system: OpticalSystem, seen_nm: F64, budget: ErrorBudget, pitch_um: float, hidden: bool
) -> Raster:
    """Return the samples of a field: those of a picture, or of a gradient as the lens and the tolerance require."""
    if isinstance(field, Raster):
        return field
    assert isinstance(field, Gradient)
    cutoff = system.highest_per_um(seen_nm)
    return sampled(field, cutoff, OF_ALIASES * budget.tolerance, pitch_um, hidden)


def _seen(
    scene: Scene, number: int, system: OpticalSystem, grid: Grid, seen_nm: F64, budget: ErrorBudget
) -> Rings | None:
    """Return the outline of a field's visible part, with curves cut as for edges; None if all of it is visible."""
    field = scene.shapes[number]
    assert isinstance(field, Field)
    later = scene.shapes[number + 1 :]
    if not later and isinstance(field, Picture):
        return None
    # A spectrum that nothing else has: its edges are the outline.
    each = Curve((400.0, 700.0), (0.25, 0.75), name="the picture", outside="hold")
    its_frame = field.frame(each)
    covered = Scene(background=scene.background, shapes=[its_frame, *later]).framed(scene.background)
    found = arranged(covered, system, grid, seen_nm, budget, textured=True)
    if each not in found.spectra:
        return np.empty((0, 2)), np.empty((0, 2))
    which = found.spectra.index(each)
    forth, back = found.left == which, found.right == which
    start = np.concatenate([found.start_um[forth], found.end_um[back]])
    end = np.concatenate([found.end_um[forth], found.start_um[back]])
    if not isinstance(field, Picture):
        return start, end
    [frame] = its_frame.primitives()
    corners = frame.layers[0][0].curves.points[:, 0]
    whole = len(start) == 4 and {*map(tuple, start.tolist())} == {*map(tuple, corners.tolist())}
    return None if whole else (start, end)
