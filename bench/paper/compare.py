"""Two runs side by side: what got slower, what got less accurate, noise taken into account."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from statistics import median
from typing import Any

from bench.paper.findings import seconds, true_error
from bench.results import of_kind
from camsim.bench.records import Line

SLOWER = 1.15  # at the least: below that two runs of the same program differ
SLOWER_WHEN_BUSY = 1.3  # other work on the cores shares their caches and units with us: CPU times grow too
SPREADS = 3.0  # and by three times the laps' own spread
LESS_ACCURATE = 1.25
FLOOR = 1e-13  # errors below the truth's own are all the same


def compared(old: Sequence[Line], new: Sequence[Line]) -> Iterator[dict[str, Any]]:
    """Yield what differs: topic, sentence and the figures it rests on; one summary first.

    Times are CPU times of one thread, the quickest of the laps, divided by the time that the same fixed arithmetic
    took in its run: a machine that is slower today is no fault of the program's.
    """
    before, after = _points(old), _points(new)
    both = [key for key in after if key in before]
    speed = _spin(new) / _spin(old)
    least = SLOWER_WHEN_BUSY if any(line["busy"] for line in of_kind([*old, *new], "machine")) else SLOWER
    slower: list[dict[str, Any]] = []
    worse: list[dict[str, Any]] = []
    better = 0
    for key in both:
        b, a = before[key], after[key]
        was, is_ = seconds(b), seconds(a)
        if was and is_:
            ratio = is_ / was / speed
            allowed = max(least, 1.0 + SPREADS * (b["one_thread"]["spread"] + a["one_thread"]["spread"]))
            better += ratio < 1.0 / allowed
            if ratio > allowed:
                words = f"{ratio:.2f} times slower ({1e3 * was:.3g} → {1e3 * is_:.3g} ms)"
                slower.append(_difference("slower", key, ratio, words))
        if true_error(a) > max(LESS_ACCURATE * true_error(b), FLOOR):
            words = f"error {true_error(b):.2g} → {true_error(a):.2g}"
            worse.append(_difference("less accurate", key, true_error(a) / true_error(b), words))
    words = f"{len(both)} settings compared: {len(slower)} slower, {better} faster, {len(worse)} less accurate"
    gone = len([key for key in before if key not in after])
    words += f"; {gone} of the older run were not measured" if gone else ""
    if old[0]["machine"] != new[0]["machine"]:
        words += "; the machines differ, so times are compared by what a fixed piece of arithmetic took on each"
    elif abs(speed - 1.0) > SLOWER - 1.0:
        words += f"; the same arithmetic took {speed:.2f} times as long as then, which is taken out"
    yield {"topic": "compared", "settings": len(both), "speed": speed, "sentence": f"{words}."}
    yield from sorted(slower, key=lambda line: -line["ratio"])
    yield from sorted(worse, key=lambda line: -line["ratio"])


def _difference(topic: str, key: tuple[str, str, int], ratio: float, words: str) -> dict[str, Any]:
    psf, label, _ = key
    return {"topic": topic, "psf": psf, "label": label, "ratio": ratio, "sentence": f"{psf}, {label}: {words}."}


def _points(lines: Sequence[Line]) -> dict[tuple[str, str, int], Line]:
    """Return the settings that can be compared: the same system, the same knob, errors over as many shifts."""
    return {(p["psf"], p["label"], p["shifts"]): p for p in of_kind(lines, "point")}


def _spin(lines: Sequence[Line]) -> float:
    return median(float(line["cpu_s"]) for line in of_kind(lines, "load"))
