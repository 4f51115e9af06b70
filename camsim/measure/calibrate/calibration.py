"""From a folder's flats and darks to the figures of its camera, each with its standard error."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import scipy.optimize
import scipy.stats

from camsim.arrays import F64
from camsim.errors import UnsupportedError
from camsim.measure.calibrate.darks import DarkStatistics, dark_statistics
from camsim.measure.calibrate.folder import Shot, ShotsOfCamera
from camsim.measure.calibrate.over_iso import OneSetting, ReadNoiseOverIso, read_noise_over_iso
from camsim.measure.calibrate.tails import LEAST_FRAMES, AtGain, Fitted, fit_after, fit_tails
from camsim.measure.noise import Estimate, Group, NoiseReport, Shots, measure_noise
from camsim.measure.noise.estimate import SURE, no_figure
from camsim.measure.noise.shots import refuse_filters
from camsim.measure.noise.stack import Codes, step_between_codes_dn

_BIT_DEPTHS = (8, 10, 12, 14, 16)
_SAME_TIME = 1e-3
_APART_C = 2.0
_WIDER = 1.1
_CLOCK, _CHANCE = 2e-4, 1e-3
"""Relative error of light and time that an index says, at least; and of gains that disagree with it by chance."""
_LONG_S = 0.5
"""Of flats longer than this the charge that gathers without light is no longer negligible beside the black level."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Setting:
    """All of one ISO setting.

    darks      : of the shortest time that has several; dark_codes: those frames
    """

    iso: float
    gain_dn_per_e: Estimate
    report: NoiseReport
    darks: DarkStatistics
    dark_codes: tuple[Codes, ...]
    dark_time_s: float

    @property
    def electrons_per_dn(self) -> Estimate:
        """The gain as profiles have it."""
        gain = self.gain_dn_per_e
        return Estimate(1.0 / gain.value, gain.sigma / gain.value**2)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Calibration:
    """The figures of a camera; each has a standard error, or a reason why it cannot be told.

    settings  : the lowest ISO first, which is the base
    bit_depth : the fewest bits that hold the codes;  largest_dn: the largest code
    cells_dn  : means of black over the filter array
    read_noise_e, dual_read_noise_e : before the gain, without jumps, of the first mode and of the one from an ISO on
    law       : of a photosite's noise, at ``law_setting``
    hot_fraction, hot_e_per_s : share of photosites steadily far above the others in the longest darks
    notes     : what a reader of the figures should know
    """

    shots: ShotsOfCamera
    settings: tuple[Setting, ...]
    bit_depth: int
    step_dn: float
    largest_dn: int
    black_dn: Estimate
    cells_dn: F64
    over_iso: ReadNoiseOverIso
    read_noise_e: Estimate
    dual_read_noise_e: Estimate | None
    output_noise_dn: Estimate
    row_noise_e: Estimate
    flicker_rows_e: Estimate
    column_noise_e: Estimate
    dsnu_e: Estimate
    prnu: Estimate
    full_well_e: Estimate
    dark_current_e_per_s: Estimate
    dark_current_at_c: float
    doubling_c: Estimate
    hot_fraction: Estimate
    hot_e_per_s: Estimate
    law: Fitted | None
    law_setting: Setting | None
    telegraph_fraction: Estimate
    telegraph_e: Estimate
    notes: tuple[str, ...]


