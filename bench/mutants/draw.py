"""Mutants: one line of a module changed, found by its syntax tree and drawn at random by kind and folder."""

from __future__ import annotations

import ast
import functools
import hashlib
import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice, pairwise
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("optics", "sensor", "measure", "config", "files", "spectra", "rendering")
KINDS = (
    "sign",
    "factor of 1 %",
    "axes swapped",
    "off by one",
    "half a pixel",
    "term dropped",
    "comparison flipped",
    "wrong entry",
    "condition negated",
    "constant changed",
)

_SWAPPED = (
    ("x", "y"),
    ("fx", "fy"),
    ("row", "col"),
    ("rows", "cols"),
    ("width", "height"),
    ("across", "down"),
    ("left", "top"),
    ("sin", "cos"),
    ("real", "imag"),
    ("first", "last"),
    ("low", "high"),
    ("min", "max"),
    ("floor", "ceil"),
    ("start", "stop"),
)
_OTHER = {a: b for pair in _SWAPPED for a, b in (pair, pair[::-1])}
_ALWAYS_KNOWN = {"sin", "cos", "real", "imag", "min", "max", "floor", "ceil"}
_OPERATOR = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
_FLIPPED = {
    ast.Lt: ("<", ">="),
    ast.LtE: ("<=", ">"),
    ast.Gt: (">", "<="),
    ast.GtE: (">=", "<"),
    ast.Eq: ("==", "!="),
    ast.NotEq: ("!=", "=="),
    ast.In: ("in", "not in"),
    ast.NotIn: ("not in", "in"),
    ast.Is: ("is", "is not"),
    ast.IsNot: ("is not", "is"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Mutant:
    """One line changed.

    path, number  : the module, from the root, and the line's number
    kind          : one of ``KINDS``
    before, after : the whole line
    """

    path: str
    number: int
    kind: str
    before: str
    after: str

    @property
    def key(self) -> str:
        """What names it while its file changes around it: nothing of where the line stands."""
        stated = "\n".join((self.path, self.before.strip(), self.after.strip()))
        return hashlib.sha256(stated.encode()).hexdigest()[:12]

    @property
    def folder(self) -> str:
        """The folder of camsim that it is in."""
        return self.path.split("/")[1]

    def text(self) -> str:
        """Return the module's source with the line changed."""
        lines = (ROOT / self.path).read_text(encoding="utf-8").splitlines(keepends=True)
        assert lines[self.number - 1] == self.before + "\n", f"{self.path}:{self.number} has changed; start again"
        lines[self.number - 1] = self.after + "\n"
        return "".join(lines)


def drawn(each: int, seed: str) -> list[Mutant]:
    """Return ``each`` mutants of every kind from every folder, or as many as there are.

    The draw goes by a hash of each mutant and the seed, so that most of it stays while the modules change.
    """
    chosen: dict[str, Mutant] = {}
    for some in _all_there_are().values():
        order = sorted(some, key=lambda key: hashlib.sha256(f"{seed} {key}".encode()).digest())
        parsed = (some[key] for key in order if key not in chosen and _parses(some[key].text()))
        chosen |= {mutant.key: mutant for mutant in islice(parsed, each)}
    return list(chosen.values())


@functools.cache
def _all_there_are() -> dict[tuple[str, str], dict[str, Mutant]]:
    """Return every mutant by folder and kind, and there by its key."""
    found: dict[tuple[str, str], dict[str, Mutant]] = {(folder, kind): {} for folder in FOLDERS for kind in KINDS}
    for folder in FOLDERS:
        for path in sorted((ROOT / "camsim" / folder).rglob("*.py")):
            for mutant in mutants(path):
                found[folder, mutant.kind].setdefault(mutant.key, mutant)
    return found


def mutants(path: Path) -> Iterator[Mutant]:
    """Yield every mutant of a module."""
    source = path.read_text(encoding="utf-8")
    lines = source.splitlines()
    tree = ast.parse(source)
    for node, parent, function in _computed(tree, tree):
        if node.lineno != node.end_lineno:
            continue
        line = lines[node.lineno - 1]
        for kind, start, end, text in _changes(node, parent, _names_in(function), line):
            coded = line.encode()
            after = (coded[:start] + text.encode() + coded[end:]).decode()
            if after != line:
                yield Mutant(
                    path=path.relative_to(ROOT).as_posix(), number=node.lineno, kind=kind, before=line, after=after
                )


def _parses(source: str) -> bool:
    try:
        ast.parse(source)
    except SyntaxError:
        return False
    return True


def _computed(tree: ast.AST, function: ast.AST) -> Iterator[tuple[ast.expr, ast.AST, ast.AST]]:
    """Yield the expressions that give numbers and decisions, each with its parent and the function that it is in.

    Left out: what only people read (messages, documentation) and what only type checkers do.
    """
    function = tree if isinstance(tree, ast.FunctionDef) else function
    for field, value in ast.iter_fields(tree):
        for node in value if isinstance(value, list) else [value]:
            if not isinstance(node, ast.AST) or isinstance(node, ast.JoinedStr | ast.Raise | ast.Assert):
                continue
            if field in ("annotation", "returns", "decorator_list", "bases", "type_params"):
                continue
            if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
                continue  # a docstring
            if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
                continue
            if isinstance(node, ast.expr):
                yield node, tree, function
            yield from _computed(node, function)


@functools.cache
def _names_in(function: ast.AST) -> set[str]:
    """Return all names in a function (or a module): variables, arguments and attributes."""
    nodes = list(ast.walk(function))
    return {
        *(node.id for node in nodes if isinstance(node, ast.Name)),
        *(node.arg for node in nodes if isinstance(node, ast.arg)),
        *(node.attr for node in nodes if isinstance(node, ast.Attribute)),
    }


def _changes(node: ast.expr, parent: ast.AST, known: set[str], line: str) -> Iterator[tuple[str, int, int, str]]:
    """Yield kind, first and last byte, and the text that goes there; ``known``: names that mean something there."""
    start, end = node.col_offset, node.end_col_offset or 0
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATOR and not _is_text(node):
        sign = _OPERATOR[type(node.op)]
        at = (node.left.end_col_offset or 0) + _between(node.left, node.right, line).index(sign)
        if sign in "+-":
            yield "sign", at, at + 1, "-" if sign == "+" else "+"
            if isinstance(parent, ast.BinOp) or sign == "+":
                yield "term dropped", node.left.end_col_offset or 0, end, ""
            if _is_half(node.right):
                yield "half a pixel", node.right.col_offset, end, "0.0"
            if _is_half(node.left):
                yield "half a pixel", start, node.left.end_col_offset or 0, "0.0"
        else:
            yield "factor of 1 %", start, end, f"({line.encode()[start:end].decode()} * 1.01)"
            yield "term dropped", node.left.end_col_offset or 0, end, ""
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub) and not _is_place(parent):
        yield "sign", start, start + 1, ""
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        yield "condition negated", start, end, _source(node.operand, line)
    elif isinstance(node, ast.Compare) and len(node.ops) == 1:
        old, new = _FLIPPED[type(node.ops[0])]
        gap = _between(node.left, node.comparators[0], line)
        yield "comparison flipped", node.left.end_col_offset or 0, node.comparators[0].col_offset, gap.replace(old, new)
    elif isinstance(node, ast.BoolOp):
        old, new = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
        gap = _between(node.values[0], node.values[1], line)
        yield "condition negated", node.values[0].end_col_offset or 0, node.values[1].col_offset, gap.replace(old, new)
    elif isinstance(node, ast.Constant):
        yield from _other_constant(node, parent, start, end)
    elif isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Load):
        word = node.attr if isinstance(node, ast.Attribute) else node.id
        for other in _other_axis(word) & (known | _ALWAYS_KNOWN):
            yield "axes swapped", end - len(word.encode()), end, other
    elif isinstance(node, ast.Dict):
        for a, b in pairwise(node.values):
            yield from _exchanged(a, b, line)
    elif isinstance(node, ast.Tuple | ast.List) and isinstance(node.ctx, ast.Load) and len(node.elts) > 1:
        yield from _exchanged(node.elts[0], node.elts[1], line)
    elif isinstance(node, ast.Call) and len(node.args) > 1 and not _is_isinstance(node.func):
        yield from _exchanged(node.args[0], node.args[1], line)
    elif isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Load) and isinstance(node.slice, ast.Constant):
        at = node.slice
        if isinstance(at.value, int) and not isinstance(at.value, bool):
            yield "wrong entry", at.col_offset, at.end_col_offset or 0, str(1 - at.value if at.value in (0, 1) else 0)
    if isinstance(parent, ast.If | ast.IfExp | ast.While) and node is parent.test and not isinstance(node, ast.Compare):
        yield "condition negated", start, end, f"not ({line.encode()[start:end].decode()})"
    if isinstance(parent, ast.comprehension) and node in parent.ifs:
        yield "condition negated", start, end, f"not ({line.encode()[start:end].decode()})"


