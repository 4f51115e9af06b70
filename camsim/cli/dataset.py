"""``camsim dataset``: samples for training, with their truth."""

from __future__ import annotations

import gc
from typing import Annotated

import typer

from camsim.cli.options import Scheduler, Workers
from camsim.cli.sweep import say_failures, say_figures


def dataset(
    study: Annotated[str, typer.Argument(metavar="DATASET.yaml", help="What it is made of (camsim new dataset).")],
    output: Annotated[str, typer.Option("-o", "--output", metavar="FOLDER", help="Where shards and index go.")],
    workers: Workers = None,
    scheduler: Scheduler = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the summary as JSON.")] = False,
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print nothing but errors.")] = False,
) -> None:
    """Make a data set: crops of noisy mosaics with their truth, split by scene, in shards, with an index and a card.

    Shards that are there already are not made again, and nothing depends on the number of workers.
    """
    from camsim.cli.progress import Bar
    from camsim.sweeping import dataset as make

    gc.enable()
    with Bar(shown=not quiet) as bar:
        made = make(study, output, workers=workers, scheduler=scheduler, progress=bar.update)
    samples = sum(row["status"] == "done" for row in made.rows)
    figures = {
        "samples": samples,
        "shard ranges made": made.made,
        "found": made.found,
        "failed": made.failed,
        "seconds": made.seconds,
    }
    title = f"{output}: README.md, manifest.csv, .parquet, croissant.json"
    say_figures(figures, as_json=as_json, quiet=quiet, title=title)
    say_failures(made.rows)
