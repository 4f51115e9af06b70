"""Scene: an infinite background and shapes in painter's order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from camsim.scene.shapes import Shape
from camsim.spectra.curve import Reflectance
from camsim.typed import judge


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """What is in front of the camera.

    background : reflectance of everything that no shape covers, out to infinity
    shapes     : later ones cover earlier ones
    """

    background: Reflectance
    shapes: Sequence[Shape] = ()

    def __post_init__(self) -> None:
        judge(self)
