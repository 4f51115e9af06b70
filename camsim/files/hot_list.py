"""Lists of hot photosites as CSV: row, column and dark current of each."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable
from pathlib import Path

from camsim.errors import InputError

HEADS = ("row", "col", "e_per_s")
_MOST_BYTES = 64 << 20

Hot = tuple[int, int, float]


def read_hot(path: Path, displayed: str) -> tuple[Hot, ...]:
    """Read a list of hot photosites: the columns row, col and e_per_s.

    displayed : name of the file in messages

    Raises InputError in one sentence.
    """
    from camsim.files.reading import opened  # imported here: with all readers, which few captures need

    with opened(path) as (file, size):
        if size > _MOST_BYTES:
            raise InputError(f"{displayed!r} has {size} bytes; {_MOST_BYTES} are the most of a list of photosites")
        text = file.read(size).decode("utf-8-sig", errors="replace")
    lines = csv.DictReader(line for line in io.StringIO(text) if not line.startswith("#"))
    if set(HEADS) - {head.strip() for head in lines.fieldnames or ()}:
        raise InputError(f"{displayed!r} needs the columns {', '.join(HEADS)}: a line for each hot photosite")
    found = []
    for number, line in enumerate(lines, start=1):
        row, col, e_per_s = ((line[head] or "").strip() for head in HEADS)
        if not (row.isdecimal() and col.isdecimal() and _is_current(e_per_s)):
            says = f"{row},{col},{e_per_s}"
            raise InputError(
                f"{displayed!r}, photosite {number}: {says[:60]!r}; give row and col, whole numbers from 0, and a dark "
                "current of 0 e⁻/s or more"
            )
        found.append((int(row), int(col), float(e_per_s)))
    return tuple(found)


def hot_text(hot: Iterable[Hot]) -> str:
    """Return the text of a list of hot photosites."""
    return "".join([",".join(HEADS), "\n", *(f"{row},{col},{e_per_s:.6g}\n" for row, col, e_per_s in hot)])


def _is_current(text: str) -> bool:
    try:
        return 0.0 <= float(text) < math.inf
    except ValueError:
        return False
