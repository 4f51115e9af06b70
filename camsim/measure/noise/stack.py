"""Statistics of equal frames: means, temporal and spatial variances, and their errors."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
import scipy

from camsim.core.arrays import F64, I64
from camsim.core.cached import cached_property
from camsim.errors import InvalidValueError
from camsim.measure.noise.estimate import SURE

Codes: TypeAlias = npt.NDArray[np.integer[Any]]
Chosen: TypeAlias = npt.NDArray[np.bool_]

_SMOOTH: F64 = np.convolve(np.convolve(np.full(7, 1 / 7), np.full(11, 1 / 11)), (0.25, 0.5, 0.25))
"""Low-pass subtracted by EMVA 1288 R4's high-pass along an axis: boxes of 7 and of 11, then 1 2 1."""
_OF_ROWS = float(1.0 - 2.0 * _SMOOTH.max() + np.sum(_SMOOTH**2))
"""Part of the variance of independent rows that remains after the high-pass."""

_FEW_CODES = 8
_LEAST_SEEN = 3
"""Fewest distinct codes that determine their distance."""
_MOST_CODES = 1 << 22
"""Most codes of a converter, summed over frames: larger numbers are not codes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Rounding:
    """Rounding by the converter.

    step_dn : between neighbouring codes: 16 of 12 bits stored in 16
    summed  : number of rounded frames summed into each; None if unknown
    """

    step_dn: float = 1.0
    summed: int | None = 1

    @property
    def dn2(self) -> float:
        """The variance of rounding; that of a single frame if the number of summed frames is unknown."""
        return (self.summed or 1) * self.step_dn**2 / 12.0

    @property
    def least_dn2(self) -> float:
        """Temporal variance below which rounding is no longer independent noise (EMVA 1288: σ_y,dark ≥ 0.49 DN)."""
        return 3.0 * self.dn2

    def sigma_dn2(self, variance_dn2: float) -> float:
        """Return the uncertainty of the variance of rounding for frames of a variance; 0 if ``summed`` is known."""
        most = 1.0 if self.summed else max(1.0, variance_dn2 / self.least_dn2)
        return (most - 1.0) * self.dn2 / math.sqrt(3.0)


_EACH_CODE = Rounding()


def step_between_codes_dn(frames: Iterable[Codes]) -> float:
    """Return the distance between neighbouring codes of a converter; 1 if few distinct ones occur.

    >>> step_between_codes_dn([np.arange(100, 140).reshape(5, 8) * 16])
    16.0
    """
    seen: npt.NDArray[Any] = np.zeros(0, np.int64)
    for codes in frames:
        seen = np.union1d(seen, codes.astype(np.int64))
        gaps = np.diff(seen)
        if gaps.size and gaps.min() == 1:
            return 1.0
    gaps = np.diff(seen)
    # Codes of 12 bits times 65535 / 4095 are 16 or 17 apart.
    near = gaps[gaps < 1.5 * gaps.min()] if gaps.size else gaps
    return float(near.mean()) if near.size >= _FEW_CODES else 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Pattern:
    """A spatial variance, the standard deviation of its estimate, and how much of that is due to temporal noise."""

    dn2: float
    sigma_dn2: float
    chance_dn2: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Stack:
    """Statistics of several equal frames over the photosites of one channel.

    frames : number of frames
    mean_dn, mean_sigma_dn : mean code and the standard deviation of its estimate
    row_sigma_dn : that standard deviation as estimated from the rows, which are many
    excess_dn2   : by how much the variance of the frames' means exceeds row_sigma_dn²; random, of either sign, if
                   frames are few
    variance_dn2, variance_sigma_dn2 : temporal variance of a photosite, and error, without offsets common to a frame
    pattern, fine      : spatial variance of the fixed pattern: total, and without parts smooth over tens of photosites
    rounding           : that of its codes;  coarser_dn2: variance that rounding adds beyond that if codes are companded
    clipped_low        : fraction of codes that are 0, or piled up at the smallest one below 0
    largest_dn, at_end : the largest code, and the fraction of codes piled up there; 0 if they thin out towards it
    """

    frames: int
    mean_dn: float
    mean_sigma_dn: float
    row_sigma_dn: float
    excess_dn2: float
    variance_dn2: float
    variance_sigma_dn2: float
    pattern: Pattern
    fine: Pattern
    rounding: Rounding
    coarser_dn2: float
    clipped_low: float
    largest_dn: int
    at_end: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Level:
    """Flats, and the darks of the same exposure time."""

    exposure: float
    light: Stack
    dark: Stack

    @property
    def signal_dn(self) -> float:
        """Mean signal that light adds: the flats' mean less the darks'."""
        return self.light.mean_dn - self.dark.mean_dn

    @property
    def signal_sigma_dn(self) -> float:
        """The standard deviation of the estimate of ``signal_dn``."""
        return math.hypot(self.light.mean_sigma_dn, self.dark.mean_sigma_dn)

    @property
    def added_dn2(self) -> float:
        """Temporal variance added by light, less what the lamp's drift adds by scaling a non-uniform light."""
        added_dn2 = self.light.variance_dn2 - self.dark.variance_dn2
        added_dn2 -= self.light.coarser_dn2 - self.dark.coarser_dn2
        if self.signal_dn > SURE * self.signal_sigma_dn:
            drift = self.light.frames * max(self.light.excess_dn2, 0.0) / self.signal_dn**2
            added_dn2 -= drift * max(self.light.pattern.dn2 - self.dark.pattern.dn2, 0.0)
        return added_dn2

    @property
    def added_sigma_dn2(self) -> float:
        """The standard deviation of the estimate of ``added_dn2``."""
        return math.hypot(self.light.variance_sigma_dn2, self.dark.variance_sigma_dn2)


