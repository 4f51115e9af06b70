"""The tables of tests/data: columns between bars, in sections below lines that begin with #."""

from __future__ import annotations

from pathlib import Path


def sections(name: str) -> dict[str, list[list[str]]]:
    """Columns of each row by the lines above them; a line that begins with a bar goes on."""
    found: dict[str, list[list[str]]] = {}
    for line in (Path(__file__).parent / "data" / name).read_text(encoding="utf-8").splitlines():
        if line.startswith("# "):
            found[line[2:]] = here = []
        elif line.startswith("  | "):
            here[-1].append(line[4:])
        else:
            here.append(line.split(" | "))
    return found


def rows(name: str, *begins: str) -> list[list[str]]:
    """Columns of each row of the sections that begin so."""
    return [
        row for begin in begins for title, each in sections(name).items() if title.startswith(begin) for row in each
    ]
