"""One bench of one scene: window, truths, then every setting's error and time."""

from __future__ import annotations

import gc
import math
import os
import time
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from camsim.bench.machine import machine, spin, versions, words_of_load
from camsim.bench.records import Bench, Finding, Head, LeftOut, Point, Record, TruthLine
from camsim.bench.settings import METHODS, SAMPLES, Setting, default_tolerances, settings_of
from camsim.bench.subject import Subject
from camsim.bench.truths import Truth, is_the_truth, truth_of_engine, truths_of
from camsim.bench.window import busiest
from camsim.bench.words import findings
from camsim.camera.window import Region
from camsim.core.typed import NonNegative, check
from camsim.errors import CamsimError
from camsim.rendering import Rendering

if TYPE_CHECKING:
    from camsim.camera.capture import Capture

LAPS = 3
LONG_S = 1.0  # renderings that take longer are timed once
LONGEST_S = 3.0  # expected, of one core: longer renderings are left out
TRUTH_TIMES = 4.0  # factor on that for a truth, which is rendered once

Take = Callable[[Record], None]
Progress = Callable[[str, float], None]


def bench_scene(
    scene: str | os.PathLike[str],
    *,
    sensor: str | os.PathLike[str] | None = None,
    overrides: Iterable[str] = (),
    sensors: Iterable[str | os.PathLike[str]] = (),
    methods: Sequence[str] = METHODS,
    tolerances: Sequence[float] | None = None,
    samples: Sequence[int] = SAMPLES,
    region: Region | None = None,
    whole: bool = False,
    longest_s: float = LONGEST_S,
    take: Take | None = None,
    progress: Progress | None = None,
) -> Bench:
    """Measure error against run time for a scene: every method at every tolerance, on a window of its frame.

    scene, sensor, overrides, sensors : see ``camsim.capture``
    methods    : methods of ``camsim.render``; ``importance`` takes ``samples``
    tolerances : every second decade from 1e-2 to 1e-8 and the scene's own when left out
    region     : the window, of the sensor's frame; the busiest 128 × 128 photosites when left out
    whole      : take the scene's own region instead
    longest_s  : leave out what is expected to take more seconds of one core; a truth may take four times that
    take       : called with every record as soon as it is known
    progress   : called with (what is done, fraction)

    Rendered is what a capture renders: mean electrons of every photosite in its own channel, before fall-off, crosstalk
    and noise. Errors are relative to full scale, the larger of a perfect diffuser and the brightest surface.

    >>> from camsim.camera.window import Region
    >>> found = bench_scene("paper-square", methods=("boundary",), tolerances=(1e-3,), region=Region(rows=4, cols=4))
    >>> [point.label for point in found.points]
    ['boundary 1e-3']
    """
    from camsim.api import load

    capture = load(scene, sensor=sensor, overrides=overrides, sensors=sensors)
    wanted = default_tolerances(capture.tolerance) if tolerances is None else tolerances
    check(longest_s, NonNegative, "longest_s")
    check(take, Take | None, "take")
    check(progress, Progress | None, "progress")
    settings = settings_of(methods, wanted, samples)
    where, chosen = _window(capture, region, whole=whole)
    subject = Subject.of(capture, where)
    run = _Run(take or (lambda record: None), progress or (lambda words, fraction: None), len(settings) + 2)
    run.add(_head(capture, subject, chosen))
    spins = [spin()]
    truths = truths_of(subject, longest_s=TRUTH_TIMES * longest_s, tell=run.tell)
    for truth in truths.values():
        run.add(truth.line)
    left: set[str] = set()
    warm: set[str] = set()
    for setting in settings:
        run.tell(setting.label)
        if setting.method not in warm:
            subject.warm(setting.method)
            warm.add(setting.method)
        # Settings of a method are ordered: those after a refused one are refused too.
        if setting.method not in left:
            record = _measured(subject, setting, truths, longest_s)
            run.add(record)
            if isinstance(record, LeftOut):
                left.add(setting.method)
    spins.append(spin())
    for sentence in (*findings(run.records), words_of_load(spins)):
        run.add(Finding(sentence=sentence))
    run.tell("done")
    return bench_of(run.records)


