"""Tables for people, on stdout."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from camsim.errors import OutputError

_WIDTH_OF_A_LOG = 1000


def print_table(title: str, heads: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print a table; the first column is text, the others are numbers."""
    table = Table(box=None, pad_edge=False)
    for number, head in enumerate(heads):
        table.add_column(head, justify="right" if number else "left", no_wrap=True)
    for row in rows:
        table.add_row(*row)
    console = Console(highlight=False, markup=False, emoji=False)
    if not console.is_terminal:
        # Lines of a log are not wrapped.
        console.width = _WIDTH_OF_A_LOG
    with console.capture() as printed:
        console.print(table)
    console.file.write(f"{title}\n")
    console.file.writelines(f"{line.rstrip()}\n" for line in printed.get().splitlines())


def csv_text(heads: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return rows as CSV; cells that are no numbers (NaN) are left empty."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(heads)
    for row in rows:
        writer.writerow(["" if isinstance(v, float) and not math.isfinite(v) else v for v in row])
    return text.getvalue()


def check_text_file(file: str, *, force: bool) -> None:
    """Raise early for a file that cannot be written."""
    if Path(file).exists() and not force:
        raise OutputError(f"{file!r} exists; overwrite it with --force, or write elsewhere")
    if not Path(file).resolve().parent.is_dir():
        raise OutputError(f"cannot write {file!r}: its folder does not exist; make it first")
