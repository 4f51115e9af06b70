"""Fields in front of the camera: samples on a turned lattice, and what makes them."""

from __future__ import annotations

import abc
from collections.abc import Iterator
from typing import Any, Literal, TypeAlias

import numpy as np

from camsim.core.arrays import F64
from camsim.scene.primitives import Primitive, Shape, turned
from camsim.scene.shapes import Rectangle
from camsim.spectra.curve import Curve, Spectrum

Interpolation: TypeAlias = Literal["squares", "linear", "cubic"]
DEGREES: dict[str, int] = {"squares": 0, "linear": 1, "cubic": 3}
"""Degrees of the B-splines whose coefficients are the samples."""


class Raster:
    """Samples on a lattice of squares, row 0 at the top, planes (planes, rows, cols) each with a spectrum."""

    __slots__ = ()

    planes: Any
    spectra: Any
    width_um: float
    centre_um: Any
    rotate_deg: float
    interpolation: Interpolation

    @property
    def kind(self) -> str:
        """Name of this kind of field in explanations."""
        return "picture"

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of samples."""
        return self.planes.shape[1], self.planes.shape[2]

    @property
    def step_um(self) -> float:
        """Distance between neighbouring samples."""
        return self.width_um / self.shape[1]

    @property
    def height_um(self) -> float:
        """Height of the whole lattice."""
        return self.step_um * self.shape[0]

    @property
    def axes(self) -> F64:
        """Unit vectors (2, 2) along rows and columns."""
        return turned(np.eye(2), self.rotate_deg)

    @property
    def flat(self) -> F64 | None:
        """Weights of the planes that sum to a reflectance of 1 at every wavelength; None if unknown."""
        if self.spectra == (1.0,):
            return np.ones(1)
        curves = [spectrum for spectrum in self.spectra if isinstance(spectrum, Curve)]
        if len(curves) < len(self.spectra) or len({(curve.wavelength_nm, curve.outside) for curve in curves}) != 1:
            return None
        total = np.sum([np.asarray(curve.values) for curve in curves], axis=0)
        held = curves[0].outside == "hold" and np.abs(total - 1.0).max() < 1e-12
        return np.ones(len(curves)) if held else None


class Field(abc.ABC):
    """A shape without a uniform colour."""

    __slots__ = ()

    @property
    @abc.abstractmethod
    def reflectance(self) -> Spectrum:
        """The mean of the field, which stands for it where only outlines matter."""

    @property
    @abc.abstractmethod
    def surfaces(self) -> tuple[Spectrum, ...]:
        """Curves with every kink of the field's spectra, for quadrature."""

    @abc.abstractmethod
    def frame(self, reflectance: Spectrum) -> Shape:
        """Return the field's outline, filled with one colour."""

    def primitives(self) -> Iterator[Primitive]:
        """Return the field's outline, filled with the mean colour."""
        return self.frame(self.reflectance).primitives()


class Oblong(Field):
    """A rectangle without a uniform colour."""

    __slots__ = ()

    width_um: Any
    height_um: Any
    centre_um: Any
    rotate_deg: Any

    @property
    def half_um(self) -> tuple[float, float]:
        """Half its sides."""
        return 0.5 * self.width_um, 0.5 * self.height_um

    def frame(self, reflectance: Spectrum) -> Rectangle:
        """Return its rectangle in one colour."""
        return Rectangle(
            width_um=self.width_um,
            height_um=self.height_um,
            centre_um=self.centre_um,
            rotate_deg=self.rotate_deg,
            reflectance=reflectance,
        )
