"""One run: truths, errors, times, memory, the paper's tables; every figure written as soon as it is known."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field

import numpy as np

from bench.paper import cases, esf, findings, table_two
from bench.paper.cases import Psf, Setting
from bench.paper.clocking import Clocks
from bench.paper.measuring import Drawn, cut_window, draw_window
from bench.paper.peers import Peer, settings_of_peer
from bench.results import Results
from bench.worker import GIVES_BACK, Worker, WorkerError
from camsim.bench.machine import Spin, spin, words_of_load
from camsim.core.arrays import F64
from camsim.core.cores import cores
from tests.truth.lattice import Lens, photosite_value, window_truths

FULL_SCALE = 65535.0
JUDGED = ((91, 106), (132, 101))  # (row, col) of the frame whose truth is computed twice: at a corner, along the edge
RATIOS = ", ratios are taken from CPU times"
Say = Callable[[float, str], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """What to measure.

    quick : fewer systems, shifts and laps: under a minute
    peers : the other programs to run
    paper : whether the paper's tables and panels are made
    """

    psfs: tuple[Psf, ...]
    methods: tuple[str, ...]
    quick: bool = False
    peers: tuple[Peer, ...] = ()
    paper: bool = True


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Truth:
    """What a system draws exactly: the window at every shift (shifts, rows, cols), and the frame at the middle one."""

    windows: F64
    frame: F64


@dataclass(slots=True)
class _Run:
    """What one run holds: its workers, its lines, and how far it is."""

    request: Request
    results: Results
    say: Say
    clocks: Clocks
    spins: list[Spin] = field(default_factory=list)
    truths: dict[str, Truth] = field(default_factory=dict)
    done: float = 0.0
    total: float = 1.0

    def settings(self, psf: Psf) -> list[Setting]:
        found = cases.settings_of(psf, self.request.methods, quick=self.request.quick)
        if psf.name in cases.CORE_PSFS:
            for peer in self.request.peers:
                found += settings_of_peer(peer, psf, quick=self.request.quick)
        return found

    def look(self, when: str) -> None:
        """Clock the fixed work once more and write down what it took."""
        self.spins.append(spin())
        now = self.spins[-1]
        self.results.add("load", when=when, cpu_s=now.cpu_s, wall_over_cpu=now.wall_over_cpu, busy=now.busy)

    def tell(self, words: str, weight: float) -> None:
        self.done += weight
        self.say(min(self.done / self.total, 1.0), words)


def run(request: Request, results: Results, say: Say) -> None:
    """Measure everything that the request names, line by line.

    say : called with the fraction done and what was just done
    """
    began = time.perf_counter()
    results.start(quick=request.quick)
    with ExitStack() as stack:

        def worker(threads: int, environment: dict[str, str] | None = None) -> Worker:
            new = Worker(threads=threads, environment=environment)
            stack.callback(new.stop)
            return new

        quick = request.quick
        state = _Run(
            request=request,
            results=results,
            say=say,
            clocks=Clocks(
                one=worker(1),
                all=worker(cores()),
                weigher=worker(cores(), GIVES_BACK),
                peers={peer.name: worker(1, GIVES_BACK) for peer in request.peers},
                laps=3 if quick else 7,
                budget_s=0.1 if quick else 0.4,
                longest_s=0.6 if quick else 3.0,
            ),
        )
        weights = [1.0 + len(state.settings(psf)) + 12.0 * _slow(psf, state) for psf in request.psfs]
        paper = sum(weights) / 8.0 if request.paper else 0.0
        state.total = sum(weights) + paper
        try:
            state.look("before")
            tables = request.paper
            for psf, weight in zip(request.psfs, weights, strict=True):
                if tables and psf.name not in cases.CORE_PSFS:  # what comes last is what an interruption costs
                    _table_two(state, paper)
                    tables = False
                _measure(psf, state, weight)
            if tables:
                _table_two(state, paper)
            state.look("after")
        finally:
            results.add("machine", busy=any(s.busy for s in state.spins), sentence=words_of_load(state.spins, RATIOS))
            for finding in findings.findings(results.lines):
                results.add("finding", **finding)
        results.add("end", seconds=time.perf_counter() - began)
        say(1.0, "done")


def _table_two(state: _Run, weight: float) -> None:
    table_two.measure_table(state.results, quick=state.request.quick, methods=state.request.methods)
    state.tell("the paper's Table II", weight)


def _slow(psf: Psf, state: _Run) -> int:
    return sum((s.samples or 0) > cases.IMPORTANCE[0] and cases.is_timed(psf, s) for s in state.settings(psf))


def _measure(psf: Psf, state: _Run, weight: float) -> None:
    """Everything about one system: its truth, then every setting's error, time and memory."""
    quick = state.request.quick
    shifts = cases.shifts_px(cases.shift_count(Setting(method="auto"), quick=quick))
    exact = _truth(psf, shifts, state)
    truth = exact.windows
    errors: dict[Setting, dict[str, object]] = {}
    times: dict[Setting, dict[str, object]] = {}
    refused: set[str] = set()
    settings = state.settings(psf)
    share = weight / (2 * len(settings) + 1)
    try:
        for setting in settings:
            if setting.method not in refused:
                found = _accuracy(psf, setting, shifts, truth, state)
                if found is None:
                    refused.add(setting.method)
                else:
                    errors[setting] = found
            state.tell(f"{psf.name}: error of {setting.label}", share)
        timed = [s for s in errors if cases.is_timed(psf, s, quick=quick)]
        for setting in state.clocks.clock(psf, timed, exact.frame, times):
            state.tell(f"{psf.name}: time of {setting.label}", share)
    finally:  # also when somebody interrupts: what is known of this system is worth keeping
        for setting, found in errors.items():
            _write(psf, setting, found, times.get(setting, {}), state)
    state.look(psf.name)
    state.tell(f"{psf.name}: written", share)