@dataclass(frozen=True, eq=False)
class Photosites:
    """The photosites (n,) of one channel, in the order of their rows; ``channel``: mask (rows, cols) of them."""

    channel: Chosen

    def __len__(self) -> int:
        return self._places.size

    def of(self, frame: Codes) -> Codes:
        """Return a frame's codes (n,)."""
        return np.take(frame, self._places)

    @cached_property
    def _places(self) -> I64:
        return np.flatnonzero(self.channel)

    @cached_property
    def lines(self) -> tuple[I64, I64]:
        """Index (n,) of each one's row, and of its column, counting only non-empty ones."""
        there = (np.cumsum(self.channel.any(axis=1 - axis)) - 1 for axis in (0, 1))
        row, col = (
            number[at] for number, at in zip(there, np.divmod(self._places, self.channel.shape[1]), strict=True)
        )
        return row, col

    @cached_property
    def _begins(self) -> I64:
        return np.searchsorted(self.lines[0], np.arange(self.lines[0][-1] + 1))

    def means_of_rows(self, values: F64) -> F64:
        """Return the mean of each row of values (n,)."""
        means: F64 = np.add.reduceat(values, self._begins) / np.diff(self._begins, append=len(self))
        return means

    def means_of_cols(self, values: F64) -> F64:
        """Return the mean of each column of values (n,)."""
        means: F64 = np.bincount(self.lines[1], values) / np.bincount(self.lines[1])
        return means

    def fine(self, mean: F64) -> F64:
        """Return values (n,) after the high-pass, scaled to preserve the variance of white noise.

        A polynomial is subtracted first: at borders, and with steep fall-off, the high-pass alone leaves some shading.
        """
        inside, around, (down, across) = self._inside, self._around, self._polynomials
        places = np.zeros(inside.shape)
        places[inside] = mean
        filled = np.where(inside, places, _smooth(places, _SMOOTH) / around)
        left = np.where(inside, filled - down @ (down.T @ filled @ across) @ across.T, 0.0)
        fine: F64 = (left - _smooth(left, _SMOOTH) / around)[inside] / math.sqrt(self.remaining)
        return fine

    @cached_property
    def remaining(self) -> float:
        """Part of the variance of white noise that is left by the high-pass, before the scaling of ``fine``."""
        one = _SMOOTH.max() ** 2 / self._around
        white = 1.0 - 2.0 * one + _smooth(self._inside.astype(np.float64), _SMOOTH**2) / self._around**2
        down, across = self._polynomials
        terms = down.shape[1] * across.shape[1]
        return float(np.mean(white[self._inside]) * max(1.0 - terms / len(self), 1e-9))

    @cached_property
    def _inside(self) -> Chosen:
        return self.channel[np.ix_(self.channel.any(axis=1), self.channel.any(axis=0))]

    @cached_property
    def _around(self) -> F64:
        return np.maximum(_smooth(self._inside.astype(np.float64), _SMOOTH), 1e-9)

    @cached_property
    def _polynomials(self) -> tuple[F64, F64]:
        down, across = (_polynomials(size) for size in self._inside.shape)
        return down, across


