"""A description (of a file, say) turned back into the stages that it describes."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Mapping
from typing import Any

import camsim
from camsim.errors import CamsimError, InputError


def revive(tree: Any) -> Any:
    """Return the objects that ``describe`` turned into a tree; lists become tuples.

    Only camsim's own public stages are ever made from a tree. Raises InputError when it names another one, a
    parameter that does not exist, or a value that cannot be.

    >>> revive({"kind": "SquarePhotosite", "side_um": 3.66})
    SquarePhotosite(side_um=3.66)
    """
    try:
        return _revived(tree)
    except RecursionError:
        raise InputError("description: it is nested too deeply") from None


def _revived(tree: Any) -> Any:
    if isinstance(tree, Mapping):
        parts = {key: _revived(value) for key, value in tree.items() if key != "kind"}
        return _make(tree["kind"], parts) if "kind" in tree else parts
    if isinstance(tree, (list, tuple)):
        return tuple(_revived(value) for value in tree)
    return tree


def _make(kind: Any, parts: Mapping[str, Any]) -> Any:
    stage = _stages().get(kind) if isinstance(kind, str) else None
    if stage is None:
        raise InputError(f"description: {kind!r} is not a stage of this version of camsim")
    try:
        return stage(**parts)
    except CamsimError as error:
        raise InputError(f"description: {error}") from None
    except (TypeError, ValueError, AttributeError, ArithmeticError) as error:
        raise InputError(f"description: {kind} cannot be made from what the file holds ({error})") from None


@functools.cache
def _stages() -> Mapping[str, Any]:
    """Return the public dataclasses by name."""
    public = {name: getattr(camsim, name) for name in camsim.__all__}
    return {name: stage for name, stage in public.items() if dataclasses.is_dataclass(stage)}
