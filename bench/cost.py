"""What ``camsim explain`` predicts against what captures take: ``python -m bench.cost`` on all shipped scenes.

Seconds are CPU seconds of one process, all threads added up, so that a busy machine measures the same; the first
capture of each scene compiles and fills caches, the second is measured. Memory is the growth of the process's peak.
Prices of ``rendering/boundary/cost.py`` were fitted to such figures, of these scenes and of squares and discs of other
numbers, f-numbers, light and tolerances.
"""

from __future__ import annotations

import json
import multiprocessing
import resource
import time

import numpy as np

SCENES = ("colorchecker", "edge-chart", "flat-field", "knife-edge", "paper-square", "slanted-edge")


def one(name: str) -> dict[str, float]:
    """Return expected and measured seconds and bytes of a scene's capture (nothing is written)."""
    from camsim.api import load
    from camsim.cli.explain import explained

    small = load("slanted-edge", overrides=["region.rows=16", "region.cols=16", "region.origin=null"])
    small.frame()  # kernels and libraries are there from now on
    setup = load(name)
    stated = explained(setup, ("mosaic",), [])
    expected = stated["expected"]
    begin_bytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    seconds, rendering = [], []
    for _ in range(3):
        begin = time.process_time()
        setup.frame()
        seconds.append(time.process_time() - begin)
        choice = setup.plan()
        job = choice.plan.job
        channel = setup.camera.cfa.channel_index(job.grid.rows, job.grid.cols, job.grid.origin)
        begin = time.process_time()
        image = np.concatenate(list(choice.plan.bands(channel, lambda done: None)))
        rows, cols = choice.checker.hardest(choice.plan)
        choice.checker.values(rows, cols, channel[rows, cols])
        rendering.append(time.process_time() - begin)
        del image
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 - begin_bytes
    return {
        "expected_s": sum(expected["seconds"].values()),
        "seconds": float(np.median(seconds)),
        "expected_render_s": expected["seconds"]["render"],
        "render_s": float(np.median(rendering)),
        "expected_bytes": expected["memory_bytes"],
        "bytes": peak,
    }


def main() -> None:
    """Measure every scene in a process of its own."""
    for name in SCENES:
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            line = pool.apply(one, (name,))
        ratios = {
            "time": line["expected_s"] / line["seconds"],
            "render": line["expected_render_s"] / line["render_s"],
            "memory": line["expected_bytes"] / max(line["bytes"], 1),
        }
        print(
            name,
            {k: round(v, 2) for k, v in ratios.items()},
            json.dumps({k: float(f"{v:.3g}") for k, v in line.items()}),
        )


if __name__ == "__main__":
    main()
