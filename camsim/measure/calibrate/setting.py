"""The frames of each ISO setting: groups of equal frames, the gain, and the darks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.stats

from camsim.core.arrays import F64
from camsim.core.note import Note
from camsim.errors import UnsupportedError
from camsim.measure.calibrate.darks import DarkStatistics, dark_statistics
from camsim.measure.calibrate.estimates import mean_of
from camsim.measure.calibrate.folder import Shot, ShotsOfCamera
from camsim.measure.noise import Estimate, Group, NoiseReport, Shots, measure_noise
from camsim.measure.noise.shots import refuse_filters
from camsim.measure.noise.stack import Codes

_SAME_TIME = 1e-3
_CLOCK, _CHANCE = 2e-4, 1e-3
"""Least relative error of light and time stated in an index; significance level for gains that disagree."""
_LONG_S = 0.5
"""In flats longer than this, dark charge is not negligible compared with the black level."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Setting:
    """Measurements of one ISO setting.

    darks      : statistics of the darks of the shortest time that has several frames;  dark_codes: these frames
    """

    iso: float
    gain_dn_per_e: Estimate
    report: NoiseReport
    darks: DarkStatistics
    dark_codes: tuple[Codes, ...]
    dark_time_s: float

    @property
    def electrons_per_dn(self) -> Estimate:
        """The gain as written in profiles."""
        gain = self.gain_dn_per_e
        return Estimate(1.0 / gain.value, gain.sigma / gain.value**2)


def settings_of(shots: ShotsOfCamera, notes: list[Note]) -> tuple[Setting, ...]:
    """Return the measurements of each ISO setting; those with too few frames are left out, with a note."""
    found: list[Setting] = []
    reason: UnsupportedError | None = None
    for iso in sorted({shot.iso for shot in shots.shots}):
        here = [shot for shot in shots.shots if shot.iso == iso]
        try:
            found.append(_setting(shots, iso, here, notes))
        except UnsupportedError as error:
            reason = error
            notes.append(Note("setting-left-out", f"ISO {iso:g} is left out: {error.message}", f"ISO {iso:g}"))
    if not found:
        assert reason is not None
        raise reason
    return tuple(found)


def _setting(shots: ShotsOfCamera, iso: float, here: Sequence[Shot], notes: list[Note]) -> Setting:
    name = f"{shots.name}, ISO {iso:g}"
    groups = _groups(here, name, notes)
    darks = sorted((group for group in groups if group.kind == "dark"), key=lambda group: group.time_s)
    if not darks:
        raise UnsupportedError("has no darks, or one alone; take two or more with the cap on", stage=name)
    times = [dark.time_s for dark in darks]
    matched = []
    for group in groups:
        nearest = min(times, key=lambda time_s: abs(math.log(time_s / group.time_s)))
        if group.kind != "dark" and abs(nearest / group.time_s - 1.0) > _SAME_TIME:
            if group.time_s > _LONG_S:
                raise UnsupportedError(
                    f"has flats of {group.time_s:g} s and no dark of that time; take darks as long as the flats",
                    stage=name,
                )
            text = f"ISO {iso:g}: flats have no darks of the same time; the nearest are taken off, with their charge"
            note = Note("other-darks", text, f"ISO {iso:g}")
            if note not in notes:
                notes.append(note)
            group = replace(group, time_s=nearest)
        matched.append(group)
    taken = Shots(name=name, channels=shots.channels, channel_index=shots.channel_index, groups=tuple(_merged(matched)))
    if not shots.filters_stated:
        refuse_filters(taken)
    report = measure_noise(taken)
    gains = [channel.transfer.gain_dn_per_e for channel in report.channels]
    gain = mean_of(gains)
    if not gain.measurable:
        raise UnsupportedError(f"its gain is not determined: {gain.why_not}", stage=name)
    codes = tuple(darks[0].codes)
    return Setting(
        iso=iso,
        gain_dn_per_e=gain,
        report=report,
        darks=dark_statistics(codes, shots.period),
        dark_codes=codes,
        dark_time_s=darks[0].time_s,
    )


