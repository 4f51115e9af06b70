"""Read noise before and after the gain from darks of several ISO settings, and whether the conversion gain changes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg
import scipy.stats

from camsim.core.arrays import F64
from camsim.measure.noise.estimate import SURE, Estimate, no_figure

_CHANCE = 1e-2
"""Significance level for two conversion gains instead of one."""
_ROUNDS = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class OneSetting:
    """ISO, gain (DN/e⁻), and the variance of darks without rounding and row noise, DN².

    gain_alone : relative error of the gain that is independent of other settings
    dn2_rows : (rows,) the variance of each row of photosites, which settings share
    """

    iso: float
    gain_dn_per_e: float
    gain_alone: float
    dn2: float
    dn2_rows: F64


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReadNoiseOverIso:
    """Noise before the gain, e⁻², and after it, DN²; with dual gain also the second mode's noise and first ISO setting.

    misfit : χ² of the variances, and degrees of freedom; p: the p-value
    """

    before_e2: Estimate
    after_dn2: Estimate
    dual_from_iso: float | None
    dual_e2: Estimate | None
    misfit: float
    freedom: int

    def variance_dn2(self, setting: OneSetting) -> float:
        """Return the fitted variance of a setting."""
        high = self.dual_from_iso is not None and setting.iso >= self.dual_from_iso
        before = self.dual_e2 if high and self.dual_e2 is not None else self.before_e2
        value = before.value if before.measurable else 0.0
        after = self.after_dn2.value if self.after_dn2.measurable else 0.0
        return setting.gain_dn_per_e**2 * value + after


def read_noise_over_iso(
    settings: Sequence[OneSetting], gain_shared: float = 0.0, after_dn2: Estimate | None = None
) -> ReadNoiseOverIso:
    """Fit variance = gain² · before + after, with one conversion gain, or two if one does not fit.

    settings    : by increasing ISO
    gain_shared : relative error shared by all gains
    after_dn2   : independent estimate of the noise after the gain
    """
    fit = _best(settings, after_dn2)
    before, *dual = [
        Estimate(each.value, math.hypot(each.sigma, 2.0 * each.value * gain_shared))
        for each in (fit.before_e2, fit.dual_e2)
        if each is not None
    ]
    return replace(fit, before_e2=before, dual_e2=dual[0] if dual else None)


def _best(settings: Sequence[OneSetting], after_dn2: Estimate | None) -> ReadNoiseOverIso:
    single = _fit(settings, None, after_dn2)
    if len(settings) < 3 or single.freedom < 1 or _probable(single):
        return single
    # High conversion gain lowers read noise in electrons, and variances are not negative.
    tried = [_fit(settings, split, after_dn2) for split in range(1, len(settings))]
    sound = [each for each in tried if _sound(each)]
    best = min(sound, key=lambda each: each.misfit, default=None)
    better = best is not None and scipy.stats.chi2.sf(single.misfit - best.misfit, 1) < _CHANCE
    return best if best is not None and better else single


def _probable(fit: ReadNoiseOverIso) -> bool:
    return bool(scipy.stats.chi2.sf(fit.misfit, fit.freedom) > _CHANCE)


def _sound(fit: ReadNoiseOverIso) -> bool:
    assert fit.dual_e2 is not None
    surely_below = any(each.value < -SURE * each.sigma for each in (fit.before_e2, fit.dual_e2, fit.after_dn2))
    return not surely_below and fit.dual_e2.value < fit.before_e2.value


def _fit(settings: Sequence[OneSetting], split: int | None, after_dn2: Estimate | None) -> ReadNoiseOverIso:
    gain = np.array([each.gain_dn_per_e for each in settings])
    gain_sigma = gain * np.array([each.gain_alone for each in settings])
    measured = np.array([each.dn2 for each in settings])
    scatter = np.atleast_2d(np.cov([each.dn2_rows for each in settings])) / len(settings[0].dn2_rows)
    columns = [gain**2, np.ones_like(gain)] if len(settings) > 1 else [gain**2]
    if split is not None:
        high = np.arange(len(settings)) >= split
        columns = [np.where(high, 0.0, gain**2), columns[1], np.where(high, gain**2, 0.0)]
    design = np.stack(columns, axis=1)
    besides = after_dn2 is not None and after_dn2.measurable and len(settings) > 1
    if besides and after_dn2 is not None:
        design = np.vstack([design, np.eye(design.shape[1])[1]])
        measured = np.append(measured, after_dn2.value)
        scatter = scipy.linalg.block_diag(scatter, np.array([[after_dn2.sigma**2]]))
        gain, gain_sigma = np.append(gain, 0.0), np.append(gain_sigma, 0.0)
    before: F64 = measured / np.maximum(gain, 1e-12) ** 2
    for _ in range(_ROUNDS):
        # An error of the gain scales the contribution of noise before it.
        weight = np.linalg.inv(scatter + np.diag((2.0 * gain * np.maximum(before, 0.0) * gain_sigma) ** 2))
        covariance = np.linalg.inv(design.T @ weight @ design)
        found = covariance @ (design.T @ weight @ measured)
        low = np.full_like(gain, found[0])
        before = low if split is None else np.where(np.arange(len(gain)) >= split, found[2], low)
    rest = measured - design @ found
    misfit = float(rest @ weight @ rest)
    freedom = len(measured) - len(found)
    # If the settings do not follow the model, the errors are widened.
    wider = misfit / freedom if freedom and scipy.stats.chi2.sf(misfit, freedom) < _CHANCE else 1.0
    stated = [Estimate(float(v), math.sqrt(wider * float(covariance[k, k]))) for k, v in enumerate(found)]
    one = no_figure("one ISO setting tells no noise after the gain from that before it: all is taken as before it")
    return ReadNoiseOverIso(
        before_e2=stated[0],
        after_dn2=stated[1] if len(stated) > 1 else one,
        dual_from_iso=None if split is None else settings[split].iso,
        dual_e2=None if split is None else stated[2],
        misfit=misfit,
        freedom=freedom,
    )
