"""Protocols of optical stages: a custom stage needs only ``otf``; further capabilities are optional.

A lens with more capabilities is rendered faster or more accurately; engines test for capabilities, never for classes.
"""

from __future__ import annotations

from typing import Any, ClassVar, Protocol, runtime_checkable

from camsim.core.arrays import F64
from camsim.core.custom import is_custom
from camsim.optics.pattern import Pattern
from camsim.spectra.curve import Spectrum

_ANSWERS: dict[tuple[type, type], bool] = {}


class _Asked(type(Protocol)):  # type: ignore[misc]
    """Caches ``isinstance`` for camsim's classes, since a protocol's test is slow; custom stages are tested anew."""

    def __instancecheck__(cls, instance: object) -> bool:
        key = cls, type(instance)
        if key not in _ANSWERS or is_custom(instance):
            _ANSWERS[key] = super().__instancecheck__(instance)
        return _ANSWERS[key]


class _Ability(Protocol, metaclass=_Asked):
    """Base of the protocols with cached tests."""


@runtime_checkable
class OpticalStage(Protocol):
    """Anything with a transfer function.

    A stage declares its role by ``place`` ("lens", "olpf" or "photosite"). One without a place is an additional blur,
    or the lens if there is no other.

    >>> import camsim
    >>> isinstance(camsim.SquarePhotosite(side_um=4.0), OpticalStage)
    True
    """

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """OTF at (fx, fy) cycles/µm: the Fourier transform of the PSF with exp(−2πi f·x).

        Real or complex, OTF(−f) the conjugate of OTF(f), 1 at zero.
        """


class Lens(OpticalStage, Protocol):
    """A lens for a camera: a frozen dataclass with these fields, and ``place`` "lens".

    >>> import camsim
    >>> isinstance(camsim.Airy(f_number=8.0), Lens), isinstance(camsim.FourSpotOlpf(split_um=3.0), Lens)
    (True, False)
    """

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def f_number(self) -> float:
        """Focal length over aperture diameter."""

    @property
    def transmission(self) -> Spectrum:
        """Fraction of the light that passes."""


@runtime_checkable
class LowPass(OpticalStage, _Ability, Protocol):
    """A filter that makes several images of a point.

    >>> import camsim
    >>> isinstance(camsim.FourSpotOlpf(split_um=3.0), LowPass)
    True
    """

    def spots_um(self) -> F64:
        """Offsets (n, 2) of the images, equal in light, µm."""


@runtime_checkable
class KnowsSplits(LowPass, Protocol):
    """A filter whose images lie on the corners of a rectangle, or at the ends of a line."""

    @property
    def splits_um(self) -> tuple[float, float]:
        """The distances between neighbouring images along x and y before rotation, µm; 0: one plate."""

    @property
    def rotate_deg(self) -> float:
        """Rotation in degrees, clockwise as displayed."""


@runtime_checkable
class PhotositeShape(OpticalStage, _Ability, Protocol):
    """The area of a pixel that collects light.

    >>> import camsim
    >>> isinstance(camsim.SquarePhotosite(side_um=4.0), PhotositeShape)
    True
    """

    @property
    def area_um2(self) -> float:
        """Light-collecting area, µm²."""

    @property
    def half_extent_um(self) -> tuple[float, float]:
        """How far the photosite reaches from its centre along x and y, µm."""


@runtime_checkable
class Rectangular(_Ability, Protocol):
    """A photosite that is a rectangle along the rows, as the boundary engine requires."""

    @property
    def sides_um(self) -> tuple[float, float]:
        """Width and height, µm."""


@runtime_checkable
class Separable(_Ability, Protocol):
    """A stage that declares whether its transfer is the product of a function of fx and one of fy."""

    @property
    def separable(self) -> bool:
        """Whether the transfer is separable."""


@runtime_checkable
class KnowsBlur(_Ability, Protocol):
    """A lens that declares the scale of its PSF."""

    def blur_um(self, wavelength_nm: float) -> float:
        """Scale of the PSF, µm; for a diffraction pattern λN."""


@runtime_checkable
class KnowsCutoff(_Ability, Protocol):
    """A lens that declares its cut-off frequency."""

    def cutoff_per_um(self, wavelength_nm: float) -> float:
        """The frequency beyond which nothing passes, cycles/µm."""


