"""What follows from a pupil and a path difference over it: transfer, pattern, and how many nodes they take."""

from __future__ import annotations

import functools
import math
from abc import abstractmethod
from collections.abc import Callable, Iterator

import numpy as np
import scipy

from camsim.arrays import C128, F64
from camsim.errors import UnsupportedError
from camsim.optics.airy import NM_PER_UM, Airy
from camsim.optics.annular import AnnularAiry
from camsim.optics.chords import chords_of
from camsim.optics.difference import Core
from camsim.optics.follow import Turns, not_followed
from camsim.optics.panels import PanelRule
from camsim.optics.protocols import Span
from camsim.optics.pupil import Pupil
from camsim.optics.rays import Rays, places_over, rays_of
from camsim.optics.spikes import Spike, spikes_of

SETTLED = 1e-11  # two rules that differ by no more than this agree
LATTICE = 512  # points across the pupil for a transfer that need not be exact: 0.015 at worst of eight drawn lenses
ACROSS = 24  # nodes along a radius, and round, for the wavefront's range
MOST_NODES, MOST_ACROSS = 1e9, 1000  # of the pupil's rule: an hour; either way, of its overlap with its shifted copy
NODES_AT_ONCE = 2_800_000  # 200 MB
LINE_PRECISION = 1e-14  # of an amplitude along one line, relative: coarser ones take as long
IN_CACHE = 16384  # nodes whose wavefront is computed at a time: over all of them at once it takes four times as long


