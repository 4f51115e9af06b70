"""Statistical comparison of two sets of frames, such as those of a camera and of its profile."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
import scipy.ndimage
import scipy.special
import scipy.stats

from camsim.camera.sensor import Sensor
from camsim.camera.window import Region
from camsim.core.arrays import F64, distinct
from camsim.measure.calibrate.calibration import Calibration
from camsim.measure.calibrate.darks import DarkStatistics, dark_statistics
from camsim.measure.calibrate.folder import Shot, ShotsOfCamera
from camsim.measure.calibrate.setting import Setting
from camsim.measure.noise.stack import Codes, Photosites, Rounding, stack
from camsim.sensor.exposure import Exposure

_SMOOTH_PX = 31
_BANDS = 10
_PROBABILITIES = (0.001, 0.02, 0.16, 0.5, 0.84, 0.98, 0.999)
_STRIPS = 32
_KL_BINS = 200
_FULL, _HEAPED = 0.9, 0.01
"""Share of codes on the largest one: of full frames, and of those whose variance is clipped."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Likeness:
    """A test at an ISO setting, and its p-value."""

    test: str
    iso: float
    probability: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SideBySide:
    """The camera's and the profile's frames of one ISO setting, reduced to statistics.

    mean_dn, variance_dn2, profile_variance_dn2 : (n,) of the groups of frames, per channel
    darks, profile_darks : statistics of the darks
    kl_nats : Kullback–Leibler divergence of the darks' codes, camera from profile, as noise models are compared (Noise
              Flow and ELD: histograms of codes above their mean); floor: between halves of the camera's darks
    """

    iso: float
    read_out: str
    mean_dn: F64
    variance_dn2: F64
    profile_variance_dn2: F64
    darks: DarkStatistics
    profile_darks: DarkStatistics
    dark_codes: Sequence[Codes]
    profile_codes: Sequence[Codes]
    kl_nats: float
    kl_floor_nats: float
    tests: tuple[Likeness, ...]


def simulated(shots: ShotsOfCamera, found: Calibration, sensor: Sensor, *, seed: int = 1) -> ShotsOfCamera:
    """Return the same frames simulated with a profile: equal brightness, ISO settings and times."""
    if sensor.dual_gain is not None and sensor.dual_gain.electrons_per_dn is not None:
        read: Any = shots.shots[0].read_out or "merged"
        sensor = sensor.replace(dual_gain=replace(sensor.dual_gain, read=read))
    by_iso = {each.iso: each for each in found.settings}
    made: list[Shot] = []
    rows, cols = shots.channel_index.shape
    whole = (rows, cols) == (sensor.rows, sensor.cols)
    light: dict[tuple[Any, ...], F64] = {}
    for number, shot in enumerate(shot for shot in shots.shots if shot.iso in by_iso and shot.time_s is not None):
        key = shot.kind, shot.iso, shot.time_s, shot.exposure
        if key not in light:
            alike = [each.codes for each in shots.shots if (each.kind, each.iso, each.time_s, each.exposure) == key]
            light[key] = _light_e(shot, alike, by_iso[shot.iso], shots.period, found)
        frame = sensor.expose(
            light[key],
            unit="electrons",
            exposure=Exposure(time_s=shot.time_s or 0.01, iso=shot.iso, temperature_c=shot.temperature_c),
            seed=seed,
            frame_number=number,
            region=None if whole else Region(rows=rows, cols=cols),
            products=("mosaic",),
        )
        made.append(replace(shot, codes=frame.linear_dn))
    return replace(shots, shots=tuple(made))


def _light_e(shot: Shot, alike: Sequence[Codes], setting: Setting, period: tuple[int, int], found: Calibration) -> F64:
    """Return mean electrons of equal frames, smoothed over each lattice of filters."""
    shape = alike[0].shape
    if shot.kind == "dark":
        return np.zeros(shape)
    mean = np.mean(alike, axis=0) - setting.darks.black_dn
    electrons = np.empty(shape)
    for row in range(period[0]):
        for col in range(period[1]):
            place = slice(row, None, period[0]), slice(col, None, period[1])
            electrons[place] = scipy.ndimage.uniform_filter(mean[place], _SMOOTH_PX, mode="reflect")
    full = shot.kind == "clipped" or float(np.mean(alike[0] == alike[0].max())) > _FULL
    scale = (3.0 if full else 1.0) / setting.gain_dn_per_e.value
    return np.maximum(electrons * scale, 0.0)


