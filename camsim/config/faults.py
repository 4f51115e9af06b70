"""Validation of a document by the schema: all faults at once, each a sentence with its place."""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar, get_args

from pydantic import ValidationError

from camsim.config.expect import Expected, along, can_contradict
from camsim.config.near import elsewhere
from camsim.config.pictured import is_picture
from camsim.config.scalars import resolve
from camsim.config.schema import Table
from camsim.config.tree import MOST_FAULTS, Document, KeyPath, Node
from camsim.core.words import DECIMAL_POINT, either, meant, number_hint, percent_hint, word_hint
from camsim.errors import ConfigError, Fault

T = TypeVar("T", bound=Table)

_LONGEST_DISPLAYED = 40
_TRUTHS = {"true": ("yes", "on", "y"), "false": ("no", "off", "n", "none")}


def parsed(document: Document, model: type[T]) -> tuple[T | None, list[Fault]]:
    """Return the document as a model (None when it has faults), and all its faults in the file's order.

    Raises ConfigError if the file is of another kind, as its keys cannot be interpreted.
    """
    faults = list(document.faults)
    if wrong_format := _format_fault(document, model):
        raise ConfigError([*faults, wrong_format])
    root = Expected.of(model)
    valid: T | None = None
    tree, said = document.tree, set[KeyPath]()
    for _ in range(2):
        try:
            valid = validate(tree, model)
            break
        except ValidationError as error:
            misspelt = False
            for detail in error.errors(include_url=False, include_context=False, include_input=False):
                path = _path_of(root, document.root, detail["loc"], detail["type"])
                validated = path[:-1] if detail["type"] == "extra_forbidden" else path
                if path not in said and not document.refuses(validated) and not _misspelt(root, document, path):
                    said.add(path)
                    faults.append(_fault(document, model, path, detail))
                misspelt |= detail["type"].startswith("union_tag") and _mend_kind(tree, root, document, path)
                if len(faults) >= MOST_FAULTS:
                    break
            if not misspelt or len(faults) >= MOST_FAULTS:
                break
    for path, message in _contradictions(root, document.root, ()):
        if len(faults) < MOST_FAULTS and not document.refuses(path) and not _misspelt(root, document, path):
            faults.append(document.fault(path, message, at_key=True))
    faults.sort(key=lambda fault: (fault.line, fault.column))
    return (valid if not faults else None), faults


def _misspelt(root: Expected, document: Document, path: KeyPath) -> bool:
    """Whether a missing key is present under another name, which has its own message."""
    holder, node = along(root, document.root, path[:-1]), document.find(path[:-1])
    table = holder.table(node) if holder is not None and node is not None else None
    if table is None or node is None or not isinstance(node.content, Mapping) or path[-1] in node.content:
        return False
    known = [name for name in table.model_fields if name != "source"]
    return any(meant(key, known) == path[-1] for key in node.content if key not in table.model_fields)


def validate(tree: Any, model: type[T]) -> T:
    """Return a plain tree as a model; raises pydantic's ValidationError."""
    # Strict pydantic accepts lists for tuples only in JSON mode.
    return model.model_validate_json(json.dumps(tree))


def format_of(model: type[Table]) -> str:
    """Return the name of a file's format, such as 'scene/1'."""
    return str(get_args(model.model_fields["camsim"].annotation)[0])


def _format_fault(document: Document, model: type[Table]) -> Fault | None:
    """Return the fault of a file of another kind, None for the right kind."""
    wanted = format_of(model)
    content = document.root.content
    if content is None:
        return document.fault((), f"the file is empty; begin it with 'camsim: {wanted}'")
    if not isinstance(content, Mapping):
        return document.fault((), f"must be a table of keys and values; begin it with 'camsim: {wanted}'")
    said = content.get("camsim")
    if said is None:
        return document.fault(("camsim",), f"missing; begin the file with 'camsim: {wanted}'")
    if said.content == wanted:
        return None
    kind, _, number = str(said.content).partition("/")
    wanted_kind, _, wanted_number = wanted.partition("/")
    if kind in ("scene", "sensor", "lens", "study", "dataset") and kind != wanted_kind:
        return document.fault(("camsim",), f"this is a {kind}, where a {wanted_kind} ({wanted}) is wanted")
    if kind == wanted_kind and number.isdecimal() and int(number) > int(wanted_number):
        message = f"{said.content} is newer than this camsim, which reads {wanted}; update camsim"
        return document.fault(("camsim",), message)
    return document.fault(("camsim",), f"must be {wanted}, not {_got(said)}; mend the file for {wanted}")


