"""Untrusted XML: elements with their lines; no entities or external content, bounded in size and depth."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from camsim.errors import ConfigError, Fault, InputError, in_brief

MOST_BYTES = 16_000_000
MOST_DEPTH = 100
SVG = "http://www.w3.org/2000/svg"
_HTML = "http://www.w3.org/1999/xhtml"
_HREF = "http://www.w3.org/1999/xlink href"


@dataclass(slots=True, eq=False)
class Element:
    """An element of the SVG namespace.

    text : its direct text content
    """

    tag: str
    attributes: dict[str, str]
    line: int
    column: int
    children: list[Element] = field(default_factory=list)
    text: str = ""

    def all(self) -> Iterator[Element]:
        """Yield this element and all that are inside, in the file's order."""
        waiting = [self]
        while waiting:
            element = waiting.pop()
            yield element
            waiting += reversed(element.children)


def read_elements(path: Path, name: str) -> Element:
    """Return the root element of an SVG file; elements of other namespaces (metadata of editors) are skipped.

    name : of the file in messages
    """
    try:
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise InputError(f"cannot be read: {in_brief(error.strerror or error)}", stage=name) from None
    if len(data) > MOST_BYTES:
        raise InputError(f"is larger than {MOST_BYTES // 1_000_000} MB; simplify its paths", stage=name)
    reader = _Reader(name)
    try:
        reader.parser.Parse(data, True)
    except expat.ExpatError as error:
        fault = Fault(name, error.lineno, error.offset + 1, "", f"is no XML: {expat.ErrorString(error.code)}")
        raise ConfigError([fault]) from None
    if reader.root is None or reader.root.tag != "svg":
        raise InputError("holds no drawing: its first element is not <svg>", stage=name)
    return reader.root


class _Reader:
    """Builds the tree while expat reads."""

    def __init__(self, name: str) -> None:
        self.name, self.root = name, None
        self.open: list[Element | None] = []
        self.spaces: tuple[str, ...] = (SVG,)  # if the root has a namespace, elements without one are foreign
        self.parser = expat.ParserCreate(namespace_separator=" ")
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self.start
        self.parser.EndElementHandler = self.end
        self.parser.CharacterDataHandler = self.letters
        self.parser.EntityDeclHandler = self.entity
        self.parser.ProcessingInstructionHandler = self.instruction
        # External entities and document types are never fetched: expat asks a handler, and there is none.

    root: Element | None

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        if len(self.open) >= MOST_DEPTH:
            self.refuse(f"elements lie more than {MOST_DEPTH} deep in one another; ungroup some")
        space, _, bare = tag.rpartition(" ")
        if space == _HTML and bare in ("style", "link"):  # these apply to a drawing too
            self.refuse(f"holds a <{bare}> of HTML; give fills and strokes to the elements themselves")
        if not self.open:
            self.spaces = ("", SVG) if space == "" else (SVG,)
        if space not in self.spaces or (self.open and self.open[-1] is None):
            self.open.append(None)
            return
        one = {key: value for key, value in attributes.items() if " " not in key}
        if _HREF in attributes:
            one.setdefault("href", attributes[_HREF])
        element = Element(bare, one, self.parser.CurrentLineNumber, self.parser.CurrentColumnNumber + 1)
        if self.open and self.open[-1] is not None:
            self.open[-1].children.append(element)
        elif not self.open:
            self.root = element
        self.open.append(element)

    def end(self, tag: str) -> None:
        self.open.pop()

    def letters(self, text: str) -> None:
        if self.open and self.open[-1] is not None:
            self.open[-1].text += text

    def entity(self, name: str, *_: object) -> None:
        self.refuse(f"declares the entity {in_brief(name, 40)!r}; save it as plain SVG, without a document type")

    def instruction(self, target: str, data: str) -> None:
        if target == "xml-stylesheet":
            self.refuse("takes its style from another file; save it with its style inside")

    def refuse(self, message: str) -> None:
        line, column = self.parser.CurrentLineNumber, self.parser.CurrentColumnNumber + 1
        raise ConfigError([Fault(self.name, line, column, "", message)])