@runtime_checkable
class KnowsOpening(_Ability, Protocol):
    """A lens whose pupil is not a full circle of diameter focal length over f-number."""

    @property
    def opening(self) -> float:
        """Area of the pupil as a fraction of the full circle of diameter f/N, and so of that circle's light."""


@runtime_checkable
class KnowsReach(_Ability, Protocol):
    """A lens that declares the extent of its PSF."""

    def reach_um(self, lost_fraction: float, wavelength_nm: float) -> float:
        """Return a radius beyond which at most ``lost_fraction`` of the light falls, µm."""


@runtime_checkable
class Fading(_Ability, Protocol):
    """A lens that declares whether its PSF vanishes beyond its reach, up to rounding."""

    @property
    def fades(self) -> bool:
        """Whether the PSF vanishes."""


@runtime_checkable
class KnowsWavelengths(_Ability, Protocol):
    """A lens that declares whether its PSF depends on the wavelength."""

    @property
    def chromatic(self) -> bool:
        """Whether the PSF depends on the wavelength."""


@runtime_checkable
class KnowsEnergy(_Ability, Protocol):
    """A lens with a rotationally symmetric PSF that declares its encircled energy."""

    def encircled_energy(self, r_um: F64, wavelength_nm: float) -> F64:
        """Fraction of the light within ``r_um`` of the centre."""


@runtime_checkable
class Round(_Ability, Protocol):
    """A lens that declares a rotationally symmetric PSF."""

    def point_spread(self, r_um: F64, wavelength_nm: float) -> F64:
        """Irradiance at ``r_um`` from a point of unit power, 1/µm²."""


@runtime_checkable
class KnowsSize(_Ability, Protocol):
    """A lens with a fast estimate of its MTF, accurate enough for bounds."""

    def otf_size(self, frequency_per_um: F64, direction: tuple[float, float], wavelength_nm: float) -> F64:
        """Return the MTF at frequencies along a unit vector."""


@runtime_checkable
class KnowsWaves(_Ability, Protocol):
    """A lens whose PSF changes with wavelength in shape as well as in scale, because of aberrations."""

    def waves_turned(self, low_nm: float, high_nm: float) -> float:
        """Return the change of the path difference over the pupil between two wavelengths, in waves."""


@runtime_checkable
class Tilts(_Ability, Protocol):
    """A lens whose wavefront may have a tilt that displaces its PSF equally at every wavelength."""

    def without_tilt(self) -> tuple[OpticalStage, tuple[float, float]]:
        """Return the lens without the tilt, and the displacement of the PSF along x and y, µm."""


@runtime_checkable
class Illuminates(_Ability, Protocol):
    """A lens that declares its relative illumination."""

    def illumination(self, radius_um: F64) -> F64:
        """Return the light at distances from the axis, relative to that on the axis."""


class Placed(OpticalStage, Protocol):
    """A lens at one place of the frame: a path difference over a circular pupil."""

    def waves(self, x: F64, y: F64, wavelength_nm: float) -> F64:
        """Return the path difference in waves at (x, y), in units of the pupil's radius."""


@runtime_checkable
class Varies(_Ability, Protocol):
    """A lens whose PSF varies over the frame, perhaps with distortion."""

    @property
    def distorts(self) -> bool:
        """Whether it has distortion."""

    def at(self, x_um: float, y_um: float) -> Placed:
        """Return the lens for a photosite at a place."""

    def distorted(self, points_um: F64) -> F64:
        """Return the distorted positions of points (n, 2), given by their ideal positions on the sensor, µm."""

    def lacks(self, wavelength_nm: F64, corners_um: F64) -> str:
        """Return why the lens does not cover a frame with corners (n, 2) at these wavelengths; "" if it does."""


@runtime_checkable
class RoundLens(OpticalStage, KnowsBlur, KnowsEnergy, Protocol):
    """A rotationally symmetric lens with a closed-form pattern that scales with its blur, for the boundary engine.

    The check uses ``encircled_energy`` and ``otf`` but not ``pattern``, so that an error in either is detected.
    """

    def pattern(self) -> Pattern:
        """Return the pattern in units of the blur."""

    def __hash__(self) -> int:
        """Equal lenses have equal hashes: tables are cached by them."""
