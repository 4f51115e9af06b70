"""Gradients and sinusoids: analytic fields between two reflectances."""

from __future__ import annotations

import abc
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from annotated_types import Ge, Le

from camsim.core.arrays import F64, distinct
from camsim.core.typed import Number, Place, Point, Positive, Whole, validate
from camsim.scene.primitives import Shape
from camsim.scene.raster import Field, Oblong
from camsim.scene.shapes import Disc, Ring
from camsim.scene.shapes.rounds import validate_radii
from camsim.spectra.curve import Curve, NumberOrCurve, Reflectance, Spectrum, spectrum_at

Cycles = Annotated[int, Ge(1), Le(100_000)]


class Gradient(Field):
    """Common interface: a value from 0 to 1 at every point, which interpolates from ``low`` to ``high``."""

    __slots__ = ()

    centre_um: Any
    low: Any
    high: Any

    @property
    def rotate_deg(self) -> float:
        """Rotation of the field's axes, clockwise as displayed."""
        return 0.0

    def __post_init__(self) -> None:
        validate(self)

    @property
    @abc.abstractmethod
    def half_um(self) -> tuple[float, float]:
        """Half the extent of the field along its axes."""

    def cycles_per_um(self, beyond_um: F64 | float = 0.0) -> F64 | float:
        """Return the highest local frequency beyond distances from the centre; 0 for polynomials up to degree 3."""
        return 0.0

    @property
    def smallest_um(self) -> float:
        """The shortest length over which the field varies in other ways than by that frequency."""
        return math.inf

    @abc.abstractmethod
    def value(self, x_um: F64, y_um: F64) -> F64:
        """Return the field at points relative to its centre, along its axes; continued smoothly beyond its rim."""

    @property
    def spectra(self) -> tuple[Spectrum, ...]:
        """Spectra of the planes: white if both reflectances are numbers, else those of ``high`` and ``low``."""
        return (1.0,) if self._grey else (self.high, self.low)

    def planes_at(self, x_um: F64, y_um: F64) -> F64:
        """Return (planes, …): weights of the spectra at points."""
        value = self.value(x_um, y_um)
        return np.stack([self.low + (self.high - self.low) * value] if self._grey else [value, 1.0 - value])

    @property
    def _grey(self) -> bool:
        return not isinstance(self.low, Curve) and not isinstance(self.high, Curve)

    @property
    def reflectance(self) -> Spectrum:
        """The mean of both reflectances."""
        if self._grey:
            return 0.5 * float(self.low + self.high)
        curves = [part for part in (self.low, self.high) if isinstance(part, Curve)]
        nodes = distinct(np.concatenate([np.asarray(curve.wavelength_nm, float) for curve in curves]))
        mean = 0.5 * (spectrum_at(self.low, nodes) + spectrum_at(self.high, nodes))
        return Curve(tuple(nodes.tolist()), tuple(mean.tolist()), outside="hold")

    @property
    def surfaces(self) -> tuple[Spectrum, ...]:
        """Both reflectances."""
        return self.low, self.high


class RoundGradient(Gradient):
    """Common interface of those with a round rim."""

    __slots__ = ()

    radius_um: Any

    @property
    def half_um(self) -> tuple[float, float]:
        """Its radius."""
        return self.radius_um, self.radius_um

    def frame(self, reflectance: Spectrum) -> Shape:
        """Return its disc."""
        return Disc(radius_um=self.radius_um, centre_um=self.centre_um, reflectance=reflectance)


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearGradient(Oblong, Gradient):
    """A rectangle, linear from ``low`` at its left side to ``high`` at its right one, then rotated.

    >>> wedge = LinearGradient(width_um=40.0, height_um=10.0, low=0.1, high=0.9)
    >>> wedge.value(np.array([-20.0, 0.0, 20.0]), np.zeros(3)).tolist()
    [0.0, 0.5, 1.0]
    """

    width_um: Positive
    height_um: Positive
    centre_um: Point = (0.0, 0.0)
    rotate_deg: float = 0.0
    low: Reflectance = 0.0
    high: Reflectance = 1.0

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            width_um: Number,
            height_um: Number,
            centre_um: Place = (0.0, 0.0),
            rotate_deg: Number = 0.0,
            low: NumberOrCurve = 0.0,
            high: NumberOrCurve = 1.0,
        ) -> None: ...

    def value(self, x_um: F64, y_um: F64) -> F64:
        """Return x, from 0 to 1."""
        return 0.5 + x_um / self.width_um + 0.0 * y_um


@dataclass(frozen=True, slots=True, kw_only=True)
class RadialGradient(RoundGradient):
    """A disc that goes from ``high`` in its centre to ``low`` at its rim, with the square of the distance.

    >>> RadialGradient(radius_um=40.0, low=0.1, high=0.9).radius_um
    40.0
    """

    radius_um: Positive
    centre_um: Point = (0.0, 0.0)
    low: Reflectance = 0.0
    high: Reflectance = 1.0

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            radius_um: Number,
            centre_um: Place = (0.0, 0.0),
            low: NumberOrCurve = 0.0,
            high: NumberOrCurve = 1.0,
        ) -> None: ...

    def value(self, x_um: F64, y_um: F64) -> F64:
        """Return 1 minus the squared distance in radii."""
        return 1.0 - (x_um * x_um + y_um * y_um) / self.radius_um**2


