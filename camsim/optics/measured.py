"""Measured lenses: samples of the PSF, or of its transfer function."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

import numpy as np
import scipy

from camsim.core.arrays import C128, F64
from camsim.core.typed import Number, Positive, Several, refusal, validate
from camsim.core.words import brief
from camsim.numerics.nonuniform import at_points
from camsim.spectra.curve import NumberOrCurve, Transmission

MOST_SAMPLES = 256  # along a side: the description in every file contains all of them
MOST_NEGATIVE = 0.5  # largest share of negative light, from noise and ringing of a measurement
PASSES, ENDS = 0.4, 0.6  # cycles per sample: end of the pass band, start of the stop band
SHARPNESS = 32.0  # of the slope in between: its tail in space is below 1e-12
ROLL_OFF_DEGREE = 95


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredPsf:
    """A lens given by samples of its PSF, the same at every wavelength.

    irradiance   : rows of equally spaced samples from the top, any unit (they are scaled to a sum of 1); the middle of
                   the array is the optical centre
    spacing_um   : between samples, µm on the sensor
    f_number     : sets the exposure only, not the blur
    transmission : fraction of the light that passes, a number or a curve over wavelength

    Interpolation between the samples is band-limited: all frequencies up to 0.4 cycles per sample pass, none from 0.6
    on, with a smooth transition that is odd about 0.5, so that the PSF passes through every sample. Beyond the array it
    is 0: light that was not measured is ignored.

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

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            irradiance: Several[Several[Number]],
            spacing_um: Number,
            f_number: Number = 8.0,
            transmission: NumberOrCurve = 1.0,
        ) -> None: ...

    __repr__ = brief

    def __post_init__(self) -> None:
        validate(self)
        rows = self.irradiance
        if len({len(row) for row in rows}) != 1 or not len(rows[0]):
            raise refusal(self, "irradiance", "the rows are not all equally long; give a rectangle of samples")
        if max(len(rows), len(rows[0])) > MOST_SAMPLES:
            message = f"{len(rows)} × {len(rows[0])} samples; give at most {MOST_SAMPLES} along a side"
            raise refusal(self, "irradiance", message)
        if not sum(value for row in rows for value in row) > 0.0:
            raise refusal(self, "irradiance", "the samples add up to no light; give some above 0")
        if (share := _negative(np.array(rows))) > MOST_NEGATIVE:
            message = f"{100.0 * share:.3g} % of the light is negative; a pattern has none: take noise and rings off it"
            raise refusal(self, "irradiance", message)

    @property
    def _centre(self) -> tuple[float, float]:
        return 0.5 * (len(self.irradiance[0]) - 1), 0.5 * (len(self.irradiance) - 1)

    def blur_um(self, wavelength_nm: float) -> float:
        """Scale of the PSF, µm: the inverse of the highest frequency along an axis."""
        return self.spacing_um / ENDS

    def cutoff_per_um(self, wavelength_nm: float) -> float:
        """The frequency beyond which nothing passes in any direction, cycles/µm."""
        return math.sqrt(2.0) * ENDS / self.spacing_um

    def reach_um(self, lost_fraction: float, wavelength_nm: float) -> float:
        """Return a radius that contains all of the PSF: the samples, and the ringing of the transition around them.

        The transform of the transition's slope ends within β/π over its width, up to 1/sinh β.
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
            phases = 2.0 * np.pi * (y - np.round(y)), 2.0 * np.pi * (x - np.round(x))
            waves = at_points(phases, samples, precision=1e-13, sign=-1)
            # The sum counts from −n//2; the middle of the array is (n − 1)/2.
            shift_x, shift_y = (c - n // 2 for c, n in zip(self._centre, samples.shape[::-1], strict=True))
            turn = np.exp(2j * np.pi * (x * shift_x + y * shift_y))
            # Reduction of x to its fraction is valid at integer places only, hence the phase of the shift.
            out[passes] = waves * turn * _roll_off(x) * _roll_off(y)
        return out.reshape(fx.shape)


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredOtf:
    """A lens given by its OTF on a grid of frequencies, the same at every wavelength.

    values         : (n, n) real or complex, n odd, rows of fy from the most negative on, zero frequency in the middle;
                     the conjugate on the other side of it; 0 in the outer fifth. They are scaled to 1 at zero
    spacing_per_um : between frequencies, cycles/µm
    f_number       : sets the exposure only, not the blur
    transmission   : fraction of the light that passes, a number or a curve over wavelength

    It is equivalent to a ``MeasuredPsf`` with as many samples that has this transfer.

    >>> ramp = 1.0 - np.abs(np.arange(-5, 6)) / 4.0
    >>> lens = MeasuredOtf(values=np.clip(np.minimum.outer(ramp, ramp), 0.0, None), spacing_per_um=0.1)
    >>> lens.otf(np.array([0.0, 0.1, 0.2]), np.array(0.0), 550.0).real.round(9)
    array([1.  , 0.75, 0.5 ])
    """

    place: ClassVar[str] = "lens"
    chromatic: ClassVar[bool] = False
    fades: ClassVar[bool] = True

    values: Several[Several[complex]]
    spacing_per_um: Positive
    f_number: Positive = 8.0
    transmission: Transmission = 1.0
    _pattern: MeasuredPsf = field(init=False, repr=False, compare=False)

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            values: Several[Several[complex]],
            spacing_per_um: Number,
            f_number: Number = 8.0,
            transmission: NumberOrCurve = 1.0,
        ) -> None: ...

    __repr__ = brief

    def __post_init__(self) -> None:
        validate(self)
        transfer = self._transfer()
        pattern = np.fft.fftshift(np.fft.ifft2(np.fft.ifftshift(transfer)).real)
        if (share := _negative(pattern)) > MOST_NEGATIVE:
            message = f"of their pattern {100.0 * share:.3g} % is negative light; no pattern has such a transfer"
            raise refusal(self, "values", message)
        psf = MeasuredPsf(irradiance=pattern, spacing_um=1.0 / (len(transfer) * self.spacing_per_um))
        object.__setattr__(self, "_pattern", psf)

    def _transfer(self) -> C128:
        """Return the values scaled to 1 at zero frequency; refuse values that no PSF can have."""
        rows = self.values
        sizes = sorted({len(rows), *map(len, rows)})
        if len(sizes) != 1 or sizes[0] % 2 == 0 or sizes[0] == 1:
            shape = f"{len(rows)} rows of {' or '.join(map(str, sorted({len(row) for row in rows})))}"
            raise refusal(self, "values", f"{shape} values; give as many rows as columns, an odd number from 3 on")
        if sizes[0] > MOST_SAMPLES:
            raise refusal(self, "values", f"{sizes[0]} × {sizes[0]} values; give at most {MOST_SAMPLES} along a side")
        array, half = np.array(rows, complex), sizes[0] // 2
        if not array[half, half].real > 0.0:
            raise refusal(self, "values", "the middle, where the frequency is 0, is not above 0")
        array /= array[half, half].real
        if np.abs(array - array[::-1, ::-1].conj()).max() > 1e-6:
            raise refusal(self, "values", "opposite frequencies are not conjugate; no pattern has such a transfer")
        outer = np.abs(np.arange(-half, half + 1)) > 2.0 * PASSES * half
        if max(np.abs(array[outer]).max(), np.abs(array[:, outer]).max()) > 0.01:
            message = "the transfer has not died away in the outer fifth of the table; measure to higher frequencies"
            raise refusal(self, "values", message)
        return array

    def blur_um(self, wavelength_nm: float) -> float:
        """Scale of the PSF, µm: the inverse of the highest frequency along an axis."""
        return self._pattern.blur_um(wavelength_nm)

    def cutoff_per_um(self, wavelength_nm: float) -> float:
        """The frequency beyond which nothing passes in any direction, cycles/µm."""
        return self._pattern.cutoff_per_um(wavelength_nm)

    def reach_um(self, lost_fraction: float, wavelength_nm: float) -> float:
        """Return a radius that contains all of the PSF."""
        return self._pattern.reach_um(lost_fraction, wavelength_nm)

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer function at (fx, fy) cycles/µm, complex: that of the band-limited PSF."""
        return self._pattern.otf(fx_per_um, fy_per_um, wavelength_nm)


def _roll_off(f: F64) -> F64:
    """Return 1 up to PASSES and 0 from ENDS on; the transition is the integral of a Kaiser–Bessel window."""
    t = np.clip((2.0 * np.abs(f) - PASSES - ENDS) / (ENDS - PASSES), -1.0, 1.0)
    values: F64 = 1.0 - _slope()(t)
    return values


@functools.cache
def _slope() -> np.polynomial.Chebyshev:
    window = np.polynomial.Chebyshev.interpolate(
        lambda t: scipy.special.i0(SHARPNESS * np.sqrt((1.0 - t) * (1.0 + t))) / scipy.special.i0(SHARPNESS),
        ROLL_OFF_DEGREE,
    )
    total = window.integ(lbnd=-1)
    whole = total / total(1.0)
    assert isinstance(whole, np.polynomial.Chebyshev)
    return whole


def _negative(pattern: F64) -> float:
    """Return the sum of a PSF's negative values over that of its positive ones, as an absolute value."""
    return -float(pattern[pattern < 0.0].sum() / pattern[pattern > 0.0].sum())