def calibrate(shots: ShotsOfCamera) -> Calibration:
    """Return the figures of the camera that took the frames; raises UnsupportedError in one sentence."""
    notes: list[str] = []
    step_dn = step_between_codes_dn(shot.codes for shot in shots.shots)
    settings = _settings(shots, notes)
    own, shared = _gain_errors(settings)
    if shots.exposures_said and (linked := _linked(settings)) is not None:
        settings, own, shared = linked
    base = settings[0]
    one = [_one(each, error, step_dn) for each, error in zip(settings, own, strict=True)]
    over_iso = read_noise_over_iso(one, shared)
    law_setting, law = _law(settings, over_iso, step_dn, notes)
    # Of normal noise and jumps nothing tells which part came before the gain.
    if law is not None and law_setting is not None and (law.shape.law != "normal" or law.shape.spread):
        after = _after(settings, law, law_setting, step_dn)
        with_it = read_noise_over_iso(one, shared, after)
        if with_it.misfit - over_iso.misfit < SURE**2:
            over_iso = with_it
    jumps_e2, fraction, amplitude_e = _jumps(law, law_setting)
    read_e = _without(over_iso.before_e2, jumps_e2)
    dual_e = None if over_iso.dual_e2 is None else _without(over_iso.dual_e2, jumps_e2)
    rows_e, flicker_e = _rows(settings, shots.rows)
    largest = max(int(shot.codes.max()) for shot in shots.shots)
    white = max(largest, int(shots.white_dn or 0))
    current, at_c, doubling = _dark_current(shots, settings, notes)
    hot_fraction, hot_e_per_s = _hot(shots, settings)
    if any(not shot.iso_said for shot in shots.shots):
        notes.append("no file says its ISO setting, which is called 100 here; a column iso in index.csv tells it")
    found = Calibration(
        shots=shots,
        settings=settings,
        bit_depth=next((bits for bits in _BIT_DEPTHS if white < 1 << bits), 16),
        step_dn=step_dn,
        largest_dn=white,
        black_dn=_mean([Estimate(each.darks.black_dn, each.darks.black_sigma_dn) for each in settings]),
        cells_dn=base.darks.cells_dn,
        over_iso=over_iso,
        read_noise_e=read_e,
        dual_read_noise_e=dual_e,
        output_noise_dn=_root(over_iso.after_dn2),
        row_noise_e=rows_e,
        flicker_rows_e=flicker_e,
        column_noise_e=_columns(settings),
        dsnu_e=_pattern(settings),
        prnu=_best([_mean([c.transfer.prnu for c in each.report.channels]) for each in settings]),
        full_well_e=_well(base),
        dark_current_e_per_s=current,
        dark_current_at_c=at_c,
        doubling_c=doubling,
        hot_fraction=hot_fraction,
        hot_e_per_s=hot_e_per_s,
        law=law,
        law_setting=law_setting,
        telegraph_fraction=fraction,
        telegraph_e=amplitude_e,
        notes=tuple(notes),
    )
    return _widened(found)


def _widened(found: Calibration) -> Calibration:
    """Return the figures with errors that are a little wider: they are estimates too, of a model that was chosen."""

    def wider(each: Any) -> Any:
        return replace(each, sigma=_WIDER * each.sigma) if isinstance(each, Estimate) else each

    changed = {field.name: wider(getattr(found, field.name)) for field in fields(found)}
    settings = tuple(replace(each, gain_dn_per_e=wider(each.gain_dn_per_e)) for each in found.settings)
    law = found.law
    if law is not None:
        law = replace(law, errors={name: _WIDER * error for name, error in law.errors.items()})
    return Calibration(**changed | {"settings": settings, "law": law})


def _settings(shots: ShotsOfCamera, notes: list[str]) -> tuple[Setting, ...]:
    """Return what each ISO setting shows; those that lack frames are left out, which a note says."""
    found: list[Setting] = []
    reason: UnsupportedError | None = None
    for iso in sorted({shot.iso for shot in shots.shots}):
        here = [shot for shot in shots.shots if shot.iso == iso]
        try:
            found.append(_setting(shots, iso, here, notes))
        except UnsupportedError as error:
            reason = error
            notes.append(f"ISO {iso:g} is left out: {error.message}")
    if not found:
        assert reason is not None
        raise reason
    return tuple(found)


def _setting(shots: ShotsOfCamera, iso: float, here: Sequence[Shot], notes: list[str]) -> Setting:
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
            note = f"ISO {iso:g}: flats have no darks of their own times; the nearest are taken off, with their charge"
            if note not in notes:
                notes.append(note)
            group = replace(group, time_s=nearest)
        matched.append(group)
    taken = Shots(name=name, channels=shots.channels, channel_index=shots.channel_index, groups=tuple(_merged(matched)))
    if not shots.filters_said:
        refuse_filters(taken)
    report = measure_noise(taken)
    gains = [channel.transfer.gain_dn_per_e for channel in report.channels]
    gain = _mean(gains)
    if not gain.measurable:
        raise UnsupportedError(f"its gain cannot be told: {gain.why_not}", stage=name)
    codes = tuple(darks[0].codes)
    return Setting(
        iso=iso,
        gain_dn_per_e=gain,
        report=report,
        darks=dark_statistics(codes, shots.period),
        dark_codes=codes,
        dark_time_s=darks[0].time_s,
    )