def _mend_kind(tree: Any, root: Expected, document: Document, path: KeyPath) -> bool:
    """Replace a misspelt kind (or name) by the intended one, so that it does not hide other faults."""
    *holder, telling = path
    expected, node = along(root, document.root, tuple(holder)), document.find(tuple(holder))
    word = expected.meant_word(node, str(telling)) if expected is not None and node is not None else None
    for key in holder:
        tree = tree[key]
    if word is None or tree.get(telling) == word:
        return False
    tree[telling] = word
    return True


def _path_of(root: Expected, node: Node, loc: tuple[str | int, ...], error: str) -> KeyPath:
    """Return the path of an error in the document: pydantic's, without the tags of union members."""
    # The last part of these two is a key of any name; a key may also be missing from the document.
    last = loc[-1:] if error in ("extra_forbidden", "missing") else ()
    path: KeyPath = ()
    here: Expected | None = root
    current: Node | None = node
    for key in loc[: len(loc) - len(last)]:
        if here is None or current is None:
            break
        if len(here.alternatives()) > 1:
            here = here.member(current)
        elif key != "[key]":
            path = (*path, key)
            here, current = here.inside(current, key), current.child(key)
    if error == "missing" and isinstance(last[0], int):
        last = ()  # a point with one number: the point is wrong
    if error.startswith("union_tag") and here is not None and len(here.tables()) > 1:
        last = (here.telling_key(),)
    return (*path, *last)


def _fault(document: Document, model: type[Table], path: KeyPath, detail: Any) -> Fault:
    root = Expected.of(model)
    if detail["type"] == "extra_forbidden":
        return document.fault(path, _unknown_key(document, model, path), at_key=True)
    if detail["loc"][-1] == "[key]":
        holder = along(root, document.root, path[:-1])
        way_out = "; write {R: {csv: …, column: R}, G: …}" if path[-1] in ("csv", "column") else ""
        words = holder.key_words() if holder else "another key"
        return document.fault(path, f"must be {words}{way_out}", at_key=True)
    expected = along(root, document.root, path)
    assert expected is not None, f"{path}: an error where the schema has nothing to say"
    meaning = f" ({expected.description})" if expected.description else ""
    node = document.find(path)
    if node is None:
        return document.fault(path, f"missing; {expected.words()}{_under_another_name(document, path)}{meaning}")
    return document.fault(path, _wrong_value(node, expected) + meaning)


def _under_another_name(document: Document, path: KeyPath) -> str:
    """Return the key used in place of the missing ``kind``."""
    holder = document.find(path[:-1])
    keys = list(holder.content) if holder is not None and isinstance(holder.content, Mapping) else []
    other = [key for key in keys if path[-1] == "kind" and meant(key, ["kind"])]
    return f"; write kind in place of {other[0]!r}" if other else ""


def _unknown_key(document: Document, model: type[Table], path: KeyPath) -> str:
    key = str(path[-1])
    holder = along(Expected.of(model), document.root, path[:-1])
    parent = document.find(path[:-1])
    table = holder.table(parent) if holder is not None and parent is not None else None
    assert table is not None, f"{path}: a key too many outside a table"
    assert holder is not None
    if comma := _comma(parent, key):
        return comma
    # A key of another kind is not a misspelling of one of this kind.
    others = [other for other in holder.tables() if key in other.model_fields]
    if kinds := dict.fromkeys(word for other in others for word in get_args(other.model_fields["kind"].annotation)):
        return f"unknown key of this kind; it is one of kind {either(list(kinds))}"
    allowed = [name for name in table.model_fields if name != "source"]
    if near := meant(key, allowed):
        description = table.model_fields[near].description
        return f"unknown key; did you mean {near!r}? ({description})"
    if places := elsewhere(key, model, path):
        return f"unknown key here; did you mean {places[0]!r}?"
    return f"unknown key; known here: {', '.join(allowed)}"


