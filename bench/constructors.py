"""What type checkers may hand to the constructors: ``python -m bench.constructors`` writes it into the classes.

A constructor takes NumPy's numbers and stores Python's. A dataclass has one type for both, as mypy does not read the
``converter`` of a field (``dataclass_transform``). So each class has below its fields, for type checkers alone, what
its constructor takes, and a camera a table of what its ``replace`` takes. They follow from the fields, which
``tests/architecture/test_constructors.py`` tests.
"""

from __future__ import annotations

import ast
import importlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, get_args, get_origin

import camsim
from camsim.camera import body

PACKAGE = Path(camsim.__file__).parent
TAKEN: dict[type, str] = {float: "Number", int: "Whole", bool: "Truth"}
WIDER = {
    "Corners": "Several[Place]",
    "Filter": "NumberOrCurve",
    "Matrix": "Several[Number]",
    "Point": "Place",
    "Reflectance": "NumberOrCurve",
    "Transmission": "NumberOrCurve",
}
"""What is taken for the kinds of values that fields have."""
VALIDATING = {"Outlined", "Gradient", "RoundGradient"}
"""Bases that validate what their classes are given."""
BODIES = ("Body", "Sensor")
"""Classes whose fields are partly those of their base."""
TABLES = {"ElectronicChanges": "Electronics", "Changes": "Body"}
"""What ``replace`` takes: tables, and the classes whose fields they have."""


def validating(tree: ast.Module) -> Iterator[ast.ClassDef]:
    """Yield the classes of a module that validate what they are given, if they are public or bodies."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef) and node.name in (*dir(camsim), *BODIES):
            made = [part for part in node.body if isinstance(part, ast.FunctionDef) and part.name == "__post_init__"]
            inherited = not made and VALIDATING & set(map(ast.unparse, node.bases))
            if node.name in BODIES or inherited or any("validate(self)" in ast.unparse(part) for part in made):
                yield node


def constructor(node: ast.ClassDef, names: dict[str, Any]) -> ast.If:
    """Return what a class says to type checkers; ``names``: those of its module."""
    parameters: list[str] = []
    of_body = "Body" in map(ast.unparse, node.bases)
    for field in ({**own_fields(BODY), **own_fields(node)} if of_body else own_fields(node)).values():
        facts = _facts(field.value)
        if facts.get("init") == "False":
            continue
        if "*" not in parameters and "True" in (_facts(node.decorator_list[0]).get("kw_only"), facts.get("kw_only")):
            parameters.append("*")
        typed = f"{ast.unparse(field.target)}: {taken_for(field.annotation, vars(body) | names)}"
        default = facts.get("default", "..." if "default_factory" in facts else "")
        parameters.append(f"{typed} = {default}" if default else typed)
    if node.name in BODIES:
        parameters.append("**electronics: Unpack[ElectronicChanges]")
    lines = f"if TYPE_CHECKING:\n    def __init__(self, {', '.join(parameters)}) -> None: ..."
    made = ast.parse(lines).body[0]
    assert isinstance(made, ast.If)
    return made


def own_fields(node: ast.ClassDef) -> dict[str, ast.AnnAssign]:
    """Return the fields that a class declares, by name."""
    declared = (part for part in node.body if isinstance(part, ast.AnnAssign))
    return {ast.unparse(part.target): part for part in declared if "ClassVar" not in ast.unparse(part.annotation)}


def taken_for(annotation: ast.expr, names: dict[str, Any]) -> str:
    """Return what is taken for a field of a type."""
    return ast.unparse(_Taken(names).visit(ast.parse(ast.unparse(annotation), mode="eval").body))


def _facts(value: ast.expr | None) -> dict[str, str]:
    """Return what ``dataclass(…)`` or ``field(…)`` says; of a plain value that it is the default."""
    if isinstance(value, ast.Call) and ast.unparse(value.func).removeprefix("dataclasses.") in ("field", "dataclass"):
        return {word.arg: ast.unparse(word.value) for word in value.keywords if word.arg}
    return {} if value is None else {"default": "..." if isinstance(value, ast.Call) else ast.unparse(value)}


class _Taken(ast.NodeTransformer):
    """From a field's type to what is taken for it."""

    def __init__(self, names: dict[str, Any]) -> None:
        self._names = names

    def visit_Name(self, node: ast.Name) -> ast.Name:
        named = kind = self._names.get(node.id, {"float": float, "int": int, "bool": bool}.get(node.id))
        while get_origin(kind) is Annotated:
            kind = get_args(kind)[0]
        name = TAKEN.get(kind) if isinstance(kind, type) else None
        plain = named is not kind and getattr(kind, "__name__", "")
        return ast.Name(name or WIDER.get(node.id) or (plain if plain and plain in self._names else node.id))

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        if ast.unparse(node.value) == "Annotated":  # limits are of no use to type checkers
            assert isinstance(node.slice, ast.Tuple)
            inside: ast.AST = self.visit(node.slice.elts[0])
            return inside
        return node if ast.unparse(node.value) == "Literal" else self.generic_visit(node)


def written(node: ast.ClassDef) -> ast.If | None:
    """Return what a class has for type checkers."""
    return next((part for part in node.body if isinstance(part, ast.If)), None)


def files() -> Iterator[Path]:
    """Yield the files that hold such classes."""
    for path in sorted(PACKAGE.rglob("*.py")):
        source = path.read_text(encoding="utf-8")
        if ("validate(self)" in source or "(Outlined)" in source) and path.name != "typed.py":
            yield path
    yield from (PACKAGE / "camera" / name for name in ("body.py", "sensor.py"))


def names_of(path: Path) -> dict[str, Any]:
    """Return the names of a file's module."""
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return vars(importlib.import_module(".".join(parts).removesuffix(".__init__")))


def class_of(tree: ast.Module, name: str) -> ast.ClassDef:
    """Return a class of a module."""
    return next(node for node in tree.body if isinstance(node, ast.ClassDef) and node.name == name)


BODY = class_of(ast.parse((PACKAGE / "camera" / "body.py").read_text(encoding="utf-8")), "Body")


def main() -> None:
    """Write what every class has for type checkers."""
    for path in files():
        source, names = path.read_text(encoding="utf-8"), names_of(path)
        tree = ast.parse(source)
        lines, new = source.splitlines(), []
        for node in validating(tree):
            made = constructor(node, names)
            old = written(node)
            if old is None or ast.dump(old) != ast.dump(made):
                last = max(part.end_lineno or 0 for part in own_fields(node).values())
                place = slice(last, last) if old is None else slice(old.lineno - 1, old.end_lineno)
                new.append((place, ["", *(f"    {line}" for line in ast.unparse(made).splitlines()), ""]))
        for table in (node for node in tree.body if isinstance(node, ast.ClassDef) and node.name in TABLES):
            first, *_, last = own_fields(table).values()
            fields = own_fields(class_of(tree, TABLES[table.name]))
            typed = [f"    {name}: {taken_for(field.annotation, names)}" for name, field in fields.items()]
            new.append((slice(first.lineno - 1, last.end_lineno), typed))
        for place, text in sorted(new, key=lambda each: -each[0].start):
            lines[place] = text
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    subprocess.run([sys.executable, "-m", "ruff", "format", "-q", *map(str, files())], check=True)


if __name__ == "__main__":
    main()
