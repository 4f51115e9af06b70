"""Scaling of a result to the truth, and detection of faults of its levels.

On uniform ground, where all methods agree, a linear result is a + g·t in each channel. Equal g for all channels means
a balanced picture, g proportional to the response to white an unbalanced one; both are common, and no fault.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy

from camsim.core.arrays import F32, F64
from camsim.measure.demosaic.subject import CHANNELS, Subject

_BALANCE_OFF, _OFFSET_OFF, _EXPONENT_OFF = 0.02, 0.01, 0.08
_MOST_SAMPLES, _LEAST_SAMPLES = 200_000, 200
_WINDOW, _EVEN = 7, 0.03
_LEAST_SPREAD = 0.02

_SURE = 4.0
"""Standard errors within which a fault may be due to noise."""

_USUAL_OFFSET = 0.002
"""Typical black offset of a correct result relative to a diffuser; a few times as much is accepted."""

_TOGETHER = 10.0
"""Photosites with correlated noise in red and blue: methods interpolate these from every fourth or fifth."""


Places = tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]
"""Rows and columns of photosites."""


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault of a result as a whole: its name, and a sentence about it."""

    name: str
    sentence: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Scaled:
    """A result on the truth's scale.

    image    : (rows, cols, 3)
    scale    : by what it was divided: its value for a perfect diffuser
    balanced : whether it was white-balanced; otherwise it was also divided by the response to white
    """

    image: F32
    scale: float
    balanced: bool
    faults: tuple[Fault, ...]


def scaled(found: F32, subject: Subject) -> Scaled:
    """Scale a result to the truth by one factor, and name faults that a factor does not explain."""
    smooth = _smooth(subject)
    even = smooth[0].size >= _LEAST_SAMPLES
    # Without uniform ground, use sums: methods conserve total light.
    true, seen = (
        (image[smooth] if even else image[subject.used]).astype(np.float64) for image in (subject.truth, found)
    )
    rows, cols = smooth if even else np.nonzero(subject.used)
    places = rows, cols
    offset, gain = _lines(true, seen) if even else _levels(true, seen)
    offset_error, gain_error = _errors(true, seen, (offset, gain), places)
    faults = (_gamma(true, seen) or _black(offset, offset_error, gain)) if even else []
    if not faults:
        gain, gain_error = _without_fault(true, seen, (offset, offset_error), places)
    largest = float(np.max(np.abs(gain))) or 1.0
    shares = np.maximum(gain, 1e-6 * largest)
    unlike = [float(np.abs(np.log(shares / model / np.median(shares / model))).max()) for model in _models(subject)]
    balanced = unlike[0] <= unlike[1] + 1e-9
    model = _models(subject)[0 if balanced else 1]
    # Sums again: least squares would treat a blurred result as a darker one.
    sums = found[subject.used].sum(axis=0, dtype=np.float64), subject.truth[subject.used].sum(axis=0, dtype=np.float64)
    level = float(sums[0].sum() / (sums[1] * model).sum())
    if not level > 0.0:
        return Scaled(image=found, scale=1.0, balanced=balanced, faults=(_NO_LIKENESS,))
    white: F32 = (level * model).astype(np.float32)
    image: F32 = found / white
    # Errors of the channel and of the one it is compared with.
    chance = _SURE * math.sqrt(2.0) * float((gain_error / shares).max())
    if not faults and min(unlike) > max(_BALANCE_OFF, chance):
        factors = shares / model / float((shares / model)[1])
        stated = ", ".join(f"{name} {factor:.3g}" for name, factor in zip(CHANNELS, factors, strict=True))
        faults.append(Fault("wrong white balance", f"against green the channels are off by {stated}"))
    return Scaled(image=image, scale=level, balanced=balanced, faults=tuple(faults))


_NO_LIKENESS = Fault("no likeness", "its brightness does not go with the truth's: is it the same picture?")


def _models(subject: Subject) -> tuple[F64, F64]:
    return np.ones(3), subject.neutral / subject.neutral[1]


