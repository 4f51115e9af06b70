"""Points of light as the field engine takes them: all of a scene's that nothing hides are one layer."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from camsim.arrays import F64
from camsim.errors import InvalidValueError
from camsim.optics import OpticalSystem
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.fields.light import Samples
from camsim.rendering.grid import Grid
from camsim.rendering.outlines import arranged
from camsim.scene import PointSource, Scene
from camsim.spectra.curve import Curve, Spectrum

_STEP = 1e-6  # pitches: of squares that no pattern tells from points


@dataclass(frozen=True, kw_only=True, eq=False)
class PointLayer:
    """Points, pitches; to the engine samples so small that nothing of them but their light is seen.

    at    : (n, 2) from the optical axis
    light : (planes, n) square pitches of a surface of each plane's spectrum that send as much
    """

    at: F64
    light: F64
    kind: ClassVar = "point sources"
    step: ClassVar = _STEP
    degree: ClassVar = 0
    upright: ClassVar = False
    outline: ClassVar = None

    @property
    def axes(self) -> F64:
        """Unit vectors along x and y."""
        return np.eye(2)

    @property
    def shape(self) -> tuple[int, int]:
        """One row of all."""
        return 1, len(self.at)

    @property
    def planes(self) -> int:
        """One for each spectrum."""
        return len(self.light)

    @property
    def corners(self) -> F64:
        """Corners (4, 2) about all."""
        (left, top), (right, bottom) = self.at.min(axis=0), self.at.max(axis=0)
        return np.array([[left, top], [right, top], [right, bottom], [left, bottom]])

    @property
    def sides(self) -> int:
        """There is no outline that would hear rings."""
        return 0

    @property
    def said(self) -> tuple[str, str]:
        """What explanations say of it, and why."""
        count, planes = len(self.at), self.planes
        return (
            f"{count} point{'s' if count != 1 else ''} of {planes} colour{'s' if planes != 1 else ''}",
            "each is the pattern itself, wherever it lies between the photosites",
        )

    @property
    def loud(self) -> float:
        """Their light as far as it may add up by chance, square pitches: what lies in one photosite does so surely."""
        _, cell = np.unique(np.floor(self.at[:, 0]) + 1j * np.floor(self.at[:, 1]), return_inverse=True)
        return float(np.sqrt(np.sum(np.bincount(cell.ravel(), self.light.sum(axis=0)) ** 2)))

    def within(self, low: F64, high: F64, origin: tuple[float, float]) -> Samples | None:
        """Return those in a box, low … high from an origin; None where there are none."""
        at = self.at - np.array(origin)
        inside = ((at >= low) & (at <= high)).all(axis=1)
        if not inside.any():
            return None
        return Samples(
            lattice=None,
            places=np.empty((0, 2)),
            strengths=np.empty((self.planes, 0)),
            points=at[inside],
            corrections=np.ascontiguousarray(self.light[:, inside]),
            step=self.step,
            degree=self.degree,
            axes=self.axes,
        )


def seen_of(scene: Scene, system: OpticalSystem, grid: Grid, seen_nm: F64, budget: ErrorBudget) -> list[PointSource]:
    """Return the points that no later shape covers."""
    found: list[PointSource] = []
    for same, shapes in itertools.groupby(enumerate(scene.shapes), lambda one: isinstance(one[1], PointSource)):
        if not same:
            continue
        together = [(number, shape) for number, shape in shapes if isinstance(shape, PointSource)]
        later = [one for one in scene.shapes[together[-1][0] + 1 :] if not isinstance(one, PointSource)]
        covered = np.zeros(len(together), bool)
        if later:
            # Beyond all of them is a colour that nothing else has.
            beyond = Curve((400.0, 700.0), (0.25, 0.75), name="what no shape covers", outside="hold")
            covering = Scene(background=beyond, shapes=later).framed(0.5)
            edges = arranged(covering, system, grid, seen_nm, budget, textured=True)
            rim = (edges.left == 0) != (edges.right == 0)
            at_um = np.array([shape.centre_um for _, shape in together], float)
            covered = _within(at_um, edges.start_um[rim], edges.end_um[rim])
        found += [shape for (_, shape), hidden in zip(together, covered.tolist(), strict=True) if not hidden]
    return found


def _within(places: F64, start: F64, end: F64) -> np.ndarray:
    """Return which places (n, 2) lie within outlines: an odd number of them is crossed on the way to the right."""
    odd = np.zeros(len(places), bool)
    low, high = np.minimum(start[:, 1], end[:, 1]), np.maximum(start[:, 1], end[:, 1])
    for k, (x, y) in enumerate(places.tolist()):
        here = np.flatnonzero((low <= y) & (y < high))
        a, b = start[here], end[here]
        crossing = a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1])
        odd[k] = np.count_nonzero(crossing > x) % 2 == 1
    return odd


def layer_of(points: Sequence[PointSource], pitch_um: float, colours: Sequence[Spectrum]) -> PointLayer:
    """Return points as a layer with a plane for each of the colours."""
    light = np.zeros((len(colours), len(points)))
    for k, point in enumerate(points):
        if point.photosites is None:
            raise InvalidValueError("needs a camera, which knows what one is; give photosites", key="electrons")
        light[colours.index(point.reflectance), k] = point.photosites
    return PointLayer(at=np.array([point.centre_um for point in points], float) / pitch_um, light=light)
