"""The tables of tests/data: columns between bars, in sections below lines that begin with #."""

from __future__ import annotations

from pathlib import Path


def rows(name: str, *sections: str) -> list[list[str]]:
    """Columns of each row of sections, which are told by how they begin; a line that begins with a bar goes on."""
    found: dict[str, list[list[str]]] = {}
    for line in (Path(__file__).parent / "data" / name).read_text(encoding="utf-8").splitlines():
        if line.startswith("# "):
            found[line[2:]] = here = []
        elif line.startswith("  | "):
            here[-1].append(line[4:])
        else:
            here.append(line.split(" | "))
    return [row for begin in sections for title, each in found.items() if title.startswith(begin) for row in each]
