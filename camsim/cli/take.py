"""``camsim capture``: check, expose, write, report."""

from __future__ import annotations

import dataclasses
import json
import sys
import time
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camsim.cli import outputs as outputs_of
from camsim.cli.outputs import Output
from camsim.cli.progress import Bar
from camsim.cli.row_by_row import come_row_by_row, write_mosaics
from camsim.core.garbage import look_in_new
from camsim.errors import CamsimError, InvalidValueError, OutputError
from camsim.files.atomic import made_together, together

if TYPE_CHECKING:
    from camsim.camera.capture import Capture
    from camsim.camera.frame import Frame, Products, Report
    from camsim.camera.shot import Shot


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """The user's request, and the time at which it was made (``time.perf_counter``)."""

    scene: str
    sensor: str | None
    sensors: tuple[str, ...]
    changes: tuple[str, ...]
    seed: int | None
    frames: int
    outputs: tuple[str, ...]
    pairs: str | None
    levels: str | None
    allow_odd_cfa: bool
    compress: bool
    force: bool
    as_json: bool
    quiet: bool
    verbose: bool
    began_s: float


def take(request: Request) -> None:
    """Take the picture; raises CamsimError with every fault of the request before any work is done."""
    texts = request.outputs or (f"{Path(request.scene).stem}.dng",)
    outputs, errors = outputs_of.check(outputs_of.numbered(texts, request.frames), force=request.force)
    products = {output.product for output in outputs}
    held = request.frames > 1 or not come_row_by_row(outputs)
    from camsim.api import load_any

    try:
        ready = load_any(
            request.scene,
            sensor=request.sensor,
            overrides=request.changes,
            seed=request.seed,
            products=products,
            sensors=request.sensors,
            held=held,
        )
        warning = odd_cfa_of(tuple(ready.camera.cfa.pattern), outputs, allowed=request.allow_odd_cfa)
    except CamsimError as error:
        # The file's name follows from the scene's: without a scene it cannot be checked.
        errors = [error, *(errors if request.outputs else ())]
    if request.compress:
        errors += compression_faults(outputs)
    if errors:
        raise CamsimError("\n".join(str(error) for error in errors))
    if warning:
        print(f"camsim: warning: {warning}", file=sys.stderr)
    look_in_new()
    ready_s = time.perf_counter()
    # Of all frames; each frame's report has separate ones.
    seconds = defaultdict[str, float](float, {"set up": ready_s - request.began_s})
    with Bar(displayed=not request.quiet) as bar, together():
        if held:
            frames = ready.frames(request.frames, products=products, progress=bar.update)
        else:
            frames = iter((_take_rows(ready, outputs, products, bar, request),))
        for number, frame in enumerate(frames):
            began_s = time.perf_counter()
            of_frame = outputs[number * len(texts) : (number + 1) * len(texts)]
            _write(frame, [output for output in of_frame if held or output.product == "spectral"], bar, request)
            for name, its_s in frame.report.seconds.items():
                seconds[name] += its_s
            seconds["write"] += time.perf_counter() - began_s
    done_s = time.perf_counter()
    total_s = done_s - request.began_s
    frame = dataclasses.replace(frame, report=with_files(frame, outputs))
    if not request.quiet:
        from camsim.cli.report import print_report

        print_report(frame, outputs, seconds, total_s, verbose=request.verbose)
    if request.as_json:
        print(json.dumps(as_json_of(frame, outputs, seconds, total_s), indent=2, ensure_ascii=False))


