"""The output files of a capture, checked before any work."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from camsim.camera.frame import Product
from camsim.errors import CamsimError, OutputError
from camsim.files import check_output
from camsim.files.naming import split_product


@dataclass(frozen=True, slots=True)
class Output:
    """One output file and the product that it is to hold."""

    path: str
    product: Product


def numbered(texts: Iterable[str], count: int) -> list[str]:
    """Return each FILE[:PRODUCT] once for every frame, with the frame's number before the suffix if there are several.

    >>> numbered(["edge.dng", "edge.exr:truth"], 2)
    ['edge-0.dng', 'edge-0.exr:truth', 'edge-1.dng', 'edge-1.exr:truth']
    >>> numbered(["edge.dng"], 1)
    ['edge.dng']
    """
    if count == 1:
        return list(texts)
    width, named = len(str(count - 1)), []
    for number in range(count):
        for text in texts:
            path, product = split_product(text)
            stem, suffix = os.path.splitext(path)
            named.append(f"{stem}-{number:0{width}}{suffix}" + (f":{product}" if product else ""))
    return named


def check(texts: Iterable[str], *, force: bool) -> tuple[list[Output], list[CamsimError]]:
    """Return the outputs, and the faults of those that cannot be written."""
    outputs: list[Output] = []
    errors: list[CamsimError] = []
    seen: set[str] = set()
    for text in texts:
        path, product = split_product(text)
        try:
            chosen = check_output(path, product)
            if Path(path).exists() and not force:
                raise OutputError(f"{path!r} exists; overwrite it with --force, or write elsewhere with -o")
            # Two names of one file would overwrite the first product.
            real = os.path.realpath(path)
            if real in seen:
                raise OutputError(f"{path!r} is named twice; each product needs a separate file")
            seen.add(real)
        except OutputError as error:
            errors.append(error)
        else:
            outputs.append(Output(path, chosen))
    return outputs, errors
