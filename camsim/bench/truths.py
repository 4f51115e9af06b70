"""The truth of a window: both exact engines at their finest, each checked directly at some photosites.

Pictures, gradients and points are supported by one of them: then there is one truth, which is stated.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from camsim.bench.records import TruthLine
from camsim.bench.settings import EXACT, Setting, power
from camsim.bench.subject import Subject
from camsim.core.arrays import F64
from camsim.errors import CamsimError, UnsupportedError

FINEST = (1e-9, 1e-8, 1e-7, 1e-6)  # tried in turn
FINER = 5.0  # ratio of tolerances required of a truth for its own engine


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Truth:
    """One truth: its image (rows, cols) relative to full scale, and its accuracy."""

    image: F64
    line: TruthLine


def truths_of(
    subject: Subject, *, longest_s: float, tell: Callable[[str], None] = lambda words: None
) -> dict[str, Truth]:
    """Return the truth of each engine that has one, by its name; UnsupportedError when none has.

    longest_s : renderings expected to take longer, seconds of one core, are not tried
    """
    found: dict[str, Truth] = {}
    without: dict[str, str] = {}
    for engine in EXACT:
        setting, why = _finest(subject, engine, longest_s)
        if setting is None:
            without[engine] = why
            continue
        tell(f"truth: {setting.label}")
        rendering = subject.render(setting)
        found[engine] = Truth(
            image=subject.relative(rendering.image),
            line=TruthLine(
                engine=rendering.method,
                tolerance=setting.asked,
                checked_to=rendering.error_estimate,
                checked_photosites=rendering.checked_photosites,
                accurate_to=rendering.error_estimate,
                seconds=rendering.seconds,
            ),
        )
    if not found:
        reasons = "; ".join(f"{engine}: {why}" for engine, why in without.items())
        raise UnsupportedError(
            f"no engine renders this window finely enough as a truth for the others ({reasons})", key="method"
        )
    if len(found) == 2:
        apart = float(np.abs(found["boundary"].image - found["fourier"].image).max())
        coarser = max(found, key=lambda engine: (found[engine].line.tolerance, found[engine].line.checked_to))
        for engine, truth in found.items():
            # Direct checks cover some photosites; remaining differences are attributed to the coarser truth.
            accurate_to = max(truth.line.checked_to, apart if engine == coarser else 0.0)
            found[engine] = replace(truth, line=replace(truth.line, difference=apart, accurate_to=accurate_to))
    return found


def _finest(subject: Subject, engine: str, longest_s: float) -> tuple[Setting | None, str]:
    """Return the finest setting of an engine within the time; else None and the reason for the finest refused."""
    reasons: list[str] = []
    for tolerance in FINEST:
        setting = Setting(method=engine, tolerance=tolerance)
        try:
            seconds = subject.plan(setting).cost.seconds
        except CamsimError as error:
            reasons.append(str(error))
            continue
        if seconds <= longest_s:
            return setting, ""
        reasons.append(f"at {power(tolerance)} it would take about {seconds:.0f} s; look at a smaller region")
    return None, reasons[-1]


def is_the_truth(setting: Setting, truths: dict[str, Truth]) -> bool:
    """Whether a setting is the engine of the only truth, and hardly coarser, so not comparable."""
    (name, truth), *others = truths.items()
    of_it = setting.method in (name, "auto")
    return not others and of_it and setting.asked < FINER * truth.line.tolerance


def truth_of_engine(truths: dict[str, Truth], engine: str) -> Truth:
    """Return the truth for an engine: the other engine's if available; of two the more accurate."""
    others: Sequence[Truth] = [truth for name, truth in truths.items() if name != engine] or list(truths.values())
    return min(others, key=lambda truth: truth.line.accurate_to)
