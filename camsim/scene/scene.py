"""Scene: an infinite background and shapes in painter's order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from camsim.scene.picture import Picture
from camsim.scene.shapes import Shape
from camsim.spectra.curve import Reflectance, Spectrum
from camsim.typed import judge


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """What is in front of the camera.

    background : reflectance of everything that no shape covers, out to infinity
    shapes     : and pictures; later ones cover earlier ones
    """

    background: Reflectance
    shapes: Sequence[Shape | Picture] = ()

    def __post_init__(self) -> None:
        judge(self)

    @property
    def spectra(self) -> tuple[Spectrum, ...]:
        """Curves that bend wherever a reflectance of the scene does, the background's first."""
        painted: list[Spectrum] = [self.background]
        for shape in self.shapes:
            painted.extend(shape.surfaces if isinstance(shape, Picture) else (shape.reflectance,))
        return tuple(dict.fromkeys(painted))
