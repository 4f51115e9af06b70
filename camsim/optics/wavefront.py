"""A lens with aberrations: any opening, any wavefront given by Zernike coefficients."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from camsim.arrays import F64
from camsim.errors import InvalidValueError
from camsim.optics.airy import NM_PER_UM
from camsim.optics.pupil import Pupil
from camsim.optics.zernike import LARGEST_INDEX, orders, zernike
from camsim.spectra.curve import Spectrum

MOST_WAVES = 50.0
COARSE = 1e-9  # a non-uniform FFT to this precision may use a grid of less than half the size
SETTLED = 1e-11  # two rules that differ by no more than this agree


@dataclass(frozen=True, slots=True, kw_only=True)
class Wavefront:
    """A lens whose wavefront is not a sphere.

    f_number      : focal length over the pupil's diameter D
    zernike_waves : (OSA/ANSI index, coefficient) pairs; coefficients are waves at ``reference_nm``, root mean square
                    over the circle of diameter D
    reference_nm  : wavelength of those waves: the path differences are the same lengths at every wavelength
    defocus_um    : focus shift δ in µm, a path difference δ/(8N²)·r², which adds to Zernike 4 with its sign
    pupil         : the opening
    transmission  : fraction of the light that passes, a number or a curve over wavelength

    The pupil's x and y run along the sensor's (y down). A positive path difference at a point of the pupil turns its
    phase by exp(+2πi·W/λ), and the image's amplitude is its transform with exp(−2πi): so a positive coefficient 2
    shifts the image to the right by 4·c·λ_ref·N, a positive 1 down, and coma 8 has its tail to the right.

    >>> lens = Wavefront(f_number=4.0, zernike_waves=((4, 0.05),), reference_nm=550.0)
    >>> round(lens.strehl(550.0), 3)  # exp(−(2π·0.05)²) = 0.906
    0.905
    """

    place: ClassVar[str] = "lens"

    f_number: float
    zernike_waves: tuple[tuple[int, float], ...] = ()
    reference_nm: float = 550.0
    defocus_um: float = 0.0
    pupil: Pupil = field(default_factory=Pupil)
    transmission: Spectrum = 1.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.f_number) and self.f_number > 0):
            raise InvalidValueError(f"f_number: {self.f_number!r} is not a lens; give a finite number above 0")
        if not (math.isfinite(self.reference_nm) and self.reference_nm > 0):
            raise InvalidValueError(f"reference_nm: {self.reference_nm!r} is not a wavelength; give nm above 0")
        if not math.isfinite(self.defocus_um):
            raise InvalidValueError(f"defocus_um: {self.defocus_um!r} is not finite; give ordinary numbers in µm")
        pairs = tuple((int(j), float(c)) for j, c in self.zernike_waves)
        object.__setattr__(self, "zernike_waves", pairs)
        for index, waves in pairs:
            if not 0 <= index <= LARGEST_INDEX:
                raise InvalidValueError(
                    f"zernike_waves: index {index} is outside 0 … {LARGEST_INDEX} (OSA/ANSI, up to order 20)"
                )
            if not (math.isfinite(waves) and abs(waves) <= MOST_WAVES):
                raise InvalidValueError(
                    f"zernike_waves: {waves!r} waves of index {index}; give finite numbers up to {MOST_WAVES:g}"
                )
        if len({index for index, _ in pairs}) < len(pairs):
            raise InvalidValueError("zernike_waves: an index is given twice; add the two up")

    def blur_um(self, wavelength_nm: float) -> float:
        """The length of the pattern without aberrations, µm: λN."""
        return self.f_number * wavelength_nm / NM_PER_UM

    def cutoff_per_um(self, wavelength_nm: float) -> float:
        """The frequency beyond which nothing passes in any direction, cycles/µm."""
        return self.pupil.outer_radius / self.blur_um(wavelength_nm)

    def waves(self, x: F64, y: F64, wavelength_nm: float) -> F64:
        """Return the path difference in waves at (x, y), in units of D/2."""
        ratio = self.reference_nm / wavelength_nm
        total: F64 = (self.defocus_um * NM_PER_UM / (8.0 * self.f_number**2 * wavelength_nm)) * (x * x + y * y)
        for index, coefficient in self.zernike_waves:
            total = total + coefficient * ratio * zernike(index, x, y)
        return total

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer function at (fx, fy) cycles/µm: the pupil's overlap with its shifted copy, weighed by phase.

        Complex where the wavefront has odd parts. Integrated within the overlap's exact boundaries, with more nodes
        until 1e-11 is reached.
        """
        fx, fy = np.broadcast_arrays(np.asarray(fx_per_um, float), np.asarray(fy_per_um, float))
        blur_um = self.blur_um(wavelength_nm)
        shifts, angles = 2.0 * blur_um * np.hypot(fx, fy), np.arctan2(fy, fx)
        out = np.empty(fx.shape, complex)
        for place in np.ndindex(fx.shape):
            out[place] = self._transfer(float(shifts[place]), float(angles[place]), wavelength_nm)
        return out.real.copy() if self._symmetric else out

    @property
    def _symmetric(self) -> bool:
        """Whether the pattern stays the same when turned by 180°, so that its transfer is real."""
        even_pupil = self.pupil.shape != "bladed" or self.pupil.blades % 2 == 0
        return even_pupil and all(orders(index)[0] % 2 == 0 for index, _ in self.zernike_waves)

    def _transfer(self, shift: float, angle: float, wavelength_nm: float) -> complex:
        """Return the transfer for pupils ``shift`` half diameters apart."""
        if shift >= 2.0 * self.pupil.outer_radius:
            return 0.0
        if shift == 0.0:
            return 1.0
        dx, dy = 0.5 * shift * math.cos(angle), 0.5 * shift * math.sin(angle)
        nodes, before = 24, complex(math.inf)
        while True:
            x, y, weights = self.pupil.overlap(shift, angle, nodes)
            # ∫ |a|²·exp(−2πi f·x) pairs the amplitude of a point with the conjugate of that f further on.
            phase = self.waves(x - dx, y - dy, wavelength_nm) - self.waves(x + dx, y + dy, wavelength_nm)
            value = complex(np.sum(weights * np.exp(2j * np.pi * phase))) / self.pupil.area
            if abs(value - before) <= SETTLED or nodes > 1000:
                return value
            before, nodes = value, math.ceil(1.5 * nodes)

    def strehl(self, wavelength_nm: float) -> float:
        """Return the pattern's height at the centre over that without aberrations."""
        spare = self._spare_nodes(wavelength_nm)
        x, y, weights = self.pupil.rule(24 + spare, 48 + 4 * spare)
        amplitude = np.sum(weights * np.exp(2j * np.pi * self.waves(x, y, wavelength_nm))) / self.pupil.area
        return float(abs(amplitude) ** 2)

    def point_spread_on(self, x_um: F64, y_um: F64, wavelength_nm: float, precision: float) -> F64:
        """Irradiance (y, x) per µm² from a point of unit power, on a lattice of even steps about 0.

        precision : of the amplitude, relative to its largest possible value

        The amplitude is summed over a rule that is exact within the pupil's boundaries, as fine as the farthest
        corner asks for, by a non-uniform FFT.
        """
        import finufft

        radius = 0.5 / self.blur_um(wavelength_nm)  # of the pupil, as a frequency
        reach_um = math.hypot(float(np.abs(x_um).max()), float(np.abs(y_um).max()))
        turns = 2.0 * math.pi * radius * self.pupil.outer_radius * reach_um
        spare = self._spare_nodes(wavelength_nm)
        x, y, weights = self.pupil.rule(math.ceil(0.27 * turns) + 24 + spare, math.ceil(1.06 * turns) + 64 + 4 * spare)
        strengths = weights * np.exp(2j * np.pi * self.waves(x, y, wavelength_nm))
        steps = [float(axis[1] - axis[0]) if axis.size > 1 else 0.0 for axis in (x_um, y_um)]
        amplitude = finufft.nufft2d1(
            2.0 * np.pi * radius * steps[1] * y,
            2.0 * np.pi * radius * steps[0] * x,
            strengths,
            n_modes=(y_um.size, x_um.size),
            eps=max(precision, 1e-14),
            upsampfac=1.25 if precision >= COARSE else 2.0,
            isign=-1,
        )
        irradiance: F64 = (np.square(amplitude.real) + np.square(amplitude.imag)) * (radius**2 / self.pupil.area)
        return irradiance

    def _spare_nodes(self, wavelength_nm: float) -> int:
        """Return how many nodes the wavefront itself asks for along a radius: its steepest phase, by Markov's bound."""
        ratio = self.reference_nm / wavelength_nm
        slope = 2.0 * abs(self.defocus_um) * NM_PER_UM / (8.0 * self.f_number**2 * wavelength_nm)
        for index, coefficient in self.zernike_waves:
            n, m = orders(index)
            slope += abs(coefficient) * ratio * n * n * math.sqrt((2 if m else 1) * (n + 1))
        return math.ceil(0.5 * math.pi * slope * self.pupil.outer_radius**2)
