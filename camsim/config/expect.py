"""Descriptions of what the schema expects at a place, derived from types alone."""

from __future__ import annotations

import functools
import operator
import types
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from annotated_types import Le, MinLen
from pydantic.fields import FieldInfo

from camsim.config.schema import Called, Table
from camsim.config.tree import KeyPath, Node
from camsim.core.words import either, in_range
from camsim.errors import nearest


@dataclass(frozen=True, slots=True)
class Expected:
    """A type with its limits and description.

    kind         the bare type: float, a Table, list[…], Union[…], …
    limits       metadata of annotated_types: Gt, Le, MinLen …
    description  the field's, with its unit
    """

    kind: Any
    limits: tuple[Any, ...] = ()
    description: str = ""

    @classmethod
    def of(cls, annotation: Any, limits: tuple[Any, ...] = (), description: str = "") -> Expected:
        """Return what an annotation expects: the type without Annotated and ``| None``, its limits and description.

        Limits and description found in the annotation are added to those given.
        """
        while get_origin(annotation) is Annotated:
            annotation, *metadata = get_args(annotation)
            for item in metadata:
                if isinstance(item, FieldInfo):
                    limits = (*limits, *item.metadata)
                    description = description or item.description or ""
                else:
                    limits = (*limits, item)
        if _is_union(annotation):
            members = [member for member in get_args(annotation) if member is not types.NoneType]
            if len(members) == 1:
                return cls.of(members[0], limits, description)
            annotation = functools.reduce(operator.or_, members)
        return cls(annotation, limits, description)

    def alternatives(self) -> tuple[Expected, ...]:
        """Return the members of a union, or this itself."""
        if _is_union(self.kind):
            return tuple(Expected.of(member, (), self.description) for member in get_args(self.kind))
        return (self,)

    def tables(self) -> tuple[type[Table], ...]:
        """Return the tables that are allowed at this place."""
        return _tables_of(self.kind)

    def holds(self) -> Iterator[type[Table]]:
        """Yield the tables that are allowed at this place, or as items of a list at this place."""
        yield from self.tables()
        for alternative in self._with_origin(list):
            yield from Expected.of(get_args(alternative.kind)[0]).holds()

    def table(self, node: Node) -> type[Table] | None:
        """Return the type of table that ``node`` is meant to be; None if it is no table, or of unknown kind.

        A misspelt kind is resolved to the nearest one, so that it does not hide other faults.
        """
        tables = self.tables()
        if not isinstance(node.content, Mapping):
            return None
        for key in ("kind", "name"):
            if len(tables) > 1:
                word = self.meant_word(node, key)
                tables = tuple(table for table in tables if word is not None and word in words_of(table, key))
        return tables[0] if tables else None

    def telling_key(self) -> str:
        """Return the key that tells the allowed tables apart: ``kind``, or ``name`` if all are of one kind."""
        return "kind" if len({kinds_of(table) for table in self.tables()}) > 1 else "name"

    def meant_word(self, node: Node, key: str) -> str | None:
        """Return the word under ``key`` (kind or name) in ``node``, or the known word nearest to it."""
        said = node.content.get(key) if isinstance(node.content, Mapping) else None
        words = [word for table in self.tables() for word in words_of(table, key)]
        if said is None or said.content in words:
            return None if said is None else str(said.content)
        near = nearest(str(said.content), words)
        return near[0] if near else None

    def inside(self, node: Node, key: str | int) -> Expected | None:
        """Return what is expected under ``key`` of a value; None if the schema does not define it."""
        if isinstance(key, str):
            table = self.table(node)
            if len(telling := self._words_that_tell(node, key)) > 1:
                return Expected(Literal[telling])
            if table is not None:
                field = table.fields().get(key)
                return None if field is None else expected_of_field(field)
            return next((Expected.of(get_args(a.kind)[1]) for a in self._with_origin(dict)), None)
        for alternative in self._with_origin(list):
            return Expected.of(get_args(alternative.kind)[0])
        for alternative in self._with_origin(tuple):
            items = get_args(alternative.kind)
            return Expected.of(items[key]) if key < len(items) else None
        return None

    def _words_that_tell(self, node: Node, key: str) -> tuple[str, ...]:
        """Return the words under ``kind``, or under the ``name`` of tables of one kind, that distinguish tables."""
        kind = self.meant_word(node, "kind") if key == "name" else None
        tables = [table for table in self.tables() if key == "kind" or kind in kinds_of(table)]
        known = [word for table in tables for word in words_of(table, key)] if key in ("kind", "name") else []
        return tuple(dict.fromkeys(known)) if len(tables) > 1 else ()

    def member(self, node: Node) -> Expected:
        """Return the member of a union intended by ``node``; this itself if undetermined."""
        kind = self.meant_word(node, "kind")
        for alternative in self.alternatives():
            if _is_union(alternative.kind) and any(kind in kinds_of(table) for table in alternative.tables()):
                return alternative
        table = self.table(node)
        if table is not None:
            return Expected.of(table)
        wanted = (dict,) if isinstance(node.content, Mapping) else (list, tuple)
        return next((member for origin in wanted for member in self._with_origin(origin)), self)

    def key_words(self) -> str:
        """Return a text, to follow 'must be', on the keys that users may choose; empty if all keys are fixed."""
        return next((Expected.of(get_args(a.kind)[0]).description for a in self._with_origin(dict)), "")

    def _with_origin(self, origin: type) -> Iterator[Expected]:
        return (alternative for alternative in self.alternatives() if get_origin(alternative.kind) is origin)

    def literals(self) -> list[str]:
        """Return the allowed literals, if any."""
        return [str(v) for a in self.alternatives() if get_origin(a.kind) is Literal for v in get_args(a.kind)]

    def is_fraction(self) -> bool:
        """Whether a number of at most 1 is allowed here."""
        limits = [limit for a in self.alternatives() if a.kind is float for limit in a.limits]
        return any(isinstance(limit, Le) and limit.le == 1 for limit in limits)

    def is_number(self) -> bool:
        """Whether a number is allowed here."""
        return any(alternative.kind in (float, int) for alternative in self.alternatives())

    def is_text(self) -> bool:
        """Whether free text is allowed here."""
        texts = (alternative for alternative in self.alternatives() if alternative.kind is str)
        return any(not any(hasattr(limit, "pattern") for limit in text.limits) for text in texts)

    def length(self) -> int:
        """Return the number of items of a list here; 0 if free."""
        return next((len(get_args(a.kind)) for a in self._with_origin(tuple)), 0)

    def words(self) -> str:
        """Return a text, to follow 'must be', on what is allowed at this place."""
        tables = self.tables()
        parts = [_words(a) for a in self.alternatives() if not a.tables() or len(tables) == 1]
        if len(tables) > 1:
            kinds = list(dict.fromkeys(kind for table in tables for kind in kinds_of(table)))
            parts.append(f"a table of kind {either(kinds)}")
        return either(parts)


