"""Photon transfer: gain, read noise, full well, dark current, non-uniformities and linearity from flats and darks.

The quantities and regressions are those of EMVA Standard 1288, Release 4.0 Linear, from stacks of more than two
frames: temporal variance is the mean over photosites of the variance over frames. Every figure comes with the
standard deviation of its own estimate.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from camsim.arrays import F64, U16
from camsim.errors import InvalidValueError
from camsim.words import percent

LEAST_NOISE_DN = 0.5
"""Below this the rounding of codes is no longer noise of 1/12 DN² (EMVA 1288: σ_y,dark ≥ 0.49 DN)."""

SURE = 4.0
"""Standard errors: what is larger is no chance (one of 30 000)."""

# EMVA 1288 R4.0: the gain from 0 to 70 % of saturation, linearity from 5 to 95 %.
LEAST_LEVELS = 3
"""Within the range of linearity; any two lie on a line."""
_GAIN_UPTO, _LINEAR_FROM, _LINEAR_UPTO = 0.7, 0.05, 0.95


@dataclass(frozen=True, slots=True)
class Estimate:
    """A measured figure and the standard deviation of its estimate; or why there is none."""

    value: float
    sigma: float
    why_not: str = ""

    @property
    def measurable(self) -> bool:
        """Whether there is a figure."""
        return not self.why_not


@dataclass(frozen=True, slots=True, kw_only=True)
class Stack:
    """What is kept of several frames taken alike, over the photosites of one channel.

    mean_dn, mean_sigma_dn : mean code and the standard deviation of its estimate
    row_sigma_dn : the same as rows tell it, of which there are many;  excess_dn2: how much more the variance of
                   frames' means is than that: of few frames by chance, and less than none as often
    variance_dn2, variance_sigma_dn2 : temporal variance of a photosite, likewise
    pattern_dn2, pattern_sigma_dn2   : spatial variance of what stays, likewise
    clipped_low, clipped_high : fractions of codes at the converter's ends
    """

    mean_dn: float
    mean_sigma_dn: float
    row_sigma_dn: float
    excess_dn2: float
    variance_dn2: float
    variance_sigma_dn2: float
    pattern_dn2: float
    pattern_sigma_dn2: float
    clipped_low: float
    clipped_high: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PhotonTransfer:
    """The figures of one channel; gain in data numbers per electron, the rest in electrons or fractions."""

    gain_dn_per_e: Estimate
    read_noise_e: Estimate
    full_well_e: Estimate
    dark_current_e_per_s: Estimate
    dsnu_e: Estimate
    prnu: Estimate
    linearity_error: Estimate


def sensitivity_threshold_e(noise_e: float) -> float:
    """Return the signal that is as large as its own noise, µ² = σ² + µ: EMVA 1288's absolute sensitivity threshold.

    noise_e : temporal noise of the dark, the rounding of codes within it: √(σ_d² + σ_q²/K²), σ_q² = 1/12 DN²

    >>> round(sensitivity_threshold_e(2.0), 4)
    2.5616
    """
    return math.sqrt(noise_e**2 + 0.25) + 0.5


def stack(frames: Iterable[U16], channel: np.ndarray, *, largest_dn: int) -> Stack:
    """Reduce frames (rows, cols) to their statistics over the photosites where ``channel`` (rows, cols) is true.

    The scatter of rows and columns enters the standard deviations, so that offsets common to a row or a column are
    not taken for many independent numbers.
    """
    total, squares, count = np.zeros(channel.shape), np.zeros(channel.shape), 0
    means, rows_means, low, high = [], [], 0, 0
    in_row = channel.sum(axis=1)
    for frame in frames:
        codes = frame.astype(np.float64)
        total += codes
        squares += codes * codes
        seen = frame[channel]
        means.append(float(seen.mean()))
        rows_means.append(np.where(channel, codes, 0.0).sum(axis=1)[in_row > 0] / in_row[in_row > 0])
        low += int(np.count_nonzero(seen == 0))
        high += int(np.count_nonzero(seen == largest_dn))
        count += 1
    if count < 2:
        raise InvalidValueError(f"{count}; two or more show what changes", key="frames")
    photosites = int(np.count_nonzero(channel))
    mean = total / count
    variance = (squares - count * mean * mean) / (count - 1)
    temporal = float(variance[channel].mean())
    between = float(np.var(means, ddof=1)) / count
    # Rows that a frame's read-out moves as a whole are so many numbers, whatever the frames are.
    by_rows = max(temporal / photosites, float(np.var(rows_means, axis=0, ddof=1).mean()) / len(rows_means[0])) / count
    average = mean[channel]
    spatial = float(average.var(ddof=1))
    pattern = spatial - temporal / count
    columns = _variance_of_lines(mean, channel, axis=0)
    rows = _variance_of_lines(mean, channel, axis=1)
    pattern_sigma = math.sqrt(
        2.0 / photosites * spatial**2 + 2.0 / channel.shape[1] * columns**2 + 2.0 / channel.shape[0] * rows**2
    )
    return Stack(
        mean_dn=float(np.mean(means)),
        mean_sigma_dn=math.sqrt(max(by_rows, between)),
        row_sigma_dn=math.sqrt(by_rows),
        excess_dn2=between - by_rows,
        variance_dn2=temporal,
        variance_sigma_dn2=max(_error_by_rows(variance, channel), temporal * math.sqrt(2.0 / (count - 1) / photosites)),
        pattern_dn2=pattern,
        pattern_sigma_dn2=pattern_sigma,
        clipped_low=low / (count * photosites),
        clipped_high=high / (count * photosites),
    )


def photon_transfer(
    *,
    flats: Sequence[tuple[float, Stack]],
    dark: Stack,
    darks: Sequence[tuple[float, Stack]],
    clipped: Stack,
    largest_dn: int,
) -> PhotonTransfer:
    """Return the figures of one channel.

    flats      : (exposure in any unit, stack), ten or more levels of light at one exposure time
    dark       : the stack without light at that exposure time
    darks      : (exposure time in s, stack) without light
    clipped    : flats so bright that every photosite is full
    largest_dn : the converter's last code
    """
    reason = _why_no_noise(dark)
    gain_dn_per_e = Estimate(math.nan, math.nan, reason) if reason else _gain(flats, dark, clipped)
    if not gain_dn_per_e.measurable:
        nothing = gain_dn_per_e
        return PhotonTransfer(
            gain_dn_per_e=nothing,
            read_noise_e=nothing,
            full_well_e=nothing,
            dark_current_e_per_s=nothing,
            dsnu_e=nothing,
            prnu=nothing,
            linearity_error=_linearity(flats, dark, clipped),
        )
    return PhotonTransfer(
        gain_dn_per_e=gain_dn_per_e,
        read_noise_e=_read_noise(darks[0][1], gain_dn_per_e),
        full_well_e=_full_well(clipped, dark, gain_dn_per_e, largest_dn),
        dark_current_e_per_s=_dark_current(darks, gain_dn_per_e),
        dsnu_e=_root(dark.pattern_dn2, dark.pattern_sigma_dn2, gain_dn_per_e),
        prnu=_prnu(flats, dark, clipped),
        linearity_error=_linearity(flats, dark, clipped),
    )


def within_linearity(signal: F64, saturation: float) -> npt.NDArray[np.bool_]:
    """Return which levels (n,) tell the linearity: 5 to 95 % of saturation."""
    inside: npt.NDArray[np.bool_] = (signal >= _LINEAR_FROM * saturation) & (signal <= _LINEAR_UPTO * saturation)
    return inside


def off_the_line(exposure: F64, signal: F64) -> float:
    """Return the mean absolute deviation from the line whose relative deviations are least, a fraction.

    >>> round(off_the_line(np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.1, 3.0])), 4)
    0.0199
    """
    line = np.stack([np.ones_like(exposure), exposure], axis=1)
    fitted = line @ np.linalg.lstsq(line / signal[:, None], np.ones_like(signal), rcond=None)[0]
    return float(np.mean(np.abs(signal / fitted - 1.0)))


def _why_no_noise(dark: Stack) -> str:
    if dark.clipped_low > 1e-4:
        return f"black is clipped: {percent(dark.clipped_low)} of dark codes are 0"
    noise_dn = math.sqrt(max(dark.variance_dn2, 0.0))
    if noise_dn < LEAST_NOISE_DN:
        return f"the dark noise of {noise_dn:.2g} DN is under {LEAST_NOISE_DN} DN: rounding hides it"
    return ""


def _gain(flats: Sequence[tuple[float, Stack]], dark: Stack, clipped: Stack) -> Estimate:
    """Regress variance on signal through the origin, 0 to 70 % of saturation, each level by its own error."""
    most_dn = _GAIN_UPTO * (clipped.mean_dn - dark.mean_dn)
    levels = [level for _, level in flats if level.mean_dn - dark.mean_dn <= most_dn]
    if not levels:
        return Estimate(math.nan, math.nan, "no flat lies within 70 % of saturation")
    signal = np.array([level.mean_dn - dark.mean_dn for level in levels])
    variance = np.array([level.variance_dn2 - dark.variance_dn2 for level in levels])
    error = np.array([math.hypot(level.variance_sigma_dn2, dark.variance_sigma_dn2) for level in levels])
    weight = 1.0 / error**2
    information = float(np.sum(weight * signal**2))
    gain, sigma = float(np.sum(weight * signal * variance)) / information, 1.0 / math.sqrt(information)
    if not gain > SURE * sigma:
        return Estimate(math.nan, math.nan, "variance does not grow with the signal, as photon noise does")
    return Estimate(gain, sigma)


def _read_noise(dark: Stack, gain_dn_per_e: Estimate) -> Estimate:
    """Return the noise of the shortest dark; the converter's rounding, a twelfth of a squared code, is taken off."""
    return _root(dark.variance_dn2 - 1.0 / 12.0, dark.variance_sigma_dn2, gain_dn_per_e)