def stack(frames: Sequence[Codes], photosites: Photosites, rounding: Rounding = _EACH_CODE) -> Stack:
    """Reduce frames (rows, cols) to their statistics over the photosites of a channel.

    The mean of each frame is subtracted before the temporal variance, as in EMVA 1288: the lamp's drift, or an offset
    of the frame, is not noise of photosites. Row offsets contribute to that mean: their share is added back.
    The scatter of rows and columns enters the standard deviations, so that offsets common to a row or a column do
    not count as many independent numbers.
    """
    count, size = len(frames), len(photosites)
    if count < 2:
        raise InvalidValueError(f"{count}; two or more show what changes", key="frames")
    rows, cols = (int(line.max()) + 1 for line in photosites.lines)
    seen = [photosites.of(frame) for frame in frames]
    largest = max(int(codes.max()) for codes in seen)
    smallest, near = min(int(codes.min()) for codes in seen), 1.5 * rounding.step_dn
    low, at = (sum(int(np.count_nonzero(c == code)) for c in seen) for code in (min(smallest, 0), largest))
    below = sum(int(np.count_nonzero(c > largest - near)) for c in seen) - at
    if smallest < 0 and low <= sum(int(np.count_nonzero(c < smallest + near)) for c in seen) - low:
        low = 0  # signed codes thin out towards the smallest
    total, squares, means, means_of_rows = np.zeros(size), np.zeros(size), [], []
    for codes in seen:
        means.append(float(codes.mean(dtype=np.float64)))
        off: F64 = codes.astype(np.float64) - means[-1]
        total += off
        squares += off * off
        means_of_rows.append(photosites.means_of_rows(off))
    mean = total / count
    variance = (squares - count * mean * mean) / (count - 1)
    apart = float(variance.mean())
    if rows > 1:
        # Row offsets give as many independent numbers as there are rows.
        of_rows = float(np.var(means_of_rows, axis=0, ddof=1).mean()) * rows / (rows - 1)
        temporal = apart + of_rows / rows
    else:
        of_rows, temporal = 0.0, apart * size / max(1, size - 1)
    between = float(np.var(means, ddof=1)) / count
    by_rows = max(temporal / size, of_rows / rows) / count
    # Temporal scatter contributes to the mean, divided by the number of frames.
    scatter = apart * size / max(1, size - 1)
    temporal_sigma = max(
        _error_by_rows(photosites.means_of_rows(variance)), _error_by_chance(temporal, of_rows, (size, rows), count)
    )

    def pattern(values: F64, of_rows: float, scatter: float) -> Pattern:
        spatial, (row, col) = float(values.var(ddof=1)), photosites.lines
        of_cols = _variance_of_lines(values, photosites.means_of_cols(values), col)
        of_means = _variance_of_lines(values, photosites.means_of_rows(values), row)
        more = temporal_sigma / count
        lines = math.sqrt(2.0 / size * spatial**2 + 2.0 / cols * of_cols**2 + 2.0 / rows * of_means**2 + more**2)
        chance = _chance(spatial, scatter / count) / size + _chance(of_means, of_rows / count) / rows
        return Pattern(dn2=spatial - scatter / count, sigma_dn2=lines, chance_dn2=math.sqrt(chance + more**2))

    remaining = photosites.remaining
    return Stack(
        frames=count,
        mean_dn=float(np.mean(means)),
        mean_sigma_dn=math.sqrt(max(by_rows, between)),
        row_sigma_dn=math.sqrt(by_rows),
        excess_dn2=between - by_rows,
        variance_dn2=temporal,
        variance_sigma_dn2=temporal_sigma,
        pattern=pattern(mean, of_rows, scatter),
        fine=pattern(
            photosites.fine(mean),
            of_rows * _OF_ROWS / remaining,
            max(scatter - of_rows * (1.0 - _OF_ROWS / remaining), 0.0),
        ),
        rounding=rounding,
        coarser_dn2=_coarser_dn2(seen, rounding, temporal),
        clipped_low=low / (count * size),
        largest_dn=largest,
        at_end=at / (count * size) if at > below else 0.0,
    )


