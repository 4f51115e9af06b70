"""What the figures say, in words: computed from the lines alone, and written among them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any

from bench.paper.cases import PSFS
from bench.results import of_kind
from camsim.bench.records import Line

LEVELS = tuple(10.0**-k for k in range(2, 11))
NOISE = 1.15  # two times that differ by less are the same
TABLE_PSF = "airy-f8-box"
# The paper's own program on the same square (Airy f/8 + photosite, 2025 samples), run earlier on a quiet machine with
# two cores: bench/paper/README.md. The entries of the paper's tables are in the paper; they are not repeated here.
PAPERS_PROGRAM = {"samples": 2025, "wall_s": 7.2, "peak_mb": 62.0, "error_max": 4.3e-3, "error_rms": 1.3e-3}


def contender(point: Line) -> str:
    """Return whose point it is: camsim's method, or the other program."""
    if point["program"] == "camsim":
        return str(point["method"])
    return str(point["program"]) + (", constant subtracted" if point.get("constant_subtracted") else "")


def true_error(point: Line) -> float:
    """Return the largest error found, on the windows of all shifts and anywhere on the clocked frame."""
    return max(float(point["error_max"]), float(point.get("error_frame_max", 0.0)))


def seconds(point: Line) -> float | None:
    """Return CPU seconds on one thread, set-up and check included; None when it was not clocked."""
    return float(point["one_thread"]["cpu_s"]) if "one_thread" in point else None


def cheapest(points: Iterable[Line], level: float) -> Line | None:
    """Return the quickest point whose true error is no more than ``level``."""
    good = [p for p in points if true_error(p) <= level and seconds(p) is not None]
    return min(good, key=lambda p: seconds(p) or 0.0) if good else None


def findings(lines: Iterable[Line]) -> Iterator[dict[str, Any]]:
    """Yield what is to be said: topic, sentence, and the figures that it rests on."""
    points = of_kind(lines, "point")
    for name in PSFS:
        mine = [p for p in points if p["psf"] == name and seconds(p) is not None]
        # Elsewhere ``auto`` alone is clocked, and nothing is to be said.
        if {"auto"} < {contender(p) for p in mine}:
            yield _fastest(name, mine)
    here = [p for p in points if p["psf"] == TABLE_PSF]
    for theirs in here:
        if theirs["program"] != "camsim" and seconds(theirs) is not None:
            yield _ratio(theirs, here)
    for sampled in here:
        if sampled["method"] == "importance" and sampled["samples"] == PAPERS_PROGRAM["samples"]:
            yield _as_the_paper(sampled)


def _fastest(name: str, points: list[Line]) -> dict[str, Any]:
    """Say where ``auto`` is the fastest of all, and where it is not."""
    others = [p for p in points if contender(p) != "auto"]
    auto = [p for p in points if contender(p) == "auto"]
    won: list[float] = []
    lost: dict[str, list[float]] = {}
    unreached: list[float] = []
    for level in LEVELS:
        ours, theirs = cheapest(auto, level), cheapest(others, level)
        if ours is None:
            unreached.append(level)
        elif theirs is None or (seconds(ours) or 0.0) <= NOISE * (seconds(theirs) or 0.0):
            won.append(level)
        else:
            pair = f"{theirs['label']} takes {_ms(theirs)} ms and {ours['label']} {_ms(ours)} ms"
            lost.setdefault(pair, []).append(level)
    if lost:
        beaten = sum(len(levels) for levels in lost.values())
        words = f"auto is the fastest at {len(won)} of {len(won) + beaten} errors; "
        words += "; ".join(f"{_span(levels)} {pair}" for pair, levels in lost.items())
    elif won:
        words = f"auto is the fastest {_span(won, every='at every error ')}"
    else:
        words = "auto reaches none of the errors"
    if unreached and (won or lost):
        words += f"; {_power(unreached[0])} and less were not reached"
    return {
        "topic": "fastest",
        "psf": name,
        "sentence": f"{PSFS[name].label}: {words}.",
        "won": won,
        "lost": [level for levels in lost.values() for level in levels],
        "unreached": unreached,
    }


def _ms(point: Line) -> str:
    return three_digits(1e3 * (seconds(point) or 0.0))


def three_digits(value: float) -> str:
    """Return a number of everyday size with three digits that count.

    >>> three_digits(1162.7), three_digits(53.28)
    ('1160', '53.3')
    """
    return f"{float(f'{value:.3g}'):g}"


def _power(level: float) -> str:
    """Return a decade in words.

    >>> _power(1e-2), _power(1e-10)
    ('1e-2', '1e-10')
    """
    return f"1e{round(math.log10(level))}"


def _span(levels: list[float], every: str = "") -> str:
    first, last = _power(levels[0]), _power(levels[-1])
    return f"at {first}" if first == last else f"{every}from {first} to {last}"


def _ratio(theirs: Line, points: list[Line]) -> dict[str, Any]:
    """Say how much faster ``auto`` reaches another program's error."""
    ours = cheapest([p for p in points if contender(p) == "auto"], true_error(theirs))
    if ours is None:
        sentence = f"{theirs['label']}: auto does not reach its error of {true_error(theirs):.2g}."
        return {"topic": "peer", "label": theirs["label"], "sentence": sentence}
    ratio = (seconds(theirs) or 0.0) / (seconds(ours) or 1.0)
    return {
        "topic": "peer",
        "label": theirs["label"],
        "ours": ours["label"],
        "ratio": ratio,
        "sentence": (
            f"{theirs['label']}: error {true_error(theirs):.2g}; camsim ({ours['label']}) is "
            f"{three_digits(ratio)} times faster at {true_error(ours):.2g}."
        ),
    }


def _as_the_paper(point: Line) -> dict[str, Any]:
    """Set the paper's sampling, run by our implementation, beside the paper's own program."""
    largest = true_error(point) / PAPERS_PROGRAM["error_max"]
    rms = float(point["error_rms"]) / PAPERS_PROGRAM["error_rms"]
    words = "both within a factor 2"
    if not all(0.5 <= r <= 2.0 for r in (largest, rms)):
        words = "not within a factor 2: the pattern is cut at 18 λN here (cut at 50 px: bench/paper/sampling.py)"
    return {
        "topic": "paper",
        "papers_program": PAPERS_PROGRAM,
        "error_max_ratio": largest,
        "error_rms_ratio": rms,
        "sentence": (
            f"The paper's sampling with {point['samples']} samples by our implementation: {largest:.2g} times the "
            f"largest and {rms:.2g} times the rms error of the paper's own program, {words}."
        ),
    }