def _groups(here: Sequence[Shot], name: str, notes: list[str]) -> list[Group]:
    """Return frames taken alike, two or more of each; of several temperatures those of the most frames."""
    temperatures = [shot.temperature_c for shot in here]
    usual = max(set(temperatures), key=temperatures.count)
    keys: dict[tuple[str, float, float], list[Shot]] = {}
    for shot in here:
        if shot.temperature_c == usual:
            keys.setdefault((shot.kind, shot.exposure, _time(shot, name)), []).append(shot)
    alone = sum(1 for each in keys.values() if len(each) < 2)
    if alone:
        notes.append(f"{name}: {alone} frames have none taken alike, and are left out: two show the noise")
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
    """Return groups, those of one kind, exposure and time as one: flats whose times were taken for a dark's."""
    found: dict[tuple[str, float, float], Group] = {}
    for group in groups:
        key = group.kind, group.exposure, group.time_s
        before = found.get(key)
        found[key] = group if before is None else replace(before, codes=[*before.codes, *group.codes])
    return list(found.values())


def _gain_errors(settings: Sequence[Setting]) -> tuple[list[float], float]:
    """Return relative errors of gains that know nothing of one another, and what they have in common: nothing."""
    return [each.gain_dn_per_e.sigma / each.gain_dn_per_e.value for each in settings], 0.0


def _linked(settings: Sequence[Setting]) -> tuple[tuple[Setting, ...], list[float], float] | None:
    """Return settings whose gains agree with the signal that the same light gives at each; None where they do not.

    Signals over exposure tell the gains' ratios far better than photon noise does, which then tells one gain of all.
    Beside the settings: relative errors of each gain alone, and the one in common.
    """
    channels = range(len(settings[0].report.channels))

    def slopes(setting: Setting) -> tuple[F64, F64]:
        logs = [np.log(each.signal_dn / each.exposure) for each in setting.report.channels]
        return np.array([each.mean() for each in logs]), np.array([
            each.std(ddof=1) / math.sqrt(each.size) if each.size > 1 else math.inf for each in logs
        ])  # fmt: skip

    found = [slopes(setting) for setting in settings]
    ratio = np.array([np.mean([logs[c] - found[0][0][c] for c in channels]) for logs, _ in found])
    own = np.array([math.hypot(float(np.sqrt(np.mean(error**2))), _CLOCK) for _, error in found])
    photon, _ = _gain_errors(settings)
    logs = np.log([each.gain_dn_per_e.value for each in settings]) - ratio
    weight = 1.0 / (np.square(photon) + own**2)
    mean = float(np.sum(weight * logs) / np.sum(weight))
    misfit = float(np.sum(weight * (logs - mean) ** 2))
    if len(settings) < 2 or scipy.stats.chi2.sf(misfit, len(settings) - 1) < _CHANCE:
        return None
    shared = 1.0 / math.sqrt(float(np.sum(weight)))
    linked = []
    for setting, by, error in zip(settings, ratio, own, strict=True):
        gain = math.exp(mean + by)
        linked.append(replace(setting, gain_dn_per_e=Estimate(gain, gain * math.hypot(shared, error))))
    return tuple(linked), own.tolist(), shared


def _one(setting: Setting, gain_own: float, step_dn: float) -> OneSetting:
    rounding = step_dn**2 / 12.0
    return OneSetting(
        iso=setting.iso,
        gain_dn_per_e=setting.gain_dn_per_e.value,
        gain_own=gain_own,
        dn2=setting.darks.own.dn2 - rounding,
        dn2_rows=setting.darks.own_rows - rounding,
    )


def _law(
    settings: Sequence[Setting], over_iso: ReadNoiseOverIso, step_dn: float, notes: list[str]
) -> tuple[Setting | None, Fitted | None]:
    """Return the law of the noise, where that before the gain is the most of it."""
    after = over_iso.after_dn2 if over_iso.after_dn2.measurable else Estimate(0.0, 0.0)

    def share(setting: Setting) -> float:
        return 1.0 - (max(after.value, 0.0) + step_dn**2 / 12.0) / setting.darks.own.dn2

    able = [each for each in settings if each.darks.frames >= LEAST_FRAMES and each.darks.own.dn2 > 0.25 * step_dn**2]
    if not able:
        notes.append(f"tails and jumps of the read noise are not looked for: that takes {LEAST_FRAMES} darks or more")
        return None, None
    best = max(able, key=share)
    rows = best.darks.rows
    used = np.array(~best.darks.hot)
    lines = used.all(axis=1) if used.all(axis=1).sum() > 64 else np.ones(len(used), dtype=bool)
    frames = [np.asarray(codes)[lines].astype(np.int64) for codes in best.dark_codes]
    normal = max(after.value, 0.0) + max(rows.dn2, 0.0)
    sigma = math.hypot(after.sigma, rows.sigma_dn2)
    return best, fit_tails(frames, step_dn=step_dn, normal_dn2=normal, normal_sigma_dn2=sigma)


