"""Point sources for the frequency sums: all visible ones of a scene form one layer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from camsim.core.arrays import F64
from camsim.errors import InvalidValueError
from camsim.scene import PointSource, Primitive, Scene, flattened
from camsim.scene.covering import covered
from camsim.spectra.curve import Spectrum

_STEP = 1e-6  # pitches: of squares that no PSF distinguishes from points


@dataclass(frozen=True, kw_only=True, eq=False)
class PointLayer:
    """Point sources, pitches; the engine treats them as samples of negligible size.

    at    : (n, 2) from the optical axis
    light : (planes, n) area, square pitches, of a surface of each plane's spectrum with the same light
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
        """One row of all points."""
        return 1, len(self.at)

    @property
    def planes(self) -> int:
        """Number of planes, one for each spectrum."""
        return len(self.light)

    @property
    def corners(self) -> F64:
        """Corners (4, 2) of the bounding box."""
        (left, top), (right, bottom) = self.at.min(axis=0), self.at.max(axis=0)
        return np.array([[left, top], [right, top], [right, bottom], [left, bottom]])

    @property
    def sides(self) -> int:
        """0: there is no outline."""
        return 0

    @property
    def said(self) -> tuple[str, str]:
        """What ``camsim explain`` says of the layer, and the reason."""
        count, planes = len(self.at), self.planes
        return (
            f"{count} point{'s' if count != 1 else ''} of {planes} colour{'s' if planes != 1 else ''}",
            "each is the pattern itself, wherever it lies between the photosites",
        )

    @property
    def strength(self) -> float:
        """Root of the sum of squares of each photosite's light, square pitches; errors of several add at random."""
        _, cell = np.unique(np.floor(self.at[:, 0]) + 1j * np.floor(self.at[:, 1]), return_inverse=True)
        return float(np.sqrt(np.sum(np.bincount(cell.ravel(), self.light.sum(axis=0)) ** 2)))


def seen_of(scene: Scene) -> list[PointSource]:
    """Return the points that no later shape covers."""
    points = [(number, shape) for number, shape in enumerate(scene.shapes) if isinstance(shape, PointSource)]
    if not points:
        return []
    primitives: list[Primitive] = []
    before: list[int] = []
    for shape in scene.framed(0.5).shapes:
        before.append(len(primitives))
        primitives += flattened([shape])
    at_um = np.array([point.centre_um for _, point in points], float)
    hidden = covered(at_um, np.array([before[number] for number, _ in points]), primitives)
    return [point for (_, point), under in zip(points, hidden.tolist(), strict=True) if not under]


def layer_of(points: Sequence[PointSource], pitch_um: float, colours: Sequence[Spectrum]) -> PointLayer:
    """Return points as a layer with a plane for each of the colours."""
    light = np.zeros((len(colours), len(points)))
    for k, point in enumerate(points):
        if point.photosites is None:
            raise InvalidValueError("needs a camera, which knows what one is; give photosites", key="electrons")
        light[colours.index(point.reflectance), k] = point.photosites
    return PointLayer(at=np.array([point.centre_um for point in points], float) / pitch_um, light=light)
