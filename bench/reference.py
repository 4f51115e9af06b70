"""The names of each page of docs/reference with a line each, for readers on the web: ``python -m bench.reference``.

The site shows each name's whole documentation, where the pages name it; the lines are the first sentences of that.
"""

from __future__ import annotations

import inspect
import operator
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer

import camsim
from camsim.cli.app import app

PAGES = sorted((Path(__file__).parents[1] / "docs" / "reference").glob("*.md"))
_NAMED = re.compile(r"^\.\. auto\w+:: camsim\.([\w.]+)$", re.MULTILINE)
_TABLE = re.compile(r"(?<=<!-- names -->\n).*?(?=<!-- /names -->)", re.DOTALL)


def written(page: str) -> str:
    """Return a page with the table of its names as the code has them; a page without a place for it as it is."""
    rows = _of_commands() if "{commands}" in page else _of_python(_NAMED.findall(page))
    table = ["| name | |", "|---|---|", *(f"| `{name}` | {line} |" for name, line in rows)]
    return _TABLE.sub(lambda _: "\n".join(table) + "\n", page)


def _of_python(names: list[str]) -> Iterator[tuple[str, str]]:
    for name in names:
        yield f"camsim.{name}", _first(inspect.getdoc(operator.attrgetter(name)(camsim)) or "")


def _of_commands() -> Iterator[tuple[str, str]]:
    def inside(command: Any, path: str) -> Iterator[tuple[str, str]]:
        for name, part in getattr(command, "commands", {}).items():
            yield from inside(part, f"{path} {name}") if hasattr(part, "commands") else [(f"{path} {name}", part.help)]

    yield from ((name, _first(told or "")) for name, told in inside(typer.main.get_command(app), "camsim"))


def _first(told: str) -> str:
    """Return the first paragraph of a docstring as a cell of a table.

    >>> _first("Return ``a | b``\\n  or c.\\n\\nMore.")
    'Return `a \\\\| b` or c.'
    """
    paragraph = " ".join(told.partition("\n\n")[0].replace("\b", "").split())
    return paragraph.replace("``", "`").replace("|", "\\|")


if __name__ == "__main__":
    for path in PAGES:
        path.write_text(written(path.read_text(encoding="utf-8")), encoding="utf-8")
