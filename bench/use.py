"""What people take: CPU seconds and memory of the captures and whole commands of ``bench/use.yaml``.

    python -m bench.use [NAME…] [-o FILE] [--against FILE] [--page] [--random N]

A capture has a process of its own, and is made twice, the second time with another f-number, so that nothing kept from
the first helps: its seconds are the second's, or the first's beyond 30. ``-o`` adds JSON lines to a file, ``--against``
compares with one; ratios count between runs on one machine, idle. ``--page`` puts the table into docs/accuracy.md.
``--random`` checks so many random photosites of a capture instead of the hardest ones.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
import multiprocessing
import os
import resource
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from PIL import Image

import camsim
from bench.paper.pages import filled, markdown
from camsim.core.arrays import I64
from camsim.rendering.direct.direct_check import DirectCheck
from camsim.rendering.direct.fourier_check import FourierCheck
from camsim.rendering.engine import Plan
from camsim.rendering.varying import FieldCheck

TAKEN = yaml.safe_load(Path(__file__).with_suffix(".yaml").read_text(encoding="utf-8"))
CAPTURES, COMMANDS = TAKEN["captures"], TAKEN["commands"]
CHECKS = DirectCheck, FourierCheck, FieldCheck
PAGE = Path(__file__).parents[1] / "docs" / "accuracy.md"
LONG_S = 30.0
SHORT_S = 0.6  # what is quicker has no line on the page
TRUTH = 1.2e6  # photosites up to which the truth is asked for too


def overrides(keys: dict[str, Any]) -> list[str]:
    """Return keys and values as of ``--set``."""
    full = {"tolerance": "render.tolerance"}
    if isinstance(region := keys.get("region"), list):
        keys = keys | {"region": dict(zip(("rows", "cols", "origin"), region, strict=False))}
    return [f"{full.get(key, key)}={json.dumps(value)}" for key, value in keys.items()]


def files(folder: Path) -> None:
    """Write the files that captures and commands take: a photograph, a spectral cube, scenes and studies."""
    rng = np.random.default_rng(7)
    y, x = np.mgrid[:1024, :1024] / 1024.0
    photo = np.stack([0.5 + 0.3 * np.sin(9 * x + 5 * y), 0.5 + 0.3 * np.cos(14 * y * x), 0.4 + 0.4 * x * y], axis=-1)
    photo += 0.1 * np.sin(400 * (x**2 + y**2))[..., None]
    for _ in range(200):
        cx, cy, r = (*rng.uniform(0, 1, 2), rng.uniform(0.01, 0.08))
        photo[(x - cx) ** 2 + (y - cy) ** 2 < r * r] = rng.uniform(0.05, 0.95, 3)
    photo += rng.normal(0, 0.01, photo.shape)
    Image.fromarray((255 * np.clip(photo, 0, 1)).astype(np.uint8)).save(folder / "photo.png")
    nm = np.arange(400.0, 701.0, 10.0)
    bands = np.exp(-(((nm - np.array([[610], [540], [450]])) / 60.0) ** 2)) / 1.4
    cube = photo[::4, ::4].clip(0.02, 0.95) @ bands
    np.savez(folder / "cube.npz", values=cube.astype(np.float32), wavelength_nm=nm)
    for name, content in TAKEN["files"].items():
        (folder / name).write_text(json.dumps(content), encoding="utf-8")


def at_random(count: int) -> Callable[..., tuple[I64, I64]]:
    """Return the choice of photosites to check that takes random ones."""

    def hardest(_: Any, plan: Plan) -> tuple[I64, I64]:
        shape = plan.job.grid.rows, plan.job.grid.cols
        places = np.random.default_rng(count).choice(math.prod(shape), min(count, math.prod(shape)), replace=False)
        rows, cols = np.unravel_index(places, shape)
        return rows, cols

    return hardest


def captured(name: str, folder: Path, random: int = 0) -> dict[str, Any]:
    """Take a capture twice, in a process of its own; ``random``: once, with so many random photosites checked."""
    if random:
        for kind in CHECKS:
            kind.hardest = at_random(random)  # type: ignore[method-assign]
    _, scene, keys = CAPTURES[name]
    capture = camsim.load(folder / scene if scene in TAKEN["files"] else scene, overrides=overrides(keys))
    products = ("mosaic", "truth") if capture.grid.rows * capture.grid.cols <= TRUTH else ("mosaic",)
    found: dict[str, Any] = {}
    of_check = clocked()
    for lap in range(2):
        of_check.clear()
        began, cpu = time.perf_counter(), time.process_time()
        report = capture.frame(products=products).report
        found |= {"wall_s": time.perf_counter() - began, "cpu_s": time.process_time() - cpu}
        found["check_s"] = sum(of_check)
        if lap == 0:
            found["of_tolerance"] = (report.error_estimate or 0.0) / capture.tolerance
            found["method"] = report.method
            found["forecast_s"] = capture.plan().cost.seconds
        if found["wall_s"] > LONG_S or random:
            break
        lens = dataclasses.replace(capture.camera.lens, f_number=1.003 * capture.camera.lens.f_number)
        capture = dataclasses.replace(capture, camera=capture.camera.replace(lens=lens))
    return found | {"peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}


def clocked() -> list[float]:
    """Return a list to which each call of a check adds its CPU seconds."""
    spent: list[float] = []
    within = [False]  # one check may call another

    def clock(own: Callable[..., Any]) -> Callable[..., Any]:
        def one(*given: Any) -> Any:
            if within[0]:
                return own(*given)
            within[0], began = True, time.process_time()
            try:
                return own(*given)
            finally:
                spent.append(time.process_time() - began)
                within[0] = False

        return one

    for kind in CHECKS:
        for name in {"hardest", "values"} & vars(kind).keys():
            setattr(kind, name, clock(vars(kind)[name]))
    return spent


def commanded(name: str, folder: Path) -> dict[str, Any]:
    """Run a command, and before it what it takes."""
    given = COMMANDS[name]
    command, before, keys = given[1], given[2] if len(given) > 2 else "", given[3] if len(given) > 3 else {}
    words = [shlex.split(one) for one in (before, command) if one]
    words[0] += [word for one in overrides(keys) for word in ("--set", one)]
    for one in words:
        began, then = time.perf_counter(), os.times()
        run = [sys.executable, "-m", "camsim", *one]
        done = subprocess.run(run, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode:
            raise RuntimeError((done.stderr.strip().splitlines() or ["it failed"])[-1])
    now = os.times()
    cpu = now.children_user + now.children_system - then.children_user - then.children_system
    return {"wall_s": time.perf_counter() - began, "cpu_s": cpu}


def measured(name: str, folder: Path, random: int = 0) -> dict[str, Any]:
    """Return what a capture or a command took, or why it failed."""
    try:
        if name in COMMANDS:
            return commanded(name, folder)
        with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as alone:
            return alone.submit(captured, name, folder, random).result()
    except Exception as error:  # a case that fails is a line of the table too
        return {"failed": str(error).splitlines()[0][:300]}


def stated(line: dict[str, Any], before: dict[str, Any]) -> str:
    """Return a line of the table on the screen."""
    if "failed" in line:
        return f"{line['name']:22s} FAILED {line['failed']}"
    parts = [f"{line['name']:22s} {line['wall_s']:8.3f} s {line['cpu_s']:8.3f} CPU s"]
    if "method" in line:
        parts.append(f"{line['peak_mb']:6.0f} MB  {line['of_tolerance']:.2g} of the tolerance  {line['method']}")
        parts.append(
            f"forecast {line['forecast_s'] / line['cpu_s']:.2g} of it, check {line['check_s'] / line['cpu_s']:.0%}"
        )
    if "cpu_s" in before:
        parts.append(f"{line['cpu_s'] / before['cpu_s']:.2f} x")
    return "  ".join(parts)


def table(lines: list[dict[str, Any]]) -> str:
    """Return the page's table."""
    return markdown(
        ("what", "CPU seconds", "memory, MB"),
        [
            (
                (CAPTURES | COMMANDS)[line["name"]][0] if "method" in line else f"`camsim {COMMANDS[line['name']][1]}`",
                f"{line['cpu_s']:.2g}",
                f"{line['peak_mb']:.0f}" if "peak_mb" in line else "",
            )
            for line in lines
            if "failed" not in line and line["cpu_s"] >= SHORT_S
        ],
    )


