"""Frames taken alike, reduced to what is kept of them: means, temporal and spatial variances, and their errors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from camsim.arrays import F64, I64
from camsim.errors import InvalidValueError
from camsim.measure.noise.estimate import SURE

Codes: TypeAlias = npt.NDArray[np.unsignedinteger[Any]]
Chosen: TypeAlias = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class Stack:
    """What is kept of several frames taken alike, over the photosites of one channel.

    frames : of how many
    mean_dn, mean_sigma_dn : mean code and the standard deviation of its estimate
    row_sigma_dn : the same as rows tell it, of which there are many;  excess_dn2: how much more the variance of
                   frames' means is than that: of few frames by chance, and less than none as often
    variance_dn2, variance_sigma_dn2 : temporal variance of a photosite, likewise, without what a frame has in common
    pattern_dn2, pattern_sigma_dn2   : spatial variance of what stays, likewise;  pattern_chance_dn2: the part of its
                   error that temporal noise makes, other photosites than these left alone
    clipped_low        : fraction of codes that are 0
    largest_dn, at_end : the largest code, and the fraction of codes that are heaped on it; 0 where they thin out to it
    """

    frames: int
    mean_dn: float
    mean_sigma_dn: float
    row_sigma_dn: float
    excess_dn2: float
    variance_dn2: float
    variance_sigma_dn2: float
    pattern_dn2: float
    pattern_sigma_dn2: float
    pattern_chance_dn2: float
    clipped_low: float
    largest_dn: int
    at_end: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Level:
    """Flats, and the darks of their own time."""

    exposure: float
    light: Stack
    dark: Stack

    @property
    def signal_dn(self) -> float:
        """What light adds to the mean."""
        return self.light.mean_dn - self.dark.mean_dn

    @property
    def signal_sigma_dn(self) -> float:
        """The standard deviation of its estimate."""
        return math.hypot(self.light.mean_sigma_dn, self.dark.mean_sigma_dn)

    @property
    def added_dn2(self) -> float:
        """What light adds to the temporal variance; the lamp's drift scales what is uneven of it, which is no noise."""
        added_dn2 = self.light.variance_dn2 - self.dark.variance_dn2
        if self.signal_dn > SURE * self.signal_sigma_dn:
            drift = self.light.frames * max(self.light.excess_dn2, 0.0) / self.signal_dn**2
            added_dn2 -= drift * max(self.light.pattern_dn2 - self.dark.pattern_dn2, 0.0)
        return added_dn2

    @property
    def added_sigma_dn2(self) -> float:
        """The standard deviation of its estimate."""
        return math.hypot(self.light.variance_sigma_dn2, self.dark.variance_sigma_dn2)


