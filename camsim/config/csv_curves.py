"""Substitution of CSV files: ``{csv: qe.csv, column: R}`` becomes a table of points."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import get_args

from camsim.config import library, schema
from camsim.config.expect import Expected, along, expected_of_field
from camsim.config.tree import Document, KeyPath, Node
from camsim.errors import CamsimError, Fault


def read_in(document: Document, model: type[schema.Table]) -> Document:
    """Return the document with points in place of CSV references; unreadable files become faults.

    Files must be under the document's folder; those of overrides may be anywhere.
    """
    reading = _Reading(document, Expected.of(model))
    root = document.root
    for path in list(_with_csv(root, ())):
        root = _changed(root, path, reading.filled)
    return (
        replace(document, root=root, faults=(*document.faults, *reading.faults))
        if root is not document.root
        else document
    )


def _with_csv(node: Node, path: KeyPath) -> Iterator[KeyPath]:
    if isinstance(node.content, Mapping):
        if "csv" in node.content or "column" in node.content:
            yield path
        for key, part in node.content.items():
            yield from _with_csv(part, (*path, key))
    elif isinstance(node.content, tuple):
        for index, part in enumerate(node.content):
            if isinstance(part.content, Mapping | tuple):
                yield from _with_csv(part, (*path, index))


def _changed(node: Node, rest: KeyPath, change: Callable[[KeyPath, Node], Node], done: KeyPath = ()) -> Node:
    if not rest:
        return change(done, node)
    key, content = rest[0], node.content
    child = node.child(key)
    assert child is not None, f"{done}: no {key!r}"
    new = _changed(child, rest[1:], change, (*done, key))
    if isinstance(content, Mapping):
        return replace(node, content={**content, str(key): new})
    assert isinstance(content, tuple)
    return replace(node, content=tuple(new if index == key else item for index, item in enumerate(content)))


@dataclass
class _Reading:
    document: Document
    root: Expected
    faults: list[Fault] = field(default_factory=list)

    def filled(self, path: KeyPath, node: Node) -> Node:
        """Return a table with the points of the CSV file that it names; marked as refused if faulty."""
        expected = along(self.root, self.document.root, path)
        table = expected.table(node) if expected is not None else None
        if table is None or not issubclass(table, schema.Tabulated) or not isinstance(node.content, Mapping):
            return node
        file, column = node.child("csv"), node.child("column")
        if file is None:
            return self._refused(node, (*path, "column"), "is of a CSV file; name it by csv")
        if given := next((key for key in schema.LISTS if key in node.content), None):
            return self._refused(node, (*path, "csv"), f"given together with {given!r}; leave one of the two out")
        if not isinstance(file.content, str) or not isinstance(column.content if column else None, str | int | None):
            # The schema reports that, without messages about the lists.
            return _filled(node, file, ([1.0, 2.0], [0.0, 0.0]))
        from camsim.spectra.csv_table import read_points  # imported here, as few files name one

        try:
            points = read_points(self._path(file), column.plain() if column else None, file.content)
        except CamsimError as error:
            return self._refused(node, (*path, error.key or "csv"), error.message)
        if _of_fractions(table) and max(points[1]) > 1.0:
            where_nm = points[0][points[1].index(max(points[1]))]
            message = f"{file.content!r} has {max(points[1]):g} at {where_nm:g} nm; must be fractions from 0 to 1"
            return self._refused(node, (*path, "csv"), f"{message} (of per cent the column's header says %)")
        return _filled(node, file, points)

    def _path(self, file: Node) -> Path:
        name = str(file.content)
        # Paths in overrides are relative to the user's working directory.
        return Path(name) if not file.place.line else library.in_folder(self.document.folder, name)

    def _refused(self, node: Node, path: KeyPath, message: str) -> Node:
        self.faults.append(self.document.fault(path, message))
        return replace(node, refused=True)


def _of_fractions(table: type[schema.Tabulated]) -> bool:
    """Whether the values of a curve are fractions."""
    values = expected_of_field(table.model_fields["values"])
    return Expected.of(get_args(values.kind)[0]).is_fraction()


def _filled(node: Node, file: Node, points: tuple[list[float], list[float]]) -> Node:
    """Return a table with its points, all with the place of the file reference."""
    assert isinstance(node.content, Mapping)
    lists = {}
    for key, numbers in zip(schema.LISTS, points, strict=True):
        items = tuple(Node(number, file.place, file.named, f"{number:g}") for number in numbers)
        lists[key] = Node(items, file.place, file.named)
    return replace(node, content={**node.content, **lists})
