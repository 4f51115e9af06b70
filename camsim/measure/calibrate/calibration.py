"""Figures of a camera from a folder of flats and darks, each with its standard error."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from camsim.core.arrays import F64
from camsim.core.note import Note
from camsim.errors import UnsupportedError
from camsim.files.hot_list import Hot
from camsim.measure.calibrate import figures
from camsim.measure.calibrate.estimates import best_of, mean_of, root, without
from camsim.measure.calibrate.folder import ShotsOfCamera
from camsim.measure.calibrate.over_iso import OneSetting, ReadNoiseOverIso, read_noise_over_iso
from camsim.measure.calibrate.setting import Setting, gain_errors, linked, settings_of
from camsim.measure.calibrate.tails import LEAST_FRAMES, AtGain, Fitted, fit_after, fit_tails
from camsim.measure.noise import Estimate
from camsim.measure.noise.estimate import SURE, no_figure
from camsim.measure.noise.stack import Chosen, step_between_codes_dn

_BIT_DEPTHS = (8, 10, 12, 14, 16)
_WIDER = 1.1
_LEAST_LINES = 64


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Calibration:
    """The figures of a camera; each has a standard error, or a reason why it cannot be measured.

    settings  : measurements by increasing ISO setting, of which the first is the base
    bit_depth : the fewest bits that hold the codes;  largest_dn: the largest code
    cells_dn  : mean black levels over the period of the filter array
    read_noise_e, dual_read_noise_e : noise before the gain, without telegraph noise, at low and at high conversion gain
    law       : distribution of a photosite's noise, at ``law_setting``
    hot_fraction, hot_e_per_s, hot : hot photosites in the longest darks: their share, mean current, and (row, col,
                                     e_per_s) of each
    high      : figures of the high-gain images, if each exposure is read at both gains; the other figures are then
                those of the low-gain images, fixed patterns those of either
    notes     : remarks on the figures
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
    hot: tuple[Hot, ...]
    law: Fitted | None
    law_setting: Setting | None
    telegraph_fraction: Estimate
    telegraph_e: Estimate
    notes: tuple[Note, ...]
    high: Calibration | None = None

    @property
    def read_outs(self) -> tuple[Calibration, ...]:
        """This calibration; or two, of the low- and of the high-gain image, if each exposure is read at both gains."""
        if self.high is None:
            return (self,)
        return replace(self, shots=self.shots.read_outs[0], high=None), self.high


_PATTERNS = ("prnu", "dsnu_e", "column_noise_e", "dark_current_e_per_s", "doubling_c")


def calibrate(shots: ShotsOfCamera) -> Calibration:
    """Return the figures of the camera that took the frames; raises UnsupportedError in one sentence."""
    found, *others = (_calibrated(each) for each in shots.read_outs)
    for high in others:
        if high.settings[0].iso != found.settings[0].iso:
            message = f"low gain is calibrated from ISO {found.settings[0].iso:g} on, and high gain from ISO "
            raise UnsupportedError(f"{message}{high.settings[0].iso:g}; take both of the lowest", stage=shots.name)
        either: dict[str, Any] = {name: best_of([getattr(each, name) for each in (found, high)]) for name in _PATTERNS}
        notes = (
            *found.notes,
            *(replace(note, text=f"high gain: {note}") for note in high.notes if note not in found.notes),
        )
        bits = max(found.bit_depth, high.bit_depth)
        found = replace(found, shots=shots, bit_depth=bits, high=high, notes=notes, **either)
    return found


def _calibrated(shots: ShotsOfCamera) -> Calibration:
    notes: list[Note] = []
    step_dn = step_between_codes_dn(shot.codes for shot in shots.shots)
    settings = settings_of(shots, notes)
    errors, shared = gain_errors(settings)
    if shots.exposures_stated and (agreed := linked(settings)) is not None:
        settings, errors, shared = agreed
    base = settings[0]
    one = [_one(each, error, step_dn) for each, error in zip(settings, errors, strict=True)]
    over_iso = read_noise_over_iso(one, shared)
    law_setting, law = _law(settings, over_iso, step_dn, notes)
    # Normal noise and telegraph noise do not reveal which part arose before the gain.
    if law is not None and law_setting is not None and (law.shape.law != "normal" or law.shape.spread):
        after = _after(settings, law, law_setting, step_dn)
        with_it = read_noise_over_iso(one, shared, after)
        if with_it.misfit - over_iso.misfit < SURE**2:
            over_iso = with_it
    jumps_e2, fraction, amplitude_e = _jumps(law, law_setting)
    read_e = without(over_iso.before_e2, jumps_e2)
    dual_e = None if over_iso.dual_e2 is None else without(over_iso.dual_e2, jumps_e2)
    rows_e, flicker_e = figures.rows(settings, shots.rows)
    largest = max(int(shot.codes.max()) for shot in shots.shots)
    white = max(largest, int(shots.white_dn or 0), *shots.linear_dn)
    current, at_c, doubling = figures.dark_current(shots, settings)
    hot_fraction, hot_e_per_s, hot = figures.hot(shots, settings)
    if any(not shot.iso_stated for shot in shots.shots):
        text = "no file says its ISO setting, which is called 100 here; a column iso in index.csv tells it"
        notes.append(Note("iso-not-stated", text, "iso"))
    found = Calibration(
        shots=shots,
        settings=settings,
        bit_depth=next((bits for bits in _BIT_DEPTHS if white < 1 << bits), 16),
        step_dn=step_dn,
        largest_dn=white,
        black_dn=mean_of([Estimate(each.darks.black_dn, each.darks.black_sigma_dn) for each in settings]),
        cells_dn=base.darks.cells_dn,
        over_iso=over_iso,
        read_noise_e=read_e,
        dual_read_noise_e=dual_e,
        output_noise_dn=root(over_iso.after_dn2),
        row_noise_e=rows_e,
        flicker_rows_e=flicker_e,
        column_noise_e=figures.columns(settings),
        dsnu_e=figures.pattern(settings),
        prnu=best_of([mean_of([c.transfer.prnu for c in each.report.channels]) for each in settings]),
        full_well_e=figures.full_well(base),
        dark_current_e_per_s=current,
        dark_current_at_c=at_c,
        doubling_c=doubling,
        hot_fraction=hot_fraction,
        hot_e_per_s=hot_e_per_s,
        hot=hot,
        law=law,
        law_setting=law_setting,
        telegraph_fraction=fraction,
        telegraph_e=amplitude_e,
        notes=tuple(notes),
    )
    return _widened(found)


