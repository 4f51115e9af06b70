"""``camsim sweep``: a study into a folder, with its manifest."""

from __future__ import annotations

import dataclasses
import json
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from camsim.cli.options import AsJson, Force, Quiet, Scheduler, Workers
from camsim.core.garbage import look_in_new
from camsim.core.note import Note
from camsim.errors import InvalidValueError

if TYPE_CHECKING:
    from camsim.study import Forecast

_MOST, _MOST_NOTES = 20, 5
_NOT_DISPLAYED = ("index", "frame", "seed", "frame_number", "bytes", "rows", "cols")


def sweep(
    study: Annotated[str, typer.Argument(metavar="STUDY.yaml", help="A study file (camsim new study).")],
    output: Annotated[
        str | None, typer.Option("-o", "--output", metavar="FOLDER", help="Where files and manifest go.")
    ] = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Say what it would take, and take nothing.")] = False,
    plot: Annotated[
        tuple[str, str, str] | None,
        typer.Option(
            "--plot",
            metavar="X Y FILE",
            help="Draw a column of the manifest over another, a line for each combination of the other varied keys.",
        ),
    ] = None,
    as_json: AsJson = False,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Take all captures of a study; those that are there already are not taken again.

    Files and checksums do not depend on the number of workers. What fails is a row of the manifest that says why, and
    the exit code is 1.
    """
    from camsim.cli.progress import Bar
    from camsim.cli.sweep_plot import draw_columns
    from camsim.study import forecast
    from camsim.study import sweep as carry_out

    if plot is not None:
        from camsim.cli.plot import check_drawing

        check_drawing(plot[2], force=force)
    look_in_new()
    if dry_run:
        say_forecast(forecast, study, output, as_json=as_json, quiet=quiet)
        return
    if output is None:
        raise InvalidValueError("missing; name a folder, or look with --dry-run", key="-o")
    with Bar(displayed=not quiet) as bar:
        done = carry_out(study, output, workers=workers, scheduler=scheduler, progress=bar.update)
    summary = {
        "captures": done.taken + done.found + done.failed,
        "taken": done.taken,
        "found": done.found,
        "failed": done.failed,
        "files": sum(row["status"] == "done" for row in done.rows),
        "seconds": done.seconds,
    }
    if plot is not None:
        x, y, file = plot[0].replace(".", "_"), plot[1].replace(".", "_"), plot[2]
        for name in (x, y):
            columns = dict.fromkeys(key for row in done.rows for key in row)
            if name not in columns:
                raise InvalidValueError(f"no column {name!r}; there are {', '.join(columns)}", key="--plot")
        draw_columns(done.rows, x, y, Path(file), by=done.varied)
    say_figures(summary, as_json=as_json, quiet=quiet, title=f"{output}/manifest.csv, .parquet")
    if not (quiet or as_json):
        _say_columns(done.rows)
    if not quiet:
        say_notes(done.rows)
    say_failures(done.rows)


def _say_columns(rows: Sequence[Mapping[str, Any]]) -> None:
    """Print minimum, median and maximum of each varying numeric column, except indices and sizes."""
    import statistics

    from rich.console import Console
    from rich.table import Table

    table = Table("column", "least", "median", "most", box=None)
    for name in dict.fromkeys(key for row in rows for key in row if key not in _NOT_DISPLAYED):
        values = [row.get(name) for row in rows]
        numbers = sorted(v for v in values if isinstance(v, int | float) and not isinstance(v, bool))
        if numbers and numbers[0] < numbers[-1]:
            table.add_row(name, *(f"{v:.6g}" for v in (numbers[0], statistics.median(numbers), numbers[-1])))
    if table.row_count:
        Console().print(table)


def say_notes(rows: Sequence[Mapping[str, Any]], more: Sequence[Note] = ()) -> None:
    """Print each note with the number of rows that have it; ``more``: notes on the sweep as a whole."""
    from camsim.study.manifest import BETWEEN_NOTES

    good = [row for row in rows if row["status"] == "done"]
    of = Counter(note for row in good for note in str(row["message"]).split(BETWEEN_NOTES) if note)
    lines = [f"note ({count} of {len(good)}): {note}" for note, count in of.most_common(_MOST_NOTES)]
    if len(of) > _MOST_NOTES:
        lines.append(f"… and {len(of) - _MOST_NOTES} more, in the manifest's column message")
    for line in (*lines, *(f"note: {note}" for note in more)):
        typer.echo(line, err=True)


def say_failures(rows: Sequence[Mapping[str, Any]]) -> None:
    """Print failures with reasons, and exit with 1."""
    failures = [row for row in rows if row["status"] != "done"]
    if failures:
        displayed = [f"capture {row['index']}: {row['message']}" for row in failures[:_MOST]]
        more = [f"… and {len(failures) - _MOST} more"] if len(failures) > _MOST else []
        typer.echo("\n".join((*displayed, *more)), err=True)
        raise typer.Exit(1)


def say_forecast(look: Callable[..., Forecast], study: str, output: str | None, *, as_json: bool, quiet: bool) -> None:
    """Print the forecast, and what exists already."""
    from camsim.cli.progress import Bar

    with Bar(displayed=not quiet) as bar:
        expected = look(study, bar.update, folder=output)
    say_figures(dataclasses.asdict(expected), as_json=as_json, quiet=quiet, title="would take")
    if not (quiet or as_json):
        print("time without measuring and the start of workers (some seconds each); memory of each worker")


def say_figures(figures: Mapping[str, float], *, as_json: bool, quiet: bool, title: str) -> None:
    """Print figures, as JSON or below a title."""
    if as_json:
        print(json.dumps(figures, indent=2))
    elif not quiet:
        from rich.console import Console
        from rich.table import Table

        print(title)
        table = Table(show_header=False, box=None)
        for name, value in figures.items():
            table.add_row(*_displayed(name, value))
        Console().print(table)


def _displayed(name: str, value: float) -> tuple[str, str]:
    from camsim.core.memory import readable
    from camsim.core.words import duration

    kind, _, unit = name.rpartition("_")
    if unit == "bytes":
        return kind, readable(int(value))
    if unit == "seconds" or name == "seconds":
        return "time", duration(value) + (" of one core" if kind else "")
    return name.replace("_", " "), f"{value:g}"
