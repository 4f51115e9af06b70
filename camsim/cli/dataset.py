"""``camsim dataset``: samples for training, with their truth."""

from __future__ import annotations

from typing import Annotated

import typer

from camsim.cli.options import AsJson, Quiet, Scheduler, Workers
from camsim.cli.sweep import say_failures, say_figures, say_forecast, say_notes
from camsim.core.garbage import look_in_new
from camsim.errors import InvalidValueError


def dataset(
    study: Annotated[str, typer.Argument(metavar="DATASET.yaml", help="What it is made of (camsim new dataset).")],
    output: Annotated[
        str | None, typer.Option("-o", "--output", metavar="FOLDER", help="Where shards and index go.")
    ] = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Say what it would take, and take nothing.")] = False,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Make a data set: crops of noisy mosaics with their truth, split by scene, in shards, with an index and a card.

    Shards that are there already are not made again, and nothing depends on the number of workers.
    """
    from camsim.cli.progress import Bar
    from camsim.study import dataset as make
    from camsim.study import forecast_dataset

    look_in_new()
    if dry_run:
        say_forecast(forecast_dataset, study, output, as_json=as_json, quiet=quiet)
        return
    if output is None:
        raise InvalidValueError("missing; name a folder, or look with --dry-run", key="-o")
    with Bar(displayed=not quiet) as bar:
        made = make(study, output, workers=workers, scheduler=scheduler, progress=bar.update)
    samples = sum(row["status"] == "done" for row in made.rows)
    figures = {
        "samples": samples,
        "shards made": made.made,
        "found": made.found,
        "failed": made.failed,
        "seconds": made.seconds,
    }
    title = f"{output}: README.md, manifest.csv, .parquet, croissant.json"
    say_figures(figures, as_json=as_json, quiet=quiet, title=title)
    if not quiet:
        say_notes(made.rows, made.notes)
    say_failures(made.rows)