class OfPupil:
    """What a lens can do that has an ``f_number``, a ``pupil``, ``waves`` over it, and knows if it is ``_symmetric``.

    It has no fields: lenses stay what they are, and share what follows.
    """

    __slots__ = ()

    f_number: float
    pupil: Pupil

    @abstractmethod
    def waves(self, x: F64, y: F64, wavelength_nm: float) -> F64:
        """Return the path difference in waves at (x, y), in units of D/2."""

    @property
    @abstractmethod
    def _symmetric(self) -> bool:
        """Whether the pattern stays the same when turned by 180°, so that its transfer is real."""

    @property
    def opening(self) -> float:
        """The pupil's area over that of a circle of diameter D."""
        return self.pupil.area / math.pi

    def blur_um(self, wavelength_nm: float) -> float:
        """The length of the pattern without aberrations, µm: λN."""
        return self.f_number * wavelength_nm / NM_PER_UM

    def cutoff_per_um(self, wavelength_nm: float) -> float:
        """The frequency beyond which nothing passes in any direction, cycles/µm."""
        return self.pupil.outer_radius / self.blur_um(wavelength_nm)

    def bands_per_um(self, wavelength_nm: float) -> tuple[float, float]:
        """The frequencies along x and along y beyond which nothing passes, whatever the other, cycles/µm."""
        along_x, along_y = self.pupil.half_extents
        return along_x / self.blur_um(wavelength_nm), along_y / self.blur_um(wavelength_nm)

    def waves_across(self, wavelength_nm: float) -> float:
        """Return how far the wavefront goes up and down over the pupil, but for a plane, waves."""
        x, y = places_over(self.pupil, ACROSS)
        waves, plane = self.waves(x, y, wavelength_nm), np.stack([x, y, np.ones_like(x)], axis=1)
        return float(np.ptp(waves - plane @ np.linalg.lstsq(plane, waves, rcond=None)[0]))

    def waves_turned(self, low_nm: float, high_nm: float) -> float:
        """Return by how many waves the path difference turns between two wavelengths, over the pupil."""
        return abs(self.waves_across(low_nm) - self.waves_across(high_nm)) if low_nm != high_nm else 0.0

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer function at (fx, fy) cycles/µm: the pupil's overlap with its shifted copy, weighed by phase.

        Complex where the wavefront has odd parts. Integrated within the overlap's exact boundaries, with more nodes
        until 1e-11 is reached; UnsupportedError where it is not.
        """
        fx, fy = np.broadcast_arrays(np.asarray(fx_per_um, float), np.asarray(fy_per_um, float))
        blur_um = self.blur_um(wavelength_nm)
        shifts, angles = 2.0 * blur_um * np.hypot(fx, fy), np.arctan2(fy, fx)
        out = np.empty(fx.shape, complex)
        for place in np.ndindex(fx.shape):
            out[place] = self._transfer(float(shifts[place]), float(angles[place]), wavelength_nm)
        return out.real.copy() if self._symmetric else out

    def otf_size(self, frequency_per_um: F64, direction: tuple[float, float], wavelength_nm: float) -> F64:
        """Size of the transfer at frequencies along a unit vector, to about a hundredth of the light: for bounds.

        The pupil on a lattice along the direction, each line of it correlated with itself by an FFT: all shifts at
        once. However fast the phase runs, what so many points get wrong of it is noise.
        """
        shift = 2.0 * self.blur_um(wavelength_nm) * frequency_per_um
        sizes: F64 = np.interp(shift, *_sizes(self, direction, wavelength_nm), right=0.0)
        return sizes

    def spikes(self, wavelength_nm: float) -> tuple[Spike, ...]:
        """Return the far light of a pupil with straight sides."""
        return spikes_of(self, wavelength_nm)

    def round_core(self) -> Core:
        """Return the lens of a round pupil without aberrations."""
        if self.pupil.obstruction:
            return AnnularAiry(f_number=self.f_number, obstruction=self.pupil.obstruction)
        return Airy(f_number=self.f_number)

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
            if abs(value - before) <= SETTLED:
                return value
            if nodes > MOST_ACROSS:
                raise not_followed(wavelength_nm, "where two copies of the pupil overlap", f"{nodes**2} points")
            before, nodes = value, math.ceil(1.5 * nodes)

    def strehl(self, wavelength_nm: float) -> float:
        """Return the pattern's height at the centre over that without aberrations."""
        rules = self._nodes(wavelength_nm, Turns(0.0, 0.0))
        amplitude = sum(complex(np.sum(w * self._phase_factor(x, y, wavelength_nm))) for x, y, w in rules)
        return abs(amplitude / self.pupil.area) ** 2

    def point_spread_on(self, x_um: F64, y_um: F64, wavelength_nm: float, precision: float) -> F64:
        """Irradiance (y, x) per µm² from a point of unit power, on an even lattice; see ``point_spread_rows``."""
        irradiance = np.empty((y_um.size, x_um.size))
        for rows, some in self.point_spread_rows(x_um, y_um, wavelength_nm, precision):
            irradiance[rows] = some
        return irradiance

    def point_spread_rows(
        self, x_um: F64, y_um: F64, wavelength_nm: float, precision: float
    ) -> Iterator[tuple[slice, F64]]:
        """Yield some rows after the others of the irradiance per µm² from a point of unit power, on an even lattice.

        precision : of the amplitude, relative to its largest possible value
        yields    : rows, each once but in no order, and what is there (n, x)

        The amplitude is summed over a rule that is exact within the pupil's boundaries, as fine as the farthest
        corner asks for, by a non-uniform FFT.
        """
        from camsim.gridded import is_large, power_rows  # with Numba, which no lens needs before it is rendered

        radius = 0.5 / self.blur_um(wavelength_nm)  # of the pupil, as a frequency
        turns = self._turns(
            (float(x_um.min()), float(x_um.max())), (float(y_um.min()), float(y_um.max())), wavelength_nm
        )
        steps = [float(axis[1] - axis[0]) if axis.size > 1 else 0.0 for axis in (x_um, y_um)]
        # The integers of a sum run about 0: the lattice's middle is moved there.
        middle = [float(axis[axis.size // 2]) for axis in (x_um, y_um)]
        plane = -radius * middle[0], -radius * middle[1]
        (mid_x, mid_y), (half_x, half_y) = self.pupil.centre, self.pupil.half_extents
        turn_x, turn_y = (2.0 * np.pi * radius * step for step in steps)

        def points(part: tuple[F64, F64, F64]) -> tuple[F64, F64, C128]:
            x, y, weights = part
            strengths = self._phase_factor(x, y, wavelength_nm, plane)
            strengths *= weights
            return turn_y * (y - mid_y), turn_x * (x - mid_x), strengths  # what all turn by changes no square

        # Where the pattern is even, so is the amplitude, but for the lattice's move.
        half = self._symmetric and is_large((y_um.size, x_um.size)) and not any(middle)
        for rows, power in power_rows(
            self._nodes(wavelength_nm, turns, half),
            points,
            (y_um.size, x_um.size),
            bands_rad=(turn_y * half_y, turn_x * half_x),
            precision=max(precision, 1e-14),
            half=half,
        ):
            power *= radius**2 / self.pupil.area
            yield rows, power

    def point_spread_round(self, r_um: F64, wavelength_nm: float) -> F64:
        """Irradiance at ``r_um`` from a point of unit power, 1/µm², where the wavefront is one of revolution.

        The amplitude along one line is the pupil, summed up across it, transformed: a pupil's nodes for waves of that
        line alone.
        """
        from camsim.nonuniform import waves_at  # with finufft, which no lens needs before it is rendered

        radius = 0.5 / self.blur_um(wavelength_nm)
        amplitude = np.zeros(r_um.shape, complex)
        farthest_um = float(np.abs(r_um).max(initial=0.0))
        rule = self._line_rule(wavelength_nm, self._turns((-farthest_um, farthest_um), (0.0, 0.0), wavelength_nm))
        for x, y, weights in rule.parts(NODES_AT_ONCE):
            strengths = weights * self._phase_factor(x, y, wavelength_nm)
            amplitude += waves_at(2.0 * np.pi * radius * x, strengths, r_um, precision=LINE_PRECISION)
        irradiance: F64 = radius**2 / self.pupil.area * (np.square(amplitude.real) + np.square(amplitude.imag))
        return irradiance

    def line_nodes(self, r_um: float, wavelength_nm: float) -> float:
        """Return how many nodes ``point_spread_round`` takes out to a radius."""
        return self._line_rule(wavelength_nm, self._turns((-r_um, r_um), (0.0, 0.0), wavelength_nm)).total

    def pupil_nodes(self, wavelength_nm: float) -> Callable[[Span, Span], float]:
        """Return what tells how many nodes ``point_spread_on`` takes from where to where along x and along y in µm."""

        def count(x_um: Span, y_um: Span) -> float:
            turns = self._turns(x_um, y_um, wavelength_nm)
            # Where all is even, about the middle, one of two opposite nodes is enough.
            half = self._symmetric and not any(turns.middle_rad)
            return (0.5 if half else 1.0) * self._rule(wavelength_nm, turns).total

        return count

    def _rule(self, wavelength_nm: float, turns: Turns) -> PanelRule | Rays:
        """Return the rule of fewer nodes: a square takes a third as many along chords, a circle more."""
        return (chords_of if self.pupil.sides > 1 else rays_of)(self, wavelength_nm, turns)

    def _line_rule(self, wavelength_nm: float, turns: Turns) -> PanelRule | Rays:
        """Return the rule of fewer nodes for waves along x alone: chords across them."""
        return chords_of(self, wavelength_nm, turns)

    def _turns(self, x_um: Span, y_um: Span, wavelength_nm: float) -> Turns:
        """Return by how much plane waves turn on half of the diameter that go such distances off the axis."""
        per_um = math.pi / self.blur_um(wavelength_nm)
        (left, right), (top, bottom) = x_um, y_um
        middle = 0.5 * per_um * (left + right), 0.5 * per_um * (top + bottom)
        return Turns(0.5 * per_um * (right - left), 0.5 * per_um * (bottom - top), middle)

    def _nodes(self, wavelength_nm: float, turns: Turns, half: bool = False) -> Iterator[tuple[F64, F64, F64]]:
        """Yield nodes of the pupil, part by part, for its amplitude times waves that turn by up to ``turns``."""
        rule = self._rule(wavelength_nm, turns)
        if rule.total > MOST_NODES:
            raise UnsupportedError(
                f"this wavefront at {wavelength_nm:g} nm, {turns.largest / math.tau:.3g} waves off the axis, "
                f"takes more than {MOST_NODES:g} nodes in the pupil; give smaller coefficients or a smaller scene",
                key="zernike_waves",
            )
        yield from rule.parts(NODES_AT_ONCE, half)

    def _phase_factor(self, x: F64, y: F64, wavelength_nm: float, plane: tuple[float, float] = (0.0, 0.0)) -> C128:
        """Return exp(2πi·W); ``plane``: waves along x and y that are added to W."""
        from camsim.kernels import shared  # with Numba, as above

        factor = np.empty(x.shape, complex)
        flat, x, y = factor.reshape(-1), x.reshape(-1), y.reshape(-1)

        def fill(begin: int, stop: int) -> None:
            for first in range(begin * IN_CACHE, min(stop * IN_CACHE, flat.size), IN_CACHE):
                some = slice(first, first + IN_CACHE)
                waves = self.waves(x[some], y[some], wavelength_nm) + plane[0] * x[some] + plane[1] * y[some]
                phase = 2.0 * np.pi * waves
                np.cos(phase, out=flat.real[some])
                np.sin(phase, out=flat.imag[some])

        self.waves(x[:0], y[:0], wavelength_nm)  # what it takes is compiled here, on a stack as large as the caller's
        shared(math.ceil(flat.size / IN_CACHE), fill)
        return factor


@functools.lru_cache(maxsize=64)
def _sizes(lens: OfPupil, direction: tuple[float, float], wavelength_nm: float) -> tuple[F64, F64]:
    """Return shifts of the pupil along a direction, half diameters, and sizes of the transfer there."""
    place = lens.pupil.outer_radius * ((2.0 * np.arange(LATTICE) + 1.0) / LATTICE - 1.0)
    cos, sin = direction
    x, y = place * cos - place[:, None] * sin, place * sin + place[:, None] * cos
    inside = lens.pupil.holds(x, y)
    amplitude = np.zeros(inside.shape, complex)
    amplitude[inside] = lens._phase_factor(x[inside], y[inside], wavelength_nm)
    power = np.sum(np.abs(scipy.fft.fft(amplitude, 2 * LATTICE, axis=1)) ** 2, axis=0)
    size = np.abs(scipy.fft.ifft(power)[:LATTICE])
    return np.arange(LATTICE) * (place[1] - place[0]), size / size[0]
