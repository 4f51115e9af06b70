"""A document after the schema: its parts, each usable even when another part is wrong."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from pydantic import ValidationError

from camsim.config.expect import Expected, along
from camsim.config.faults import parsed, validate
from camsim.config.schema import Table
from camsim.config.tree import MOST_FAULTS, Document, KeyPath
from camsim.core.words import number_hint
from camsim.errors import CamsimError, ConfigError, Fault, UnknownNameError

M = TypeVar("M", bound=Table)
P = TypeVar("P", bound=Table)
T = TypeVar("T")

_LISTS = {
    "illuminant": "; see camsim list illuminants",
    "reflectance": "; see camsim list reflectances",
    "sensitivity": "; see camsim list sensitivities",
}


@dataclass
class Validated(Generic[M]):
    """A document with its model (None when the schema found faults) and the faults found so far.

    A part is read by its own path, so that one wrong number elsewhere does not hide what is wrong here.
    """

    document: Document
    model_type: type[M]
    model: M | None = None
    faults: list[Fault] = field(default_factory=list)

    @classmethod
    def of(cls, document: Document, model_type: type[M]) -> Validated[M]:
        """Validate a document by its schema."""
        model, faults = parsed(document, model_type)
        return cls(document, model_type, model, faults)

    def value(self, path: KeyPath) -> Any:
        """Return the plain value at ``path``; None when there is none."""
        node = self.document.find(path)
        return None if node is None or node.refused else node.plain()

    def part(self, path: KeyPath, kind: type[P]) -> P | None:
        """Return the table at ``path``, with its defaults; None when missing, wrong or of another kind."""
        if self.model is not None:
            found: Any = self.model
            for key in path:
                found = getattr(found, str(key)) if isinstance(found, Table) else found[key]
            return found if isinstance(found, kind) else None
        table = self._table(path)
        if table is None or not issubclass(table, kind):
            return None
        try:
            return validate(self.value(path), table)
        except ValidationError:
            return None

    def build(self, path: KeyPath, make: Callable[[], T], *, keys: Mapping[str, KeyPath] | None = None) -> T | None:
        """Make a stage of the part at ``path``; errors that the stage raises become faults of that part.

        keys : where the file has the stage's parameters, from ``path``, those that it calls by other names
        """
        if self.full:
            return None
        try:
            return make()
        except ConfigError as error:
            self.faults.extend(error.faults)
        except UnknownNameError as error:
            displayed = "" if error.near else number_hint(error.name) or _LISTS.get(error.kind, "")
            self.refuse(self._place(path, error, keys or {}), error.message + displayed)
        except CamsimError as error:
            self.refuse(self._place(path, error, keys or {}), error.message)
        return None

    @property
    def full(self) -> bool:
        """Whether the limit of reported faults is reached."""
        return len(self.faults) >= MOST_FAULTS

    def refuse(self, path: KeyPath, message: str) -> None:
        """Add a fault."""
        self.faults.append(self.document.fault(path, message))

    def _table(self, path: KeyPath) -> type[Table] | None:
        node = self.document.find(path)
        expected = along(Expected.of(self.model_type), self.document.root, path)
        return expected.table(node) if node is not None and expected is not None else None

    def _place(self, path: KeyPath, error: CamsimError, keys: Mapping[str, KeyPath]) -> KeyPath:
        """Return the path of the key that a stage complains about; the stage's own where the file has no such key."""
        if error.key in keys:
            return (*path, *keys[error.key])
        table = self._table(path)
        return (*path, error.key) if table is not None and error.key in table.model_fields else path
