"""Scene: an infinite background and shapes in painter's order."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from camsim.core import notebook
from camsim.core.arrays import F64
from camsim.core.doors import above
from camsim.core.typed import refusal, validate
from camsim.core.words import brief
from camsim.errors import InvalidValueError
from camsim.scene.point_source import PointSource
from camsim.scene.primitives import Shape, counted, numbered
from camsim.scene.raster import Field
from camsim.spectra.curve import NumberOrCurve, Reflectance, Spectrum

_DISPLAYED = 10
"""Most shapes listed in notebooks."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """What is in front of the camera.

    background : reflectance of everything that no shape covers, out to infinity
    shapes     : pictures and gradients; later ones cover earlier ones

    >>> from camsim.scene import Disc
    >>> len(Scene(background=0.9, shapes=[Disc(radius_um=30.0, reflectance=0.1)]).shapes)
    1
    """

    background: Reflectance
    shapes: Sequence[Shape | Field] = ()

    if TYPE_CHECKING:

        def __init__(self, *, background: NumberOrCurve, shapes: Sequence[Shape | Field] = ()) -> None: ...

    __repr__ = brief

    def __post_init__(self) -> None:
        validate(self)
        try:
            counted(shape for shape in self.shapes if not isinstance(shape, Field))
        except InvalidValueError as error:
            raise refusal(self, "shapes", error.message) from None

    @property
    def spectra(self) -> tuple[Spectrum, ...]:
        """Distinct curves with every kink of the scene's reflectances, for quadrature; the background comes first."""
        painted: list[Spectrum] = [self.background]
        for shape in self.shapes:
            known = getattr(shape, "surfaces", None)  # of pictures and charts
            painted.extend((one.reflectance for one in shape.primitives()) if known is None else known)
        return numbered(painted)[0]

    def framed(self, reflectance: Spectrum) -> Scene:
        """Return the scene with every picture and gradient replaced by its outline in one colour."""
        return self._changed(Field, lambda shape: shape.frame(reflectance))

    def exposed(self, wavelength_nm: F64, electrons: F64) -> Scene:
        """Return the scene with its points in units of photosites; see ``PointSource.exposed``."""
        return self._changed(PointSource, lambda point: point.exposed(wavelength_nm, electrons))

    def _changed(self, kind: type, change: Callable[[Any], Any]) -> Scene:
        if not any(isinstance(shape, kind) for shape in self.shapes):
            return self
        shapes = [change(shape) if isinstance(shape, kind) else shape for shape in self.shapes]
        return Scene(background=self.background, shapes=shapes)

    @classmethod
    def from_yaml(
        cls,
        scene: str | os.PathLike[str],
        *,
        sensor: str | os.PathLike[str] | None = None,
        overrides: Iterable[str] = (),
        sensors: Iterable[str | os.PathLike[str]] = (),
    ) -> Scene:
        """Return the scene of a scene file (a path, or the name of a shipped one).

        sensor, overrides, sensors : as of ``camsim.load``; lengths in pixels are of the sensor's pitch
        """
        capture = above("api.load")(scene, sensor=sensor, overrides=overrides, sensors=sensors, held=False)
        found: Scene = capture.scene
        return found

    def _repr_html_(self) -> str:
        rows = [("background", brief(self.background)), ("shapes", str(len(self.shapes)))]
        rows += [(str(number), brief(shape)) for number, shape in enumerate(self.shapes[:_DISPLAYED])]
        rows += [("…", f"{len(self.shapes) - _DISPLAYED} more")] * (len(self.shapes) > _DISPLAYED)
        return notebook.table(rows, "Scene")