def main() -> None:
    """Measure, and print a line for each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join([*CAPTURES, *COMMANDS]))
    parser.add_argument("-o", type=Path, metavar="FILE")
    parser.add_argument("--against", type=Path, metavar="FILE")
    parser.add_argument("--page", action="store_true")
    parser.add_argument("--random", type=int, default=0, metavar="N")
    given = parser.parse_args()
    if unknown := {*given.names} - {*CAPTURES, *COMMANDS}:
        parser.error(f"{', '.join(sorted(unknown))}: known are {', '.join([*CAPTURES, *COMMANDS])}")
    old = given.against.read_text(encoding="utf-8").splitlines() if given.against else []
    before = {line["name"]: line for line in map(json.loads, old)}
    lines = []
    with tempfile.TemporaryDirectory() as folder:
        files(Path(folder))
        for name in given.names or [*CAPTURES, *COMMANDS]:
            lines.append({"name": name} | measured(name, Path(folder), given.random))
            print(stated(lines[-1], before.get(name, {})), flush=True)
            if given.o:
                with given.o.open("a", encoding="utf-8") as out:
                    out.write(json.dumps(lines[-1]) + "\n")
    if given.page:
        PAGE.write_text(filled(PAGE.read_text(encoding="utf-8"), {"use": table(lines)}), encoding="utf-8")


if __name__ == "__main__":
    main()
