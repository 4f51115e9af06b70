"""Photon transfer on every sensor: what goes into a profile comes back from its flats and darks.

    python bench/photon_transfer.py [NAME …] [--side 1000] [--frames 16] [--judge]

A window of ``--side`` squared photosites of each sensor, 16 flats at each of 12 levels of even light, darks from 1 ms
to 30 s. A figure passes when it is off by no more than the larger of its tolerance and 4 σ of its estimator; both are
printed. ``--judge`` gives the same frames of monochrome sensors to the package emva1288 (pip install emva1288). One
JSON line a channel goes to stdout, a table to stderr; exit code 1 when a figure fails.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Iterator

import numpy as np

import camsim
from camsim.capturing import load_camera
from camsim.config import library
from camsim.measure.photon_transfer import Estimate, photon_transfer, stack

TIME_S = 0.01
DARK_TIMES_S = (0.001, 3.0, 10.0, 20.0, 30.0)
LEVELS = (0.04, 0.08, 0.15, 0.22, 0.3, 0.38, 0.46, 0.54, 0.62, 0.7, 0.8, 0.9)
# Of the larger of these and 4 σ; linearity in absolute terms.
TOLERANCES = {
    "gain_dn_per_e": 0.005,
    "read_noise_e": 0.01,
    "full_well_e": 0.005,
    "dark_current_e_per_s": 0.02,
    "dsnu_e": 0.02,
    "prnu": 0.02,
    "linearity_error": 0.001,
}


def noisy(name: str) -> bool:
    camera = load_camera(name, lens=camsim.Airy(f_number=8.0))
    return camera.shot_noise is not None


def expected(camera: camsim.Camera, letter: str, signal_e: dict[str, float]) -> dict[str, float]:
    """What the profile says, by sums of its own numbers."""
    iso, dark = camera.adc.base_iso, camera.dark_current
    dark_e_per_s = dark.e_per_s if dark else 0.0
    dcnu_e = dark.e_per_s * dark.nonuniformity * TIME_S if dark else 0.0
    offsets = (camera.dsnu.sigma_e if camera.dsnu else 0.0, camera.column_noise.sigma_e if camera.column_noise else 0.0)
    return {
        "gain_dn_per_e": 1.0 / camera.adc.electrons_per_dn,
        "read_noise_e": math.sqrt(camera.dark_noise_e(iso) ** 2 + dark_e_per_s * DARK_TIMES_S[0]),
        "full_well_e": camera.well_as_read_e(iso) or math.nan,
        "dark_current_e_per_s": dark_e_per_s,
        "dsnu_e": math.hypot(*offsets, dcnu_e),
        "prnu": pattern_of(camera, letter, signal_e),
        "linearity_error": bent(camera),
    }


def pattern_of(camera: camsim.Camera, letter: str, signal_e: dict[str, float]) -> float:
    """PRNU as a flat shows it: crosstalk mixes gains that know nothing of one another, and light of other colours."""
    fraction = camera.prnu.fraction if camera.prnu else 0.0
    if camera.crosstalk is None:
        return fraction
    pattern = np.tile(np.array([[signal_e[c] for c in row] for row in camera.cfa.pattern]), (3, 3))
    mixed, squares = np.zeros_like(pattern), np.zeros_like(pattern)
    for i, row in enumerate(camera.crosstalk.kernel):
        for j, share in enumerate(row):
            part = share * np.roll(pattern, (i - 1, j - 1), axis=(0, 1))
            mixed += part
            squares += part**2
    here = np.tile(np.array([list(row) for row in camera.cfa.pattern]) == letter, (3, 3))
    return float(math.sqrt(fraction**2 * squares[here].mean() + mixed[here].var()) / mixed[here].mean())


def bent(camera: camsim.Camera) -> float:
    """The linearity error of the profile's response itself."""
    if camera.nonlinearity is None:
        return 0.0
    well = camera.full_well.capacity_e if camera.full_well else 0.0
    exposure = np.array([level for level in LEVELS if 0.05 <= level <= 0.95]) * well
    signal = camera.nonlinearity.response(exposure)
    line = np.polynomial.Polynomial.fit(exposure, signal, 1, w=1.0 / signal)
    return float(np.mean(np.abs(signal / line(exposure) - 1.0)))


