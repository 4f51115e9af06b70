"""Figures from all settings together: patterns, rows, full well, dark current, hot photosites."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy.optimize

from camsim.core.arrays import F64
from camsim.files.hot_list import Hot
from camsim.measure.calibrate.darks import dark_statistics
from camsim.measure.calibrate.estimates import best_of, mean_of, root
from camsim.measure.calibrate.folder import Shot, ShotsOfCamera
from camsim.measure.calibrate.setting import Setting
from camsim.measure.noise import Estimate
from camsim.measure.noise.estimate import SURE, no_figure

_APART_C = 2.0


def pattern(settings: Sequence[Setting]) -> Estimate:
    """Return the fixed pattern of photosites from all darks, electrons: settings share it, with independent noise.

    The correlation between settings is estimated from blocks of rows.
    """
    blocks = np.stack([each.darks.pattern_blocks / each.gain_dn_per_e.value**2 for each in settings])
    scatter = np.atleast_2d(np.cov(blocks)) / blocks.shape[1]
    weight = np.linalg.solve(scatter, np.ones(len(blocks)))
    squared = Estimate(float(weight @ blocks.mean(axis=1) / weight.sum()), 1.0 / math.sqrt(float(weight.sum())))
    found = root(squared)
    shared = min(each.gain_dn_per_e.sigma / each.gain_dn_per_e.value for each in settings)
    return replace(found, sigma=math.hypot(found.sigma, found.value * shared)) if found.measurable else found


def columns(settings: Sequence[Setting]) -> Estimate:
    """Return the fixed pattern of columns, electrons, from the setting with the smallest error."""
    stated = []
    for setting in settings:
        squared, gain = setting.darks.columns, setting.gain_dn_per_e.value
        if squared.there:
            sigma_dn = math.sqrt(squared.dn2)
            by_gain = sigma_dn / gain * setting.gain_dn_per_e.sigma / gain
            stated.append(Estimate(sigma_dn / gain, math.hypot(0.5 * squared.sigma_dn2 / sigma_dn / gain, by_gain)))
        else:
            most = math.sqrt(max(squared.dn2, 0.0) + SURE * squared.null_dn2) / gain
            stated.append(no_figure("noise gives as much by chance; more darks tell more", at_most=most))
    known = [each for each in stated if each.measurable]
    return best_of(stated) if known else min(stated, key=lambda each: each.at_most)


def full_well(base: Setting) -> Estimate:
    """Return the full well over all channels, converted to electrons by the gain of the base setting."""
    gain, stated = base.gain_dn_per_e, []
    for channel in base.report.channels:
        its_gain, well = channel.transfer.gain_dn_per_e, channel.transfer.full_well_e
        if not well.measurable:
            return well
        alone = math.sqrt(max((well.sigma / well.value) ** 2 - (its_gain.sigma / its_gain.value) ** 2, 0.0))
        value = well.value * its_gain.value / gain.value
        stated.append(Estimate(value, value * max(alone, 1e-6)))
    mean = mean_of(stated)
    return Estimate(mean.value, math.hypot(mean.sigma, mean.value * gain.sigma / gain.value))


def rows(settings: Sequence[Setting], rows_of_frame: int) -> tuple[Estimate, Estimate]:
    """Return the temporal row noise in electrons, white and 1/f, from the power spectrum of row offsets."""
    white, pink = [], []
    for setting in settings:
        darks, gain = setting.darks, setting.gain_dn_per_e
        chance = darks.temporal.dn2 / darks.shape[1]
        frequency, power = darks.row_frequency, darks.row_power - chance
        freedom = max(darks.frames - 1, 1)
        design = np.stack([np.ones_like(frequency), 1.0 / frequency], axis=1)
        model = np.maximum(darks.row_power.mean(), 1e-12) * np.ones_like(power)
        for _ in range(4):
            weight = freedom / model**2
            covariance = np.linalg.inv(design.T @ (weight[:, None] * design))
            found = covariance @ (design.T @ (weight * power))
            model = np.maximum(design @ found + chance, 0.2 * darks.row_power.mean())
        surely = found[1] > SURE * math.sqrt(covariance[1, 1])
        scale = 1.0 / gain.value**2
        if surely:
            white.append(Estimate(found[0] * scale, math.sqrt(covariance[0, 0]) * scale))
            # As in ``FlickerRows``: over all frequencies of twice the frame's rows.
            of_frame = np.arange(1, rows_of_frame) / (2.0 * rows_of_frame)
            whole = (2.0 * np.sum(1.0 / of_frame) + 2.0) / (2.0 * rows_of_frame)
            pink.append(Estimate(found[1] * whole * scale, math.sqrt(covariance[1, 1]) * whole * scale))
        else:
            white.append(Estimate(darks.rows.dn2 * scale, darks.rows.sigma_dn2 * scale))
    flicker = root(mean_of(pink)) if pink else no_figure("the power of rows does not rise towards low frequencies")
    return root(mean_of(white)), flicker


def dark_current(shots: ShotsOfCamera, settings: Sequence[Setting]) -> tuple[Estimate, float, Estimate]:
    """Return the dark current in e⁻/s, the temperature at which it holds, and the warming that doubles it, °C."""
    gains = {each.iso: each.gain_dn_per_e.value for each in settings}
    of_iso: dict[float, dict[tuple[float, float | None], list[float]]] = {iso: {} for iso in gains}
    for shot in shots.shots:
        if shot.kind == "dark" and shot.iso in gains and shot.time_s is not None:
            key = shot.time_s, shot.temperature_c
            of_iso[shot.iso].setdefault(key, []).append(float(np.mean(shot.codes, dtype=np.float64)))

    def spans(iso: float) -> float:
        times = [time_s for time_s, _ in of_iso[iso]]
        return max(times) - min(times) if times else 0.0

    iso = max(gains, key=spans)
    points = of_iso[iso]
    no_temperature = no_figure("the darks have no two temperatures")
    if len({time_s for time_s, _ in points}) < 2:
        return no_figure("all darks are of one exposure time, and two tell it"), 25.0, no_temperature
    time_s = np.array([time for time, _ in points])
    mean = np.array([np.mean(each) for each in points.values()])
    scatter = [np.var(each, ddof=1) for each in points.values() if len(each) > 1]
    setting = next(each for each in settings if each.iso == iso)
    sigma = np.array([
        math.sqrt(max((float(np.mean(scatter)) if scatter else 0.0) / len(each), setting.darks.black_sigma_dn**2))
        for each in points.values()
    ])  # fmt: skip
    stated = [celsius for _, celsius in points if celsius is not None]
    degrees = np.array([25.0 if celsius is None else celsius for _, celsius in points])
    at_c = float(np.median(stated)) if stated else 25.0
    if len(stated) == len(points) and max(stated) - min(stated) >= _APART_C and len(points) > 3:

        def warm(_: F64, black: float, current: float, doubling: float) -> F64:
            dark: F64 = black + current * time_s * 2.0 ** ((degrees - at_c) / doubling)
            return dark

        slope = max(float(np.ptp(mean)) / float(time_s.max()), 1e-6)
        found, covariance = scipy.optimize.curve_fit(
            warm, time_s, mean, p0=(float(mean.min()), slope, 7.0), sigma=sigma, absolute_sigma=True,
            bounds=([-np.inf, 0.0, 1.0], [np.inf, np.inf, 100.0]),
        )  # fmt: skip
        error = math.sqrt(covariance[2, 2])
        doubling = Estimate(float(found[2]), error)
        if not error < 0.25 * found[2]:
            doubling = no_figure("the darks grow too little with the temperature")
    else:
        design = np.stack([np.ones_like(time_s), time_s], axis=1) / sigma[:, None]
        covariance = np.linalg.inv(design.T @ design)
        found, doubling = covariance @ (design.T @ (mean / sigma)), no_temperature
    gain = gains[iso]
    current = Estimate(float(found[1]) / gain, math.sqrt(covariance[1, 1]) / gain)
    if not current.value > SURE * current.sigma:
        most = max(current.value, 0.0) + SURE * current.sigma
        current = no_figure("the darks do not grow with their time", at_most=most)
    return current, at_c, doubling


def hot(shots: ShotsOfCamera, settings: Sequence[Setting]) -> tuple[Estimate, Estimate, tuple[Hot, ...]]:
    """Return the hot photosites of the longest darks: their share, their mean current, and a list with their places."""
    known = {each.iso: each.gain_dn_per_e.value for each in settings}
    darks: dict[tuple[float, float], list[Shot]] = {}
    for shot in shots.shots:
        if shot.kind == "dark" and shot.iso in known and shot.time_s is not None:
            darks.setdefault((shot.time_s, -shot.iso), []).append(shot)
    (time_s, iso), frames = max((key, each) for key, each in darks.items() if len(each) > 1)
    found = dark_statistics([shot.codes for shot in frames], shots.period)
    count = int(np.count_nonzero(found.hot))
    if not count:
        none = no_figure("no photosite is steadily far above the others")
        return none, none, ()
    e_per_s = found.hot_excess_dn / known[-iso] / time_s
    places = np.argwhere(found.hot) + shots.origin
    current = float(e_per_s.mean())
    return (
        Estimate(count / found.hot.size, math.sqrt(count) / found.hot.size),
        Estimate(current, current / math.sqrt(count)),
        tuple((int(row), int(col), float(each)) for (row, col), each in zip(places, e_per_s, strict=True)),
    )
