"""Sweeps that are killed (kill −9) at random moments and resumed, held against one that was left alone.

``python -m bench.kills`` kills a worker, the sweep itself, the sweep with all of its workers, a worker of a dask
cluster and its scheduler in turns, twenty times in all, and then begins two sweeps into one folder at once. The moment
is drawn: after so many files, and a part of a second. Afterwards every file must be there once, whole, with the
checksum that it has undisturbed, and nothing beside them.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import hashlib
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import psutil

import camsim
from bench.cluster import cluster

KINDS = ("a worker", "the sweep", "sweep and workers", "a cluster's worker", "a cluster's scheduler")
WORKERS = 2
MANIFEST = {"manifest.csv", "manifest.parquet"}
STUDY = """
camsim: study/1
scene: slanted-edge
set: {{region: {{rows: 512, cols: 512}}, render.tolerance: 1.0e-3}}
vary: {{lens.f_number: {{linear: [4, 16, {captures}]}}}}
frames: 2
"""


def main() -> None:
    """Print what came of each kill; exit with 1 when a folder is not as it would be undisturbed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--captures", type=int, default=24, help="of 512², two frames each")
    parser.add_argument("--seed", type=int, default=1, help="of the moments")
    options = parser.parse_args()
    drawn = random.Random(options.seed)
    print(f"seed {options.seed}, {options.captures} captures of 2 frames, {WORKERS} workers")
    wrong = 0
    with tempfile.TemporaryDirectory() as place:
        study = Path(place) / "study.yaml"
        study.write_text(STUDY.format(captures=options.captures), encoding="utf-8")
        alone = Path(place) / "alone"
        camsim.sweep(study, alone, workers=0)
        wanted = _files(alone)
        for number in range(options.kills):
            kind, folder = KINDS[number % len(KINDS)], Path(place) / f"kill{number}"
            came = _killed(kind, study, folder, drawn, len(wanted))
            faults = _faults(folder, wanted)
            wrong += bool(faults)
            print(f"{number + 1:3} {kind:22} {came}: {'; '.join(faults) or 'as undisturbed'}", flush=True)
        faults = _two_at_once(study, Path(place) / "two", wanted)
        wrong += bool(faults)
        print(f"two sweeps into one folder at once: {'; '.join(faults) or 'one refused or both right'}")
    sys.exit(1 if wrong else 0)


def _sweep(study: Path, folder: Path, *words: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "camsim", "sweep", str(study), "-o", str(folder), "--json", *words]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def _killed(kind: str, study: Path, folder: Path, drawn: random.Random, files: int) -> str:
    """Sweep, kill, and sweep again until all is there; return what came of it."""
    after, later_s = drawn.randrange(files), drawn.random()
    with cluster(WORKERS) if "cluster" in kind else contextlib.nullcontext() as hosts:
        words = ("--scheduler", hosts[0]) if hosts else ("--workers", str(WORKERS))
        sweep = _sweep(study, folder, *words)
        while sweep.poll() is None and len(list(folder.glob("*.dng"))) < after:
            time.sleep(0.01)
        with contextlib.suppress(subprocess.TimeoutExpired):
            sweep.wait(later_s)
        victims = _victims(kind, sweep, hosts[1] if hosts else [], drawn) if sweep.poll() is None else []
        there = len(list(folder.glob("*.dng")))
        for victim in victims:
            with contextlib.suppress(psutil.NoSuchProcess):
                victim.kill()
        _, said = sweep.communicate()  # until no worker is left either
    stated = f"after {there:2} files" if victims else "after the end"
    if sweep.returncode == 0:
        return f"{stated}, went on to the end"
    again = camsim.sweep(study, folder, workers=0)
    why = f" ({said.strip().splitlines()[-1]})" if sweep.returncode > 0 else ""
    return f"{stated}, ended with {sweep.returncode}{why}, resumed: {again.found} found, {again.taken} taken"


def _victims(kind: str, sweep: subprocess.Popen[str], hosts: list[int], drawn: random.Random) -> list[psutil.Process]:
    one = psutil.Process(sweep.pid)
    if kind == "the sweep":
        return [one]
    if kind == "sweep and workers":
        return [one, *one.children(recursive=True)]
    if kind == "a cluster's scheduler":
        return [psutil.Process(hosts[0])]
    children = one.children() if kind == "a worker" else psutil.Process(hosts[1]).children(recursive=True)
    workers = [child for child in children if "resource_tracker" not in " ".join(child.cmdline())]
    return [drawn.choice(workers)] if workers else []


def _two_at_once(study: Path, folder: Path, wanted: dict[str, str]) -> list[str]:
    both = [_sweep(study, folder, "--workers", "1") for _ in range(2)]
    said = [sweep.communicate()[1] for sweep in both]
    codes = sorted(sweep.returncode for sweep in both)
    refused = "another sweep is writing into" in "".join(said)
    return [
        *([] if codes == [0, 0] or (codes == [0, 2] and refused) else [f"ended with {codes}"]),
        *_faults(folder, wanted),
    ]


def _files(folder: Path) -> dict[str, str]:
    found = sorted(path for path in folder.rglob("*") if path.is_file() and ".sweep" not in path.parts)
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in found
        if path.name not in MANIFEST
    }


def _faults(folder: Path, wanted: dict[str, str]) -> list[str]:
    """Return in what a folder differs from one that was left alone."""
    there, faults = _files(folder), []
    if there != wanted:
        off = {name for name in {*there, *wanted} if there.get(name) != wanted.get(name)}
        faults.append(f"{len(off)} files are not as undisturbed, such as {min(off)}")
    with (folder / "manifest.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    if sorted((row["file"], row["sha256"]) for row in rows) != sorted(wanted.items()):
        faults.append("the manifest does not tell every file once, with its checksum")
    return faults


if __name__ == "__main__":
    main()