def _widened(found: Calibration) -> Calibration:
    """Return the figures with slightly larger errors: these are estimates of a selected model themselves."""

    def wider(each: Any) -> Any:
        return replace(each, sigma=_WIDER * each.sigma) if isinstance(each, Estimate) else each

    changed = {field.name: wider(getattr(found, field.name)) for field in fields(found)}
    settings = tuple(replace(each, gain_dn_per_e=wider(each.gain_dn_per_e)) for each in found.settings)
    law = found.law
    if law is not None:
        law = replace(law, errors={name: _WIDER * error for name, error in law.errors.items()})
    return Calibration(**changed | {"settings": settings, "law": law})


def _one(setting: Setting, gain_alone: float, step_dn: float) -> OneSetting:
    rounding = step_dn**2 / 12.0
    return OneSetting(
        iso=setting.iso,
        gain_dn_per_e=setting.gain_dn_per_e.value,
        gain_alone=gain_alone,
        dn2=setting.darks.temporal.dn2 - rounding,
        dn2_rows=setting.darks.temporal_rows - rounding,
    )


def _law(
    settings: Sequence[Setting], over_iso: ReadNoiseOverIso, step_dn: float, notes: list[Note]
) -> tuple[Setting | None, Fitted | None]:
    """Return the noise distribution, at a setting where noise before the gain dominates."""
    after = over_iso.after_dn2 if over_iso.after_dn2.measurable else Estimate(0.0, 0.0)

    def share(setting: Setting) -> float:
        return 1.0 - (max(after.value, 0.0) + step_dn**2 / 12.0) / setting.darks.temporal.dn2

    many = [each for each in settings if each.darks.frames >= LEAST_FRAMES]
    able = [each for each in many if each.darks.temporal.dn2 > 0.25 * step_dn**2]
    if not able:
        text = f"tails and jumps of the read noise are not looked for: that takes {LEAST_FRAMES} darks or more"
        notes.append(Note("few-darks", text, "readout"))
        return None, None
    best = max(able, key=share)
    rows = best.darks.rows
    period: tuple[int, int] = best.darks.cells_dn.shape
    used: Chosen = np.all(~best.darks.hot, axis=1)
    # Whole periods of the filter array, so that its cells stay aligned.
    blocks = used[: len(used) // period[0] * period[0]].reshape(-1, period[0]).all(axis=1).repeat(period[0])
    lines = np.pad(blocks, (0, len(used) - len(blocks))) if blocks.sum() > _LEAST_LINES else np.ones_like(used)
    frames = [np.asarray(codes)[lines].astype(np.int64) for codes in best.dark_codes]
    normal = max(after.value, 0.0) + max(rows.dn2, 0.0)
    sigma = math.hypot(after.sigma, rows.sigma_dn2)
    fixed = max(best.darks.pattern.dn2, 0.0) + max(best.darks.columns.dn2, 0.0)
    found = fit_tails(
        frames, step_dn=step_dn, normal_dn2=normal, normal_sigma_dn2=sigma, fixed_dn2=fixed,
        period=period,
    )  # fmt: skip
    return best, found


def _after(settings: Sequence[Setting], law: Fitted, law_setting: Setting, step_dn: float) -> Estimate:
    """Return the noise after the gain, from how far each setting shows the distribution of that before it."""
    darks = [
        AtGain(
            frames=[np.asarray(codes).astype(np.int64) for codes in each.dark_codes],
            gain_dn_per_e=each.gain_dn_per_e.value,
            each_dn2=each.darks.temporal.dn2 - step_dn**2 / 12.0,
            rows_dn2=max(each.darks.rows.dn2, 0.0),
        )
        for each in settings
        if each.darks.frames >= LEAST_FRAMES and not each.darks.hot.any()
    ]
    if not darks:
        return no_figure("too few darks")
    return fit_after(darks, law, law_setting.gain_dn_per_e.value, step_dn=step_dn)


def _jumps(law: Fitted | None, setting: Setting | None) -> tuple[Estimate, Estimate, Estimate]:
    """Return the mean variance of telegraph noise, e⁻², the share of photosites with it, and its mean amplitude, e⁻."""
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
