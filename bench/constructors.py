"""What type checkers may hand to the constructors: ``python -m bench.constructors`` writes it into the classes.

A constructor takes NumPy's numbers and keeps Python's. A dataclass has one type for both, what is given and what is
kept; so each class says below its fields, for type checkers alone, what its constructor takes. It follows from the
fields, and ``tests/architecture/test_constructors.py`` sees that it does.
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
"""What is taken for the kinds of values that fields keep."""


def validating(tree: ast.Module) -> Iterator[ast.ClassDef]:
    """Yield the public classes of a module that judge what they are given."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef) and node.name in dir(camsim):
            made = [part for part in node.body if isinstance(part, ast.FunctionDef) and part.name == "__post_init__"]
            if any("validate(self)" in ast.unparse(part) for part in made):
                yield node


def constructor(node: ast.ClassDef, names: dict[str, Any]) -> ast.If:
    """Return what a class says to type checkers; ``names``: those of its module."""
    parameters: list[str] = []
    for field in node.body:
        if not isinstance(field, ast.AnnAssign) or "ClassVar" in ast.unparse(field.annotation):
            continue
        facts = _facts(field.value)
        if facts.get("init") == "False":
            continue
        if "*" not in parameters and "True" in (_facts(node.decorator_list[0]).get("kw_only"), facts.get("kw_only")):
            parameters.append("*")
        said = f"{ast.unparse(field.target)}: {taken_for(field.annotation, names)}"
        default = facts.get("default", "..." if "default_factory" in facts else "")
        parameters.append(f"{said} = {default}" if default else said)
    lines = f"if TYPE_CHECKING:\n    def __init__(self, {', '.join(parameters)}) -> None: ..."
    made = ast.parse(lines).body[0]
    assert isinstance(made, ast.If)
    return made


def taken_for(kept: ast.expr, names: dict[str, Any]) -> str:
    """Return what is taken for what a field keeps."""
    return ast.unparse(_Taken(names).visit(ast.parse(ast.unparse(kept), mode="eval").body))


def _facts(value: ast.expr | None) -> dict[str, str]:
    """Return what ``dataclass(…)`` or ``field(…)`` says; of a plain value that it is the default."""
    if isinstance(value, ast.Call) and ast.unparse(value.func) in ("field", "dataclass"):
        return {word.arg: ast.unparse(word.value) for word in value.keywords if word.arg}
    return {} if value is None else {"default": "..." if isinstance(value, ast.Call) else ast.unparse(value)}


class _Taken(ast.NodeTransformer):
    """From what a field keeps to what is taken for it."""

    def __init__(self, names: dict[str, Any]) -> None:
        self._names = names

    def visit_Name(self, node: ast.Name) -> ast.Name:
        kept = self._names.get(node.id, {"float": float, "int": int, "bool": bool}.get(node.id))
        while get_origin(kept) is Annotated:
            kept = get_args(kept)[0]
        name = TAKEN.get(kept) if isinstance(kept, type) else None
        return ast.Name(name or WIDER.get(node.id, node.id))

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        if ast.unparse(node.value) == "Annotated":  # limits are of no use to type checkers
            assert isinstance(node.slice, ast.Tuple)
            inside: ast.AST = self.visit(node.slice.elts[0])
            return inside
        return node if ast.unparse(node.value) == "Literal" else self.generic_visit(node)


def written(node: ast.ClassDef) -> ast.If | None:
    """Return what a class says to type checkers now."""
    return next((part for part in node.body if isinstance(part, ast.If)), None)


def files() -> Iterator[Path]:
    """Yield the files that hold such classes."""
    for path in sorted(PACKAGE.rglob("*.py")):
        if "validate(self)" in path.read_text(encoding="utf-8") and path.name != "typed.py":
            yield path


def names_of(path: Path) -> dict[str, Any]:
    """Return the names of a file's module."""
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return vars(importlib.import_module(".".join(parts).removesuffix(".__init__")))


def main() -> None:
    """Write what every class says to type checkers."""
    for path in files():
        source = path.read_text(encoding="utf-8")
        lines = source.splitlines()
        for node in sorted(validating(ast.parse(source)), key=lambda node: -node.lineno):
            made = constructor(node, names_of(path))
            if (old := written(node)) is not None:
                if ast.dump(old) == ast.dump(made):
                    continue
                lines[old.lineno - 1 : old.end_lineno] = []
                first = old.lineno - 1
            else:
                fields = [part for part in node.body if isinstance(part, ast.AnnAssign)]
                first = max(part.end_lineno or 0 for part in fields)
            lines[first:first] = ["", *(f"    {line}" for line in ast.unparse(made).splitlines()), ""]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    subprocess.run([sys.executable, "-m", "ruff", "format", "-q", *map(str, files())], check=True)


if __name__ == "__main__":
    main()