def _full_well(clipped: Stack, dark: Stack, gain_dn_per_e: Estimate, largest_dn: int) -> Estimate:
    if clipped.clipped_high > 1e-4:
        reach_e = (largest_dn - dark.mean_dn) / gain_dn_per_e.value
        return Estimate(math.nan, math.nan, f"the converter ends at {reach_e:.0f} e⁻, before the well is full")
    return _over(clipped.mean_dn - dark.mean_dn, math.hypot(clipped.mean_sigma_dn, dark.mean_sigma_dn), gain_dn_per_e)


def _dark_current(darks: Sequence[tuple[float, Stack]], gain_dn_per_e: Estimate) -> Estimate:
    time_s = np.array([time for time, _ in darks])
    mean = np.array([level.mean_dn for _, level in darks])
    # Weighed by what a few frames' means scatter, those that agree by chance would count for the others.
    excess_dn2 = max(0.0, float(np.mean([level.excess_dn2 for _, level in darks])))
    weight = 1.0 / (np.array([level.row_sigma_dn for _, level in darks]) ** 2 + excess_dn2)
    centre = np.sum(weight * time_s) / np.sum(weight)
    information = float(np.sum(weight * (time_s - centre) ** 2))
    slope = float(np.sum(weight * (time_s - centre) * mean)) / information
    return _over(slope, 1.0 / math.sqrt(information), gain_dn_per_e)


