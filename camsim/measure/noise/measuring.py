"""From flats and darks to figures: stacks of every channel, without its defects."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated

import numpy as np
import numpy.typing as npt

from camsim.arrays import F64, U8
from camsim.errors import UnsupportedError
from camsim.marks import Called
from camsim.measure.noise.photon_transfer import (
    SURE,
    Estimate,
    PhotonTransfer,
    Stack,
    photon_transfer,
    sensitivity_threshold_e,
    stack,
)
from camsim.measure.noise.result import ChannelNoise, NoiseReport, Spectrogram
from camsim.measure.noise.shots import Group, Shots
from camsim.typed import check

_LEAST_FLATS, _LEAST_DARKS, _LEAST_FRAMES = 4, 2, 2
_SAME_TIME = 1e-3
_DEFECT = 8.0
_DARKER = 0.05
"""Of a flat's signal: less is the slack of a saturation that is not quite even, which linearity leaves out as well."""
_ONE_CODE_DN = 1.0
"""Nearer than this no photosite is told from what rounding does where the noise is small."""

_SHOTS = Annotated[Shots, Called("Shots", "take_shots of a camera or read_shots of a folder gives them")]
Chosen = npt.NDArray[np.bool_]


def measure_noise(shots: Shots, *, expected: Mapping[str, dict[str, float]] | None = None) -> NoiseReport:
    """Return the figures of EMVA 1288 R4 of every channel.

    expected : figures by channel to put beside them

    Raises UnsupportedError in one sentence when the frames cannot give them.
    """
    check(shots, _SHOTS, "shots")
    _refuse(shots)
    flats, darks, index = shots.of("flat"), shots.of("dark"), shots.channel_index
    clipped = (shots.of("clipped") or flats)[-1]
    end_dn = _end_of_converter(clipped)
    half = flats[len(flats) // 2]
    good = _healthy(_longest(darks), index) & _healthy(half, index)
    channels = []
    for number, name in enumerate(shots.channels):
        here = (index == number) & good

        def reduced(group: Group, here: Chosen = here) -> Stack:
            return stack(group.codes, here, largest_dn=end_dn)

        darks_of = [(group.time_s, reduced(group)) for group in darks]
        # Every flat has the dark of its own time; what that differs from the first flat's is taken off.
        reference = _at(darks_of, flats[0].time_s)
        levels = [(g.exposure, _brought(reduced(g), _at(darks_of, g.time_s), reference)) for g in flats]
        full = _brought(reduced(clipped), _at(darks_of, clipped.time_s), reference)
        _refuse_unlit(shots.name, name, [*zip(flats, [s for _, s in levels], strict=True), (clipped, full)], reference)
        found = photon_transfer(flats=levels, dark=reference, darks=darks_of, clipped=full, largest_dn=end_dn)
        threshold_e, saturation_e, snr_max_db, dynamic_range_db = _range(found, full, reference)
        signal = np.array([level.mean_dn - reference.mean_dn for _, level in levels])
        noise = np.sqrt(np.maximum([level.variance_dn2 for _, level in levels], 1e-12))
        channels.append(
            ChannelNoise(
                channel=name,
                photosites=int(np.count_nonzero(here)),
                defects_left_out=int(np.count_nonzero((index == number) & ~good)),
                transfer=found,
                sensitivity_threshold_e=threshold_e,
                saturation_e=saturation_e,
                snr_max_db=snr_max_db,
                dynamic_range_db=dynamic_range_db,
                exposure=np.array([exposure for exposure, _ in levels]),
                signal_dn=signal,
                variance_dn2=np.array([level.variance_dn2 - reference.variance_dn2 for _, level in levels]),
                snr=signal / noise,
                dark=_spectrogram(_nearest_dark(darks, flats[0].time_s), index == number, good),
                flat=_spectrogram(half, index == number, good),
                expected=None if expected is None else dict(expected[name]),
            )
        )
    return NoiseReport(
        source=shots.name,
        rows=index.shape[0],
        cols=index.shape[1],
        frames=sum(len(group.codes) for group in shots.groups),
        channels=tuple(channels),
    )


def _refuse(shots: Shots) -> None:
    flats, darks = shots.of("flat"), shots.of("dark")
    if len(flats) < _LEAST_FLATS:
        raise UnsupportedError(
            f"has {len(flats)} levels of light; {_LEAST_FLATS} flats of different exposure or more are needed",
            stage=shots.name,
        )
    if len(darks) < _LEAST_DARKS:
        raise UnsupportedError(
            f"has darks of {len(darks)} exposure times; {_LEAST_DARKS} or more tell the dark current", stage=shots.name
        )
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
    # The brightest one may be full: it tells saturation.
    full = sum(_end_of_converter(group) == max(int(codes.max()) for codes in group.codes) for group in flats)
    if len(flats) - full < _LEAST_FLATS - 1:
        raise UnsupportedError(
            f"has {full} of {len(flats)} flats clipped by the converter; expose them less", stage=shots.name
        )


def _refuse_unlit(name: str, channel: str, flats: list[tuple[Group, Stack]], dark: Stack) -> None:
    """Refuse flats that show no light, or less of it the more they are said to have.

    flats : the least exposure first, clipped ones last
    """

    def told(group: Group, signal: float) -> str:
        what = "flat" if group.kind == "flat" else f"{group.kind} flat"
        return f"the {what} at exposure {group.exposure:g} and {group.time_s:g} s, {signal:.4g} DN over its dark"

    signals = [level.mean_dn - dark.mean_dn for _, level in flats]
    errors = [math.hypot(level.mean_sigma_dn, dark.mean_sigma_dn) for _, level in flats]
    # Faint ones may lie below their dark by chance; the last two are to show light.
    for (group, _), signal, error in list(zip(flats, signals, errors, strict=True))[-2:]:
        if not signal > SURE * error:
            raise UnsupportedError(
                f"{told(group, signal)}, shows no light in {channel}: see that no cap was on, and that flats and "
                "darks are not swapped",
                stage=name,
            )
    for k, (group, _) in enumerate(flats[1:], start=1):
        if signals[k - 1] - signals[k] > max(SURE * math.hypot(errors[k - 1], errors[k]), _DARKER * signals[k - 1]):
            raise UnsupportedError(
                f"{told(group, signals[k])}, is darker in {channel} than {told(flats[k - 1][0], signals[k - 1])}: see "
                "that nothing covered it, and that each has its own exposure",
                stage=name,
            )


def _end_of_converter(clipped: Group) -> int:
    """Return the code at which the converter ends: the one that most have; beyond all where the well ends first."""
    largest = int(max(int(codes.max()) for codes in clipped.codes))
    at_end = float(np.mean([np.mean(codes == largest) for codes in clipped.codes]))
    return largest if at_end > 0.5 else largest + 1


def _longest(darks: tuple[Group, ...]) -> Group:
    return max(darks, key=lambda group: group.time_s)


def _nearest_dark(darks: tuple[Group, ...], time_s: float) -> Group:
    return min(darks, key=lambda group: abs(group.time_s - time_s))


def _at(darks: list[tuple[float, Stack]], time_s: float) -> Stack:
    return min(darks, key=lambda dark: abs(dark[0] - time_s))[1]


def _brought(flat: Stack, own: Stack, reference: Stack) -> Stack:
    """Return a flat as if its dark had been another."""
    if own is reference:
        return flat
    return replace(
        flat,
        mean_dn=flat.mean_dn - own.mean_dn + reference.mean_dn,
        variance_dn2=flat.variance_dn2 - own.variance_dn2 + reference.variance_dn2,
        pattern_dn2=flat.pattern_dn2 - own.pattern_dn2 + reference.pattern_dn2,
    )


def _healthy(group: Group, index: U8) -> Chosen:
    """Return photosites that are no outliers of their channel (8 robust standard deviations): defects."""
    mean = np.mean(group.codes, axis=0)
    good = np.ones(mean.shape, dtype=bool)
    for k in np.unique(index):
        here = mean[index == k]
        away = np.abs(here - np.median(here))
        good[index == k] = away <= max(_DEFECT * 1.4826 * float(np.median(away)), _ONE_CODE_DN)
    return good


def _range(found: PhotonTransfer, full: Stack, dark: Stack) -> tuple[Estimate, Estimate, Estimate, Estimate]:
    """Return sensitivity threshold, saturation, SNR there and dynamic range."""
    gain, read = found.gain_dn_per_e, found.read_noise_e
    if not gain.measurable:
        nothing = Estimate(math.nan, math.nan, gain.why_not)
        return nothing, nothing, nothing, nothing
    saturation = (full.mean_dn - dark.mean_dn) / gain.value
    share = math.hypot(gain.sigma / gain.value, full.mean_sigma_dn / (full.mean_dn - dark.mean_dn))
    decibels = 20.0 / math.log(10.0)
    rounding_e = math.sqrt(1.0 / 12.0) / gain.value
    least = sensitivity_threshold_e(math.hypot(read.value, rounding_e))
    least_sigma = math.hypot(read.sigma * read.value, rounding_e**2 * gain.sigma / gain.value) / (least - 0.5)
    return (
        Estimate(least, least_sigma),
        Estimate(saturation, saturation * share),
        Estimate(10.0 * math.log10(saturation), 0.5 * decibels * share),
        Estimate(20.0 * math.log10(saturation / least), decibels * math.hypot(share, least_sigma / least)),
    )


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
