"""Drawings too large to be read in seconds are refused in advance."""

from __future__ import annotations

import re
from collections.abc import Mapping

from camsim.scene.svg.outline import NUMBER
from camsim.scene.svg.xml import Element

MOST_NUMBERS = 1_000_000
MOST_ELEMENTS = 100_000
MOST_USES = 20


def too_large(root: Element, known: Mapping[str, Element]) -> tuple[Element, str] | None:
    """Return the element at which a drawing is too large, and the message; ``known``: elements by id."""
    count = 0
    for element in root.all():
        for key in ("d", "points"):
            count += sum(1 for _ in re.finditer(NUMBER, element.attributes.get(key, "")))
        if count > MOST_NUMBERS:
            return element, f"the paths up to here hold more than {MOST_NUMBERS} numbers; simplify them"
    if _drawn(root, known, {}, 0) > MOST_ELEMENTS:
        return root, f"draws more than {MOST_ELEMENTS} elements, those that <use> repeats counted each time"
    return None


def _drawn(element: Element, known: Mapping[str, Element], found: dict[int, int], uses: int) -> int:
    """Return the number of elements that an element draws; arbitrary for recursion or excessive depth."""
    if id(element) not in found:
        found[id(element)] = 1  # guard against recursion
        linked = known.get(element.attributes.get("href", "").removeprefix("#"))
        inner = [linked] if element.tag == "use" and linked is not None and uses < MOST_USES else element.children
        deeper = uses + (element.tag == "use")
        found[id(element)] = 1 + sum(_drawn(each, known, found, deeper) for each in inner)
    return found[id(element)]
