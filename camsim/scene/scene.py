"""Scene: an infinite background and shapes in painter's order."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from camsim import notebook
from camsim.scene.shapes import Shape
from camsim.spectra.curve import Curve, Reflectance, Spectrum, spectrum_at
from camsim.typed import judge
from camsim.words import brief

_SHOWN, _DRAWN = 10, 2000
"""Shapes that notebooks list, and draw."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """What is in front of the camera.

    background : reflectance of everything that no shape covers, out to infinity
    shapes     : later ones cover earlier ones
    """

    background: Reflectance
    shapes: Sequence[Shape] = ()

    __repr__ = brief

    def __post_init__(self) -> None:
        judge(self)

    @classmethod
    def from_yaml(
        cls,
        scene: str | os.PathLike[str],
        *,
        sensor: str | os.PathLike[str] | None = None,
        overrides: Iterable[str] = (),
    ) -> Scene:
        """Return what is in front of the camera in a scene file (a path, or the name of a shipped one).

        sensor, overrides : as of ``camsim.load``; lengths in pixels are of the sensor's pitch
        """
        from camsim.capturing import load  # a door upward: the name users look for is here

        return load(scene, sensor=sensor, overrides=overrides, held=False).scene

    def _repr_html_(self) -> str:
        rows = [("background", _in_words(self.background)), ("shapes", str(len(self.shapes)))]
        rows += [(type(shape).__name__, _in_words(shape.reflectance)) for shape in self.shapes[:_SHOWN]]
        rows += [("…", f"{len(self.shapes) - _SHOWN} more")] * (len(self.shapes) > _SHOWN)
        drawn = [(shape.outline_um(math.inf), _grey(shape.reflectance)) for shape in self.shapes[:_DRAWN]]
        return notebook.table(rows, "Scene") + notebook.outlines(drawn, _grey(self.background))


def _in_words(reflectance: Spectrum) -> str:
    return (reflectance.name or repr(reflectance)) if isinstance(reflectance, Curve) else f"{reflectance:g}"


def _grey(reflectance: Spectrum) -> float:
    """Return the mean over what is seen, as a drawing shows it."""
    return float(spectrum_at(reflectance, np.arange(400.0, 701.0, 10.0)).mean())