@dataclass(frozen=True, slots=True, kw_only=True)
class SineGrating(Oblong, Gradient):
    """A rectangle with a sinusoid along its width, then rotated.

    period_um : length of a wave;  phase_deg: phase of the wave in the rectangle's centre; at 0 the centre is bright

    >>> SineGrating(width_um=80.0, height_um=40.0, period_um=10.0, low=0.1, high=0.7).period_um
    10.0
    """

    width_um: Positive
    height_um: Positive
    period_um: Positive
    phase_deg: float = 0.0
    centre_um: Point = (0.0, 0.0)
    rotate_deg: float = 0.0
    low: Reflectance = 0.0
    high: Reflectance = 1.0

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            width_um: Number,
            height_um: Number,
            period_um: Number,
            phase_deg: Number = 0.0,
            centre_um: Place = (0.0, 0.0),
            rotate_deg: Number = 0.0,
            low: NumberOrCurve = 0.0,
            high: NumberOrCurve = 1.0,
        ) -> None: ...

    def cycles_per_um(self, beyond_um: F64 | float = 0.0) -> F64 | float:
        """Return the frequency of its waves."""
        return 1.0 / self.period_um

    def value(self, x_um: F64, y_um: F64) -> F64:
        """Return a wave along x."""
        turn = x_um / self.period_um + self.phase_deg / 360.0 + 0.0 * y_um
        return 0.5 + 0.5 * np.cos(2.0 * np.pi * turn)


@dataclass(frozen=True, slots=True, kw_only=True)
class SineStar(RoundGradient):
    """A sinusoidal Siemens star: a ring whose reflectance is a sinusoid of the angle.

    cycles     : number of waves around the star
    rotate_deg : direction of the first bright middle from the right, clockwise as displayed

    >>> SineStar(radius_um=80.0, inner_radius_um=5.0, cycles=36, low=0.1, high=0.7).cycles
    36
    """

    radius_um: Positive
    inner_radius_um: Positive
    cycles: Cycles
    centre_um: Point = (0.0, 0.0)
    rotate_deg: float = 0.0
    low: Reflectance = 0.0
    high: Reflectance = 1.0

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            radius_um: Number,
            inner_radius_um: Number,
            cycles: Whole,
            centre_um: Place = (0.0, 0.0),
            rotate_deg: Number = 0.0,
            low: NumberOrCurve = 0.0,
            high: NumberOrCurve = 1.0,
        ) -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        validate_radii(self, self.inner_radius_um, self.radius_um)

    def cycles_per_um(self, beyond_um: F64 | float = 0.0) -> F64 | float:
        """Return the frequency along circles; it is highest along the inner one."""
        return self.cycles / (2.0 * math.pi * np.maximum(beyond_um, self.inner_radius_um))

    @property
    def smallest_um(self) -> float:
        """The inner radius; inside it, where nothing is visible, the waves fade out."""
        return self.inner_radius_um

    def value(self, x_um: F64, y_um: F64) -> F64:
        """Return a wave of the angle."""
        distance = np.hypot(x_um, y_um) / self.inner_radius_um
        # The invisible centre fades out smoothly: full amplitude from 0.8 of the inner radius.
        t = np.clip((distance - 0.3) / 0.5, 1e-9, 1.0 - 1e-9)
        size = 1.0 / (1.0 + np.exp(np.clip(1.0 / t - 1.0 / (1.0 - t), -700.0, 700.0)))
        value: F64 = 0.5 + 0.5 * size * np.cos(self.cycles * np.arctan2(y_um, x_um))
        return value

    def frame(self, reflectance: Spectrum) -> Shape:
        """Return the ring of the field, filled with one reflectance."""
        return Ring(
            radius_um=self.radius_um,
            inner_radius_um=self.inner_radius_um,
            centre_um=self.centre_um,
            reflectance=reflectance,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class SineZonePlate(RoundGradient):
    """A disc of circular waves whose frequency rises evenly from 0 in its centre, which is bright.

    finest_period_um : length of a wave at the rim

    >>> SineZonePlate(radius_um=80.0, finest_period_um=8.0).finest_period_um
    8.0
    """

    radius_um: Positive
    finest_period_um: Positive
    centre_um: Point = (0.0, 0.0)
    low: Reflectance = 0.0
    high: Reflectance = 1.0

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            radius_um: Number,
            finest_period_um: Number,
            centre_um: Place = (0.0, 0.0),
            low: NumberOrCurve = 0.0,
            high: NumberOrCurve = 1.0,
        ) -> None: ...

    def cycles_per_um(self, beyond_um: F64 | float = 0.0) -> F64 | float:
        """Return the frequency at its rim."""
        return 1.0 / self.finest_period_um

    def value(self, x_um: F64, y_um: F64) -> F64:
        """Return a wave of the square of the distance."""
        turn = (x_um * x_um + y_um * y_um) / (2.0 * self.radius_um * self.finest_period_um)
        return 0.5 + 0.5 * np.cos(2.0 * np.pi * turn)