def bench_of(records: Sequence[Record]) -> Bench:
    """Return the records, grouped by kind."""
    (head,) = (r for r in records if isinstance(r, Head))
    return Bench(
        head=head,
        truths=tuple(r for r in records if isinstance(r, TruthLine)),
        points=tuple(r for r in records if isinstance(r, Point)),
        left_out=tuple(r for r in records if isinstance(r, LeftOut)),
        findings=tuple(r for r in records if isinstance(r, Finding)),
    )


class _Run:
    """The records so far, passed on immediately."""

    def __init__(self, take: Take, progress: Progress, steps: int) -> None:
        self.records: list[Record] = []
        self._take, self._progress, self._steps, self._done = take, progress, steps, 0

    def add(self, record: Record) -> None:
        self.records.append(record)
        self._take(record)

    def tell(self, words: str) -> None:
        self._progress(words, min(self._done / self._steps, 1.0))
        self._done += 1


def _window(capture: Capture, region: Region | None, *, whole: bool) -> tuple[Region | None, str]:
    """Return the window, None for the scene's whole capture, and the reason in words."""
    if region is not None:
        return region, "asked for"
    found = busiest(capture.scene, capture.grid)
    if whole or (found.rows, found.cols) == (capture.grid.rows, capture.grid.cols):
        return None, "all that the scene captures"
    return found, f"the {'busiest part' if capture.scene.shapes else 'middle'} of what the scene captures"


def _head(capture: Capture, subject: Subject, chosen: str) -> Head:
    grid = subject.grid
    return Head(
        scene=capture.scene_name,
        camera=capture.camera.name,
        rows=grid.rows,
        cols=grid.cols,
        origin=grid.origin,
        frame_rows=capture.grid.rows,
        frame_cols=capture.grid.cols,
        chosen=chosen,
        tolerance=capture.tolerance,
        wavelengths=int(np.count_nonzero(np.any(subject.response > 0.0, axis=0))),
        channels=capture.camera.cfa.channels,
        machine=machine(),
        versions=versions(),
    )


def _left_out(setting: Setting, why: str) -> LeftOut:
    return LeftOut(method=setting.method, label=setting.label, why=why)


def _measured(subject: Subject, setting: Setting, truths: dict[str, Truth], longest_s: float) -> Point | LeftOut:
    """Render a setting, repeatedly if fast, and compare it with the truth."""
    if is_the_truth(setting, truths):
        return _left_out(setting, "it is the truth itself: no other engine judges it")
    try:
        expected = subject.plan(setting).cost.seconds
        if expected > longest_s:
            return _left_out(
                setting, f"it would take about {expected:.0f} s of one core; look at a smaller region for it"
            )
        rendering, laps = _clocked(subject, setting)
    except CamsimError as refusal:
        return _left_out(setting, str(refusal))
    truth = truth_of_engine(truths, rendering.method)
    error = subject.relative(rendering.image) - truth.image
    row, col = np.unravel_index(int(np.argmax(np.abs(error))), error.shape)
    wall_s, cpu_s = min(laps)
    return Point(
        method=setting.method,
        label=setting.label,
        tolerance=setting.tolerance,
        samples=setting.samples,
        engine=rendering.method,
        error_max=float(np.abs(error).max()),
        error_rms=math.sqrt(float(np.mean(error**2))),
        row=subject.grid.origin[0] + int(row),
        col=subject.grid.origin[1] + int(col),
        truth=f"{truth.line.engine} at {truth.line.tolerance:g}",
        accurate_to=truth.line.accurate_to,
        error_estimate=rendering.error_estimate,
        wall_s=wall_s,
        cpu_s=cpu_s,
        first_wall_s=laps[0][0],
        laps=len(laps),
    )


def _clocked(subject: Subject, setting: Setting) -> tuple[Rendering, list[tuple[float, float]]]:
    """Return the rendering, and wall and CPU seconds of every lap."""
    laps: list[tuple[float, float]] = []
    while True:
        gc.collect()
        wall, cpu = time.perf_counter(), time.process_time()
        rendering = subject.render(setting)
        laps.append((time.perf_counter() - wall, time.process_time() - cpu))
        if len(laps) >= LAPS or laps[-1][0] > LONG_S:
            return rendering, laps