def expected_of_field(field: FieldInfo) -> Expected:
    """Return what a field of a table expects."""
    return Expected.of(field.annotation, tuple(field.metadata), field.description or "")


def along(root: Expected, node: Node, path: KeyPath) -> Expected | None:
    """Follow a path from the root of a document."""
    here: Expected | None = root
    current: Node | None = node
    for key in path:
        if here is None or current is None:
            return None
        here, current = here.inside(current, key), current.child(key)
    return here


@functools.cache
def can_contradict(expected: Expected) -> bool:
    """Whether any table in here has keys that may contradict each other (a long list of shapes has none)."""
    known, waiting = set[type[Table]](), [expected]
    while waiting:
        tables = _tables_inside(waiting.pop()) - known
        if any(table.can_contradict() for table in tables):
            return True
        known |= tables
        waiting += [expected_of_field(field) for table in tables for field in table.model_fields.values()]
    return False


@functools.cache
def _tables_inside(expected: Expected) -> frozenset[type[Table]]:
    """Return the tables that may stand here, or in lists and tables of the user's own keys here."""
    several = (a.kind for a in expected.alternatives() if get_origin(a.kind) in (list, tuple, dict))
    items = (Expected.of(item) for kind in several for item in get_args(kind))
    return frozenset(expected.tables()).union(*map(_tables_inside, items))


@functools.cache
def _tables_of(kind: Any) -> tuple[type[Table], ...]:
    if isinstance(kind, type) and issubclass(kind, Table):
        return (kind,)
    members = get_args(kind) if _is_union(kind) else ()
    return tuple(table for member in members for table in Expected.of(member).tables())


def kinds_of(table: type[Table]) -> tuple[str, ...]:
    """Return the words that ``kind`` may be in a table."""
    return words_of(table, "kind")


@functools.cache
def words_of(table: type[Table], key: str) -> tuple[str, ...]:
    """Return the words that a key of a table may be, where they are a fixed few."""
    field = table.model_fields.get(key)
    return () if field is None or get_origin(field.annotation) is not Literal else get_args(field.annotation)


def _is_union(annotation: Any) -> bool:
    return get_origin(annotation) in (Union, types.UnionType)


def _words(expected: Expected) -> str:
    kind, limits = expected.kind, expected.limits
    origin = get_origin(kind)
    called = next((limit.words for limit in limits if isinstance(limit, Called)), None)
    if called is not None:
        return called
    if origin is Literal:
        return either([repr(value) if " " in str(value) else str(value) for value in get_args(kind)])
    if origin is tuple:
        return f"a list of {len(get_args(kind))} numbers"
    if origin is list:
        least = next((limit.min_length for limit in limits if isinstance(limit, MinLen)), 0)
        return f"a list of at least {least}" if least else "a list"
    if origin is dict:
        return "a table"
    if isinstance(kind, type) and issubclass(kind, Table):
        keys = [key for key in kind.model_fields if key != "source"]
        return f"a table {{{', '.join(keys)}}}"
    return _SIMPLE.get(kind, "something else") + in_range(limits)


_SIMPLE = {float: "a number", int: "a whole number", bool: "true or false", str: "a word"}
