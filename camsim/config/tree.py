"""A YAML document as a tree with the source position of every part."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

from camsim.core.cached import cached_property
from camsim.errors import Fault

Scalar: TypeAlias = str | int | float | bool | None
KeyPath: TypeAlias = tuple[str | int, ...]

MOST_FAULTS = 100
"""Most faults reported for one file: finding all of very many would take minutes."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where something was written: a file with line and column from 1, or an override of the command line.

    line    0 for an override
    key     for an override, the key already contained in ``file`` (which is then ``--set KEY``); messages leave it out
    """

    file: str
    line: int = 0
    column: int = 0
    key: str = ""


@dataclass(frozen=True, slots=True)
class Node:
    """One value of a document.

    content  a scalar, a tuple of nodes (list) or a mapping of nodes (table)
    place    where the value begins
    named    where its key begins (for an item of a list and for the root: where the value begins)
    text     a scalar as it was written
    refused  the reader has already reported it: its content is not validated again
    """

    content: Scalar | tuple[Node, ...] | Mapping[str, Node]
    place: Place
    named: Place
    text: str = ""
    refused: bool = False

    def child(self, key: str | int) -> Node | None:
        """Return the part under ``key``; None when there is none."""
        if isinstance(self.content, Mapping):
            return self.content.get(key) if isinstance(key, str) else None
        if isinstance(self.content, tuple) and isinstance(key, int) and 0 <= key < len(self.content):
            return self.content[key]
        return None

    def plain(self) -> Any:
        """Return the value as dicts, lists and scalars."""
        if isinstance(self.content, Mapping):
            return {key: node.plain() for key, node in self.content.items()}
        if isinstance(self.content, tuple):
            return [node.plain() for node in self.content]
        return self.content


@dataclass(frozen=True)
class Document:
    """A YAML file after reading (and after the overrides that concern it).

    file    as the user gave it: the name that faults carry
    folder  where the file lies; files that it names lie under here
    faults  what the reader refused
    removed keys that overrides removed, with the places of these overrides
    """

    file: str
    folder: Path
    root: Node
    faults: tuple[Fault, ...] = ()
    removed: Mapping[KeyPath, Place] = field(default_factory=dict)

    @cached_property
    def tree(self) -> Any:
        """The whole document as dicts, lists and scalars."""
        return self.root.plain()

    def find(self, path: KeyPath) -> Node | None:
        """Return the part at ``path``; None when there is none."""
        *_, last = self._along(path)
        return last

    def _along(self, path: KeyPath) -> Iterator[Node | None]:
        node: Node | None = self.root
        yield node
        for key in path:
            node = node.child(key) if node is not None else None
            yield node

    def fault(self, path: KeyPath, message: str, *, at_key: bool = False) -> Fault:
        """Return a fault at a value or its key; if it is missing, at the key of the part that should hold it."""
        nodes = list(self._along(path))
        found = nodes[-1]
        if found is not None:
            place = found.named if at_key else found.place
        else:
            holder = next(node.named for node in reversed(nodes) if node is not None)
            place = self.removed.get(path, holder)
        key = dotted(path)
        return Fault(place.file, place.line, place.column, "" if key == place.key else key, message)

    def refuses(self, path: KeyPath) -> bool:
        """Whether the reader has already reported this part or an enclosing one."""
        return any(node is not None and node.refused for node in self._along(path))


def dotted(path: KeyPath) -> str:
    """Return a path in the user's notation.

    >>> dotted(("scene", "shapes", 0, "reflectance"))
    'scene.shapes.0.reflectance'
    """
    return ".".join(str(key) for key in path)