def side_by_side(camera: ShotsOfCamera, profile: ShotsOfCamera, found: Calibration) -> tuple[SideBySide, ...]:
    """Compare the frames of every ISO setting."""
    return tuple(_of_setting(setting, camera, profile, found.step_dn) for setting in found.settings)


def together(tests: Sequence[Likeness]) -> float:
    """Return one p-value for tests of one kind at several ISO settings, which are dependent, as they share photosites.

    Cauchy combination test, valid for dependent tests (Liu and Xie 2020).

    >>> round(together([Likeness(test="row spectrum", iso=100.0, probability=0.02)] * 3), 6)
    0.02
    """
    angles = [math.tan((0.5 - min(max(each.probability, 1e-12), 1.0 - 1e-12)) * math.pi) for each in tests]
    return 0.5 - math.atan(sum(angles) / len(angles)) / math.pi


def _of_setting(setting: Setting, camera: ShotsOfCamera, profile: ShotsOfCamera, step_dn: float) -> SideBySide:
    groups: dict[tuple[Any, ...], tuple[list[Codes], list[Codes]]] = {}
    for side, shots in enumerate((camera, profile)):
        for shot in shots.shots:
            if shot.iso == setting.iso and shot.time_s is not None:
                key = shot.kind, shot.time_s, shot.exposure, shot.temperature_c
                groups.setdefault(key, ([], []))[side].append(shot.codes)
    mean, ours, theirs, errors = [], [], [], []
    rounding = Rounding(step_dn=step_dn)
    channels = [Photosites((camera.channel_index == k) & ~setting.darks.hot) for k in range(len(camera.channels))]
    for (kind, *_), both in groups.items():
        if kind == "clipped" or len(both[0]) < 2:
            continue
        for here in channels:
            real, made = (stack(codes, here, rounding) for codes in both)
            if max(real.at_end, made.at_end) > _HEAPED:
                continue
            mean.append(real.mean_dn)
            ours.append(real.variance_dn2)
            theirs.append(made.variance_dn2)
            errors.append(math.hypot(real.variance_sigma_dn2, made.variance_sigma_dn2))
    z = (np.array(ours) - np.array(theirs)) / np.array(errors)
    dark = next(
        both
        for (kind, time_s, *_), both in sorted(groups.items(), key=lambda each: each[0][1])
        if kind == "dark" and time_s == setting.dark_time_s and len(both[0]) > 1
    )
    period = camera.period
    darks, made_darks = dark_statistics(dark[0], period), dark_statistics(dark[1], period)
    tests = (
        Likeness(test="variance against mean", iso=setting.iso, probability=float(scipy.stats.chi2.sf(z @ z, z.size))),
        Likeness(test="row spectrum", iso=setting.iso, probability=_same_power(darks, made_darks)),
        Likeness(test="quantiles of darks", iso=setting.iso, probability=_same_quantiles(dark[0], dark[1], step_dn)),
    )
    half = len(dark[0]) // 2
    return SideBySide(
        iso=setting.iso,
        read_out=camera.shots[0].read_out,
        mean_dn=np.array(mean),
        variance_dn2=np.array(ours),
        profile_variance_dn2=np.array(theirs),
        darks=darks,
        profile_darks=made_darks,
        dark_codes=dark[0],
        profile_codes=dark[1],
        kl_nats=kl_nats(dark[0], dark[1], step_dn),
        kl_floor_nats=kl_nats(dark[0][:half], dark[0][half:], step_dn),
        tests=tests,
    )