def _smooth(subject: Subject) -> Places:
    """Return rows and columns where the truth is locally uniform, so that all methods agree."""
    brightness = subject.truth.mean(axis=2)
    reach = scipy.ndimage.maximum_filter(brightness, _WINDOW) - scipy.ndimage.minimum_filter(brightness, _WINDOW)
    rows, cols = np.nonzero(subject.used & (reach <= _EVEN * float(brightness.max())))
    every = max(1, rows.size // _MOST_SAMPLES)
    return rows[::every], cols[::every]


def _levels(true: F64, seen: F64) -> tuple[F64, F64]:
    """Return offset (0) and gain of each channel, for a line through the origin."""
    return np.zeros(3), seen.mean(axis=0) / true.mean(axis=0)


def _lines(true: F64, seen: F64) -> tuple[F64, F64]:
    """Return offset and gain of each channel; through the origin if there is hardly more than one level."""
    offset, gain = _levels(true, seen)
    for k in range(3):
        t, r = true[:, k], seen[:, k]
        centred = t - t.mean()
        if float(np.std(t)) < _LEAST_SPREAD:
            continue
        gain[k] = float(np.mean(centred * r) / np.mean(centred * centred))
        offset[k] = float(r.mean() - gain[k] * t.mean())
    return offset, gain


def _errors(true: F64, seen: F64, line: tuple[F64, F64], places: Places) -> tuple[F64, F64]:
    """Return the standard errors of offset and gain of each channel; for a line through the origin only the gain."""
    errors = np.zeros((2, 3))
    for k, (offset, gain) in enumerate(zip(*line, strict=True)):
        t = true[:, k]
        left, mean = seen[:, k] - offset - gain * t, float(t.mean())
        if offset == 0.0:
            errors[1, k] = _scatter(left / (t.size * mean), places)
            continue
        centred = t - mean
        of_gain = centred * left / float(np.sum(centred * centred))
        errors[:, k] = _scatter(left / t.size - mean * of_gain, places), _scatter(of_gain, places)
    return errors[0], errors[1]


def _scatter(pull: F64, places: Places) -> float:
    """Return the standard error of a weighted sum of photosites with noise correlated in blocks or lines."""
    lines = (float(np.sum(np.bincount(place, pull) ** 2)) for place in places)
    return math.sqrt(max(_TOGETHER * float(np.sum(pull * pull)), *lines))


def _without_fault(true: F64, seen: F64, offset: tuple[F64, F64], places: Places) -> tuple[F64, F64]:
    """Return gains and their standard errors with the prior that black is nearly right."""
    zero, level = _levels(true, seen)
    _, error = _errors(true, seen, (zero, level), places)
    usual = (_USUAL_OFFSET * np.abs(level)) ** 2
    variance = np.where(offset[0] == 0.0, 0.0, offset[1] ** 2 * usual / (offset[1] ** 2 + usual + 1e-300))
    share = usual / (offset[1] ** 2 + usual + 1e-300)
    mean = true.mean(axis=0)
    return level - share * offset[0] / mean, np.sqrt(error**2 + variance / mean**2)


def _gamma(true: F64, seen: F64) -> list[Fault]:
    """Report a gamma encoding: r = c·t^p fits better than a line, and p is not 1."""
    exponents = []
    for k in range(3):
        t, r = true[:, k], seen[:, k]
        exposed = (t > 0.02) & (r > 0.0)
        if np.count_nonzero(exposed) < _LEAST_SAMPLES or float(np.std(t[exposed])) < 2.0 * _LEAST_SPREAD:
            continue
        x, y = np.log(t[exposed]), np.log(r[exposed])
        centred = x - x.mean()
        p = float(np.mean(centred * y) / np.mean(centred * centred))
        power = np.exp(y.mean() + p * centred) - r[exposed]
        offset, gain = _lines(true[exposed], seen[exposed])
        line = offset[k] + gain[k] * t[exposed] - r[exposed]
        if abs(p - 1.0) > _EXPONENT_OFF and float(np.mean(power**2)) < 0.7 * float(np.mean(line**2)):
            exponents.append(p)
    if len(exponents) < 2:
        return []
    p = float(np.median(exponents))
    like = ", as sRGB or 1/2.2 have" if 0.35 < p < 0.6 else ""
    way_out = "give linear numbers, or undo it with --gamma srgb or --gamma 2.2" if p < 1.0 else "give linear numbers"
    return [Fault("wrong gamma", f"its numbers go as the {p:.2f}th power of light{like}; {way_out}")]


def _black(offset: F64, error: F64, slope: F64) -> list[Fault]:
    held = np.maximum(slope, 1e-30)
    off, chance = (float(np.median(part / held)) for part in (offset, _SURE * error))
    if not math.isfinite(off) or abs(off) <= max(_OFFSET_OFF, chance):
        return []
    return [Fault("wrong black level", f"black has {off:+.1%} of a diffuser's level; subtract the black level")]
