"""The difference's transfers, wavelengths fused: what they are made of depends on the lens, and is kept."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from camsim.arrays import C128, F64, I64
from camsim.kept import cached_property
from camsim.kernels import shared
from camsim.optics.difference import Difference
from camsim.quadrature import SIX_POINTS, chebyshev
from camsim.rendering.aberrated.polar_kernels import BESSELS, Profiles, Waves, add_patterns, project
from camsim.rendering.aberrated.series import DEGREES, LAST, Series, length_of, series_of
from camsim.rendering.aberrated.settings import Settings
from camsim.rendering.aberrated.window_kernels import frequencies_within
from camsim.rendering.angular import Transfer
from camsim.rendering.fast_length import fast_length
from camsim.rendering.fourier.taper import taper, tapered

MORE_NODES = 10  # along the radius
FINER = 16  # times as many nodes as the radius takes, for a six-point look-up: 2e-7 of what is far out, 1e-9 of all
RADII = 16  # at which it is asked what an edge shows
STEEP_RAD = 80.0  # per radius of the pupil: from there on harmonics about the move may be many
COLUMNS = 20.0  # of a pattern that is not steep, cosines and sines: 19 to 24 of a few lenses
PLACES = 0.25 * math.pi / (0.49 * 0.97)  # of a quarter of the plane, by the square of cycles within the taper
BESIDES = 20.0  # columns that a place's radius and angle take as long as
SERIES_MORE = 20.0  # degrees
# Seconds: of a series' node and term (the first one is looked for by as much again), of an amplitude's term at a radius
# and an angle, of Bessel functions at a radius, of a pattern's column at a place of the plane, and at a frequency.
PER_NODE, PER_TERM, PER_BESSEL, PER_PROJECTED, PER_LOOK = 2.3e-9, 1e-9, 8e-8, 5e-9, 1e-9
COARSEST = 1.0  # radians that a transfer's fastest part turns by from one row of its table to the next, at most
KEPT_BYTES = 1 << 23  # of what windows look up, of each of few lenses


class Harmonics(NamedTuple):
    """Patterns by the angle: values (columns, b, radii), each of cos or, where ``sine`` is 1, sin(order·φ)."""

    values: F64
    order: I64
    sine: I64


@dataclass(frozen=True, kw_only=True, eq=False)
class ShortTransfers:
    """Patterns of several weight sets about their move, cut off.

    wavelength_nm : (j,);  weights: (b, j) that patterns are added up with
    precision     : of a pattern, relative to all of the light
    """

    rest: Difference
    pitch_um: float
    settings: Settings
    wavelength_nm: F64
    weights: F64
    precision: float

    @property
    def made_over(self) -> str:
        """What its patterns are made over, for whoever asks how it is rendered."""
        return "over radius and angle"

    @cached_property
    def allowed(self) -> float:
        """What each approximation may be wrong by: of all the light."""
        return max(0.25 * self.precision, 1e-14)

    def _series(self, wavelength_nm: F64) -> list[Series]:
        return series_of(self.rest, wavelength_nm, 0.5 * self.allowed)

    @property
    def steep(self) -> bool:
        """Whether waves turn so quickly about the move that there may be many harmonics."""
        return 2.0 * math.pi * self.rest.steepest_waves(self._steepest_nm) > STEEP_RAD

    @cached_property
    def _steepest_nm(self) -> float:
        """At which end of the spectrum waves turn the more quickly; tables may have more of them where it is red."""
        ends: list[float] = self.wavelength_nm[[0, -1]].tolist()
        return max(ends, key=self.rest.steepest_waves)

    @cached_property
    def _expected(self) -> tuple[int, float, float, float]:
        """Discs, degree, highest harmonic and columns of the phase factor of the most waves.

        Without its series where it is steep, which takes long by itself.
        """
        if not self.steep:
            series = self._series(np.array([self._steepest_nm]))[0]
            return len(series.terms), series.degree, series.most, min(2.0 * series.most + 1.0, COLUMNS)
        degree, most = length_of(self.rest, self._steepest_nm, self.allowed)
        return 2 if self.rest.obstruction else 1, degree, most, 2.0 * most + 1.0

    def seconds(self, lines: int) -> float:
        """Return what they take, of one core, with what is looked up for so many directions of lines.

        Infinite where no series follows the phase factor.
        """
        settings, (discs, degree, most, columns) = self.settings, self._expected
        if degree > LAST * DEGREES[-1]:
            return math.inf
        count, columns = discs * self.wavelength_nm.size, len(self.weights) * columns
        places = (settings.cut * settings.outer) ** 2 * PLACES
        frequencies = settings.tile(0, 0, settings.side, settings.side).points
        of_lines = 3.0 * lines * settings.cut * settings.outer
        return (
            PER_NODE * (count + discs) * (degree + SERIES_MORE) ** 3
            + PER_TERM * count * self.radii.size * (degree + 1.0) * (2.0 * most + 1.0)
            + PER_BESSEL * count * self.radii.size
            + PER_PROJECTED * places * (columns + BESIDES)
            + PER_LOOK * (frequencies + of_lines) * columns
        )

    @property
    def held(self) -> float:
        """Numbers of 8 bytes that they are, besides what a window has of them."""
        columns = len(self.weights) * self._expected[3]
        return columns * (20.0 * self.radii.size + 20.0 * self.settings.cut * self.settings.outer)

    @cached_property
    def radii(self) -> F64:
        """Chebyshev nodes of 0 … outer that follow the patterns, whose finest ripples are λN long."""
        outer = self.settings.outer
        turns = math.pi * outer * self.rest.cutoff_per_um(float(self.wavelength_nm.min())) * self.pitch_um
        # Bessel functions J_n(κ), the series' coefficients, fall as Airy's Ai(∛2·(n − κ)/∛κ) from n = κ on.
        beyond = 0.8 * (1.5 * math.log(10.0 / self.allowed)) ** (2.0 / 3.0)
        return 0.5 * outer * (1.0 + chebyshev(math.ceil(turns + beyond * turns ** (1.0 / 3.0)) + MORE_NODES))

    @cached_property
    def harmonics(self) -> Harmonics:
        """Patterns (columns, b, radii) less the round one: c·cos mφ + s·sin mφ, those of them that matter."""
        radius = self.radii
        every = self._series(self.wavelength_nm)
        degree, most, discs = max(own.degree for own in every), max(own.most for own in every), len(every[0].terms)
        angle = np.pi * np.arange(2.0 * most + 1.0) / (2.0 * most + 1.0)
        around = np.zeros((len(every), discs, degree + 1, 2, angle.size))
        for into, own in zip(around, every, strict=True):
            gamma = own.around(angle)
            into[:, : own.degree + 1, 0], into[:, : own.degree + 1, 1] = gamma.real, gamma.imag
        blur = np.array([self.rest.blur_um(float(nm)) for nm in self.wavelength_nm]) / self.pitch_um
        size = np.pi / (np.square(blur) * (1.0 - self.rest.obstruction**2))
        waves = Waves(np.pi / blur, around, self.rest.obstruction, self.weights * size)
        halves = np.zeros((len(self.weights), radius.size, 2, angle.size))
        shared(radius.size, functools.partial(add_patterns, radius, waves, BESSELS, halves))
        whole = np.concatenate([halves[:, :, 0] + halves[:, :, 1], halves[:, :, 0] - halves[:, :, 1]], axis=2)
        spectrum = scipy.fft.rfft(whole, axis=2, norm="forward")
        spectrum[:, :, 1:] *= 2.0
        columns = np.moveaxis(np.stack([spectrum.real, -spectrum.imag], axis=3), (2, 3), (0, 1))
        columns = columns.reshape(-1, *columns.shape[2:])
        order, sine = np.divmod(np.arange(len(columns)), 2)
        # A ring's share of Chebyshev's nodes is the cosine's slope.
        outer = self.settings.outer
        rings = (np.pi**2 / radius.size) * radius * np.sqrt(radius * (outer - radius))
        light = np.max(np.sum(np.abs(columns) * 2.0 * rings, axis=2), axis=1)
        kept = np.ones(len(light), bool)
        faintest = np.argsort(light)
        kept[faintest[np.cumsum(light[faintest]) <= self.allowed]] = False
        return Harmonics(columns[kept], order[kept], sine[kept])

    @cached_property
    def transfer(self) -> Transfer:
        """The patterns' transfers, tapered."""
        settings, harmonics = self.settings, self.harmonics
        columns, sets, nodes = harmonics.values.shape
        if not columns:
            return Transfer.of(np.zeros((6, 0, sets)), 0.0, harmonics.order, harmonics.sine, settings.cut)
        # From the farthest radius inwards: so a cosine's angles run.
        series = scipy.fft.dct(harmonics.values[..., ::-1].reshape(-1, nodes), axis=1, norm="forward")
        fine = FINER * nodes
        padded = np.zeros((fine, columns * sets))
        padded[:nodes] = series.T
        values = scipy.fft.idct(padded, axis=0, norm="forward", overwrite_x=True)
        radius = 0.5 * settings.outer * (1.0 + chebyshev(fine)[::-1])
        beyond = radius > settings.reach
        shape = tapered(radius[beyond], settings.reach, settings.outer, taper(settings.sharpness))
        values[beyond] *= shape[:, None]
        around = np.concatenate([values[2::-1], values, values[:-4:-1]])
        profiles = Profiles(around, fine / np.pi, settings.outer, harmonics.order, sets)
        step_x, step_y = 0.49 / settings.cut, 0.97 / settings.cut
        line = np.zeros((math.floor(settings.outer / step_x) + 1, columns * sets))
        shared(len(line), functools.partial(project, profiles, step_x, step_y, line))
        return self._of_line(line.T, step_x)

    def _of_line(self, line: F64, step: float) -> Transfer:
        """Return the transfers of projections (columns · sets, x) at 0, step …; odd harmonics' are odd."""
        settings, order, sets = self.settings, self.harmonics.order, self.harmonics.values.shape[1]
        length = fast_length(math.ceil(math.pi * settings.outer / (step * self._turn)) + len(line[0]), real=True)
        odd = np.repeat(order % 2 == 1, sets)
        padded = np.zeros((len(line), length + 1))
        padded[:, : line.shape[1]] = step * line
        padded[~odd] = scipy.fft.dct(padded[~odd], type=1, axis=1)
        padded[odd, 1:-1] = -scipy.fft.dst(padded[odd, 1:-1], type=1, axis=1)
        padded[odd, 0] = padded[odd, -1] = 0.0
        rows = min(math.ceil(settings.cut * 2.0 * length * step) + 4, length + 1)
        before = padded[:, 2:0:-1] * np.where(odd, -1.0, 1.0)[:, None]
        table = np.concatenate([before, padded[:, :rows]], axis=1)
        values = table.T.reshape(-1, order.size, sets)
        return Transfer.of(values, 2.0 * length * step, order, self.harmonics.sine, settings.cut)

    @property
    def _turn(self) -> float:
        """By how much the transfer's fastest part may turn from one row of its table to the next, radians.

        A six-point look-up errs by (angle)⁶ of what an edge shows of each radius.
        """
        radius = self.settings.outer * (np.arange(RADII) + 0.5) / RADII
        ends_nm = {float(self.wavelength_nm.min()), float(self.wavelength_nm.max())}
        shown = np.max([self.rest.light_beyond(radius * self.pitch_um, nm) for nm in ends_nm], axis=0)
        moment = float(np.mean(6.0 * (radius / self.settings.outer) ** 5 * shown))
        return min(COARSEST, math.pow(self.allowed / (SIX_POINTS * moment), 1.0 / 6.0))

    def at(self, fx: F64, fy: F64) -> C128:
        """Return the transfers (b, places) at places (n,)."""
        return self.transfer.at(fx, fy)

    def on_window(self) -> F64:
        """Return the transfers at (i, ±j)/period, real and imaginary parts apart: (b, 2, j, 2, i), the caller's own."""
        numbers = 4 * len(self.weights) * frequencies_within(self.settings.cut, self.settings.period) ** 2
        return self._kept.copy() if 8 * numbers <= KEPT_BYTES else self._on_window()

    @cached_property
    def _kept(self) -> F64:
        return self._on_window()

    def _on_window(self) -> F64:
        step, count = 1.0 / self.settings.period, frequencies_within(self.settings.cut, self.settings.period)
        return self.transfer.on_quarters((step, step), (count, count))


@functools.lru_cache(maxsize=4)
def transfers_of(
    rest: Difference,
    pitch_um: float,
    settings: Settings,
    wavelength_nm: tuple[float, ...],
    packed: bytes,
    precision: float,
) -> ShortTransfers:
    """Return what is kept of a lens for its next rendering; packed: weights (b, j)."""
    return ShortTransfers(
        rest=rest,
        pitch_um=pitch_um,
        settings=settings,
        wavelength_nm=np.array(wavelength_nm),
        weights=np.frombuffer(packed).reshape(-1, len(wavelength_nm)),
        precision=precision,
    )
