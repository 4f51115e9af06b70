"""A description (of a file, say) turned back into the stages that it describes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import camsim
from camsim.errors import CamsimError

KINDS = frozenset(
    "Adc Airy Camera Cfa Curve DarkCurrent Disc Dsnu Exposure FourSpotOlpf FullWell Light Polygon Prnu QuantumEfficiency "
    "ReadNoise Rectangle Region Scene ShotNoise SquarePhotosite".split()
)
"""The stages a description may name; nothing else is ever made from a file."""


def revive(tree: Any) -> Any:
    """Return the objects that ``describe`` turned into a tree; lists become tuples.

    Raises CamsimError when the tree names a stage or a parameter that does not exist, or a value it cannot have.

    >>> revive({"kind": "FourSpotOlpf", "split_um": 3.66})
    FourSpotOlpf(split_um=3.66)
    """
    if isinstance(tree, Mapping):
        parts = {key: revive(value) for key, value in tree.items() if key != "kind"}
        return _make(tree["kind"], parts) if "kind" in tree else parts
    if isinstance(tree, (list, tuple)):
        return tuple(revive(value) for value in tree)
    return tree


def _make(kind: Any, parts: Mapping[str, Any]) -> Any:
    if kind not in KINDS:
        raise CamsimError(f"description: {kind!r} is not a stage of this version of camsim")
    try:
        return getattr(camsim, kind)(**parts)
    except (TypeError, ValueError, AttributeError) as error:
        raise CamsimError(f"description: {kind} cannot be made from what the file holds ({error})") from None
