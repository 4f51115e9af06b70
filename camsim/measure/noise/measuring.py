"""The figures of flats and darks, from the stack of every channel without its defective photosites."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from typing import Annotated

import numpy as np

from camsim.core.annotations import Called
from camsim.core.arrays import F64, U8, distinct
from camsim.core.note import Note
from camsim.core.typed import check
from camsim.errors import UnsupportedError
from camsim.measure.noise.estimate import SURE, Estimate, no_figure
from camsim.measure.noise.fullness import saturation
from camsim.measure.noise.photon_transfer import PhotonTransfer, photon_transfer, sensitivity_threshold_e
from camsim.measure.noise.result import BENT, ChannelNoise, NoiseReport, Spectrogram
from camsim.measure.noise.shots import Group, Shots
from camsim.measure.noise.stack import Chosen, Codes, Level, Photosites, Rounding, Stack, stack, step_between_codes_dn

_LEAST_FLATS, _LEAST_FRAMES = 4, 2
_SAME_TIME = 1e-3
_DEFECT = 8.0
_DARKER = 0.05
"""Relative decrease of a flat's signal to report: less occurs near saturation, which linearity also excludes."""
_ONE_CODE = 1.0
"""Steps within which an outlier may be due to rounding if the noise is small."""

_BENT = 0.005
"""Relative non-linearity to report: less may come from lamps and clocks."""

_DECIBELS = 20.0 / math.log(10.0)

_SHOTS = Annotated[Shots, Called("Shots", "take_shots of a camera or read_shots of a folder gives them")]


