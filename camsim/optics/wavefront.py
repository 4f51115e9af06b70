"""A lens with aberrations: any pupil, with a wavefront given by Zernike coefficients."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, TypeAlias

import numpy.typing as npt
from annotated_types import Ge, Le

from camsim.core.annotations import Before, Called
from camsim.core.arrays import F64
from camsim.core.typed import Number, Positive, Whole, refusal, validate
from camsim.core.words import brief
from camsim.numerics.zernike import LARGEST_INDEX, orders, zernike_sum
from camsim.optics.airy import NM_PER_UM
from camsim.optics.of_pupil import OfPupil
from camsim.optics.pupil import Pupil
from camsim.spectra.curve import NumberOrCurve, Transmission, Wavelength

MOST_WAVES = 50.0
FOCUS_NM = 550.0  # wavelength of the limit MOST_WAVES on a focus shift, at the rim of the pupil
PLANE = 2  # Zernikes up to this one are tilts, which displace the PSF


def _as_pairs(given: Any) -> Any:
    return tuple(given.items()) if isinstance(given, Mapping) else given


_Index: TypeAlias = Annotated[int, Ge(0), Le(LARGEST_INDEX)]
_Waves: TypeAlias = Annotated[float, Ge(-MOST_WAVES), Le(MOST_WAVES)]
if TYPE_CHECKING:
    Zernikes: TypeAlias = Mapping[int, Number] | Sequence[tuple[Whole, Number] | Sequence[Number]] | npt.NDArray[Any]
else:
    Zernikes = Annotated[
        tuple[Annotated[tuple[_Index, _Waves], Called("a pair of index and waves, such as (4, 0.1)")], ...],
        Called("pairs of index and waves, such as {4: 0.1}"),
        Before(_as_pairs),
    ]


@dataclass(frozen=True, slots=True, kw_only=True)
class Wavefront(OfPupil):
    """A lens with aberrations: any pupil, with a path difference over it.

    f_number      : focal length over the pupil's diameter D
    zernike_waves : (OSA/ANSI index, coefficient) pairs, or a mapping of these; coefficients are waves at
                    ``reference_nm``, root mean square over the circle of diameter D
    reference_nm  : wavelength of those waves: the path differences are the same lengths at every wavelength
    defocus_um    : focus shift δ in µm, a path difference δ/(8N²)·r², which adds to Zernike 4 with its sign
    pupil         : shape of the pupil
    transmission  : fraction of the light that passes, a number or a curve over wavelength

    The pupil's x and y run along the sensor's (y down). A positive path difference at a point of the pupil turns its
    phase by exp(+2πi·W/λ), and the image's amplitude is its transform with exp(−2πi): so a positive coefficient 2
    shifts the image to the right by 4·c·λ_ref·N, a positive 1 down, and coma 8 has its tail to the right.

    >>> lens = Wavefront(f_number=4.0, zernike_waves=((4, 0.05),), reference_nm=550.0)
    >>> round(lens.strehl(550.0), 3)  # exp(−(2π·0.05)²) = 0.906
    0.905
    """

    place: ClassVar[str] = "lens"

    f_number: Positive
    zernike_waves: Zernikes = ()
    reference_nm: Wavelength = 550.0
    defocus_um: float = 0.0
    pupil: Pupil = field(default_factory=Pupil)
    transmission: Transmission = 1.0

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            f_number: Number,
            zernike_waves: Zernikes = (),
            reference_nm: Number = 550.0,
            defocus_um: Number = 0.0,
            pupil: Pupil = ...,
            transmission: NumberOrCurve = 1.0,
        ) -> None: ...

    __repr__ = brief

    def __post_init__(self) -> None:
        validate(self)
        if len({index for index, _ in self._pairs}) < len(self._pairs):
            raise refusal(self, "zernike_waves", "an index is given twice; add the two up")
        check_focus(self, "defocus_um", self.defocus_um, self.f_number)

    def waves(self, x: F64, y: F64, wavelength_nm: float) -> F64:
        """Return the path difference in waves at (x, y), in units of D/2."""
        ratio = self.reference_nm / wavelength_nm
        defocus: F64 = (self.defocus_um * NM_PER_UM / (8.0 * self.f_number**2 * wavelength_nm)) * (x * x + y * y)
        index, coefficients = tuple(j for j, _ in self._pairs), [ratio * one for _, one in self._pairs]
        return defocus + zernike_sum(index, coefficients, x, y) if index else defocus

    def without_tilt(self) -> tuple[Wavefront, tuple[float, float]]:
        """Return the lens without its tilts, and the displacement of the PSF that these cause along x and y, µm.

        A tilt of c waves, 2c·x, displaces the PSF by c·4·λ_ref·N, the same at every wavelength.
        """
        tilt_y, tilt_x = (sum(c for index, c in self._pairs if index == plane) for plane in (PLANE - 1, PLANE))
        if not (tilt_x or tilt_y):
            return self, (0.0, 0.0)
        bent = tuple((index, c) for index, c in self._pairs if not 0 < index <= PLANE)
        each_um = 4.0 * self.blur_um(self.reference_nm)
        return replace(self, zernike_waves=bent), (each_um * tilt_x, each_um * tilt_y)

    @property
    def _pairs(self) -> tuple[tuple[int, float], ...]:
        """The pairs in standard form."""
        pairs: Any = self.zernike_waves
        return tuple(pairs)

    @property
    def _symmetric(self) -> bool:
        """Whether the PSF is symmetric under rotation by 180°, so that its transfer is real."""
        even_pupil = self.pupil.shape != "bladed" or self.pupil.blades % 2 == 0
        return even_pupil and all(orders(index)[0] % 2 == 0 for index, _ in self._pairs)


def check_focus(lens: object, key: str, focus_um: float, f_number: float) -> None:
    """Refuse a focus shift δ with too many waves at the rim of the pupil, δ/(8N²)."""
    most_um = MOST_WAVES * 8.0 * f_number**2 * FOCUS_NM / NM_PER_UM
    if abs(focus_um) > most_um:
        allowed = f"from {-most_um:.3g} to {most_um:.3g} at f/{f_number:g}, {MOST_WAVES:g} waves on the pupil's rim"
        raise refusal(lens, key, f"must be a number {allowed}, not {focus_um:g}")
