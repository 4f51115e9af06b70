"""Read YAML by the rules of YAML 1.2, with positions; ambiguous constructs are refused.

PyYAML reads ``1e-3`` as a word, ``010`` as 8, ``no`` as false, and lets the second of two equal keys win
silently. So only its parser is used here; what the events mean is decided in this module.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

from camsim.config.scalars import resolve
from camsim.config.tree import MOST_FAULTS, Document, KeyPath, Node, Place, dotted
from camsim.errors import ConfigError, Fault

MAX_BYTES = 16 * 1024 * 1024
MAX_DEPTH = 64

# libyaml is ten times faster; PyYAML without it reads the same files.
_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_FORBIDDEN_CHARACTER = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_INDENTATION = "the indentation or a '-' does not fit the lines above; keys of one table start in one column"
# PyYAML's words for a mistake (both its parsers'), and what the user should read.
_SYNTAX = (
    ("tab character that violates", "a tab in the indentation; use spaces"),
    (
        "mapping values are not allowed",
        "a second ': ' in one value; put it in quotes or mend the indentation",
    ),
    ("',' or ']'", "a list '[' is not closed; write [a, b, c]"),
    ("',' or '}'", "a table '{' is not closed; write {key: value, key: value}"),
    ("node content", "a value or a closing bracket is missing here"),
    ("could not find expected ':'", "a line without ': '; write key: value"),
    ("expected key", _INDENTATION),
    ("<block end>", _INDENTATION),
    ("<document start>", "text after the end of the document; a file holds one table"),
    ("escape", "an unknown escape after '\\' in double quotes; use single quotes or '\\\\'"),
    ("nesting depth", f"nested more than {MAX_DEPTH} deep"),  # of newer ones of libyaml, which look ahead
    ("incompatible YAML", "this is not YAML 1.2; leave the %YAML line out"),
)


def read(path: Path, displayed: str) -> Document:
    """Read a file.

    path    the file
    displayed  its name as the user gave it

    Raises ConfigError when nothing can be made of the file. Lesser faults (anchors, duplicate keys) travel in
    the document, so that they are reported together with what the schema finds.
    """
    try:
        with path.open("rb") as stream:
            data = stream.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise ConfigError([Fault(displayed, 0, 0, "", "no such file")]) from None
    except (OSError, ValueError) as error:
        reason = (getattr(error, "strerror", None) or str(error)).lower()
        raise ConfigError([Fault(displayed, 0, 0, "", f"cannot be read: {reason}")]) from None
    return parse(data, displayed, path.parent)


def parse(data: bytes, displayed: str, folder: Path) -> Document:
    """Make a document of the bytes of a file; see ``read``."""
    if len(data) > MAX_BYTES:
        raise ConfigError([Fault(displayed, 0, 0, "", f"larger than {MAX_BYTES // 2**20} MB, the most that is read")])
    reader = _Reader(displayed)
    root = reader.document(_decode(data, displayed))
    return Document(displayed, folder, root, tuple(reader.faults))


def parse_value(text: str, place: Place) -> Node:
    """Make a node of the value of an override; all of it is at ``place``."""
    reader = _Reader(place.file, place)
    root = reader.document(_decode(text.encode("utf-8", "surrogateescape"), place.file))
    if reader.faults:
        raise ConfigError(reader.faults)
    return root


def _decode(data: bytes, displayed: str) -> str:
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line, column = _line_and_column(data[: error.start].decode("utf-8", "replace"))
        message = f"byte 0x{data[error.start]:02x} is not UTF-8; save the file as UTF-8"
        raise ConfigError([Fault(displayed, line, column, "", message)]) from None
    if bad := _FORBIDDEN_CHARACTER.search(text):
        line, column = _line_and_column(text[: bad.start()])
        message = f"the control character U+{ord(bad[0]):04X} has no place in a YAML file; delete it"
        raise ConfigError([Fault(displayed, line, column, "", message)])
    return text


def _line_and_column(before: str) -> tuple[int, int]:
    lines = before.replace("\r\n", "\n").split("\n")
    return len(lines), len(lines[-1]) + 1


class _Reader:
    """One pass over the events of a document."""

    def __init__(self, displayed: str, place: Place | None = None) -> None:
        self.displayed = displayed
        self.fixed_place = place
        self.faults: list[Fault] = []

    def document(self, text: str) -> Node:
        events = self._events(text)
        next(events)
        first = next(events)
        if isinstance(first, yaml.StreamEndEvent):
            return Node(None, self._place(first), self._place(first))
        if first.tags or first.version not in (None, (1, 2)):
            self._refuse(first, (), "files are read as YAML 1.2; leave the lines that begin with % out")
        root = self._node(next(events), events, (), None)
        next(events)
        following = next(events)
        if not isinstance(following, yaml.StreamEndEvent):
            self._refuse(following, (), "a second document begins here; a file holds one (delete the '---')")
        return root

    def _events(self, text: str) -> Iterator[Any]:
        try:
            yield from yaml.parse(text, Loader=_LOADER)
        except yaml.MarkedYAMLError as error:
            raise ConfigError([*self.faults, self._syntax_fault(error, text)]) from None
        except yaml.YAMLError as error:
            raise ConfigError([*self.faults, Fault(self.displayed, 0, 0, "", f"not YAML: {error}")]) from None

    def _syntax_fault(self, error: yaml.MarkedYAMLError, text: str) -> Fault:
        problem = error.problem or "not YAML"
        mark = error.problem_mark or error.context_mark
        message = next((said for sign, said in _SYNTAX if sign in problem), None)
        if message is not None and "is not closed" in message and error.context_mark is not None:
            mark = error.context_mark
        line, column = (mark.line + 1, mark.column + 1) if mark is not None else (1, 1)
        if message is None and "cannot start any token" in problem:
            lines = text.splitlines()
            character = lines[line - 1][column - 1 : column] if line <= len(lines) else ""
            message = f"a value cannot begin with {character!r}; put it in quotes"
            if character == "\t":
                message = "a tab in the indentation; use spaces"
        if message is None and "end of stream" in problem and error.context_mark is not None:
            message = "the quote that opens here is never closed"
            line, column = error.context_mark.line + 1, error.context_mark.column + 1
        if self.fixed_place is not None:
            line = column = 0
        return Fault(self.displayed, line, column, "", message or f"not YAML: {problem}")

    def _place(self, event: Any) -> Place:
        if self.fixed_place is not None:
            return self.fixed_place
        return Place(self.displayed, event.start_mark.line + 1, event.start_mark.column + 1)

    def _refuse(self, event: Any, path: KeyPath, message: str) -> None:
        self._add(self._place(event), path, message)

    def _add(self, place: Place, path: KeyPath, message: str) -> None:
        self.faults.append(Fault(place.file, place.line, place.column, dotted(path), message))
        if len(self.faults) >= MOST_FAULTS:
            raise ConfigError(self.faults)

    def _node(self, event: Any, events: Iterator[Any], path: KeyPath, named: Place | None) -> Node:
        place = self._place(event)
        named = named or place
        if isinstance(event, yaml.AliasEvent):
            self._refuse(event, path, f"the alias *{event.anchor} is not allowed; write the value out")
            return Node(None, place, named, refused=True)
        refused = self._refuse_decorations(event, path)
        if isinstance(event, yaml.ScalarEvent):
            # The text was looked through; only an escape in double quotes brings in others.
            if event.style == '"' and (bad := _FORBIDDEN_CHARACTER.search(event.value)):
                self._refuse(event, path, f"the character U+{ord(bad[0]):04X} has no place here; leave it out")
                refused = True
            # A style marks quotes or a block (| >): those are words, whatever they look like.
            content = resolve(event.value) if not event.style else event.value
            return Node(content, place, named, event.value, refused)
        if len(path) >= MAX_DEPTH:
            fault = Fault(place.file, place.line, place.column, "", f"nested more than {MAX_DEPTH} deep")
            raise ConfigError([*self.faults, fault])
        if isinstance(event, yaml.SequenceStartEvent):
            items: list[Node] = []
            while not isinstance(event := next(events), yaml.SequenceEndEvent):
                items.append(self._node(event, events, (*path, len(items)), None))
            return Node(tuple(items), place, named, refused=refused)
        return Node(self._entries(events, path), place, named, refused=refused)

    def _refuse_decorations(self, event: Any, path: KeyPath) -> bool:
        if event.anchor is not None:
            self._refuse(
                event,
                path,
                f"the anchor &{event.anchor} is not allowed; write the value out where it is used",
            )
        if event.tag is not None:
            tag = event.tag.replace("tag:yaml.org,2002:", "!!")
            self._refuse(event, path, f"the tag {tag} is not allowed; leave it out")
        return event.tag is not None

    def _entries(self, events: Iterator[Any], path: KeyPath) -> dict[str, Node]:
        entries: dict[str, Node] = {}
        while not isinstance(event := next(events), yaml.MappingEndEvent):
            named = self._place(event)
            if not isinstance(event, yaml.ScalarEvent):
                self._refuse(event, path, "a key must be a word")
                self._node(event, events, path, None)
                self._node(next(events), events, path, None)
                continue
            self._refuse_decorations(event, (*path, event.value))
            key = event.value
            node = self._node(next(events), events, (*path, key), named)
            if key in entries:
                line = entries[key].named.line
                message = f"given twice{f' (first on line {line})' if line else ''}; keep one"
                self._add(named, (*path, key), message)
            else:
                entries[key] = node
        return entries
