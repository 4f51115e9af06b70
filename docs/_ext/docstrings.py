"""Docstrings say ``name : meaning, unit, shape``, a line each: the site shows them as a list of parameters.

Bars are absolute values there, and not reStructuredText's substitutions.
"""

from __future__ import annotations

import re
from typing import Any

_ITEM = re.compile(r"^(?P<names>\w[\w.]*(?:, \w[\w.]*)*)(?: *: +| {2,})(?P<meaning>\S.*)$")


def fields_of(lines: list[str]) -> list[str]:
    """Return the docstring with its lists as reStructuredText's fields."""
    out: list[str] = []
    block: list[str] = []
    for line in [*lines, ""]:
        if line.strip():
            block.append(line)
            continue
        out += [*(_as_fields(block) if _is_list(block) else block), ""]
        block = []
    return out[:-1]


def _is_list(block: list[str]) -> bool:
    flush = [line for line in block if not line.startswith(" ")]
    return bool(block) and not block[0].startswith(" ") and all(_ITEM.match(line) for line in flush)


def _as_fields(block: list[str]) -> list[str]:
    out = []
    for line in block:
        item = _ITEM.match(line)
        if item is None:
            out.append(f"    {line.strip()}")
        elif item["names"] == "returns":
            out.append(f":returns: {item['meaning']}")
        else:
            out.append(f":param {item['names'].replace(', ', ',')}: {item['meaning']}")
    return out


def plain(signature: str) -> str:
    """Return a signature without the limits of its types, which refusals say, and arrays by that name.

    >>> plain("(f_number: Annotated[float, Gt(gt=0)])")
    '(f_number: float)'
    """
    signature = re.sub(r"ndarray\[tuple\[Any, \.\.\.\], dtype\[[^\]]*\]\]", "array", signature)
    while (start := signature.find("Annotated[")) >= 0:
        depth, comma, end = 0, None, start + len("Annotated[")
        while depth >= 0:
            depth += {"[": 1, "(": 1, "{": 1, "]": -1, ")": -1, "}": -1}.get(signature[end], 0)
            comma = end if comma is None and depth == 0 and signature[end] == "," else comma
            end += 1
        signature = signature[:start] + signature[start + len("Annotated[") : comma] + signature[end:]
    return signature


def _signature(
    app: Any, what: str, name: str, obj: Any, options: Any, signature: str | None, returns: str | None
) -> tuple[str | None, str | None]:
    return signature and plain(signature), returns and plain(returns)


def _process(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    lines[:] = [re.sub(r"\|(?=\S)|(?<=\S)\|", r"\|", line) for line in fields_of(lines)]


def setup(app: Any) -> dict[str, bool]:
    app.connect("autodoc-process-docstring", _process)
    app.connect("autodoc-process-signature", _signature)
    return {"parallel_read_safe": True}
