"""Twenty synthetic cameras drawn at random, calibrated: do the figures' errors hold, and is the profile the camera?

The cameras are plain NumPy: nothing of camsim makes their frames. ``python -m bench.calibration`` writes
bench/calibration.jsonl and prints a table.
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

CAMERAS, SIDE = 20, 512
FLATS, DARKS = 6, 8
"""Levels of light, two frames of each; darks of their time. Of every ISO setting."""
TIME_S = 0.01
WITHIN, MOST, LEAST_SHARE = 2.0, 4.0, 0.95
MOST_TOLD_APART = 3

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
    if camera.colours:
        filters = np.tile(np.array([[0.55, 1.0], [1.0, 0.7]]), (side // 2, side // 2))
    else:
        filters = np.ones(shape)
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
        p = 1.0 - rng.random(shape) * (1.0 - 1e-16)
        drawn = (p**camera.tails - (1.0 - p + 1e-17) ** camera.tails) / camera.tails
        fine = (np.arange(2_000_000) + 0.5) / 2_000_000
        # The variance by a sum over quantiles; what lies beyond the finest is in it by the integral of its power.
        law = (fine**camera.tails - (1.0 - fine) ** camera.tails) / camera.tails
        return drawn / np.sqrt(np.mean(law**2))
    return rng.standard_normal(shape)
