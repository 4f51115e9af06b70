"""The extremes as a run of their own: each case as a line."""

from __future__ import annotations

import time
from collections.abc import Callable

from camsim.bench.machine import cores, machine, versions
from camsim.bench.results import FORMAT, Results

FAILED = "wrong"


def start(results: Results, *, quick: bool) -> None:
    """Write what the run is."""
    results.add(
        "run",
        format=FORMAT,
        quick=quick,
        started=time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
        machine=machine(),
        versions=versions(),
        threads=cores(),
    )


def run_extremes(results: Results, say: Callable[[float, str], None]) -> int:
    """Run every stiff and extreme case; return how many came out wrong. One that breaks does not stop the others."""
    from camsim.bench import extremes, sensor_extremes

    failed, everything, begin = 0, (*extremes.cases(), *sensor_extremes.cases()), time.perf_counter()
    for number, case in enumerate(everything, 1):
        began = time.perf_counter()
        line: dict[str, object] = {"name": case.name, "input": case.input}
        try:
            found = case.run()
        except Exception as error:
            line |= {"seconds": time.perf_counter() - began, "verdict": FAILED}
            line |= {"truth": f"{type(error).__name__}: {error}"}
        else:
            line |= {"asked": found.asked, "reached": found.reached, "truth": found.truth}
            line |= {"seconds": found.seconds, "verdict": found.verdict}
        failed += line["verdict"] == FAILED
        results.add("extreme", **line)
        say(number / len(everything), f"{case.name}: {line['verdict']}")
    words = "all are right or refused with a reason" if not failed else f"{failed} are wrong"
    results.add("finding", topic="extremes", sentence=f"{len(everything)} stiff and extreme cases: {words}.")
    results.add("end", seconds=time.perf_counter() - begin)
    return failed
