"""A lens whose pattern was measured: an array of samples, or of its transfer function."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt
from scipy import special

from camsim.arrays import F64
from camsim.errors import InvalidValueError
from camsim.nonuniform import at_points
from camsim.spectra.curve import Spectrum, Transmission
from camsim.typed import Positive, Several, check, judge, refusal

MOST_SAMPLES = 256  # along a side: the description in every file holds them all
PASSES, ENDS = 0.4, 0.6  # cycles per sample: all passes, nothing does
SHARPNESS = 32.0  # of the slope in between: its tail in space is below 1e-12
ROLL_OFF_DEGREE = 95


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredPsf:
    """A lens given by samples of its pattern, the same at every wavelength.

    irradiance   : rows of equally spaced samples from the top, any unit (they are scaled to a sum of 1); the middle of
                   the array is the optical centre
    spacing_um   : between samples, µm on the sensor
    f_number     : sets the exposure only, not the blur
    transmission : fraction of the light that passes, a number or a curve over wavelength

    The pattern between the samples is band-limited: all frequencies up to 0.4 cycles per sample pass, none from 0.6 on,
    with a smooth slope that is odd about 0.5, so that the pattern goes through every sample. Beyond the array it
    is 0: light that was not measured is nowhere.

    >>> lens = MeasuredPsf(irradiance=((0, 1, 0), (1, 4, 1), (0, 1, 0)), spacing_um=0.5)
    >>> round(abs(complex(lens.otf(np.array(0.0), np.array(0.0), 550.0))), 12)
    1.0
    """

    place: ClassVar[str] = "lens"
    chromatic: ClassVar[bool] = False
    fades: ClassVar[bool] = True

    irradiance: Several[Several[float]]
    spacing_um: Positive
    f_number: Positive = 8.0
    transmission: Transmission = 1.0

    def __post_init__(self) -> None:
        judge(self)
        rows = self.irradiance
        if len({len(row) for row in rows}) != 1 or not len(rows[0]):
            raise refusal(self, "irradiance", "the rows are not all equally long; give a rectangle of samples")
        if max(len(rows), len(rows[0])) > MOST_SAMPLES:
            message = f"{len(rows)} × {len(rows[0])} samples; give at most {MOST_SAMPLES} along a side"
            raise refusal(self, "irradiance", message)
        if not sum(value for row in rows for value in row) > 0.0:
            raise refusal(self, "irradiance", "the samples add up to no light; give some above 0")

    @classmethod
    def from_otf(
        cls,
        values: npt.ArrayLike | Sequence[Sequence[complex]],
        *,
        spacing_per_um: float,
        f_number: float = 8.0,
        transmission: Spectrum = 1.0,
    ) -> MeasuredPsf:
        """Return the lens with a measured transfer function.

        values         : (n, n) real or complex, n odd, rows of fy from the most negative on, zero frequency in the
                         middle; the conjugate on the other side of it; 0 in the outer fifth
        spacing_per_um : between frequencies, cycles/µm
        """
        array = np.asarray(values)
        if array.ndim != 2 or array.shape[0] != array.shape[1] or array.shape[0] % 2 == 0:
            raise InvalidValueError(
                f"a table of {array.shape}; give as many rows as columns, an odd number", key="values"
            )
        if not np.isfinite(array).all():
            raise InvalidValueError(
                "not all of them are finite; give ordinary numbers", key="values", stage=cls.__name__
            )
        check(spacing_per_um, Positive, "spacing_per_um", cls.__name__)
        half = array.shape[0] // 2
        if not array[half, half].real > 0.0:
            raise InvalidValueError(
                "the middle, where the frequency is 0, is not above 0", key="values", stage=cls.__name__
            )
        array = array / array[half, half].real
        if np.abs(array - array[::-1, ::-1].conj()).max() > 1e-6:
            raise InvalidValueError(
                "opposite frequencies are not conjugate; no pattern has such a transfer", key="values"
            )
        place = np.abs(np.arange(-half, half + 1)) > 2.0 * PASSES * half
        if max(np.abs(array[place]).max(), np.abs(array[:, place]).max()) > 0.01:
            raise InvalidValueError(
                "the transfer has not died away in the outer fifth of the table; measure to higher frequencies",
                key="values",
                stage=cls.__name__,
            )
        pattern = np.fft.fftshift(np.fft.ifft2(np.fft.ifftshift(array)).real)
        return cls(
            irradiance=tuple(tuple(row) for row in pattern.tolist()),
            spacing_um=1.0 / (array.shape[0] * spacing_per_um),
            f_number=f_number,
            transmission=transmission,
        )

    @property
    def _centre(self) -> tuple[float, float]:
        return 0.5 * (len(self.irradiance[0]) - 1), 0.5 * (len(self.irradiance) - 1)

    def blur_um(self, wavelength_nm: float) -> float:
        """The pattern's own length, µm: the inverse of the highest frequency along an axis."""
        return self.spacing_um / ENDS

    def cutoff_per_um(self, wavelength_nm: float) -> float:
        """The frequency beyond which nothing passes in any direction, cycles/µm."""
        return math.sqrt(2.0) * ENDS / self.spacing_um

    def reach_um(self, lost_fraction: float, wavelength_nm: float) -> float:
        """Return a radius that holds all of the pattern: the samples, and the waves that the slope leaves about them.

        The slope's own transform ends within β/π over its width, but for 1/sinh β.
        """
        waves = (SHARPNESS + 2.0) / (math.pi * (ENDS - PASSES))
        return (math.hypot(*self._centre) + waves) * self.spacing_um

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer function at (fx, fy) cycles/µm, complex: the samples' sum of waves, times the roll-off."""
        fx, fy = np.broadcast_arrays(np.asarray(fx_per_um, float), np.asarray(fy_per_um, float))
        x, y = fx.ravel() * self.spacing_um, fy.ravel() * self.spacing_um
        out = np.zeros(x.size, complex)
        passes = np.flatnonzero((np.abs(x) < ENDS) & (np.abs(y) < ENDS))
        if passes.size:
            x, y = x[passes], y[passes]
            samples = np.array(self.irradiance)
            samples = (samples / samples.sum()).astype(complex)
            turns = 2.0 * np.pi * (y - np.round(y)), 2.0 * np.pi * (x - np.round(x))
            waves = at_points(turns, samples, precision=1e-13, sign=-1)
            # The sum counts from −n//2; the middle of the array is (n − 1)/2.
            shift_x, shift_y = (c - n // 2 for c, n in zip(self._centre, samples.shape[::-1], strict=True))
            turn = np.exp(2j * np.pi * (x * shift_x + y * shift_y))
            # The fraction of x beyond a whole number is the same wave at whole places only.
            out[passes] = waves * turn * _roll_off(x) * _roll_off(y)
        return out.reshape(fx.shape)


def _roll_off(f: F64) -> F64:
    """Return 1 up to PASSES and 0 from ENDS on; the slope is the integral of a Kaiser–Bessel window."""
    t = np.clip((2.0 * np.abs(f) - PASSES - ENDS) / (ENDS - PASSES), -1.0, 1.0)
    values: F64 = 1.0 - _slope()(t)
    return values


@functools.cache
def _slope() -> np.polynomial.Chebyshev:
    window = np.polynomial.Chebyshev.interpolate(
        lambda t: special.i0(SHARPNESS * np.sqrt((1.0 - t) * (1.0 + t))) / special.i0(SHARPNESS), ROLL_OFF_DEGREE
    )
    total = window.integ(lbnd=-1)
    whole = total / total(1.0)
    assert isinstance(whole, np.polynomial.Chebyshev)
    return whole
