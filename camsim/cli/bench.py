"""``camsim bench``: error against run time for the user's scene; text, JSON lines, a page and a diagram."""

from __future__ import annotations

import functools
import json
import os
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from camsim.cli.options import Changes, Quiet, SensorName, Sensors
from camsim.errors import InvalidValueError, OutputError

if TYPE_CHECKING:
    from camsim.bench import Bench
    from camsim.bench.records import Record
    from camsim.camera.window import Region

LINES = "bench.jsonl"


def bench(
    scene: Annotated[str, typer.Argument(metavar="SCENE", help="A scene file, or the name of a shipped scene.")],
    sensor: SensorName = None,
    sensors: Sensors = None,
    changes: Changes = None,
    methods: Annotated[
        str | None, typer.Option("--methods", metavar="A,B,…", help="Such as auto,boundary; all when left out.")
    ] = None,
    tolerances: Annotated[
        str | None,
        typer.Option("--tolerances", metavar="A,B,…", help="Such as 1e-3,1e-6; every second decade when left out."),
    ] = None,
    samples: Annotated[
        str | None, typer.Option("--samples", metavar="A,B,…", help="Of importance; 121,2025 when left out.")
    ] = None,
    region: Annotated[
        str | None,
        typer.Option(
            "--region",
            metavar="ROW,COL,ROWS,COLS",
            help="A window of the sensor's frame; the busiest 128 × 128 photosites when left out.",
        ),
    ] = None,
    whole: Annotated[bool, typer.Option("--whole", help="All that the scene captures instead of a window.")] = False,
    longest: Annotated[
        float | None,
        typer.Option("--longest", metavar="S", min=0.0, help="Seconds of one core: what takes more is left out; 3."),
    ] = None,
    output: Annotated[
        str | None,
        typer.Option("-o", "--output", metavar="DIR", help="Folder for the report; SCENE-bench when left out."),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite a report that exists.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print everything as JSON on stdout, and no words.")] = False,
    quiet: Quiet = False,
) -> None:
    """Measure error against run time for a scene: every method at every tolerance, on a window of its frame.

    The truth is the other exact engine at its finest. Writes bench.jsonl, bench.html and bench.svg.
    """
    from camsim.bench.diagram import check_matplotlib
    from camsim.bench.lines import LinesFile
    from camsim.bench.records import Finding, Head, line_of
    from camsim.bench.running import LONGEST_S, bench_of, bench_scene
    from camsim.bench.settings import SAMPLES, numbers, parsed_methods
    from camsim.cli.progress import Bar

    check_matplotlib()
    decades = None if tolerances is None else numbers(tolerances, "--tolerances", "1e-3,1e-6", float)
    counts = SAMPLES if samples is None else numbers(samples, "--samples", "121,2025", int)
    window = _region(region, whole=whole)
    folder = Path(output or f"{Path(scene).stem}-bench")
    if (folder / LINES).exists() and not force:
        raise OutputError(
            f"{str(folder / LINES)!r} exists; overwrite it with --force, or choose another folder with -o"
        )
    records: list[Record] = []
    with Bar(displayed=not quiet) as bar, ExitStack() as files:
        # Created with the first record, so that a refused scene leaves no folder.
        made = functools.cache(lambda: files.enter_context(LinesFile(folder / LINES)))

        def take(record: Record) -> None:
            records.append(record)
            made().write(line_of(record))

        try:
            found = bench_scene(
                scene,
                sensor=sensor,
                overrides=changes or (),
                sensors=sensors or (),
                methods=parsed_methods(methods),
                tolerances=decades,
                samples=counts,
                region=window,
                whole=whole,
                longest_s=LONGEST_S if longest is None else longest,
                take=take,
                progress=bar.update,
            )
        except KeyboardInterrupt:
            if any(isinstance(record, Head) for record in records):
                take(Finding(sentence="The run was interrupted: this was measured before that."))
                _tell(bench_of(records), folder, "interrupted; what was measured is in", as_json=as_json, quiet=quiet)
            raise
    _tell(found, folder, "written:", as_json=as_json, quiet=quiet)


def _region(text: str | None, *, whole: bool) -> Region | None:
    from camsim.bench.settings import numbers
    from camsim.camera.window import Region

    if text is None:
        return None
    if whole:
        raise InvalidValueError("it and --whole name two windows: leave one out", key="--region")
    places = numbers(text, "--region", "0,0,64,64", int)
    if len(places) != 4:
        raise InvalidValueError(f"{text!r} are not 4 numbers; give ROW,COL,ROWS,COLS", key="--region")
    row, col, rows, cols = places
    return Region(rows=rows, cols=cols, origin=(row, col))


def _tell(bench: Bench, folder: Path, words: str, *, as_json: bool, quiet: bool) -> None:
    from camsim.bench.report import write_report

    files = [folder / LINES, *write_report(bench, folder)]
    if as_json:
        print(json.dumps({"lines": bench.lines, "files": [str(file) for file in files]}, indent=2, ensure_ascii=False))
    elif not quiet:
        for finding in bench.findings:
            print(finding.sentence)
        done = {point.method for point in bench.points}
        for left in bench.left_out:
            name = f"{left.label} and beyond" if left.method in done else left.method
            print(f"Left out: {name}: {left.why}")
        print(f"{words} {', '.join(os.path.relpath(file) for file in files)}")
