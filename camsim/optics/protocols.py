"""What an optical stage is, and what else one may know: a stage of the user's own needs ``otf`` and no more.

The second half are abilities. A lens that has one is quicker, or more exact; nothing asks what kind of lens it is.
"""

from __future__ import annotations

from typing import Any, ClassVar, Protocol, runtime_checkable

from camsim.core.arrays import F64
from camsim.core.custom import is_custom
from camsim.optics.pattern import Pattern
from camsim.spectra.curve import Spectrum

_ANSWERS: dict[tuple[type, type], bool] = {}


class _Asked(type(Protocol)):  # type: ignore[misc]
    """Answers once for every class of camsim's, as a protocol looks through all of it; each of one's own is asked."""

    def __instancecheck__(cls, instance: object) -> bool:
        key = cls, type(instance)
        if key not in _ANSWERS or is_custom(instance):
            _ANSWERS[key] = super().__instancecheck__(instance)
        return _ANSWERS[key]


class _Ability(Protocol, metaclass=_Asked):
    """What the abilities below have in common."""


@runtime_checkable
class OpticalStage(Protocol):
    """Anything with a transfer function.

    A stage says by ``place`` ("lens", "olpf" or "photosite") what it stands for. One without a place is a blur of its
    own besides these, or the lens when there is no other.

    >>> import camsim
    >>> isinstance(camsim.SquarePhotosite(side_um=4.0), OpticalStage)
    True
    """

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer function at (fx, fy) cycles/µm: the transform of the point image with exp(−2πi f·x).

        Real or complex, OTF(−f) the conjugate of OTF(f), 1 at zero.
        """


class Lens(OpticalStage, Protocol):
    """A lens that a camera can carry: a frozen dataclass with these fields, and ``place`` "lens".

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
        """The distances between neighbouring images along x and y before they are turned, µm; 0: one plate."""

    @property
    def rotate_deg(self) -> float:
        """The turn, clockwise as displayed."""


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
        """How far it reaches from its centre along x and y, µm."""


@runtime_checkable
class Rectangular(_Ability, Protocol):
    """A photosite that is a rectangle along the rows: the boundary engine takes it."""

    @property
    def sides_um(self) -> tuple[float, float]:
        """Width and height, µm."""


@runtime_checkable
class Separable(_Ability, Protocol):
    """A stage that may say that its transfer is a product of one along x and one along y."""

    @property
    def separable(self) -> bool:
        """Whether it is."""


@runtime_checkable
class KnowsBlur(_Ability, Protocol):
    """A lens that knows its pattern's own length."""

    def blur_um(self, wavelength_nm: float) -> float:
        """The length, µm."""


@runtime_checkable
class KnowsCutoff(_Ability, Protocol):
    """A lens that knows the end of its transfer."""

    def cutoff_per_um(self, wavelength_nm: float) -> float:
        """The frequency beyond which nothing passes, cycles/µm."""


@runtime_checkable
class KnowsOpening(_Ability, Protocol):
    """A lens whose opening is no circle of the diameter focal length over f-number."""

    @property
    def opening(self) -> float:
        """Its area over that circle's: so much of the light passes."""


@runtime_checkable
class KnowsReach(_Ability, Protocol):
    """A lens that knows how far its light goes."""

    def reach_um(self, lost_fraction: float, wavelength_nm: float) -> float:
        """Return a radius that holds all of the light but so much, µm."""


@runtime_checkable
class Fading(_Ability, Protocol):
    """A lens that may say that its pattern is nothing beyond its reach, rounding apart."""

    @property
    def fades(self) -> bool:
        """Whether it is."""


@runtime_checkable
class KnowsWavelengths(_Ability, Protocol):
    """A lens that may say that all wavelengths have the same pattern."""

    @property
    def chromatic(self) -> bool:
        """Whether they differ."""


@runtime_checkable
class KnowsEnergy(_Ability, Protocol):
    """A round lens that knows its encircled energy."""

    def encircled_energy(self, r_um: F64, wavelength_nm: float) -> F64:
        """Fraction of the light within ``r_um`` of the centre."""


@runtime_checkable
class Round(_Ability, Protocol):
    """A lens with a round pattern that it knows."""

    def point_spread(self, r_um: F64, wavelength_nm: float) -> F64:
        """Irradiance at ``r_um`` from a point of unit power, 1/µm²."""


@runtime_checkable
class KnowsSize(_Ability, Protocol):
    """A lens that tells the size of its transfer quicker than its transfer, as well as a bound needs it."""

    def otf_size(self, frequency_per_um: F64, direction: tuple[float, float], wavelength_nm: float) -> F64:
        """Return the size at frequencies along a unit vector."""


@runtime_checkable
class KnowsWaves(_Ability, Protocol):
    """A lens whose pattern changes with the wavelength by more than its size, because its wavefront is no sphere."""

    def waves_turned(self, low_nm: float, high_nm: float) -> float:
        """Return by how many waves the path difference turns between two wavelengths, over the pupil."""


@runtime_checkable
class Tilts(_Ability, Protocol):
    """A lens that may move its pattern, the same way at every wavelength, and be one that does not besides."""

    def without_tilt(self) -> tuple[OpticalStage, tuple[float, float]]:
        """Return the lens that does not, and by how much along x and y this one moves its pattern, µm."""


@runtime_checkable
class Illuminates(_Ability, Protocol):
    """A lens that says how its light falls off."""

    def illumination(self, radius_um: F64) -> F64:
        """Return the light at distances from the axis, relative to that on the axis."""


class Placed(OpticalStage, Protocol):
    """A lens as one place of the frame has it: a path difference over a round pupil."""

    def waves(self, x: F64, y: F64, wavelength_nm: float) -> F64:
        """Return the path difference in waves at (x, y), in units of the pupil's radius."""


@runtime_checkable
class Varies(_Ability, Protocol):
    """A lens whose pattern, and whose distortion, are those of a place in the frame."""

    @property
    def distorts(self) -> bool:
        """Whether it moves anything."""

    def at(self, x_um: float, y_um: float) -> Placed:
        """Return the lens that a photosite at a place sees through."""

    def distorted(self, points_um: F64) -> F64:
        """Return where points (n, 2) of the scene, as it would fall on the sensor without distortion, fall."""

    def lacks(self, wavelength_nm: F64, corners_um: F64) -> str:
        """Return why the lens cannot take a frame with these corners (n, 2) in light of wavelengths, "" if it can."""


@runtime_checkable
class RoundLens(OpticalStage, KnowsBlur, KnowsEnergy, Protocol):
    """A round lens whose pattern scales with its blur and is known in closed form: the boundary engine takes it.

    The check takes ``encircled_energy`` and ``otf`` of it and nothing of ``pattern``, so that neither can be wrong
    unseen.
    """

    def pattern(self) -> Pattern:
        """Return the pattern in units of the blur."""

    def __hash__(self) -> int:
        """Equal lenses have equal hashes: tables are kept by them."""
