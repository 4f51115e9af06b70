"""Twenty synthetic cameras drawn at random, calibrated: do the figures' errors hold, and is the profile the camera?

The cameras are plain NumPy: nothing of camsim makes their frames. ``python -m bench.calibration`` prints a line for
each camera and writes bench/calibration.jsonl; exit code 1 where a figure is more than 4 of its errors off, fewer than
95 % are within 2, or more than 3 of 60 tests tell the profile's frames from the camera's at 1 %.
"""

from __future__ import annotations

import csv
import json
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.stats

from camsim.camera.sensor import Sensor
from camsim.measure.calibrate import Calibration, calibrate, read_folder
from camsim.measure.calibrate.likeness import side_by_side, simulated, together
from camsim.measure.calibrate.profile_file import profile_text
from camsim.measure.noise import Estimate

CAMERAS, SIDE = 20, 512
FLATS, DARKS = 6, 8
"""Levels of light, two frames of each; darks of their time. Of every ISO setting."""
TIME_S = 0.01
WITHIN, MOST, LEAST_SHARE = 2.0, 4.0, 0.95
MOST_DISTINGUISHED = 3

_RESULTS = Path(__file__).with_suffix(".jsonl")


@dataclass(frozen=True, kw_only=True)
class SyntheticCamera:
    """What a camera is; codes are whole multiples of ``step_dn``, electrons are before the gain."""

    bits: int
    step_dn: int
    black_dn: int
    iso: tuple[float, ...]
    electrons_per_dn: tuple[float, ...]
    dual_from: int | None
    read_noise_e: tuple[float, ...]
    output_noise_dn: float
    row_noise_e: float
    law: str
    tails: float
    telegraph_fraction: float
    telegraph_e: float
    dsnu_e: float
    column_noise_e: float
    prnu: float
    full_well_e: float
    colours: bool


def draw_camera(rng: np.random.Generator) -> SyntheticCamera:
    """Draw a camera."""
    bits, step = [(12, 1), (14, 1), (14, 4), (16, 16), (16, 4)][rng.integers(5)]
    codes = 2**bits // step
    iso = (100.0, 800.0, 6400.0) if codes > 4096 else (100.0, 400.0, 1600.0)
    full_e = rng.uniform(25_000.0, 60_000.0)
    base = full_e / (0.8 * 2**bits)
    gains = [base * 100.0 / at * (1.0 if at == 100.0 else rng.uniform(0.93, 1.07)) for at in iso]
    noise_e = rng.uniform(2.5, 6.0)
    dual = int(rng.integers(1, 3)) if rng.random() < 0.5 else None
    high_e = noise_e * rng.uniform(0.35, 0.6)
    read_e = [high_e if dual is not None and k >= dual else noise_e for k in range(3)]
    law = ["normal", "student", "tukey"][rng.integers(3)]
    tails = {"normal": 0.0, "student": 1.0 / rng.uniform(4.5, 12.0), "tukey": rng.uniform(-0.16, 0.0)}[law]
    jumps = rng.random() < 0.6
    least_e = min(read_e)
    black = int(max(rng.uniform(0.015, 0.07) * 2**bits, 22.0 * read_e[2] / gains[2]))
    return SyntheticCamera(
        bits=bits,
        step_dn=step,
        black_dn=black // step * step,
        iso=iso,
        electrons_per_dn=tuple(gains),
        dual_from=dual,
        read_noise_e=tuple(read_e),
        output_noise_dn=step * rng.uniform(0.7, 1.8),
        row_noise_e=least_e * rng.uniform(0.1, 0.5),
        law=law,
        tails=tails,
        telegraph_fraction=rng.uniform(0.003, 0.03) if jumps else 0.0,
        telegraph_e=least_e * rng.uniform(4.0, 8.0) if jumps else 0.0,
        dsnu_e=least_e * rng.uniform(0.3, 1.0),
        column_noise_e=least_e * rng.uniform(0.1, 0.3),
        prnu=rng.uniform(0.004, 0.012),
        full_well_e=full_e,
        colours=bool(rng.random() < 0.5),
    )