def _same_power(ours: DarkStatistics, theirs: DarkStatistics) -> float:
    """Return the p-value of two row spectra: from log ratios over bands, whose distribution is known."""
    count = len(ours.row_power)
    edges = distinct(np.round(np.geomspace(1, count + 1, _BANDS + 1)).astype(int)) - 1
    total, freedom = 0.0, 0
    for first, stop in pairwise(edges.tolist()):
        shape = (stop - first) * 0.5 * (ours.frames - 1 + theirs.frames - 1)
        ratio = math.log(ours.row_power[first:stop].mean() / theirs.row_power[first:stop].mean())
        total += ratio**2 / (2.0 * float(scipy.special.polygamma(1, max(shape, 1.0))))
        freedom += 1
    return float(scipy.stats.chi2.sf(total, freedom))


def _same_quantiles(ours: Sequence[Codes], theirs: Sequence[Codes], step_dn: float) -> float:
    """Return the p-value of two sets of darks: from shares of codes below their pooled quantiles.

    Errors come from shares over strips of rows and of columns, as photosites of a strip are correlated.
    """
    whole = np.concatenate([np.concatenate([codes.ravel() for codes in side]) for side in (ours, theirs)])
    spread = np.bincount(np.rint(whole / step_dn).astype(np.int64))
    share = np.cumsum(spread) / whole.size
    thresholds = distinct(np.searchsorted(share, _PROBABILITIES))
    (mean_a, error_a), (mean_b, error_b) = (
        _shares(side, step_dn * thresholds.astype(np.float64), step_dn) for side in (ours, theirs)
    )
    apart = mean_a - mean_b
    worth, axes = np.linalg.eigh(error_a + error_b)
    sound = worth > 1e-6 * worth.max()
    squared = float(np.sum((axes.T @ apart)[sound] ** 2 / worth[sound]))
    size, freedom = int(sound.sum()), _STRIPS - 1
    return float(scipy.stats.f.sf(squared * (freedom - size + 1) / (size * freedom), size, freedom - size + 1))


def _shares(frames: Sequence[Codes], thresholds: F64, step_dn: float) -> tuple[F64, F64]:
    below = np.stack([
        np.mean([codes <= at + 0.5 * step_dn for codes in frames], axis=0, dtype=np.float64) for at in thresholds
    ])  # fmt: skip
    height, width = below.shape[1:]
    rows, cols = min(_STRIPS, height), min(_STRIPS, width)
    tiles = below[:, : height // rows * rows, : width // cols * cols]
    tiles = tiles.reshape(len(thresholds), rows, height // rows, cols, width // cols).mean(axis=(2, 4))
    by_row, by_col = np.cov(tiles.mean(axis=2)) / rows, np.cov(tiles.mean(axis=1)) / cols
    # Both include the independent noise of photosites, so it is subtracted once.
    both = np.cov(tiles.reshape(len(thresholds), -1)) / (rows * cols)
    error: F64 = np.atleast_2d(by_row + by_col - both)
    return tiles.mean(axis=(1, 2)), error


def kl_nats(ours: Sequence[Codes], theirs: Sequence[Codes], step_dn: float) -> float:
    """Return the divergence D(ours ‖ theirs) of codes relative to the mean of their frames, in nats.

    Bins span 0.01 … 99.99 % of both; an empty one counts as half a code.
    """
    sides = [
        np.concatenate(
            [np.rint(codes.ravel() / step_dn - float(codes.mean(dtype=np.float64)) / step_dn) for codes in s]
        )
        for s in (ours, theirs)
    ]
    low, high = np.round(np.quantile(np.concatenate([side[::7] for side in sides]), [1e-4, 1.0 - 1e-4]))
    wide = math.ceil((high - low + 1.0) / _KL_BINS)
    counts = [np.bincount(((np.clip(side, low, high) - low) // wide).astype(np.int64)) for side in sides]
    bins = max(len(each) for each in counts)
    p, q = (np.maximum(np.pad(each, (0, bins - len(each))), 0.5) / each.sum() for each in counts)
    return float(np.sum(p * np.log(p / q)))