def _comma(parent: Node | None, key: str) -> str:
    """Return the fault of a comma in a number that turned its rest into a key; empty if none."""
    entries = parent.content if parent is not None else None
    if not isinstance(entries, Mapping) or not key.isdecimal() or entries[key].content is not None:
        return ""
    names = list(entries)
    name = names[names.index(key) - 1] if names[0] != key else ""
    before = entries[name] if name else None
    if before is None or isinstance(before.content, bool) or not isinstance(before.content, int | float):
        return ""
    number = f"{before.text},{key}"
    return f"a comma ends the value of {name!r}, so {number} is read as {before.text}{number_hint(number)}"


def _wrong_value(node: Node, expected: Expected) -> str:
    value, words = node.content, expected.words()
    if isinstance(value, float) and not math.isfinite(value):
        return f"must be {words.replace('a number', 'a finite number', 1)}, not {node.text}"
    hint = ""
    if expected.tables() and (picture := _picture_in(value)):
        hint = (
            f"; a picture is one of scene.shapes, {{kind: picture, file: {picture}, sample: 0.5}}: camsim new scene "
            f"--picture {shlex.quote(picture)} writes a scene of it"
        )
    elif isinstance(value, str):
        hint = word_hint(value, expected.literals()) or _hint_of_text(value, expected)
    elif expected.is_fraction():
        hint = percent_hint(value)
    elif expected.is_text() and isinstance(value, int | float):
        hint = f"; as a text it stands in quotes: '{node.text}'"
    elif isinstance(value, tuple) and value and len(value) == 2 * expected.length():
        hint = DECIMAL_POINT
    return f"must be {words}, not {_got(node)}{hint}"


def _picture_in(value: Any) -> str:
    """Return the name of a picture given in place of a table; empty if there is none."""
    name = value[0].content if isinstance(value, tuple) and value else value
    return name if isinstance(name, str) and is_picture(Path(name)) else ""


def _hint_of_text(text: str, expected: Expected) -> str:
    """Return a remedy for a text in place of a number, of true or false, or of a table with one key."""
    if expected.is_number():
        # A number in quotes.
        return "; write it without quotes" if isinstance(resolve(text), int | float) else number_hint(text)
    truth = next((said for said, words in _TRUTHS.items() if text.lower() in words), None)
    if expected.kind is bool:
        return f"; write {truth}" if truth else ""
    for table in expected.tables()[:1]:
        keys = [key for key in table.model_fields if key != "source"]
        if truth and table.model_fields[keys[0]].annotation is bool:
            return f"; write {{{keys[0]}: {truth}}}"
        if len(keys) == 1:
            return f"; write {{{keys[0]}: {text}}}"
    return ""


def _got(node: Node) -> str:
    """Return a value as written by the user."""
    if node.content is None:
        return "empty"
    if isinstance(node.content, Mapping):
        return "a table"
    if isinstance(node.content, tuple):
        return f"a list of {len(node.content)}" if node.content else "an empty list"
    text = node.text if len(node.text) <= _LONGEST_DISPLAYED else node.text[: _LONGEST_DISPLAYED - 1] + "…"
    return repr(text) if isinstance(node.content, str) else text


def _contradictions(expected: Expected, node: Node, path: KeyPath) -> Iterator[tuple[KeyPath, str]]:
    """Check all tables of a document for contradicting keys."""
    table = expected.table(node)
    if table is not None and table.can_contradict():
        for key, message in table.contradictions(node.plain()):
            yield (*path, key), message
    if isinstance(node.content, Mapping):
        for key, part in node.content.items():
            inside = expected.inside(node, key)
            if inside is not None and can_contradict(inside):
                yield from _contradictions(inside, part, (*path, key))
    elif isinstance(node.content, tuple):
        for index, part in enumerate(node.content):
            inside = expected.inside(node, index)
            if inside is not None:
                yield from _contradictions(inside, part, (*path, index))
