"""FILE[:PRODUCT], the syntax of output files."""

from __future__ import annotations

import re


def split_product(text: str) -> tuple[str, str | None]:
    """Split FILE[:PRODUCT].

    >>> split_product("out/edge.exr:truth"), split_product("C:/edge.dng"), split_product("a:b.dng")
    (('out/edge.exr', 'truth'), ('C:/edge.dng', None), ('a:b.dng', None))
    """
    file, colon, product = text.rpartition(":")
    # With a dot or a slash it is part of a path: a:b.dng, C:/edge.dng.
    if colon and file and not re.search(r"[./\\]", product):
        return file, product
    return text, None
