"""Time and memory against size: photosites, edges, wavelengths, patches, threads; each size in a process of its own."""

from __future__ import annotations

import gc
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.memory import forget_peak, held_memory_mb, peak_memory_mb
from bench.results import Results, of_kind
from bench.worker import GIVES_BACK, Worker
from camsim.bench.records import Line
from camsim.core.cores import cores
from camsim.optics import Airy, OpticalSystem, SquarePhotosite
from camsim.rendering import Grid, render_channels
from camsim.scene import Polygon, Rectangle, Scene
from camsim.spectra.curve import Curve

PITCH_UM, TOLERANCE, LAPS = 4.88, 1e-6, 3
LONG_S = 3.0  # what takes longer is clocked once
SIZES: dict[str, tuple[int, ...]] = {
    "photosites": (10_000, 100_000, 1_000_000, 10_000_000, 24_000_000),
    "edges": (100, 1000, 10_000, 100_000),
    "wavelengths": (1, 4, 16, 64, 256),
    "patches": (1, 6, 24, 96),
    "threads": (1,),
}
QUICK = 3  # so many of the sizes in a quick run


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """One rendering: the scene, the frame's (rows, cols) and how many wavelengths."""

    scene: Scene
    rows: int
    cols: int
    wavelengths: int = 1
    tolerance: float = TOLERANCE


def task_of(over: str, size: int) -> Task:
    """Return the rendering of one size."""
    if over == "photosites":
        side = round(math.sqrt(size))
        return Task(scene=_square(0.56 * side), rows=side, cols=side)
    if over == "edges":
        return Task(scene=_triangles(size // 3, 3008, 2000), rows=2000, cols=3008, tolerance=1e-5)
    if over == "wavelengths":
        return Task(scene=_square(250.0), rows=446, cols=446, wavelengths=size)
    if over == "patches":
        return Task(scene=_patches(size), rows=446, cols=446, wavelengths=64)
    return Task(scene=_square(560.0), rows=1000, cols=1000)


def _square(side_px: float) -> Scene:
    side = side_px * PITCH_UM
    return Scene(background=1.0, shapes=[Rectangle(width_um=side, height_um=side, rotate_deg=4, reflectance=0.0)])


def _triangles(count: int, cols: int, rows: int) -> Scene:
    """Return triangles of about 3 px, each in a cell of its own, none over another."""
    across = math.ceil(math.sqrt(count * cols / rows))
    rng = np.random.default_rng(3)
    cell = np.array([cols / across, rows / math.ceil(count / across)])
    radius = min(1.8, 0.45 * float(cell.min()))
    shapes = []
    for k in range(count):
        centre = (np.array([k % across, k // across]) + 0.5) * cell - 0.5 * np.array([cols, rows])
        angle = rng.uniform(0.0, 2.0 * math.pi) + 2.0 * math.pi / 3.0 * np.arange(3)
        points = (centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)) * PITCH_UM
        shapes.append(Polygon(points_um=tuple((float(x), float(y)) for x, y in points), reflectance=0.2))
    return Scene(background=0.9, shapes=shapes)


def _patches(count: int) -> Scene:
    """Return squares side by side, each with a spectrum of its own."""
    across = math.ceil(math.sqrt(1.5 * count))
    cell = 400.0 / across * PITCH_UM
    shapes = []
    for k in range(count):
        centre = ((k % across - 0.5 * (across - 1)) * cell, (k // across - 0.5 * (count // across)) * cell)
        peak = 400.0 + 300.0 * (k + 0.5) / count
        curve = Curve((300.0, peak - 60.0, peak, peak + 60.0, 800.0), (0.1, 0.1, 0.8, 0.1, 0.1))
        shapes.append(
            Rectangle(width_um=0.8 * cell, height_um=0.8 * cell, rotate_deg=4, centre_um=centre, reflectance=curve)
        )
    return Scene(background=0.05, shapes=shapes)


def render_task(over: str, size: int, lap: int) -> tuple[float, float, float | None]:
    """Render; return wall and CPU seconds, and the peak memory beyond what was held before, MB."""
    task = task_of(over, size)
    n = task.wavelengths
    wavelength_nm = np.linspace(420.0, 680.0, n) if n > 1 else np.array([550.0])
    lens, photosite = Airy(f_number=8.0 * (1.0 + lap * 1e-11)), SquarePhotosite(side_um=PITCH_UM)
    gc.collect()
    held = held_memory_mb() if forget_peak() else None
    wall, cpu = time.perf_counter(), time.process_time()
    render_channels(
        task.scene,
        OpticalSystem.of([lens, photosite]),
        Grid(rows=task.rows, cols=task.cols, pitch_um=PITCH_UM),
        response=np.full((1, n), 1.0 / n),
        wavelength_nm=wavelength_nm,
        channel=np.zeros((task.rows, task.cols), np.uint8),
        tolerance=task.tolerance,
    )
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    peak = peak_memory_mb()
    return wall, cpu, None if held is None or peak is None else max(peak - held, 0.0)


def run_scaling(results: Results, say: Callable[[float, str], None], *, quick: bool = False) -> None:
    """Clock and weigh every size, and say how time grows."""
    begin = time.perf_counter()
    plan = [(over, size) for over, sizes in SIZES.items() for size in (sizes[:QUICK] if quick else sizes)]
    plan += [("threads", count) for count in range(2, cores() + 1)]
    for number, (over, size) in enumerate(plan, 1):
        threads = size if over == "threads" else cores()
        found = _laps(over, size, LAPS, threads=threads)
        # Weighed in a process that gives back what it frees: that takes time which nobody takes who does not ask.
        weighed = _laps(over, size, 1, threads=threads, environment=GIVES_BACK)
        results.add(
            "scaling",
            over=over,
            size=size,
            wall_s=min(f[0] for f in found),
            cpu_s=min(f[1] for f in found),
            beyond_mb=weighed[0][2],
            laps=len(found),
        )
        say(number / len(plan), f"{over}: {size}")
    for finding in growth(results.lines):
        results.add("finding", **finding)
    results.add("end", seconds=time.perf_counter() - begin)


def _laps(over: str, size: int, laps: int, **process: Any) -> list[tuple[float, float, float | None]]:
    """Render so often, once if that takes long, in a process of its own with the kernels loaded."""
    with Worker(**process) as worker:
        worker.call(render_task, "photosites", 100, 0)  # loads the kernels
        found = [worker.call(render_task, over, size, 1)]
        while len(found) < laps and found[0][1] < LONG_S:
            found.append(worker.call(render_task, over, size, len(found) + 1))
        return found


def growth(lines: list[Line]) -> Iterator[dict[str, object]]:
    """Say how CPU time grows over the last decade or so of each size; with threads, how wall time falls."""
    for over in SIZES:
        mine = [line for line in of_kind(lines, "scaling") if line["over"] == over]
        if len(mine) < 2:
            continue
        first, last = (mine[0], mine[-1]) if over == "threads" else mine[-2:]
        if over == "threads":
            ratio = first["wall_s"] / last["wall_s"]
            words = f"{last['size']} threads are {ratio:.2g} times as fast as one"
        else:
            ratio = math.log(last["cpu_s"] / first["cpu_s"]) / math.log(last["size"] / first["size"])
            words = f"from {first['size']} to {last['size']} {over} CPU time grows with power {ratio:.2g}"
        yield {"topic": "scaling", "over": over, "growth": ratio, "sentence": f"{words[0].upper()}{words[1:]}."}