def measure_noise(shots: Shots, *, expected: Mapping[str, dict[str, float]] | None = None) -> NoiseReport:
    """Return the figures of EMVA 1288 R4 of every channel.

    expected : expected figures by channel, for comparison

    Raises UnsupportedError if the frames do not determine them.
    """
    check(shots, _SHOTS, "shots")
    step_dn = step_between_codes_dn(codes for group in shots.groups for codes in group.codes)
    rounding = Rounding(step_dn=step_dn, summed=shots.summed)
    _refuse(shots, rounding)
    flats, darks, index = shots.of("flat"), shots.of("dark"), shots.channel_index
    brightest = (shots.of("clipped") or flats)[-1]
    half = flats[len(flats) // 2]
    good = _healthy(_longest(darks, brightest, index), index, step_dn) & _healthy(half, index, step_dn)
    channels = []
    for number, name in enumerate(shots.channels):
        here = Photosites((index == number) & good)
        darks_of = [(group.time_s, stack(group.codes, here, rounding)) for group in darks]
        levels = [
            Level(exposure=g.exposure, light=stack(g.codes, here, rounding), dark=_at(darks_of, g.time_s))
            for g in (flats if brightest is flats[-1] else (*flats, brightest))
        ]
        seen, full = levels[: len(flats)], levels[-1]
        _refuse_unlit(shots.name, name, [*zip((*flats, brightest), (*seen, full), strict=True)])
        found = photon_transfer(flats=seen, darks=darks_of, brightest=full)
        threshold_e, saturation_e, snr_max_db, dynamic_range_db = _range(found, full)
        signal = np.array([level.signal_dn for level in seen])
        # Every flat has the dark of its exposure time; its difference from the first flat's is subtracted.
        added = np.array([level.added_dn2 for level in seen])
        channels.append(
            ChannelNoise(
                channel=name,
                photosites=len(here),
                defects_left_out=int(np.count_nonzero((index == number) & ~good)),
                transfer=found,
                sensitivity_threshold_e=threshold_e,
                saturation_e=saturation_e,
                snr_max_db=snr_max_db,
                dynamic_range_db=dynamic_range_db,
                exposure=np.array([level.exposure for level in seen]),
                signal_dn=signal,
                variance_dn2=added,
                snr=signal / np.sqrt(np.maximum(added + seen[0].dark.variance_dn2, 1e-12)),
                dark=_spectrogram(_nearest_dark(darks, flats[0].time_s), index == number, good),
                flat=_spectrogram(half, index == number, good),
                expected=None if expected is None else dict(expected[name]),
                notes=_notes(found, rounding),
            )
        )
    return NoiseReport(
        source=shots.name,
        rows=index.shape[0],
        cols=index.shape[1],
        frames=sum(len(group.codes) for group in shots.groups),
        channels=tuple(channels),
    )


def _notes(found: PhotonTransfer, rounding: Rounding) -> tuple[Note, ...]:
    """Return remarks on the figures."""
    error, gain = found.linearity_error, found.gain_dn_per_e
    notes = []
    if gain.measurable and error.measurable and error.value - SURE * error.sigma > _BENT:
        text = (
            f"{BENT}: the signal is off the line (see the linearity error), so that the gain, and by it all that is "
            "counted in electrons, is another at every signal, and several times as far off"
        )
        notes.append(Note(BENT, text, "linearity_error"))
    if rounding.summed is None and found.read_noise_e.measurable:
        text = (
            "codes are wider than 16 bits and nobody says of how many frames they are sums: the read noise is that of "
            "single ones, its error has in it what sums would round; a column summed in the index tells"
        )
        notes.append(Note("sums-not-stated", text, "summed"))
    return tuple(notes)


def _refuse(shots: Shots, rounding: Rounding) -> None:
    flats, darks = shots.of("flat"), shots.of("dark")
    if len(flats) < _LEAST_FLATS:
        raise UnsupportedError(
            f"has {len(flats)} levels of light; {_LEAST_FLATS} flats of different exposure or more are needed",
            stage=shots.name,
        )
    if not darks:
        raise UnsupportedError("has no darks; take some as long as the flats", stage=shots.name)
    for group in shots.groups:
        if len(group.codes) < _LEAST_FRAMES:
            raise UnsupportedError(
                f"has one {group.kind} at exposure {group.exposure:g} and {group.time_s:g} s; two alike show the noise",
                stage=shots.name,
            )
    for group in (*flats, *shots.of("clipped")):
        if not any(abs(dark.time_s / group.time_s - 1.0) < _SAME_TIME for dark in darks):
            raise UnsupportedError(
                f"has flats of {group.time_s:g} s and no dark of that time; take darks as long as the flats",
                stage=shots.name,
            )
    # The brightest one may be full: it gives the saturation.
    full = sum(_ended(group) for group in flats)
    if len(flats) - full < _LEAST_FLATS - 1:
        raise UnsupportedError(
            f"has {full} of {len(flats)} flats clipped by the converter; expose them less", stage=shots.name
        )
    _refuse_copies(shots, rounding)


def _refuse_copies(shots: Shots, rounding: Rounding) -> None:
    """Raise for duplicate frames: they have no noise between them, which would bias the group's noise.

    If even the shortest dark scatters over codes, no two frames are equal unless they are full.
    """
    darks = shots.of("dark")
    if _scatter_dn(min(darks, key=lambda dark: dark.time_s)) ** 2 < rounding.least_dn2:
        return
    for group in (*shots.of("flat")[:-1], *darks):
        different = _different([codes[:1] for codes in group.codes])
        if different < len(group.codes):
            different = _different(group.codes)
        if different < len(group.codes) and not _ended(group):
            raise UnsupportedError(
                f"has {len(group.codes)} frames of kind {group.kind} at exposure {group.exposure:g} and "
                f"{group.time_s:g} s, of which {different} differ: copies show no noise; give each frame once",
                stage=shots.name,
            )


def _different(frames: Sequence[Codes]) -> int:
    """Return the number of frames without copies."""
    return len({hashlib.blake2b(np.ascontiguousarray(codes).data).digest() for codes in frames})


def _scatter_dn(group: Group) -> float:
    """Return the largest standard deviation of the difference between the first frame and another."""
    first = group.codes[0].astype(np.float64)
    return max(float(np.std(codes - first)) for codes in group.codes[1:]) / math.sqrt(2.0)


def _refuse_unlit(name: str, channel: str, flats: list[tuple[Group, Level]]) -> None:
    """Raise for flats without light, or with less signal at more stated light.

    flats : by increasing exposure, the brightest one last
    """

    def stated(group: Group, signal: float) -> str:
        what = "flat" if group.kind == "flat" else f"{group.kind} flat"
        return f"the {what} at exposure {group.exposure:g} and {group.time_s:g} s, {signal:.4g} DN over its dark"

    signals, errors = [level.signal_dn for _, level in flats], [level.signal_sigma_dn for _, level in flats]
    # Faint ones may be below their dark by chance; the last two must show light.
    for (group, _), signal, error in list(zip(flats, signals, errors, strict=True))[-2:]:
        if not signal > SURE * error:
            raise UnsupportedError(
                f"{stated(group, signal)}, shows no light in {channel}: see that no cap was on, and that flats and "
                "darks are not swapped",
                stage=name,
            )
    for k, (group, _) in enumerate(flats[1:], start=1):
        if signals[k - 1] - signals[k] > max(SURE * math.hypot(errors[k - 1], errors[k]), _DARKER * signals[k - 1]):
            raise UnsupportedError(
                f"{stated(group, signals[k])}, is darker in {channel} than {stated(flats[k - 1][0], signals[k - 1])}: "
                "see "
                "that nothing covered it, and that each has its own exposure",
                stage=name,
            )


def _ended(flat: Group) -> bool:
    """Whether most of a flat is clipped by the converter."""
    largest = max(int(codes.max()) for codes in flat.codes)
    return float(np.mean([np.mean(codes == largest) for codes in flat.codes])) > 0.5


def _longest(darks: tuple[Group, ...], brightest: Group, index: U8) -> Group:
    """Return the longest dark nearer to the shortest one than to the brightest flat: full ones hide defects."""

    def charge(group: Group) -> F64:
        return np.array([np.median(group.codes[0][index == k]) for k in distinct(index)], np.float64)

    ordered = sorted(darks, key=lambda group: group.time_s)
    half = 0.5 * (charge(ordered[0]) + charge(brightest))
    return next((group for group in reversed(ordered) if np.all(charge(group) < half)), ordered[0])


def _nearest_dark(darks: tuple[Group, ...], time_s: float) -> Group:
    return min(darks, key=lambda group: abs(group.time_s - time_s))


def _at(darks: list[tuple[float, Stack]], time_s: float) -> Stack:
    return min(darks, key=lambda dark: abs(dark[0] - time_s))[1]


def _healthy(group: Group, index: U8, step_dn: float) -> Chosen:
    """Return a mask without defects, i.e. outliers of their channel by 8 robust standard deviations."""
    mean = np.mean(group.codes, axis=0)
    good = np.ones(mean.shape, dtype=bool)
    for k in distinct(index):
        here = mean[index == k]
        away = np.abs(here - np.median(here))
        good[index == k] = away <= max(_DEFECT * 1.4826 * float(np.median(away)), _ONE_CODE * step_dn)
    return good


def _range(found: PhotonTransfer, full: Level) -> tuple[Estimate, Estimate, Estimate, Estimate]:
    """Return sensitivity threshold, saturation, SNR there and dynamic range."""
    gain, read, reach = found.gain_dn_per_e, found.read_noise_e, saturation(full, found.gain_dn_per_e)
    if not read.measurable:
        return no_figure(read.why_not), reach, _snr_max(reach), no_figure(read.why_not)
    rounding_e = math.sqrt(full.dark.rounding.dn2) / gain.value
    noise_e2 = read.value**2 + rounding_e**2
    least = sensitivity_threshold_e(math.sqrt(noise_e2))
    # Figures in electrons share the gain's error, which nearly cancels in the range.
    by_gain = gain.sigma / gain.value
    by_read = read.value**2 * math.sqrt(max((read.sigma / read.value) ** 2 - by_gain**2, 0.0)) / (least - 0.5)
    threshold = Estimate(least, math.hypot(by_read, noise_e2 * by_gain / (least - 0.5)))
    if not reach.measurable:
        return threshold, reach, reach, reach
    by_reach = math.sqrt(max((reach.sigma / reach.value) ** 2 - by_gain**2, 0.0))
    share = math.hypot(by_reach, by_read / least, by_gain * (1.0 - noise_e2 / (least * (least - 0.5))))
    return threshold, reach, _snr_max(reach), Estimate(20.0 * math.log10(reach.value / least), _DECIBELS * share)


def _snr_max(reach: Estimate) -> Estimate:
    if not reach.measurable:
        return reach
    return Estimate(10.0 * math.log10(reach.value), 0.5 * _DECIBELS * reach.sigma / reach.value)


def _spectrogram(group: Group, channel: Chosen, good: Chosen) -> Spectrogram:
    """Return the spectra of the mean of frames on the first lattice of a channel, defects replaced by the mean."""
    rows, cols = np.nonzero(channel.any(axis=1))[0], np.nonzero(channel[np.nonzero(channel.any(axis=1))[0][0]])[0]
    step = int(np.diff(rows).min()) if rows.size > 1 else 1, int(np.diff(cols).min()) if cols.size > 1 else 1
    lattice = slice(rows[0], None, step[0]), slice(cols[0], None, step[1])
    mean = np.mean([codes[lattice] for codes in group.codes], axis=0)
    used = channel[lattice] & good[lattice]
    level = float(mean[used].mean())
    offset = np.where(used, mean - level, 0.0)
    along_rows, along_cols = (_root_power(part, used.mean()) for part in (offset, offset.T))
    return Spectrogram(
        frequency_cycles_per_pixel=np.fft.rfftfreq(offset.shape[1]) / step[1],
        rows=along_rows,
        cols_frequency_cycles_per_pixel=np.fft.rfftfreq(offset.shape[0]) / step[0],
        cols=along_cols,
    )


def _root_power(lines: F64, filled: float) -> F64:
    power = np.mean(np.abs(np.fft.rfft(lines, axis=1)) ** 2, axis=0) / lines.shape[1] / filled
    root: F64 = np.sqrt(power)
    return root
