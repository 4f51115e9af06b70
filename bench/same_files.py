"""The same manifest whoever takes a sweep or a data set: this process, 1, 2 or 4 others, a dask cluster over TCP.

``python -m bench.same_files`` prints a checksum of all files' names and checksums for each, and of a cluster of two
workers that ``dask worker`` has begun; it exits with 1 when they differ.
"""

from __future__ import annotations

import hashlib
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import camsim
from bench.cluster import cluster

STUDY = {
    "scene": "slanted-edge",
    "set": {"region": {"rows": 64, "cols": 64}, "render.tolerance": 1e-3},
    "vary": {"lens.f_number": {"linear": [4, 16, 24]}, "exposure.iso": [200, 1600]},
}
DATASET = {
    **STUDY,
    "scene": ["slanted-edge", "grey-steps", "checkerboard"],
    "vary": {"exposure.iso": [200, 1600], "lens.f_number": {"linear": [4, 16, 8]}},
    "crops": {"rows": 32, "cols": 32, "each": 3},
    "samples_per_shard": 32,
}
WORKERS = (0, 1, 2, 4)


def main() -> None:
    """Print a line for each; exit with 1 when not all are the same."""
    same = True
    with tempfile.TemporaryDirectory() as place, cluster(2) as (address, _):
        engines: dict[str, dict[str, Any]] = {f"{count} workers": {"workers": count} for count in WORKERS}
        engines["a cluster of 2 over TCP"] = {"scheduler": address}
        makers: tuple[tuple[str, Callable[..., Any], dict[str, Any]], ...] = (
            ("sweep", camsim.sweep, STUDY),
            ("data set", camsim.dataset, DATASET),
        )
        for what, make, study in makers:
            found = set()
            for name, engine in engines.items():
                done = make(study, Path(place) / what / name, **engine)
                found.add(sums := _sums(done.rows))
                print(f"{what}, {name}: {len(done.rows)} rows, {done.failed} failed, {sums}", flush=True)
                same &= not done.failed
            same &= len(found) == 1
    print("all the same" if same else "not the same")
    sys.exit(0 if same else 1)


def _sums(rows: tuple[dict[str, Any], ...]) -> str:
    stated = repr([(row["index"], row["file"], row["sha256"], row.get("place")) for row in rows])
    return hashlib.sha256(stated.encode()).hexdigest()[:16]


if __name__ == "__main__":
    main()