def write_frames(
    camera: SyntheticCamera, folder: Path, rng: np.random.Generator, *, side: int = SIDE, levels: int = FLATS,
    darks: int = DARKS,
) -> None:  # fmt: skip
    """Write flats and darks as NPY with their index.

    The last level at the base ISO fills every well.
    """
    shape = (side, side)
    response = 1.0 + camera.prnu * rng.standard_normal(shape)
    filters = np.tile(np.array([[0.55, 1.0], [1.0, 0.7]]), (side // 2, side // 2)) if camera.colours else np.ones(shape)
    offset_e = camera.dsnu_e * rng.standard_normal(shape) + camera.column_noise_e * rng.standard_normal(side)
    jump_e = np.where(
        rng.random(shape) < camera.telegraph_fraction, rng.exponential(1.0, shape) * camera.telegraph_e, 0.0
    )

    def frame(light_e: float, setting: int) -> npt.NDArray[np.uint16]:
        charge = np.minimum(rng.poisson(light_e * filters * response), camera.full_well_e)
        read = camera.read_noise_e[setting] * _noise(camera, shape, rng)
        jumps = jump_e * (rng.integers(0, 2, shape) - 0.5)
        rows = camera.row_noise_e * rng.standard_normal((side, 1))
        signal = (charge + read + jumps + rows + offset_e) / camera.electrons_per_dn[setting]
        signal += camera.black_dn + camera.output_noise_dn * rng.standard_normal(shape)
        largest = (2**camera.bits - 1) // camera.step_dn
        return (np.clip(np.rint(signal / camera.step_dn), 0, largest) * camera.step_dn).astype(np.uint16)

    with (folder / "index.csv").open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(("file", "kind", "exposure", "time_s", "iso"))

        def put(name: str, kind: str, exposure: float, setting: int) -> None:
            np.save(folder / name, frame(exposure, setting))
            table.writerow((name, kind, exposure, TIME_S, camera.iso[setting]))

        for setting in range(len(camera.iso)):
            range_e = ((2**camera.bits - 1) - camera.black_dn) * camera.electrons_per_dn[setting]
            top_e = min(range_e, camera.full_well_e)
            shares = np.linspace(0.08, 0.85, levels if setting else levels - 1)
            for number, share in enumerate(shares):
                for k in range(2):
                    put(f"flat-{setting}-{number}-{k}.npy", "flat", float(share * top_e), setting)
            if not setting:
                for k in range(2):
                    put(f"clipped-{k}.npy", "clipped", 3.0 * top_e, setting)
            for k in range(darks):
                put(f"dark-{setting}-{k}.npy", "dark", 0.0, setting)


def _noise(camera: SyntheticCamera, shape: tuple[int, int], rng: np.random.Generator) -> npt.NDArray[np.float64]:
    """Draw the camera's law with a standard deviation of 1."""
    if camera.law == "student":
        dof = 1.0 / camera.tails
        # A normal over the root of a mean of squares; its variance is dof/(dof − 2).
        return rng.standard_normal(shape) / np.sqrt(rng.chisquare(dof, shape) / dof) * np.sqrt(1.0 - 2.0 / dof)
    if camera.law == "tukey":
        p = np.clip(rng.random(shape), 1e-16, 1.0 - 1e-16)
        return (p**camera.tails - (1.0 - p) ** camera.tails) / camera.tails / scipy.stats.tukeylambda.std(camera.tails)
    return rng.standard_normal(shape)


def figures(camera: SyntheticCamera, found: Calibration) -> dict[str, tuple[float, Estimate]]:
    """Return every figure that was calibrated with the camera's own; one that is not there has none."""
    stated = {
        f"electrons_per_dn {iso:g}": (item, setting.electrons_per_dn)
        for iso, item, setting in zip(camera.iso, camera.electrons_per_dn, found.settings, strict=True)
    }
    stated |= {
        "black_dn": (camera.black_dn, found.black_dn),
        "read_noise_e": (camera.read_noise_e[0], found.read_noise_e),
        "output_noise_dn": (camera.output_noise_dn, found.output_noise_dn),
        "row_noise_e": (camera.row_noise_e, found.row_noise_e),
        "column_noise_e": (camera.column_noise_e, found.column_noise_e),
        "dsnu_e": (camera.dsnu_e, found.dsnu_e),
        "prnu": (camera.prnu, found.prnu),
        "full_well_e": (camera.full_well_e, found.full_well_e),
        "telegraph_fraction": (camera.telegraph_fraction, found.telegraph_fraction),
        "telegraph_e": (camera.telegraph_e, found.telegraph_e),
    }
    if found.dual_read_noise_e is not None:
        stated["dual_read_noise_e"] = (camera.read_noise_e[-1], found.dual_read_noise_e)
    if found.law is not None and found.law.shape.law != "normal":
        stated["tails"] = (camera.tails, Estimate(found.law.shape.tails, found.law.errors["tails"]))
    return {name: each for name, each in stated.items() if each[1].measurable}


def faults(camera: SyntheticCamera, found: Calibration) -> list[str]:
    """Return what was not recognised: the kind of law, jumps, dual gain, the step between codes, the bits."""
    dual = None if camera.dual_from is None else camera.iso[camera.dual_from]
    assert found.law is not None
    seen = {
        "law": (camera.law, found.law.shape.law),
        "dual gain from": (dual, found.over_iso.dual_from_iso),
        "step": (camera.step_dn, found.step_dn),
        "bits": (camera.bits, found.bit_depth),
        "jumps": (camera.telegraph_fraction > 0.0, found.telegraph_fraction.measurable),
    }
    return [f"{name}: {stated} for {item}" for name, (item, stated) in seen.items() if item != stated]


def judged(number: int, *, side: int = SIDE, levels: int = FLATS, darks: int = DARKS) -> dict[str, Any]:
    """Draw a camera, calibrate it, take its frames with the profile, and lay both side by side."""
    rng = np.random.default_rng([64, number])
    camera = draw_camera(rng)
    with tempfile.TemporaryDirectory() as place:
        write_frames(camera, Path(place), rng, side=side, levels=levels, darks=darks)
        shots = read_folder(place, cfa="RGGB" if camera.colours else "mono")
        began = time.process_time()
        found = calibrate(shots)
        seconds = time.process_time() - began
        profile = Path(place) / "profile.yaml"
        profile.write_text(profile_text(found, name=f"Synthetic {number}"), encoding="utf-8")
        # Another specimen and other noise for each camera: those of one would be lucky or unlucky for all.
        sensor = Sensor.from_yaml(profile).replace(serial=number)
    sides = side_by_side(shots, simulated(shots, found, sensor, seed=number), found)
    kinds = [each.test for each in sides[0].tests]
    compared = figures(camera, found)
    return {
        "camera": number,
        "is": asdict(camera),
        "figures": {n: {"is": item, "told": e.value, "error": e.sigma} for n, (item, e) in compared.items()},
        "off": {name: (each.value - item) / each.sigma for name, (item, each) in compared.items()},
        "faults": faults(camera, found),
        "probability": {
            kind: together([each for one in sides for each in one.tests if each.test == kind]) for kind in kinds
        },
        "kl_nats": [one.kl_nats for one in sides],
        "kl_floor_nats": [one.kl_floor_nats for one in sides],
        "cpu_seconds": round(seconds, 1),
    }


def verdict(results: list[dict[str, Any]]) -> tuple[str, bool]:
    """Return a sentence, and whether all is as it must be."""
    off = np.abs([each for result in results for each in result["off"].values()])
    stated = [p for result in results for p in result["probability"].values()]
    apart = sum(p < 0.01 for p in stated)
    wrong = sum(len(result["faults"]) for result in results)
    within = float(np.mean(off <= WITHIN))
    sentence = (
        f"{off.size} figures of {len(results)} cameras: the farthest {off.max():.2f} of its errors off, "
        f"{100 * within:.1f} % within {WITHIN:g}; {wrong} not recognised; "
        f"{apart} of {len(stated)} tests told apart at 1 %"
    )
    allowed = MOST_DISTINGUISHED * len(stated) / 60
    return sentence, bool(off.max() <= MOST and within >= LEAST_SHARE and not wrong and apart <= allowed)


def main() -> int:
    """Judge all cameras."""
    results = []
    with _RESULTS.open("w", encoding="utf-8") as file:
        for number in range(CAMERAS):
            result = judged(number)
            results.append(result)
            file.write(json.dumps(result, sort_keys=True) + "\n")
            farthest = max(result["off"].items(), key=lambda each: abs(each[1]))
            least = min(result["probability"].values())
            print(f"{number}: {farthest[0]} {farthest[1]:+.2f}; p {least:.3f}; {result['faults'] or ''}", flush=True)
    sentence, passed = verdict(results)
    print(sentence)
    return 0 if passed else 1


if __name__ == "__main__":
    sys.exit(main())
