"""OTF and PSF of a pupil with a path difference over it, with adaptive quadrature."""

from __future__ import annotations

import functools
import itertools
import math
from abc import abstractmethod

import numpy as np
import scipy

from camsim.core.arrays import C128, F64
from camsim.errors import UnsupportedError
from camsim.optics.airy import Airy, DiffractionLimit
from camsim.optics.annular import AnnularAiry
from camsim.optics.pupil import Pupil

SETTLED = 1e-11  # two rules that differ by no more than this agree
LATTICE = 512  # points across the pupil for an approximate transfer: errors up to 0.015 for eight random lenses
ACROSS = 24  # nodes along a radius, and around, for the wavefront's range
MOST_NODES, MOST_ACROSS = 4e6, 1000  # of the pupil's rule; per axis of its overlap with its shifted copy
PER_RADIAN, SPARE, GROWTH = 0.2, 24, 1.4  # nodes along a ray: per radian of phase, in addition, and their growth


class OfPupil(DiffractionLimit):
    """Mixin of lenses with an ``f_number``, a ``pupil``, ``waves`` over it, and a property ``_symmetric``.

    It has no fields.
    """

    __slots__ = ()

    pupil: Pupil

    @abstractmethod
    def waves(self, x: F64, y: F64, wavelength_nm: float) -> F64:
        """Return the path difference in waves at (x, y), in units of D/2."""

    @property
    @abstractmethod
    def _symmetric(self) -> bool:
        """Whether the PSF is symmetric under rotation by 180°, so that its transfer is real."""

    @property
    def opening(self) -> float:
        """Area of the pupil as a fraction of a circle of diameter D."""
        return self.pupil.area / math.pi

    def cutoff_per_um(self, wavelength_nm: float) -> float:
        """The frequency beyond which nothing passes in any direction, cycles/µm."""
        return self.pupil.outer_radius / self.blur_um(wavelength_nm)

    def waves_across(self, wavelength_nm: float) -> float:
        """Return the peak-to-valley wavefront over the pupil without piston and tilt, waves."""
        x, y, _ = self.pupil.nodes(ACROSS, ACROSS)
        waves, plane = self.waves(x, y, wavelength_nm), np.stack([x, y, np.ones_like(x)], axis=1)
        return float(np.ptp(waves - plane @ np.linalg.lstsq(plane, waves, rcond=None)[0]))

    def waves_turned(self, low_nm: float, high_nm: float) -> float:
        """Return the change of the path difference over the pupil between two wavelengths, in waves."""
        return abs(self.waves_across(low_nm) - self.waves_across(high_nm)) if low_nm != high_nm else 0.0

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer function at (fx, fy) cycles/µm: the autocorrelation of the pupil function.

        Complex if the wavefront has odd parts. The integral over the exact overlap is refined to 1e-11; raises
        UnsupportedError if it does not converge.
        """
        from camsim.optics.overlaps import SHARES, Overlaps  # with a compiler, which no lens needs before it is asked

        fx, fy = np.broadcast_arrays(np.asarray(fx_per_um, float), np.asarray(fy_per_um, float))
        rho, angle = self.blur_um(wavelength_nm) * np.hypot(fx, fy).ravel(), np.arctan2(fy, fx).ravel()
        out = (rho == 0.0).astype(complex)
        left = np.flatnonzero((rho > 0.0) & (rho < self.pupil.outer_radius))
        at, nodes = Overlaps.of(self, np.array([wavelength_nm])), 24
        before = np.full(left.size, np.inf)
        while left.size:
            if nodes > MOST_ACROSS:
                raise _not_followed(wavelength_nm, "where two copies of the pupil overlap", nodes**2)
            found = at(rho[left], angle[left], np.full(SHARES.size, nodes))[0]
            out[left] = found
            moves = np.abs(found - before) > SETTLED
            left, before, nodes = left[moves], found[moves], math.ceil(1.5 * nodes)
        otf: F64 = out.reshape(fx.shape)
        return otf.real.copy() if self._symmetric else otf

    def otf_size(self, frequency_per_um: F64, direction: tuple[float, float], wavelength_nm: float) -> F64:
        """MTF at frequencies along a unit vector, accurate to about a hundredth, for bounds.

        The pupil function is sampled on a lattice along the direction, and each line is autocorrelated by an FFT, which
        gives all shifts at once. Undersampling of a steep phase only adds noise.
        """
        shift = 2.0 * self.blur_um(wavelength_nm) * frequency_per_um
        sizes: F64 = np.interp(shift, *_sizes(self, direction, wavelength_nm), right=0.0)
        return sizes

    def round_core(self) -> Airy | AnnularAiry:
        """Return the aberration-free lens with the same circular pupil."""
        if self.pupil.obstruction:
            return AnnularAiry(f_number=self.f_number, obstruction=self.pupil.obstruction)
        return Airy(f_number=self.f_number)

    def strehl(self, wavelength_nm: float) -> float:
        """Return the Strehl ratio: the PSF at the centre over that without aberrations."""
        centre = np.zeros(1)
        height = float(self.point_spread_on(centre, centre, wavelength_nm, SETTLED)[0, 0])
        return height * 4.0 * self.blur_um(wavelength_nm) ** 2 / self.pupil.area

    def point_spread_on(self, x_um: F64, y_um: F64, wavelength_nm: float, precision: float) -> F64:
        """Irradiance (y, x) per µm² from a point of unit power, on an evenly spaced lattice.

        precision : allowed error of the amplitude, relative to its largest possible value

        The amplitude is a sum over quadrature nodes in the pupil, by a non-uniform FFT. The number of nodes is
        increased until the sum has converged in the lattice's corners and its middle.
        """
        from camsim.numerics.nonuniform import modes  # with finufft, which no lens needs before it is rendered

        radius = 0.5 / self.blur_um(wavelength_nm)  # of the pupil, as a frequency
        x, y, strengths = self._settled(x_um, y_um, wavelength_nm, precision)
        phases = []
        for places, axis in ((y, y_um), (x, x_um)):
            # The integers of a sum are centred on 0: shift the lattice's middle there.
            step, middle = (float(axis[1] - axis[0]) if axis.size > 1 else 0.0), float(axis[axis.size // 2])
            strengths = strengths * np.exp(-2j * np.pi * radius * middle * places)
            phases.append(np.remainder(-2.0 * np.pi * radius * step * places + np.pi, 2.0 * np.pi) - np.pi)
        amplitude = modes(
            (phases[0], phases[1]), strengths[None], (y_um.size, x_um.size), precision=max(precision, 1e-14), sign=1
        )[0]
        irradiance: F64 = radius**2 / self.pupil.area * (np.square(amplitude.real) + np.square(amplitude.imag))
        return irradiance

    def _settled(self, x_um: F64, y_um: F64, wavelength_nm: float, precision: float) -> tuple[F64, F64, C128]:
        """Return nodes of the pupil, and weights times phase factors, that resolve the phase for all of a lattice."""
        radius = 0.5 / self.blur_um(wavelength_nm)
        ends = [(float(axis.min()), float(axis[axis.size // 2]), float(axis.max())) for axis in (x_um, y_um)]
        farthest_um = math.hypot(*(max(abs(low), abs(high)) for low, _, high in ends))
        turned_rad = 2.0 * math.pi * (radius * self.pupil.outer_radius * farthest_um + self.waves_across(wavelength_nm))
        along, before = SPARE + math.ceil(PER_RADIAN * turned_rad), None
        while True:
            # Odd numbers of rays: a sine may vanish on an even number.
            about = 4 * along + 1 if self.pupil.shape == "circular" else along
            if along * about * self.pupil.sides > MOST_NODES:
                raise _not_followed(wavelength_nm, "over the pupil", int(MOST_NODES))
            x, y, weights = self.pupil.nodes(along, about)
            strengths = weights * np.exp(2j * np.pi * self.waves(x, y, wavelength_nm))
            found = np.array(
                [
                    np.sum(strengths * np.exp(-2j * np.pi * radius * (at_x * x + at_y * y)))
                    for at_x, at_y in itertools.product(*ends)
                ]
            )
            if before is not None and np.abs(found - before).max() <= max(SETTLED, 0.1 * precision) * self.pupil.area:
                return x, y, strengths
            along, before = math.ceil(GROWTH * along), found


@functools.lru_cache(maxsize=64)
def _sizes(lens: OfPupil, direction: tuple[float, float], wavelength_nm: float) -> tuple[F64, F64]:
    """Return shifts of the pupil along a direction, half diameters, and the MTF there."""
    place = lens.pupil.outer_radius * ((2.0 * np.arange(LATTICE) + 1.0) / LATTICE - 1.0)
    cos, sin = direction
    x, y = place * cos - place[:, None] * sin, place * sin + place[:, None] * cos
    inside = lens.pupil.holds(x, y)
    amplitude = np.zeros(inside.shape, complex)
    amplitude[inside] = np.exp(2j * np.pi * lens.waves(x[inside], y[inside], wavelength_nm))
    power = np.sum(np.abs(scipy.fft.fft(amplitude, 2 * LATTICE, axis=1)) ** 2, axis=0)
    size = np.abs(scipy.fft.ifft(power)[:LATTICE])
    return np.arange(LATTICE) * (place[1] - place[0]), size / size[0]


def _not_followed(wavelength_nm: float, where: str, most: int) -> UnsupportedError:
    """Return the error for a wavefront that the largest number of nodes does not resolve."""
    return UnsupportedError(
        f"the wavefront has too many waves at {wavelength_nm:g} nm to be sampled {where} "
        f"({most} points do not follow it); give smaller coefficients",
        key="zernike_waves",
    )