def _after(settings: Sequence[Setting], law: Fitted, law_setting: Setting, step_dn: float) -> Estimate:
    """Return the noise after the gain by what the settings show of the law of that before it."""
    darks = [
        AtGain(
            frames=[np.asarray(codes).astype(np.int64) for codes in each.dark_codes],
            gain_dn_per_e=each.gain_dn_per_e.value,
            own_dn2=each.darks.own.dn2 - step_dn**2 / 12.0,
            rows_dn2=max(each.darks.rows.dn2, 0.0),
        )
        for each in settings
        if each.darks.frames >= LEAST_FRAMES and not each.darks.hot.any()
    ]
    if not darks:
        return no_figure("too few darks")
    return fit_after(darks, law, law_setting.gain_dn_per_e.value, step_dn=step_dn)


def _jumps(law: Fitted | None, setting: Setting | None) -> tuple[Estimate, Estimate, Estimate]:
    """Return the mean variance of jumps, e⁻², the share of photosites that have them, and their mean size in e⁻."""
    if law is None or setting is None:
        none = no_figure("too few darks to tell jumps from tails")
        return Estimate(0.0, 0.0), none, none
    if not law.shape.fraction:
        none = no_figure("the darks ask for no jumps")
        return Estimate(0.0, 0.0), none, none
    gain = setting.gain_dn_per_e
    size, error = law.shape.amplitude_dn, law.errors["amplitude_dn"]
    amplitude = Estimate(size / gain.value, size / gain.value * math.hypot(error / size, gain.sigma / gain.value))
    jumps = Estimate(law.shape.telegraph_dn2 / gain.value**2, law.telegraph_sigma_dn2 / gain.value**2)
    return jumps, Estimate(law.shape.fraction, law.errors["fraction"]), amplitude


def _without(before_e2: Estimate, jumps_e2: Estimate) -> Estimate:
    return _root(Estimate(before_e2.value - jumps_e2.value, math.hypot(before_e2.sigma, jumps_e2.sigma)))


def _root(squared: Estimate) -> Estimate:
    """Return the root of a variance; a limit where it is not surely above 0."""
    if not squared.measurable:
        return squared
    if squared.value > SURE * squared.sigma:
        root = math.sqrt(squared.value)
        return Estimate(root, 0.5 * squared.sigma / root)
    most = math.sqrt(max(squared.value, 0.0) + SURE * squared.sigma)
    return no_figure(f"its square is within {SURE:g} standard errors of 0", at_most=most)


def _mean(told: Sequence[Estimate]) -> Estimate:
    """Return the mean of independent figures by their errors; that of those which disagree has a wider one."""
    known = [each for each in told if each.measurable]
    if not known:
        return told[0]
    if any(each.sigma == 0.0 for each in known):
        return known[0]
    weight = np.array([1.0 / each.sigma**2 for each in known])
    value = np.array([each.value for each in known])
    mean = float(np.sum(weight * value) / np.sum(weight))
    misfit = float(np.sum(weight * (value - mean) ** 2))
    wider = max(1.0, misfit / (len(known) - 1)) if len(known) > 1 else 1.0
    return Estimate(mean, math.sqrt(wider / float(np.sum(weight))))


def _best(told: Sequence[Estimate]) -> Estimate:
    """Return the figure of the least relative error: settings see the same photosites, and are not independent."""
    known = [each for each in told if each.measurable]
    return min(known, key=lambda each: each.sigma / each.value) if known else told[0]


