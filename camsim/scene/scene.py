"""Scene: an infinite background and shapes in painter's order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from camsim.scene.shapes import Shape, check_reflectance
from camsim.spectra.curve import Spectrum


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """What is in front of the camera.

    background : reflectance of everything that no shape covers, out to infinity
    shapes     : later ones cover earlier ones
    """

    background: Spectrum
    shapes: Sequence[Shape] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "shapes", tuple(self.shapes))
        check_reflectance(self.background, "background")