def _prnu(flats: Sequence[tuple[float, Stack]], dark: Stack, clipped: Stack) -> Estimate:
    """Return the pattern at half of saturation, less that of the dark, over the signal."""
    half_dn = 0.5 * (clipped.mean_dn - dark.mean_dn)
    _, level = min(flats, key=lambda flat: abs(flat[1].mean_dn - dark.mean_dn - half_dn))
    signal = level.mean_dn - dark.mean_dn
    squared = (level.pattern_dn2 - dark.pattern_dn2) / signal**2
    sigma = math.hypot(level.pattern_sigma_dn2, dark.pattern_sigma_dn2) / signal**2
    return _root(squared, sigma, Estimate(1.0, 0.0))


def _linearity(flats: Sequence[tuple[float, Stack]], dark: Stack, clipped: Stack) -> Estimate:
    exposure = np.array([exposure for exposure, _ in flats])
    signal = np.array([level.mean_dn - dark.mean_dn for _, level in flats])
    error = np.array([math.hypot(level.mean_sigma_dn, dark.mean_sigma_dn) for _, level in flats])
    used = within_linearity(signal, clipped.mean_dn - dark.mean_dn)
    if np.count_nonzero(used) < LEAST_LEVELS:
        return Estimate(math.nan, math.nan, f"{np.count_nonzero(used)} levels lie within 5 to 95 % of saturation")
    return Estimate(off_the_line(exposure[used], signal[used]), float(np.mean(error[used] / signal[used])))


def _over(value_dn: float, sigma_dn: float, gain_dn_per_e: Estimate) -> Estimate:
    value, share = value_dn / gain_dn_per_e.value, gain_dn_per_e.sigma / gain_dn_per_e.value
    return Estimate(value, math.hypot(sigma_dn / gain_dn_per_e.value, value * share))


def _root(squared_dn2: float, sigma_dn2: float, gain_dn_per_e: Estimate) -> Estimate:
    """Return the root of a variance in electrons, 0 where chance has made it negative."""
    root_dn = math.sqrt(max(squared_dn2, 0.0))
    # Near zero the root's error is that of a variance within one of its own errors.
    sigma_dn = 0.5 * sigma_dn2 / max(root_dn, 0.5 * math.sqrt(sigma_dn2))
    return _over(root_dn, sigma_dn, gain_dn_per_e)


def _error_by_rows(values: F64, channel: np.ndarray) -> float:
    """Return the standard deviation of a mean over photosites, from the scatter of its rows."""
    rows = [values[r][channel[r]].mean() for r in range(len(values)) if channel[r].any()]
    return float(np.std(rows, ddof=1)) / math.sqrt(len(rows)) if len(rows) > 1 else 0.0


def _variance_of_lines(mean: F64, channel: np.ndarray, axis: int) -> float:
    """Return the variance that columns (axis 0) or rows (axis 1) have in common, beyond what chance gives."""
    count = channel.sum(axis=axis)
    there = count > 0
    if np.count_nonzero(there) < 2:
        return 0.0
    lines = np.sum(np.where(channel, mean, 0.0), axis=axis) / np.maximum(count, 1)
    apart = np.where(channel, mean - np.expand_dims(lines, axis), 0.0)
    # Chance is what differs within lines: what is common to them is no part of it.
    within = float(np.sum(apart**2)) / max(1, int(count.sum()) - int(np.count_nonzero(there)))
    return max(0.0, float(lines[there].var(ddof=1)) - within / float(count[there].mean()))