def _coarser_dn2(codes: Sequence[Codes], rounding: Rounding, temporal_dn2: float) -> float:
    """Return what rounding adds to the temporal variance beyond that in the dark: companded codes are further apart.

    A code represents the interval nearest to it among codes that occur, in which the signal is spread evenly with the
    slope of a normal law: where the distance changes, rounding moves signals apart or together. Absent codes widen
    their neighbours' intervals by less than a thousandth of the noise.
    """
    low, high = min(int(each.min()) for each in codes), max(int(each.max()) for each in codes)
    if high - low > _MOST_CODES:
        return 0.0
    count = np.zeros(high - low + 1, np.int64)
    for each in codes:
        count += np.bincount(each.astype(np.int64) - low, minlength=count.size)
    seen = np.flatnonzero(count)
    if len(seen) < _LEAST_SEEN:
        return 0.0
    share, gap = count[seen] / count.sum(), np.diff(seen.astype(np.float64))
    before, after = np.concatenate([gap[:1], gap]), np.concatenate([gap, gap[-1:]])
    middle = seen + 0.25 * (after - before)
    middle -= share @ middle
    spread = float(share @ middle**2)
    inside = (before + after) ** 2 / 48.0  # variance of the signal within an interval
    moved = 0.25 * (before - after) + middle / spread * inside  # mean of code − signal
    own = share @ ((before**3 + after**3) / (12.0 * (before + after))) - (share @ moved) ** 2
    along = 2.0 * min(temporal_dn2 / spread, 1.0) * (share @ (middle * moved - inside))
    return (rounding.summed or 1) * float(own + along) - rounding.dn2


def _smooth(values: F64, kernel: F64) -> F64:
    """Return an array (rows, cols) filtered along both axes."""
    for axis in (0, 1):
        values = scipy.ndimage.correlate1d(values, kernel, axis=axis, mode="constant")
    return values


def _polynomials(size: int) -> F64:
    """Return orthonormal polynomials (size, n) over a line of photosites, of the tenth degree at most."""
    degree = min(10, size // 10)
    powers = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, size), degree)
    basis: F64 = np.linalg.qr(powers)[0]
    return basis


def _error_by_chance(temporal: float, of_rows: float, numbers: tuple[int, int], count: int) -> float:
    """Return the standard deviation of a variance from ``count`` frames: of row offsets, and of the rest."""
    photosites, rows = numbers
    rest = max(0.0, temporal - of_rows) if photosites > rows else 0.0
    parts = of_rows**2 / max(1, rows - 1) + rest**2 / max(1, photosites - rows)
    return math.sqrt(2.0 / (count - 1) * max(parts, temporal**2 / photosites))


def _chance(whole: float, noise: float) -> float:
    """Return the sampling variance of a variance that includes noise, times the number of samples.

    >>> _chance(3.0, 0.0), _chance(1.0, 1.0)
    (0.0, 2.0)
    """
    return 2.0 * noise * (2.0 * max(whole - noise, 0.0) + noise)


def _error_by_rows(rows: F64) -> float:
    """Return the standard deviation of a mean over photosites, from the scatter of its rows."""
    return float(np.std(rows, ddof=1)) / math.sqrt(len(rows)) if len(rows) > 1 else 0.0


def _variance_of_lines(mean: F64, lines: F64, line: I64) -> float:
    """Return the variance of offsets of columns or rows, beyond that expected by chance.

    lines : their means;  line: (n,) that of each photosite
    """
    if len(lines) < 2:
        return 0.0
    # The chance level comes from variation within lines, without their offsets.
    within = float(np.sum((mean - lines[line]) ** 2)) / max(1, len(mean) - len(lines))
    return max(0.0, float(lines.var(ddof=1)) - within * len(lines) / len(mean))
