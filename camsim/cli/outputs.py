"""The files that a capture is to write, checked before any work."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from camsim.errors import CamsimError, OutputError
from camsim.files import check_output


@dataclass(frozen=True, slots=True)
class Output:
    """One file with the product that it is to hold."""

    path: str
    product: str


def parse(text: str) -> tuple[str, str | None]:
    """Split FILE[:PRODUCT].

    >>> parse("out/edge.exr:truth"), parse("C:/edge.dng"), parse("a:b.dng")
    (('out/edge.exr', 'truth'), ('C:/edge.dng', None), ('a:b.dng', None))
    """
    file, colon, product = text.rpartition(":")
    # What holds a dot or a slash is the rest of a path: a:b.dng, C:/edge.dng.
    if colon and file and not re.search(r"[./\\]", product):
        return file, product
    return text, None


def check(texts: Iterable[str], *, force: bool) -> tuple[list[Output], list[CamsimError]]:
    """Return the outputs, and what is wrong with those that cannot be written."""
    outputs: list[Output] = []
    errors: list[CamsimError] = []
    seen: set[str] = set()
    for text in texts:
        path, product = parse(text)
        try:
            chosen = check_output(path, product)
            if Path(path).exists() and not force:
                raise OutputError(f"{path!r} exists; overwrite it with --force, or write elsewhere with -o")
            # Two names of one file would leave the second product only.
            real = os.path.realpath(path)
            if real in seen:
                raise OutputError(f"{path!r} is named twice; each product needs a file of its own")
            seen.add(real)
        except OutputError as error:
            errors.append(error)
        else:
            outputs.append(Output(path, chosen))
    return outputs, errors
