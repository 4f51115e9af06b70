"""Scene: an infinite background and shapes in painter's order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from camsim.errors import InvalidValueError
from camsim.scene.primitives import Shape, counted, flattened
from camsim.spectra.curve import Reflectance, Spectrum
from camsim.typed import judge, refusal


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
        try:
            counted(self.shapes)
        except InvalidValueError as error:
            raise refusal(self, "shapes", error.message) from None

    @property
    def spectra(self) -> tuple[Spectrum, ...]:
        """Distinct reflectances, the background's first."""
        painted = (primitive.reflectance for primitive in flattened(self.shapes))
        return tuple(dict.fromkeys((self.background, *painted)))
