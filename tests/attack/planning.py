"""Systems planned, none rendered: what camsim expects of each, and a list of those that it expects to be slow."""

from __future__ import annotations

import time
import warnings
from collections import Counter

from camsim.errors import AccuracyError, InvalidValueError, UnsupportedError
from tests.attack import systems
from tests.attack.draw import draw
from tests.attack.judge import SLOWEST_S, described


def planned(seed, number):
    """Record of one system: the method chosen and why, seconds of one core and bytes expected, seconds of planning."""
    system = draw(seed, number)
    record = described(system, seed, number)
    begin = time.process_time()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            choice = systems.choice(system, tolerance=system["tolerance"], method=system["method"])
            image, whole = choice.plan.cost, choice.cost
    except (UnsupportedError, InvalidValueError, AccuracyError) as refused:
        return record | {"refused": f"{type(refused).__name__}: {refused}"}
    return record | {
        "method": choice.method, "why": choice.why, "expected": whole.seconds, "of_image": image.seconds,
        "memory_bytes": whole.memory_bytes, "planning": time.process_time() - begin,
    }  # fmt: skip


def line(record):
    """What is told of a system that is expected to be slow; None of the others."""
    if record.get("expected", 0.0) <= SLOWEST_S:
        return None
    return (
        f"{record['seed']}:{record['number']} {record['expected']:.0f} s expected, {record['of_image']:.0f} of them "
        f"for the image, {record['memory_bytes'] / 1e6:.0f} MB; {record['method']} of {record['asked']}: "
        f"{record['lens']}, {record['photosite']}, {record['olpf']}, λN {record['blur']:.3g}, "
        f"{record['rows']} × {record['cols']}, {record['tolerance']:.2g}; {record['why']}"
    )


def summary(records):
    """How many are slow, of which lenses; how long the slowest and the planning take."""
    seconds = [r["expected"] for r in records if "expected" in r]
    slow = Counter((r["lens"], r["method"]) for r in records if line(r))
    kinds = ", ".join(f"{lens} by {method} {count}" for (lens, method), count in slow.most_common())
    return (
        f"{len(records)} systems: {len(records) - len(seconds)} refused, {sum(slow.values())} expected over "
        f"{SLOWEST_S:g} s ({kinds or 'none'}); the slowest {max(seconds, default=0.0):.3g} s, "
        f"all of them {sum(seconds):.3g} s, planning {sum(r.get('planning', 0.0) for r in records):.3g} s"
    )