def _groups(here: Sequence[Shot], name: str, notes: list[Note]) -> list[Group]:
    """Return groups of two or more equal frames; of several temperatures the one with most frames."""
    temperatures = [shot.temperature_c for shot in here]
    usual = max(set(temperatures), key=temperatures.count)
    keys: dict[tuple[str, float, float], list[Shot]] = {}
    for shot in here:
        if shot.temperature_c == usual:
            keys.setdefault((shot.kind, shot.exposure, _time(shot, name)), []).append(shot)
    alone = sum(1 for each in keys.values() if len(each) < 2)
    if alone:
        text = f"{name}: {alone} frames have none taken alike, and are left out: two show the noise"
        notes.append(Note("single-frames", text, name))
    return [
        Group(kind=each[0].kind, exposure=exposure, time_s=time_s, codes=[shot.codes for shot in each])
        for (_, exposure, time_s), each in keys.items()
        if len(each) > 1
    ]


def _time(shot: Shot, name: str) -> float:
    if shot.time_s is None:
        raise UnsupportedError(
            f"{shot.file!r} does not say its exposure time; give it in index.csv, column time_s", stage=name
        )
    return shot.time_s


def _merged(groups: Sequence[Group]) -> list[Group]:
    """Return groups, merging those of one kind, exposure and time, which arise when times were rounded to a dark's."""
    found: dict[tuple[str, float, float], Group] = {}
    for group in groups:
        key = group.kind, group.exposure, group.time_s
        before = found.get(key)
        found[key] = group if before is None else replace(before, codes=[*before.codes, *group.codes])
    return list(found.values())


def gain_errors(settings: Sequence[Setting]) -> tuple[list[float], float]:
    """Return the relative errors of gains that are independent of one another; the error that they share is 0."""
    return [each.gain_dn_per_e.sigma / each.gain_dn_per_e.value for each in settings], 0.0


def linked(settings: Sequence[Setting]) -> tuple[tuple[Setting, ...], list[float], float] | None:
    """Return settings with gains consistent with the signal of equal light; None if they are inconsistent.

    Signals over exposure determine the ratios of gains far better than photon noise, which then sets their common
    scale. Also returned: independent relative errors of the gains, and the shared one.
    """
    channels = range(len(settings[0].report.channels))

    def slopes(setting: Setting) -> tuple[F64, F64]:
        logs = [np.log(each.signal_dn / each.exposure) for each in setting.report.channels]
        return np.array([each.mean() for each in logs]), np.array([
            each.std(ddof=1) / math.sqrt(each.size) if each.size > 1 else math.inf for each in logs
        ])  # fmt: skip

    found = [slopes(setting) for setting in settings]
    ratio = np.array([np.mean([logs[c] - found[0][0][c] for c in channels]) for logs, _ in found])
    one = np.array([math.hypot(float(np.sqrt(np.mean(error**2))), _CLOCK) for _, error in found])
    photon, _ = gain_errors(settings)
    logs = np.log([each.gain_dn_per_e.value for each in settings]) - ratio
    weight = 1.0 / (np.square(photon) + one**2)
    mean = float(np.sum(weight * logs) / np.sum(weight))
    misfit = float(np.sum(weight * (logs - mean) ** 2))
    if len(settings) < 2 or scipy.stats.chi2.sf(misfit, len(settings) - 1) < _CHANCE:
        return None
    shared = 1.0 / math.sqrt(float(np.sum(weight)))
    agreed = []
    for setting, by, error in zip(settings, ratio, one, strict=True):
        gain = math.exp(mean + by)
        agreed.append(replace(setting, gain_dn_per_e=Estimate(gain, gain * math.hypot(shared, error))))
    return tuple(agreed), one.tolist(), shared