def stack(frames: Sequence[Codes], channel: Chosen) -> Stack:
    """Reduce frames (rows, cols) to their statistics over the photosites where ``channel`` (rows, cols) is true.

    A frame's own mean is taken off before the temporal variance, as in EMVA 1288: the lamp's drift, or an offset of the
    frame, is no noise of photosites. Offsets of rows move that mean a little too: what they tell of it is given back.
    The scatter of rows and columns enters the standard deviations, so that offsets common to a row or a column are
    not taken for many independent numbers.
    """
    count, photosites = len(frames), int(np.count_nonzero(channel))
    if count < 2:
        raise InvalidValueError(f"{count}; two or more show what changes", key="frames")
    row, col = (_lines(channel, axis) for axis in (0, 1))
    rows, cols = int(row.max()) + 1, int(col.max()) + 1
    seen = [frame[channel] for frame in frames]
    largest = max(int(codes.max()) for codes in seen)
    low, at, below = (sum(int(np.count_nonzero(c == code)) for c in seen) for code in (0, largest, largest - 1))
    total, squares, means, means_of_rows = np.zeros(photosites), np.zeros(photosites), [], []
    for codes in seen:
        means.append(float(codes.mean(dtype=np.float64)))
        off: F64 = codes.astype(np.float64) - means[-1]
        total += off
        squares += off * off
        means_of_rows.append(_means(off, row))
    mean = total / count
    variance = (squares - count * mean * mean) / (count - 1)
    apart = float(variance.mean())
    if rows > 1:
        # Rows that a frame's read-out moves as a whole are so many numbers, whatever the frames are.
        of_rows = float(np.var(means_of_rows, axis=0, ddof=1).mean()) * rows / (rows - 1)
        temporal = apart + of_rows / rows
    else:
        of_rows, temporal = 0.0, apart * photosites / max(1, photosites - 1)
    between = float(np.var(means, ddof=1)) / count
    by_rows = max(temporal / photosites, of_rows / rows) / count
    spatial = float(mean.var(ddof=1))
    # What scatters from frame to frame scatters the mean, by so much less.
    scatter = apart * photosites / max(1, photosites - 1)
    temporal_sigma = max(_error_by_rows(variance, row), _error_by_chance(temporal, of_rows, (photosites, rows), count))
    of_cols, of_means = _variance_of_lines(mean, col), _variance_of_lines(mean, row)
    pattern_sigma = math.sqrt(
        2.0 / photosites * spatial**2
        + 2.0 / cols * of_cols**2
        + 2.0 / rows * of_means**2
        + (temporal_sigma / count) ** 2
    )
    return Stack(
        frames=count,
        mean_dn=float(np.mean(means)),
        mean_sigma_dn=math.sqrt(max(by_rows, between)),
        row_sigma_dn=math.sqrt(by_rows),
        excess_dn2=between - by_rows,
        variance_dn2=temporal,
        variance_sigma_dn2=temporal_sigma,
        pattern_dn2=spatial - scatter / count,
        pattern_sigma_dn2=pattern_sigma,
        pattern_chance_dn2=math.sqrt(
            _chance(spatial, scatter / count) / photosites
            + _chance(of_means, of_rows / count) / rows
            + (temporal_sigma / count) ** 2
        ),
        clipped_low=low / (count * photosites),
        largest_dn=largest,
        at_end=at / (count * photosites) if at > below else 0.0,
    )


def _error_by_chance(temporal: float, of_rows: float, numbers: tuple[int, int], count: int) -> float:
    """Return the standard deviation of a variance of so many frames: of what rows have in common, and of the rest."""
    photosites, rows = numbers
    rest = max(0.0, temporal - of_rows) if photosites > rows else 0.0
    parts = of_rows**2 / max(1, rows - 1) + rest**2 / max(1, photosites - rows)
    return math.sqrt(2.0 / (count - 1) * max(parts, temporal**2 / photosites))


def _chance(whole: float, noise: float) -> float:
    """Return by how much a variance of numbers of which noise is a part scatters when they are drawn anew, times them.

    >>> _chance(3.0, 0.0), _chance(1.0, 1.0)
    (0.0, 2.0)
    """
    return 2.0 * noise * (2.0 * max(whole - noise, 0.0) + noise)


def _lines(channel: Chosen, axis: int) -> I64:
    """Return which row (axis 0) or column (axis 1) of those that have any each photosite is in."""
    there = channel.any(axis=1 - axis)
    number: I64 = (np.cumsum(there) - 1)[np.nonzero(channel)[axis]]
    return number


def _means(values: F64, line: I64) -> F64:
    """Return the mean of each line."""
    means: F64 = np.bincount(line, values) / np.bincount(line)
    return means


def _error_by_rows(values: F64, row: I64) -> float:
    """Return the standard deviation of a mean over photosites, from the scatter of its rows."""
    rows = _means(values, row)
    return float(np.std(rows, ddof=1)) / math.sqrt(len(rows)) if len(rows) > 1 else 0.0


def _variance_of_lines(mean: F64, line: I64) -> float:
    """Return the variance that columns or rows have in common, beyond what chance gives."""
    lines = _means(mean, line)
    if len(lines) < 2:
        return 0.0
    # Chance is what differs within lines: what is common to them is no part of it.
    within = float(np.sum((mean - lines[line]) ** 2)) / max(1, len(mean) - len(lines))
    return max(0.0, float(lines.var(ddof=1)) - within * len(lines) / len(mean))