def take_pairs(request: Request) -> None:
    """Take noisy and clean pictures with their truth; raises CamsimError for options that do not go together."""
    if request.pairs is None:
        raise InvalidValueError("is of --pairs; name a folder with --pairs FOLDER", key="--levels")
    if request.outputs or request.frames != 1 or request.as_json:
        raise InvalidValueError("names its files itself; leave out -o, --frames and --json", key="--pairs")
    from camsim.api import load
    from camsim.cli.pairs import check_folder, parse_levels, plan_pairs, write_pairs

    levels = parse_levels(request.levels)
    if request.compress:
        from camsim.files.dng_image import lossless_encoder

        lossless_encoder()
    ready = load(
        request.scene,
        sensor=request.sensor,
        overrides=request.changes,
        seed=request.seed,
        products=("mosaic", "truth"),
        sensors=request.sensors,
    )
    pairs = plan_pairs(ready, levels)
    folder = check_folder(request.pairs, force=request.force)
    look_in_new()
    with Bar(displayed=not request.quiet) as bar, made_together(folder):
        write_pairs(ready, pairs, folder, compress=request.compress, quiet=request.quiet, progress=bar.update)


def odd_cfa_of(pattern: tuple[str, ...], outputs: Iterable[Output], *, allowed: bool) -> str | None:
    """Return a warning if developers misread DNGs of this filter array; raises OutputError if not ``allowed``."""
    from camsim.files.dng_tags import odd_cfa

    file = next((o.path for o in outputs if o.product == "mosaic" and o.path.lower().endswith(".dng")), None)
    why = odd_cfa(pattern) if file else None
    if why and not allowed:
        raise OutputError(f"cannot write {file!r}: {why}, or insist with --allow-odd-cfa")
    return f"{file}: {why}" if why else None


def compression_faults(outputs: Iterable[Output]) -> list[CamsimError]:
    """Return the faults of a request for lossless JPEG."""
    from camsim.files.dng_image import lossless_encoder

    if not any(output.path.lower().endswith(".dng") for output in outputs):
        return [OutputError("--compress is for DNG and none is written; EXR and PNG are always compressed")]
    try:
        lossless_encoder()
    except OutputError as error:
        return [error]
    return []


def _take_rows(capture: Capture | Shot, outputs: list[Output], products: Products, bar: Bar, request: Request) -> Frame:
    """Take the picture and write its mosaics while it is computed: memory does not grow with the frame."""
    return write_mosaics(
        outputs,
        lambda take: capture.rows(take, products=products, progress=bar.update),
        camera=capture.camera,
        region=capture.region,
        allow_odd_cfa=request.allow_odd_cfa,
        compress=request.compress,
    )


def _write(frame: Frame, outputs: list[Output], bar: Bar, request: Request) -> None:
    from camsim.files import save

    for number, output in enumerate(outputs):
        bar.update("write", number / len(outputs))
        save(
            frame,
            output.path,
            product=output.product,
            force=True,  # checked before the work
            allow_odd_cfa=request.allow_odd_cfa,
            compress=request.compress,
        )


def with_files(frame: Frame, outputs: Iterable[Output]) -> Report:
    """Return the report of a frame with the work of writing its files added."""
    matrices = len(frame.channels) > 1 and sum(
        output.path.lower().endswith(".dng") or output.product == "preview" for output in outputs
    )
    written = sum(Path(output.path).stat().st_size for output in outputs)
    work = {**frame.report.work, "colour_matrices": int(matrices), "bytes_written": written}
    return dataclasses.replace(frame.report, work=work)


def as_json_of(frame: Frame, outputs: list[Output], seconds: dict[str, float], total_s: float) -> dict[str, Any]:
    """Return the report as a plain tree."""
    return {
        **asdict(frame.report),
        "seconds": seconds,
        "total_seconds": total_s,
        "camera": frame.camera_name,
        "rows": frame.shape[0],
        "cols": frame.shape[1],
        "channels": list(frame.channels),
        "cfa_pattern": list(frame.cfa_pattern),
        "f_number": frame.f_number,
        "time_s": frame.time_s,
        "iso": frame.iso,
        "seed": frame.seed,
        "bit_depth": frame.bit_depth,
        "black_level_dn": frame.black_level_dn,
        "black_offsets_dn": [list(row) for row in frame.black_offsets_dn],
        "white_level_dn": frame.white_level_dn,
        "electrons_per_dn": frame.electrons_per_dn,
        "outputs": [
            {"file": output.path, "product": output.product, "bytes": Path(output.path).stat().st_size}
            for output in outputs
        ],
    }
