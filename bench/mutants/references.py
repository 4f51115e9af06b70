"""Who uses a line: kernels that have it compiled in, and the functions that run it or what it defines.

Names are followed by how they are written, in the modules that import the one that they are from, or anything of its
folder: two things of one name only mean that more is looked at than need be.
"""

from __future__ import annotations

import ast
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(slots=True)
class _Definition:
    """A function, a class or a constant of a module: where it is, and the names that it uses on which line."""

    path: str
    name: str
    first: int
    last: int
    kernel: bool = False
    runs_when_called: bool = False
    uses: dict[str, set[int]] = field(default_factory=lambda: defaultdict(set))


class References:
    """All definitions of the package below ``root``; not ``compiled``: kernels are plain functions."""

    def __init__(self, root: Path, *, compiled: bool = True) -> None:
        self._compiled = compiled
        self._all: list[_Definition] = []
        self._imports: dict[str, set[str]] = {}
        for path in sorted((root / "camsim").rglob("*.py")):
            tree = ast.parse(path.read_text(encoding="utf-8"))
            module = path.relative_to(root).as_posix()
            self._imports[module] = {module, *_imported(root, tree)}
            for statement in tree.body:
                self._define(module, statement)
        known = {definition.name for definition in self._all}
        self._users: dict[str, list[_Definition]] = defaultdict(list)
        for definition in self._all:
            for name in known & definition.uses.keys():
                self._users[name].append(definition)

    def compiled_with(self, path: str, number: int) -> set[str]:
        """Return the modules whose kernels have the line compiled in."""
        frozen = self._frozen_with(path, number)
        return {definition.path for definition in frozen if definition.kernel}

    def run_by(self, path: str, number: int) -> set[tuple[str, int]]:
        """Return the lines (module, number) of plain functions one of which must run for the line to matter."""
        inner = [d for d in self._all if d.path == path and d.first <= number <= d.last and d.runs_when_called]
        if inner and not inner[-1].kernel:
            return {(path, number)}
        frozen = self._frozen_with(path, number)
        return {
            (user.path, line)
            for definition in frozen
            for user in self._users_of(definition)
            if user.runs_when_called and not user.kernel
            for line in user.uses[definition.name]
        }

    def _frozen_with(self, path: str, number: int) -> list[_Definition]:
        """Return the definitions that hold the line, and all into which those go when modules load or compile."""
        waiting = [d for d in self._all if d.path == path and d.first <= number <= d.last][-1:]
        frozen: list[_Definition] = []
        while waiting:
            definition = waiting.pop()
            if definition in frozen:
                continue
            frozen.append(definition)
            waiting += [user for user in self._users_of(definition) if user.kernel or not user.runs_when_called]
        return frozen

    def _users_of(self, definition: _Definition) -> list[_Definition]:
        return [user for user in self._users[definition.name] if definition.path in self._imports[user.path]]

    def _define(self, path: str, statement: ast.stmt, owner: str = "") -> None:
        if isinstance(statement, ast.FunctionDef):
            name, kernel, called = statement.name, self._compiled and _is_kernel(statement), True
        elif isinstance(statement, ast.ClassDef):
            name, kernel, called = statement.name, False, False
        elif isinstance(statement, ast.Assign | ast.AnnAssign):
            target = statement.targets[0] if isinstance(statement, ast.Assign) else statement.target
            # Of a class a constant is the class's own.
            name, kernel, called = owner or ast.unparse(target).strip("()"), False, False
        else:
            return
        made = [
            _Definition(path, one, statement.lineno, statement.end_lineno or 0, kernel, called)
            for one in name.split(", ")
        ]
        self._all += made
        inner = statement.body if isinstance(statement, ast.ClassDef) else []
        for node in ast.walk(statement):
            if isinstance(node, ast.Name | ast.Attribute) and not any(
                isinstance(part, ast.FunctionDef) and part.lineno <= node.lineno <= (part.end_lineno or 0)
                for part in inner
            ):
                for definition in made:
                    definition.uses[node.id if isinstance(node, ast.Name) else node.attr].add(node.lineno)
        for part in inner:
            self._define(path, part, owner=owner or name)


def _is_kernel(function: ast.FunctionDef) -> bool:
    return any("kernel" in ast.unparse(decorator) for decorator in function.decorator_list)


def _imported(root: Path, tree: ast.Module) -> set[str]:
    """Return the modules that a module imports from anywhere in it; of a package all that is in its folder."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("camsim"):
            place = root / (node.module or "").replace(".", "/")
            for path in [
                place.with_suffix(".py"),
                *(place.rglob("*.py") if len(place.parts) > len(root.parts) + 1 else []),
            ]:
                found.add(path.relative_to(root).as_posix())
            found |= {(place / f"{name.name}.py").relative_to(root).as_posix() for name in node.names}
    return found