def _truth(psf: Psf, shifts: F64, state: _Run) -> Truth:
    """Return the exact window at every shift and the exact frame; samples of it are computed by another road.

    The systems of one lens share most of the work: the others' truths are kept until they are asked for.
    """
    began = time.perf_counter()
    lens = Lens(blur=psf.blurs_px(), weights=psf.spectrum()[1], gaussian=psf.gaussian)
    grid, polygon = cases.frame(), cases.corners_px()
    x0, y0 = grid.first_centre
    if psf.name not in state.truths:
        alike = [other for other in state.request.psfs if other.same_lens(psf)]
        covered = window_truths(
            polygon,
            lens,
            [(other.side_px, other.split_px) for other in alike],
            origin=(x0, y0),
            shape=(grid.rows, grid.cols),
            shifts=shifts,
        )
        for other, frames in zip(alike, 1.0 - covered, strict=True):
            state.truths[other.name] = Truth(windows=cut_window(frames), frame=frames[len(shifts) // 2].copy())
    truth = state.truths.pop(psf.name)
    judged = JUDGED[:1] if psf.split_px else JUDGED
    apart = [
        abs(
            1.0
            - photosite_value(polygon, x0 + col, y0 + row, lens, side=psf.side_px, split=psf.split_px)
            - truth.frame[row, col]
        )
        for row, col in judged
    ]
    state.results.add(
        "truth",
        psf=psf.name,
        label=psf.label,
        shifts=len(shifts),
        photosites=truth.frame.size,
        checked=len(judged),
        largest_difference=max(apart),
        seconds=time.perf_counter() - began,
    )
    return truth


def _accuracy(psf: Psf, setting: Setting, shifts: F64, truth: F64, state: _Run) -> dict[str, object] | None:
    """Return the errors over the window and the shifts; None when the program refuses."""
    count = min(cases.shift_count(setting, quick=state.request.quick), len(shifts))
    some = np.round(np.linspace(0, len(shifts) - 1, count)).astype(int) if count > 1 else np.array([len(shifts) // 2])
    worker, images, last = state.clocks.worker(setting, 0), [], Drawn(image=None)
    try:
        for k in some:
            last = worker.call(draw_window, psf, setting, tuple(shifts[k]))
            if last.image is None:
                state.results.add("refused", psf=psf.name, method=setting.method, label=setting.label, why=last.refused)
                return None
            images.append(last.image)
    except WorkerError as error:
        state.results.add("refused", psf=psf.name, method=setting.method, label=setting.label, why=str(error))
        return None
    if setting.method in esf.METHODS and psf.name in esf.PANELS:
        esf.add_panel(state.results, psf, setting, images, truth[some], shifts[some])
    image = np.stack(images)
    found = _figures(image, truth[some])
    found |= {"engine": last.engine, "error_estimate": last.error_estimate, "shifts": count}
    if setting.program == "GalSim":
        # What wraps round is a constant: the best constant taken off is a fair second look.
        found["without_constant"] = _figures(image - np.mean(image - truth[some]), truth[some])
    return found


def _figures(image: F64, truth: F64) -> dict[str, object]:
    """Return largest and root mean square error, as they are and after rounding to 16 bits."""
    error = image - truth
    codes = np.rint(FULL_SCALE * np.clip(image, 0.0, 1.0)) / FULL_SCALE - truth
    return {
        "error_max": float(np.abs(error).max()),
        "error_rms": float(np.sqrt(np.mean(error**2))),
        "error_mean": float(np.mean(error)),
        "error_max_16bit": float(np.abs(codes).max()),
        "error_rms_16bit": float(np.sqrt(np.mean(codes**2))),
    }


def _write(psf: Psf, setting: Setting, errors: dict[str, object], times: dict[str, object], state: _Run) -> None:
    what = {
        "psf": psf.name,
        "program": setting.program,
        "method": setting.method,
        "label": setting.label,
        "tolerance": setting.tolerance,
        "samples": setting.samples,
        "knob": setting.knob,
    }
    best, frame_max = errors.pop("without_constant", None), times.pop("error_frame_max_without_constant", None)
    state.results.add("point", **what, **errors, **times)
    if isinstance(best, dict):
        label = f"{setting.label}, its constant subtracted"
        if frame_max is not None:
            times["error_frame_max"] = frame_max
        state.results.add("point", **{**what, **errors, **best, **times, "label": label, "constant_subtracted": True})