def _is_isinstance(node: ast.expr) -> bool:
    return isinstance(node, ast.Name) and node.id == "isinstance"


def _other_constant(node: ast.Constant, parent: ast.AST, start: int, end: int) -> Iterator[tuple[str, int, int, str]]:
    value = node.value
    if isinstance(value, bool):
        yield "condition negated", start, end, str(not value)
    elif isinstance(value, int):
        if not _is_place(parent):
            yield "off by one", start, end, str(value + 1)
            yield "constant changed", start, end, str(2 * value if value > 1 else value + 2)
        if isinstance(parent, ast.keyword) and parent.arg == "axis":
            yield "axes swapped", start, end, str(1 - value if value in (0, 1) else 0)
    elif isinstance(value, float):
        yield "constant changed", start, end, repr(2.0 * value or 0.1)
        yield "factor of 1 %", start, end, repr(1.01 * value or 0.01)


def _exchanged(a: ast.expr, b: ast.expr, line: str) -> Iterator[tuple[str, int, int, str]]:
    if a.lineno == a.end_lineno == b.lineno == b.end_lineno and type(a) is type(b):
        start, end = a.col_offset, b.end_col_offset or 0
        yield "wrong entry", start, end, f"{_source(b, line)}{_between(a, b, line)}{_source(a, line)}"


def _source(node: ast.expr, line: str) -> str:
    return line.encode()[node.col_offset : node.end_col_offset].decode()


def _between(a: ast.expr, b: ast.expr, line: str) -> str:
    return line.encode()[a.end_col_offset : b.col_offset].decode()


def _is_place(parent: ast.AST) -> bool:
    """Whether a number inside of it says which element is meant: another would hardly ever exist."""
    return isinstance(parent, ast.Subscript | ast.UnaryOp)


def _other_axis(name: str) -> set[str]:
    """Return the name with one of its words exchanged for its opposite.

    >>> _other_axis("width_um")
    {'height_um'}
    """
    words = name.split("_")
    return {"_".join([*words[:k], _OTHER[word], *words[k + 1 :]]) for k, word in enumerate(words) if word in _OTHER}


def _is_half(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value == 0.5


def _is_text(node: ast.BinOp) -> bool:
    """Whether it is text or a list that is put together, and no number."""
    return bool(re.match(r"[\[(]*[frb]?['\"\[]", ast.unparse(node.left)))
