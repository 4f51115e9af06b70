"""Check of the filter order of a result: the possible order that it resembles most."""

from __future__ import annotations

import numpy as np

from camsim.core.arrays import F32, U8
from camsim.files.preview import demosaic
from camsim.measure.demosaic.scaling import Fault
from camsim.measure.demosaic.subject import CHANNELS, Subject, Used
from camsim.sensor.cfa import BAYER, Cfa

_LESS = 0.6
"""Ratio of residuals to that with the true order below which another order is reported."""

_LARGEST = 768


def order_fault(found: F32, subject: Subject) -> Fault | None:
    """Return the fault of swapped colours or a wrong phase of the array; None when the true order fits best.

    The mosaic is sampled from the truth and demosaiced bilinearly in every phase of the array. A result of any method
    resembles the one with the phase that it assumed, up to a factor in each channel.
    """
    index, window = subject.channel_index, _middle(subject)
    seen, used = found[window], subject.used[window]
    truth = subject.truth[window]
    straight = _residual(seen, truth, used)
    swapped = _residual(seen[..., ::-1], truth, used)
    if swapped < _LESS * straight:
        return _exchanged(subject.cfa)
    if index is None or subject.cfa is None:
        return None
    index = index[window]
    mosaic = np.take_along_axis(truth, index[..., None].astype(np.intp), axis=2)[..., 0]
    mosaic = mosaic * subject.neutral.astype(np.float32)[index]
    true = _residual(seen, _by(mosaic, index), used)
    best, least = "", true
    for name, other in _others(subject.cfa, subject.shape):
        residual = _residual(seen, _by(mosaic, other[window]), used)
        if residual < least:
            best, least = name, residual
    if best and least < _LESS * true:
        if best == _opposite(subject.cfa):
            return _exchanged(subject.cfa)
        return Fault("wrong phase", f"it was demosaiced as {best}, and the mosaic is {_statement(subject.cfa)}")
    return None


def _exchanged(cfa: tuple[str, ...] | None) -> Fault:
    also = f" (a phase of {_opposite(cfa)} does the same)" if cfa and "".join(cfa) in BAYER else ""
    return Fault("R and B are swapped", f"with red and blue exchanged it fits far better{also}")


def _middle(subject: Subject) -> tuple[slice, slice]:
    rows, cols = (slice(max(0, (size - _LARGEST) // 2), (size + _LARGEST) // 2) for size in subject.shape)
    return rows, cols


def _by(mosaic: F32, index: U8) -> F32:
    planes: F32 = np.moveaxis(demosaic(mosaic, index, len(CHANNELS)), 0, 2)
    return planes


def _residual(found: F32, wanted: F32, used: Used) -> float:
    """Return the residual variance of the result after the best factor and offset in each channel."""
    left = total = 0.0
    for k in range(wanted.shape[2]):
        a, b = wanted[..., k][used].astype(np.float64), found[..., k][used].astype(np.float64)
        a, b = a - a.mean(), b - b.mean()
        power = float(np.mean(a * a))
        both = max(float(np.mean(a * b)), 0.0)
        scale = float(np.mean(b * b)) or 1.0
        left += 1.0 - (both * both / power / scale if power > 0.0 else 0.0)
        total += 1.0
    return left / total


def _others(cfa: tuple[str, ...], shape: tuple[int, int]) -> list[tuple[str, U8]]:
    """Return the array shifted to every other origin, each order once."""
    found: dict[tuple[str, ...], U8] = {}
    base = Cfa(cfa)
    for row in range(len(cfa)):
        for col in range(len(cfa[0])):
            pattern = base.window_pattern((row, col))
            found.setdefault(pattern, Cfa(pattern).channel_index(*shape))
    found.pop(cfa, None)
    return [(_statement(pattern), index) for pattern, index in found.items()]


def _statement(cfa: tuple[str, ...]) -> str:
    return "".join(cfa) if len(cfa) <= 2 else "/".join(cfa)


def _opposite(cfa: tuple[str, ...]) -> str:
    return _statement(cfa).translate(str.maketrans("RB", "BR"))