def _pattern(settings: Sequence[Setting]) -> Estimate:
    """Return what photosites have of their own in all darks, electrons: settings see the same, with noise of their own.

    Blocks of rows tell how far the settings' figures go together.
    """
    blocks = np.stack([each.darks.pattern_blocks / each.gain_dn_per_e.value**2 for each in settings])
    scatter = np.atleast_2d(np.cov(blocks)) / blocks.shape[1]
    weight = np.linalg.solve(scatter, np.ones(len(blocks)))
    squared = Estimate(float(weight @ blocks.mean(axis=1) / weight.sum()), 1.0 / math.sqrt(float(weight.sum())))
    found = _root(squared)
    shared = min(each.gain_dn_per_e.sigma / each.gain_dn_per_e.value for each in settings)
    return replace(found, sigma=math.hypot(found.sigma, found.value * shared)) if found.measurable else found


def _columns(settings: Sequence[Setting]) -> Estimate:
    """Return what columns have of their own in all darks, electrons, of the setting that tells it best."""
    told = []
    for setting in settings:
        squared, gain = setting.darks.columns, setting.gain_dn_per_e.value
        if squared.there:
            root = math.sqrt(squared.dn2)
            by_gain = root / gain * setting.gain_dn_per_e.sigma / gain
            told.append(Estimate(root / gain, math.hypot(0.5 * squared.sigma_dn2 / root / gain, by_gain)))
        else:
            most = math.sqrt(max(squared.dn2, 0.0) + SURE * squared.null_dn2) / gain
            told.append(no_figure("noise gives as much by chance; more darks tell more", at_most=most))
    known = [each for each in told if each.measurable]
    return _best(told) if known else min(told, key=lambda each: each.at_most)


def _well(base: Setting) -> Estimate:
    """Return the full well of all channels, counted by the setting's gain."""
    gain, told = base.gain_dn_per_e, []
    for channel in base.report.channels:
        own, well = channel.transfer.gain_dn_per_e, channel.transfer.full_well_e
        if not well.measurable:
            return well
        alone = math.sqrt(max((well.sigma / well.value) ** 2 - (own.sigma / own.value) ** 2, 0.0))
        value = well.value * own.value / gain.value
        told.append(Estimate(value, value * max(alone, 1e-6)))
    mean = _mean(told)
    return Estimate(mean.value, math.hypot(mean.sigma, mean.value * gain.sigma / gain.value))


def _rows(settings: Sequence[Setting], rows_of_frame: int) -> tuple[Estimate, Estimate]:
    """Return what a row has of its own in a frame, white and 1/f, electrons, by the power over frequency."""
    white, pink = [], []
    for setting in settings:
        darks, gain = setting.darks, setting.gain_dn_per_e
        chance = darks.own.dn2 / darks.shape[1]
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
            # As ``FlickerRows`` has it: over all frequencies of twice the frame's rows.
            of_frame = np.arange(1, rows_of_frame) / (2.0 * rows_of_frame)
            whole = (2.0 * np.sum(1.0 / of_frame) + 2.0) / (2.0 * rows_of_frame)
            pink.append(Estimate(found[1] * whole * scale, math.sqrt(covariance[1, 1]) * whole * scale))
        else:
            white.append(Estimate(darks.rows.dn2 * scale, darks.rows.sigma_dn2 * scale))
    flicker = _root(_mean(pink)) if pink else no_figure("the power of rows does not rise towards low frequencies")
    return _root(_mean(white)), flicker


def _dark_current(
    shots: ShotsOfCamera, settings: Sequence[Setting], notes: list[str]
) -> tuple[Estimate, float, Estimate]:
    """Return the charge that gathers without light, e⁻/s, the temperature it holds at, and what doubles it, °C."""
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
    no_temperature = no_figure("no two temperatures are told")
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
    told = [celsius for _, celsius in points if celsius is not None]
    degrees = np.array([25.0 if celsius is None else celsius for _, celsius in points])
    at_c = float(np.median(told)) if told else 25.0
    if len(told) == len(points) and max(told) - min(told) >= _APART_C and len(points) > 3:

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


def _hot(shots: ShotsOfCamera, settings: Sequence[Setting]) -> tuple[Estimate, Estimate]:
    """Return the share of photosites that are steadily far above the others in the longest darks, and their current."""
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
        return none, none
    current = found.hot_excess_dn / known[-iso] / time_s
    return (
        Estimate(count / found.hot.size, math.sqrt(count) / found.hot.size),
        Estimate(current, current / math.sqrt(count)),
    )
