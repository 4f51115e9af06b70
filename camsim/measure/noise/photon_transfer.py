"""Photon transfer: gain, read noise, full well, dark current, non-uniformities and linearity from flats and darks.

The quantities and regressions are those of EMVA Standard 1288, Release 4.0 Linear, from stacks of more than two
frames: temporal variance is the mean over photosites of the variance over frames. Every figure comes with the
standard deviation of its estimate.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from camsim.core.arrays import F64
from camsim.core.words import percent
from camsim.measure.noise.estimate import SURE, Estimate, no_figure, over, root_over
from camsim.measure.noise.fullness import full_well, not_full
from camsim.measure.noise.stack import Level, Stack

# EMVA 1288 R4.0: the gain from 0 to 70 % of saturation, linearity from 5 to 95 %.
LEAST_LEVELS = 3
"""Least levels within the range of linearity: any two lie on a line."""
_GAIN_UPTO, _LINEAR_FROM, _LINEAR_UPTO = 0.7, 0.05, 0.95
_LEAST_DARKS = 2
_ROUNDS = 3
"""Iterations of the gain, each weighted by the variances of the previous one."""


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
    """Return the signal µ that is as large as its own noise, µ² = σ² + µ: EMVA 1288's absolute sensitivity threshold.

    noise_e : temporal noise of the dark, including rounding of codes: √(σ_d² + σ_q²/K²), σ_q² = 1/12 DN²

    >>> round(sensitivity_threshold_e(2.0), 4)
    2.5616
    """
    return math.sqrt(noise_e**2 + 0.25) + 0.5


def photon_transfer(
    *, flats: Sequence[Level], darks: Sequence[tuple[float, Stack]], brightest: Level
) -> PhotonTransfer:
    """Return the figures of one channel.

    flats     : levels of light, increasing
    darks     : (exposure time in s, stack) without light, the shortest first
    brightest : flats in which every photosite is full, if any; else the last of the flats
    """
    dark = flats[0].dark
    reason = _why_no_noise(dark)
    gain_dn_per_e, shared_dn3 = (no_figure(reason), 0.0) if reason else _gain(flats, brightest, darks[0][1])
    if not gain_dn_per_e.measurable:
        nothing = gain_dn_per_e
        return PhotonTransfer(
            gain_dn_per_e=nothing,
            read_noise_e=nothing,
            full_well_e=nothing,
            dark_current_e_per_s=nothing,
            dsnu_e=nothing,
            prnu=nothing,
            linearity_error=_linearity(flats, brightest),
        )
    return PhotonTransfer(
        gain_dn_per_e=gain_dn_per_e,
        read_noise_e=_read_noise(darks[0][1], gain_dn_per_e, shared_dn3),
        full_well_e=full_well(brightest, gain_dn_per_e),
        dark_current_e_per_s=_dark_current(not_full(darks, brightest, gain_dn_per_e), gain_dn_per_e, of=len(darks)),
        dsnu_e=root_over(dark.pattern.dn2, (dark.pattern.sigma_dn2, dark.pattern.chance_dn2), gain_dn_per_e),
        prnu=_prnu(flats, brightest),
        linearity_error=_linearity(flats, brightest),
    )


def within_linearity(signal: F64, saturation: float) -> npt.NDArray[np.bool_]:
    """Return a mask of levels (n,) for linearity: 5 to 95 % of saturation."""
    inside: npt.NDArray[np.bool_] = (signal >= _LINEAR_FROM * saturation) & (signal <= _LINEAR_UPTO * saturation)
    return inside


def off_the_line(exposure: F64, signal: F64) -> float:
    """Return the mean absolute deviation from the line that minimises relative deviations, a fraction.

    >>> round(off_the_line(np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.1, 3.0])), 4)
    0.0199
    """
    line = np.stack([np.ones_like(exposure), exposure], axis=1)
    fitted = line @ np.linalg.lstsq(line / signal[:, None], np.ones_like(signal), rcond=None)[0]
    return float(np.mean(np.abs(signal / fitted - 1.0)))


def _why_no_noise(dark: Stack) -> str:
    if dark.clipped_low > 1e-4:
        return f"black is clipped: {percent(dark.clipped_low)} of dark codes are 0"
    noise_dn, least_dn = math.sqrt(max(dark.variance_dn2, 0.0)), math.sqrt(dark.rounding.least_dn2)
    if noise_dn < least_dn:
        return f"the dark noise of {noise_dn:.2g} DN is under {least_dn:.3g} DN: rounding hides it"
    return ""


def _gain(flats: Sequence[Level], brightest: Level, shortest: Stack) -> tuple[Estimate, float]:
    """Regress variance on signal through the origin, 0 to 70 % of saturation, each level by its own error.

    Levels with a common dark share its error, so they are not independent. Errors are computed from fitted variances:
    with measured ones, levels that are small by chance would dominate.

    Also returned: the covariance of the gain with the variance of the shortest dark, which may be one of those.
    """
    levels = [level for level in flats if level.signal_dn <= _GAIN_UPTO * brightest.signal_dn]
    if not levels:
        return no_figure("no flat lies within 70 % of saturation"), 0.0
    one = list({id(level.dark): level.dark for level in levels}.values())
    above = np.array([[level.dark is dark for dark in one] for level in levels], np.float64)
    signal = np.array([level.signal_dn for level in levels])
    added = np.array([level.added_dn2 for level in levels])
    exposed, dark = np.array([_both(level.light) for level in levels]), np.array([_both(each) for each in one])
    variance, below = exposed[:, 0], dark[:, 0]
    for _ in range(_ROUNDS):
        error, shared = variance * exposed[:, 1], below * dark[:, 1]
        covariance = np.diag(error**2) + (above * shared**2) @ above.T
        stated = np.linalg.solve(covariance, signal)
        information = float(signal @ stated)
        gain = float(stated @ added) / information
        rest = np.linalg.solve(covariance, added - gain * signal)
        below = np.maximum(dark[:, 0] + shared**2 * (rest @ above), 0.1 * dark[:, 0])
        variance = np.maximum(above @ below + gain * signal, 0.1 * exposed[:, 0])
    sigma = 1.0 / math.sqrt(information)
    if not gain > SURE * sigma:
        return no_figure("variance does not grow with the signal, as photon noise does"), 0.0
    common = sum(float(stated @ above[:, k]) * shared[k] ** 2 for k, each in enumerate(one) if each is shortest)
    return Estimate(gain, sigma), -common / information


def _both(level: Stack) -> tuple[float, float]:
    """Return a variance, at least that of rounding, and its relative error: duplicate frames have none."""
    variance_dn2 = max(level.variance_dn2, level.rounding.dn2)
    return variance_dn2, max(level.variance_sigma_dn2 / variance_dn2, 1e-6)


def _read_noise(dark: Stack, gain_dn_per_e: Estimate, shared_dn3: float) -> Estimate:
    """Return the noise of the shortest dark; the converter's rounding, a twelfth of a squared step, is subtracted.

    shared_dn3 : covariance of its variance and the gain, of which it may be a part
    """
    gain, squared = gain_dn_per_e.value, dark.variance_dn2 - dark.rounding.dn2
    if not squared > 0.0:
        return no_figure("rounding hides the noise of the shortest dark")
    each_dn2 = math.hypot(dark.variance_sigma_dn2, dark.rounding.sigma_dn2(dark.variance_dn2))
    one, by_gain = 0.5 * each_dn2 / squared, gain_dn_per_e.sigma / gain
    value = math.sqrt(squared) / gain
    return Estimate(value, value * math.sqrt(one**2 + by_gain**2 - shared_dn3 / (squared * gain)))


def _dark_current(darks: Sequence[tuple[float, Stack]], gain_dn_per_e: Estimate, *, of: int) -> Estimate:
    """Return the slope of darks' means over time.

    darks : those not full;  of: their original number
    """
    if of < _LEAST_DARKS:
        return no_figure("all darks are of one exposure time, and two tell it")
    if len(darks) < _LEAST_DARKS:
        return no_figure(f"{len(darks)} of {of} darks is not full, and two tell it; take shorter ones")
    time_s = np.array([time for time, _ in darks])
    mean = np.array([level.mean_dn for _, level in darks])
    # Weights from the scatter of a few frames' means would favour those that agree by chance.
    excess_dn2 = max(0.0, float(np.mean([level.excess_dn2 for _, level in darks])))
    weight = 1.0 / (np.array([level.row_sigma_dn for _, level in darks]) ** 2 + excess_dn2)
    centre = np.sum(weight * time_s) / np.sum(weight)
    information = float(np.sum(weight * (time_s - centre) ** 2))
    slope = float(np.sum(weight * (time_s - centre) * mean)) / information
    return over(slope, 1.0 / math.sqrt(information), gain_dn_per_e)


def _prnu(flats: Sequence[Level], brightest: Level) -> Estimate:
    """Return the pattern at half of saturation, minus that of the dark, over the signal; smooth parts are the light's.

    Under non-uniform light the pattern varies too, so the root mean square of the signal is used.
    """
    half = min(flats, key=lambda level: abs(level.signal_dn - 0.5 * brightest.signal_dn))
    light, dark = half.light, half.dark
    fine_dn2 = light.fine.dn2 - dark.fine.dn2
    smooth_dn2 = max(light.pattern.dn2 - dark.pattern.dn2 - fine_dn2, 0.0)
    errors = (
        math.hypot(light.fine.sigma_dn2, dark.fine.sigma_dn2),
        math.hypot(light.fine.chance_dn2, dark.fine.chance_dn2),
    )
    return root_over(
        fine_dn2, errors, Estimate(math.hypot(half.signal_dn, math.sqrt(smooth_dn2)), half.signal_sigma_dn)
    )


def _linearity(flats: Sequence[Level], brightest: Level) -> Estimate:
    exposure = np.array([level.exposure for level in flats])
    signal = np.array([level.signal_dn for level in flats])
    error = np.array([level.signal_sigma_dn for level in flats])
    used = within_linearity(signal, brightest.signal_dn)
    if np.count_nonzero(used) < LEAST_LEVELS:
        return no_figure(f"{np.count_nonzero(used)} levels lie within 5 to 95 % of saturation")
    return Estimate(off_the_line(exposure[used], signal[used]), float(np.mean(error[used] / signal[used])))
