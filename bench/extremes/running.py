"""The extremes as a run of their own: each case as a line."""

from __future__ import annotations

import time
from collections.abc import Callable

from bench.extremes import judging, sensor_cases
from bench.results import Results

FAILED = "wrong"


def run_extremes(results: Results, say: Callable[[float, str], None]) -> int:
    """Run every stiff and extreme case; return how many came out wrong. One that breaks does not stop the others."""
    failed, everything, begin = 0, (*judging.cases(), *sensor_cases.cases()), time.perf_counter()
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
