"""What the check sees of a scene's pictures, gradients and points: from the scene itself, with spectra of its own."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64
from camsim.errors import InvalidValueError
from camsim.kept import cached_property
from camsim.optics import OpticalSystem
from camsim.quadrature import gauss_order
from camsim.rendering.check.crossings import Bounds, bounds_of
from camsim.rendering.check.from_afar import FromAfar, from_afar
from camsim.rendering.check.gradient_samples import Cell, SeenGradient
from camsim.rendering.check.point_samples import SeenPoints, seen_points
from camsim.rendering.check.scene_samples import LARGEST, Seen
from camsim.rendering.check.wavelengths import densities
from camsim.rendering.job import Job
from camsim.rendering.spectral import carrying
from camsim.scene import Picture, PointSource, Scene
from camsim.scene.arcs import Fineness
from camsim.scene.gradients import Gradient
from camsim.scene.raster import Field, flat_of
from camsim.spectra.component import Component
from camsim.spectra.curve import Spectrum

MOST_PIECES = 125_000_000  # a gigabyte


class Summed(NamedTuple):
    """What is summed: pictures, optics, and what all planes (planes, channels, j) give; what a sum may be wrong by."""

    pictures: tuple[Seen, ...]
    system: OpticalSystem
    wavelength_nm: F64
    density: F64
    allowed: float


@dataclass(frozen=True, kw_only=True, eq=False)
class SeenFields:
    """What there is to see.

    job : of everything else;  scene: as it came in;  system: with a round lens, or the round part of one
    """

    job: Job
    scene: Scene
    system: OpticalSystem

    @cached_property
    def _highest(self) -> float:
        """The highest frequency that passes the lens, cycles/pitch."""
        job = self.job
        seen_nm = job.wavelength_nm[carrying(job.response)]
        return job.system.highest_per_um(seen_nm) * job.grid.pitch_um

    def _fine(self, field: Field) -> Fineness:
        """Return how closely a field's outlines are followed: a gradient's the less, the farther away they are."""
        job, away = self.job, self._away if isinstance(field, Gradient) else None
        longest = 1.0 / (self._highest + _cycles(field, job.grid.pitch_um))
        return Fineness(longest, job.budget.of_check.tolerance, away)

    @cached_property
    def _away(self) -> FromAfar | None:
        """How loud far places are."""
        return from_afar(self.job, self.job.wavelength_nm)

    @cached_property
    def bounds(self) -> dict[int, Bounds | None]:
        """What bounds what is seen of every field, by its number among the shapes; None for all of a picture."""
        return {
            number: bounds_of(self.scene, number, self.job.grid.pitch_um, self._fine(shape))
            for number, shape in enumerate(self.scene.shapes)
            if isinstance(shape, Picture | Gradient)
        }

    @property
    def visible(self) -> bool:
        """Whether anything of pictures, gradients and points is to be seen."""
        return bool(self.points) or any(bounds is None or len(bounds.start) for bounds in self.bounds.values())

    @cached_property
    def points(self) -> list[PointSource]:
        """Points that nothing covers, the brightest first."""
        seen = seen_points(self.scene)
        return sorted(seen, key=lambda point: -(point.photosites or 0.0))

    def summed(self) -> Summed:
        """Return what photosites are summed of."""
        job = self.job
        allowed = job.budget.of_check.tolerance
        background = self.scene.background
        pictures: list[Seen] = []
        spectra: list[Spectrum | Component] = []
        for number, shape in enumerate(self.scene.shapes):
            if isinstance(shape, Picture | Gradient):
                pictures.append(self._seen(number, shape, allowed))
                spectra.extend(shape.spectra)
                if pictures[-1].ones:
                    spectra.append(Component.less(background))
        colours: list[Spectrum] = list(dict.fromkeys(point.reflectance for point in self.points))
        wavelength_nm, density = densities(
            [*spectra, *colours] or [0.0], job.response, job.wavelength_nm, full=job.signals.scale
        )
        if self.points:
            pictures.append(SeenPoints.of(self.points, colours, job.grid.pitch_um))
            allowed /= max(1.0, pictures[-1].loud)
        return Summed(tuple(pictures), self.system, wavelength_nm, density, allowed)

    def _seen(self, number: int, shape: Field, allowed: float) -> Seen:
        """Return what is seen of a picture or gradient."""
        assert isinstance(shape, Picture | Gradient)
        highest, bounds = self._highest, self.bounds[number]
        pitch_um, background = self.job.grid.pitch_um, self.scene.background
        grey = background if isinstance(background, float | int) else None
        flat = None if grey is None else flat_of(shape.spectra)
        less = np.zeros(len(shape.spectra)) if flat is None or grey is None else grey * flat
        outline = None if bounds is None else (bounds.start, bounds.end)
        raster = Cell.of(shape, pitch_um) if isinstance(shape, Gradient) else shape
        phase = math.pi * (highest + _cycles(shape, pitch_um)) * min(raster.step_um / pitch_um, LARGEST)
        order = gauss_order(phase, max(allowed, 1e-12), most=60)
        if isinstance(shape, Gradient):
            return SeenGradient(
                picture=raster, less=less, ones=flat is None, outline=outline, pitch_um=pitch_um, order=order + 1,
                gradient=shape, highest=highest, allowed=allowed,
            )  # fmt: skip
        seen = Seen(picture=raster, less=less, ones=flat is None, outline=outline, pitch_um=pitch_um, order=order + 1)
        if seen.parts > 1 and (pieces := seen.planes * math.prod(seen.shape)) > MOST_PIECES:
            rows, cols = raster.shape
            size = f"{rows} × {cols} samples, each {raster.step_um / pitch_um:.3g} photosites wide"
            raise InvalidValueError(
                f"a picture of {size}, is checked in {pieces:.2g} pieces of a few photosites, and the most is "
                f"{MOST_PIECES:.3g}; crop it to what lies near the frame",
                key="shapes",
            )
        return seen


def _cycles(field: Field, pitch_um: float) -> float:
    """Return the most cycles/pitch of a gradient; a picture is told by its samples."""
    return field.cycles_per_um * pitch_um if isinstance(field, Gradient) else 0.0