def measure(name: str, side: int, frames: int, judge: bool) -> Iterator[dict]:
    camera = load_camera(name, lens=camsim.Airy(f_number=8.0))
    # Patterns do not depend on the format; a smaller frame spares drawing those of photosites that nobody looks at.
    camera = camera.replace(rows=side, cols=side, olpf=None)
    iso = camera.adc.base_iso
    saturation_e = camera.adc.saturation_e(iso, camera.well_as_read_e(iso))
    per_watt = camera.diffuser_electrons(light(1.0), TIME_S)
    brightest = saturation_e / per_watt.max()
    channels = camera.cfa.channels
    index = camera.cfa.channel_index(side, side)
    begun = time.perf_counter()

    def taken(level: float, time_s: float, seed: int, count: int = frames) -> list[np.ndarray]:
        flat = camsim.Capture(
            camera=camera,
            scene=camsim.Scene(background=1.0 if level else 0.0),
            light=light(brightest * (level or 1.0)),
            exposure=camsim.Exposure(time_s=time_s, iso=iso),
            seed=seed,
            tolerance=1e-2,
        )
        return [shot.mosaic for shot in flat.frames(count)]

    flats = [(level, taken(level, TIME_S, 100 + n)) for n, level in enumerate(LEVELS)]
    dark = taken(0.0, TIME_S, 1, 2 * frames)
    good = healthy(taken(0.0, DARK_TIMES_S[-1], 3), index) & healthy(flats[len(flats) // 2][1], index)

    def stacks(codes: list[np.ndarray]) -> list:
        return [stack(codes, (index == k) & good, largest_dn=camera.adc.largest_dn) for k in range(len(channels))]

    darks = [(time_s, stacks(taken(0.0, time_s, 10 + n))) for n, time_s in enumerate(DARK_TIMES_S)]
    clipped = stacks(taken(4.0 * per_watt.max() / per_watt.min(), TIME_S, 2, 2))
    flat_stacks = [(level, stacks(codes)) for level, codes in flats]
    dark_stack = stacks(dark)
    signal_e = dict(zip(channels, (per_watt * brightest).tolist(), strict=True))
    for k, letter in enumerate(channels):
        found = photon_transfer(
            flats=[(level, each[k]) for level, each in flat_stacks],
            dark=dark_stack[k],
            darks=[(time_s, each[k]) for time_s, each in darks],
            clipped=clipped[k],
            largest_dn=camera.adc.largest_dn,
        )
        used = int(np.count_nonzero((index == k) & good))
        line = {"sensor": name, "channel": letter, "photosites": used, "frames": frames}
        line |= {"defects_left_out": int(np.count_nonzero((index == k) & ~good))}
        line |= {"figures": judged(found, expected(camera, letter, signal_e))}
        if judge and len(channels) == 1:
            line["emva1288"] = emva(flats, dark, per_watt[0] * brightest)
        yield line | {"seconds": round(time.perf_counter() - begun, 1)}


def healthy(codes: list[np.ndarray], index: np.ndarray) -> np.ndarray:
    """Photosites that are no outliers of their channel (8 robust standard deviations): defects are another list."""
    mean = np.mean(codes, axis=0)
    good = np.ones(mean.shape, dtype=bool)
    for k in np.unique(index):
        here = mean[index == k]
        spread = 1.4826 * np.median(np.abs(here - np.median(here)))
        good[index == k] = np.abs(here - np.median(here)) <= 8.0 * max(spread, 0.05)
    return good


def light(watts: float) -> camsim.Light:
    return camsim.Light("E", irradiance_w_per_m2=watts, at="sensor")


def judged(found: object, truth: dict[str, float]) -> dict[str, dict]:
    figures = {}
    for name, tolerance in TOLERANCES.items():
        estimate: Estimate = getattr(found, name)
        if not estimate.measurable:
            figures[name] = {"expected": truth[name], "not measurable": estimate.why_not}
            continue
        relative = tolerance if name == "linearity_error" else tolerance * truth[name]
        allowed = max(relative, 4.0 * estimate.sigma)
        figures[name] = {
            "expected": truth[name],
            "measured": estimate.value,
            "tolerance": relative,
            "4 sigma": 4.0 * estimate.sigma,
            "passes": bool(abs(estimate.value - truth[name]) <= allowed),
        }
    return figures


def emva(flats: list, dark: list, saturation_photons: float) -> dict[str, float]:
    """The package's word on the same frames, fed through its own reduction.

    Trustworthy: K, σ_d, DSNU1288 and PRNU1288 (totals, in e⁻ and %). Of two frames a level, its K has 1/15 of our
    degrees of freedom. Not to be compared: everything about photons (QE, thresholds), since 1 photon = 1 electron is
    assumed here; its saturation is where the variance is largest, not where charge is clipped; its linearity error
    follows Release 3, with other weights.
    """
    if not hasattr(np, "asfarray"):  # version 1.0.2 of the package was written for numpy 1
        vars(np)["asfarray"] = lambda values: np.asarray(values, dtype=float)
    from emva1288.process import routines
    from emva1288.process.data import Data1288
    from emva1288.process.results import Results1288

    def images(codes: list, kind: str) -> dict:
        whole = routines.get_int_imgs([c.astype(np.int64) for c in codes])
        if kind == "spatial":
            return whole
        return {"sum": np.sum(whole["sum"]), "pvar": np.sum(whole["pvar"]), "dmean": whole["dmean"]}

    exposure = TIME_S * 1e9
    temporal = {level * saturation_photons: images(codes[:2], "temporal") for level, codes in flats}
    temporal[0.0] = images(dark[:2], "temporal")
    half = min(flats, key=lambda flat: abs(flat[0] - 0.5))
    spatial = {half[0] * saturation_photons: images(half[1], "spatial"), 0.0: images(dark, "spatial")}
    rows, cols = dark[0].shape
    data = {"temporal": {exposure: temporal}, "spatial": {exposure: spatial}, "height": rows, "width": cols}
    results = Results1288(Data1288(data).data)
    names = {"K": "gain_dn_per_e", "sigma_d": "read_noise_e", "DSNU1288": "dsnu_e", "PRNU1288": "prnu_percent"}
    return {ours: float(getattr(results, theirs)) for theirs, ours in names.items()}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help="sensors; all that have noise when left out")
    parser.add_argument("--side", type=int, default=1000)
    parser.add_argument("--frames", type=int, default=16)
    parser.add_argument("--judge", action="store_true")
    asked = parser.parse_args()
    names = asked.names or list(library.shipped("sensor"))
    failed = 0
    for name in names:
        if not noisy(name):
            print(f"{name}: not measurable: it has no photon noise", file=sys.stderr)
            continue
        for line in measure(name, asked.side, asked.frames, asked.judge):
            print(json.dumps(line, ensure_ascii=False), flush=True)
            print(f"{name} {line['channel']}, {line['photosites']} photosites, {line['seconds']} s", file=sys.stderr)
            for figure, told in line["figures"].items():
                if "not measurable" in told:
                    print(f"  {figure:22} not measurable: {told['not measurable']}", file=sys.stderr)
                    continue
                failed += not told["passes"]
                print(
                    f"  {figure:22} {told['expected']:12.6g} → {told['measured']:12.6g}  tolerance "
                    f"{told['tolerance']:8.2g}  4σ {told['4 sigma']:8.2g}  {'ok' if told['passes'] else 'FAILS'}",
                    file=sys.stderr,
                )
            if "emva1288" in line:
                print(f"  emva1288: {line['emva1288']}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
