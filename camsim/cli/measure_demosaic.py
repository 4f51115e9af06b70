"""``camsim measure demosaic``: a ranking of results against the truth."""

from __future__ import annotations

import functools
import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from camsim.cli.measure import gamma_of
from camsim.cli.measured import Outputs
from camsim.cli.tables import check_text_file, print_table
from camsim.errors import InputError, InvalidValueError
from camsim.files.atomic import together, write_whole

if TYPE_CHECKING:
    from camsim.camera.capture import Capture
    from camsim.cli.measure_demosaic_page import Page
    from camsim.core.arrays import F32
    from camsim.measure.demosaic import Ranking, Subject, Verdict

HEADS = (
    "method",
    "CPSNR dB",
    "R dB",
    "G dB",
    "B dB",
    "developed dB",
    "SSIM",
    "MS-SSIM",
    "ΔE2000",
    "95 %",
    "zipper %",
    "false colour ΔC",
    "shift px",
    "faults",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class DemosaicRequest:
    """The options of the command, as the user gave them."""

    files: tuple[str, ...]
    published: bool
    programs: tuple[str, ...]
    result: str
    sensor: str | None
    sensors: tuple[str, ...]
    changes: tuple[str, ...]
    gamma: str | None
    cfa: str | None
    white: float | None
    border: int
    html: str | None
    outputs: Outputs

    @property
    def of_scenes(self) -> bool:
        """Whether the arguments are scenes to be captured; otherwise they are a truth and results."""
        return self.published or bool(self.programs)


def measure(request: DemosaicRequest) -> None:
    """Evaluate, print and write; raises CamsimError with one sentence."""
    from camsim.cli.measure_demosaic_page import Page

    _check(request)
    page = Page() if request.html is not None else None
    rankings = list((_of_scenes if request.of_scenes else _of_results)(request, page))
    with together():
        request.outputs.write(*_figures(rankings), functools.partial(_draw, rankings))
        if page is not None and request.html is not None:
            write_whole(request.html, page.html(rankings).encode("utf-8"))
    request.outputs.tell(rankings, _print)


def _draw(rankings: Sequence[Ranking], file: str) -> bytes:
    from camsim.cli.plot_demosaic import draw

    return draw(rankings, file)


def _print(ranking: Ranking) -> None:
    print_table(_title(ranking), HEADS, [row_of(verdict) for verdict in ranking.verdicts])
    for verdict in ranking.verdicts:
        for fault in verdict.faults:
            print(f"{verdict.method}: {fault.name}: {fault.sentence}")
    for sentence in ranking.left_out:
        print(f"left out: {sentence}")


def _check(request: DemosaicRequest) -> None:
    """Raise early for impossible requests."""
    request.outputs.check({"--html": request.html})
    if request.html is not None:
        check_text_file(request.html, force=request.outputs.force)
    if not request.of_scenes and len(request.files) < 2:
        raise InvalidValueError(
            "give a truth and one result or more, or scenes with --all (published methods) or --run (a program)",
            key="FILE",
        )
    _check_options(request)
    from camsim.measure.demosaic.program import check_command
    from camsim.measure.demosaic.similarity import scikit_metrics

    for template in request.programs:
        check_command(template, request.result)
    scikit_metrics()


def _check_options(request: DemosaicRequest) -> None:
    """Raise for options without effect: those of scenes with files, those of a truth with scenes."""
    of_files = {"--cfa": request.cfa is not None, "--white": request.white is not None}
    of_scenes = {"--sensor": request.sensor, "--set": request.changes, "--sensors": request.sensors}
    for option, given in (of_files if request.of_scenes else of_scenes).items():
        if given:
            what = "a truth in a file" if request.of_scenes else "scenes, with --all or --run"
            raise InvalidValueError(f"is for {what}; leave it out", key=option)


def _of_scenes(request: DemosaicRequest, page: Page | None) -> Iterator[Ranking]:
    """Capture every scene and run methods and programs on its mosaic."""
    from camsim.api import load
    from camsim.measure.demosaic import Method, compete, evaluate, methods, ranked, run_program
    from camsim.measure.demosaic.subject import subject_of_capture

    for scene in request.files:
        capture = load(
            scene,
            sensor=request.sensor,
            overrides=request.changes,
            sensors=request.sensors,
            products=("mosaic", "truth"),
        )
        frame = capture.frame(products=("mosaic", "truth"))
        assert frame.truth is not None
        subject = subject_of_capture(capture, frame.truth, border=request.border)
        keep = _keeper(page, subject)
        entries: list[Method]
        entries, why = methods(frame) if request.published else ([], [])
        ranking = compete(subject, frame, entries, left_out=why, on_verdict=keep)
        verdicts = list(ranking.verdicts)
        for template in request.programs:
            found = run_program(template, frame, suffix=request.result, gamma=gamma_of(request.gamma))
            verdict, image = evaluate(found, subject, method=template)
            keep(verdict, image)
            verdicts.append(verdict)
        yield ranked(subject, verdicts, ranking.left_out)


def _of_results(request: DemosaicRequest, page: Page | None) -> Iterator[Ranking]:
    """Compare results with a truth."""
    from camsim.measure.demosaic import evaluate, ranked
    from camsim.measure.demosaic.subject import planes_of
    from camsim.measure.reading import read_picture

    truth, *results = request.files
    subject = _subject(truth, request)
    keep = _keeper(page, subject)
    verdicts = []
    for file in results:
        found = planes_of(read_picture(file, gamma=gamma_of(request.gamma)))
        verdict, image = evaluate(found, subject, method=file)
        keep(verdict, image)
        verdicts.append(verdict)
    yield ranked(subject, verdicts)


def _keeper(page: Page | None, subject: Subject) -> Any:
    if page is None:
        return lambda verdict, image: None
    page.begin(subject)
    return page.keep


def _subject(file: str, request: DemosaicRequest) -> Subject:
    """Return the truth of a file: electrons of camsim, a repeated capture of camsim, or any picture."""
    import numpy as np

    from camsim.config.from_record import capture_from_record
    from camsim.measure.demosaic import subject_of_picture
    from camsim.measure.demosaic.subject import subject_of_capture
    from camsim.measure.filters import filter_rows
    from camsim.measure.reading import read_picture

    picture = read_picture(file)
    if picture.description is None:
        pattern = None if request.cfa is None else filter_rows(request.cfa)
        return subject_of_picture(picture, cfa=pattern, border=request.border, white=request.white)
    for option, given in (("--cfa", request.cfa), ("--white", request.white)):
        if given is not None:
            raise InvalidValueError(f"{file} says it itself; leave it out", key=option)
    capture: Capture = replace(capture_from_record(picture.description), scene_name=file)
    channels = capture.camera.cfa.channels
    planes = {plane.name: plane.samples for plane in picture.planes}
    whole = all(plane.step == (1, 1) for plane in picture.planes) and set(planes) == set(channels)
    truth: F32 | None
    if whole and len(channels) > 1 and not _is_integer(planes[channels[0]]):
        truth = np.stack([planes[name] for name in channels], axis=2).astype(np.float32)
    else:
        print(f"{file} holds no truth in electrons; it is computed again from what the file says", file=sys.stderr)
        truth = capture.frame(products=("truth",)).truth
    if truth is None:
        raise InputError(f"{file!r} tells no truth")
    return subject_of_capture(capture, truth, border=request.border)


def _is_integer(samples: Any) -> bool:
    return bool(samples.dtype.kind in "ui")


def _title(ranking: Ranking) -> str:
    clipped = f", {ranking.clipped} clipped photosites and their neighbours left out" if ranking.clipped else ""
    cfa = f", {ranking.cfa}" if ranking.cfa else ""
    return f"{ranking.subject}: {ranking.rows} × {ranking.cols} photosites{cfa}, {ranking.photosites} compared{clipped}"


def row_of(verdict: Verdict) -> tuple[str, ...]:
    """Return a verdict as the texts of a table's row."""
    return (
        verdict.method,
        "∞ (identical)" if verdict.identical else _decibels(verdict.cpsnr_db),
        *(_decibels(value) for value in verdict.psnr_db),
        _decibels(verdict.cpsnr_developed_db),
        f"{verdict.ssim:.4f}",
        "–" if math.isnan(verdict.ms_ssim) else f"{verdict.ms_ssim:.4f}",
        f"{verdict.delta_e_mean:.2f}",
        f"{verdict.delta_e_95:.2f}",
        f"{100.0 * verdict.zipper:.1f}",
        f"{verdict.false_colour:.2f}",
        " ".join(f"{round(shift, 2) + 0.0:+.2f}" for shift in (verdict.shift_x_px, verdict.shift_y_px)),
        ", ".join(fault.name for fault in verdict.faults) or "none",
    )


def _decibels(value: float) -> str:
    return "∞" if math.isinf(value) else f"{value:.2f}"


def _figures(rankings: Sequence[Ranking]) -> tuple[list[str], list[list[object]]]:
    """Return heads and one row per ranking and method."""
    rows: list[list[object]] = []
    heads: list[str] = []
    for ranking in rankings:
        for entry in ranking.as_dict()["verdicts"]:
            flat: dict[str, object] = {"subject": ranking.subject}
            for key, value in entry.items():
                if isinstance(value, dict):
                    flat |= {f"{key}_{name.lower()}": each for name, each in value.items()}
                else:
                    flat[key] = "; ".join(fault["name"] for fault in value) if key == "faults" else value
            heads = list(flat)
            rows.append(["" if value is None else value for value in flat.values()])
    return heads, rows
