"""Who imports whom: floors, circles, doors.

python -m bench.imports
"""

from __future__ import annotations

import ast
import functools
import graphlib
import re
from dataclasses import dataclass, field
from pathlib import Path

PACKAGE = Path(__file__).parents[1] / "camsim"
SOURCES = sorted(PACKAGE.rglob("*.py"))

# From the ground up; a floor may use those before it.
FLOORS = (
    "errors",
    "core",
    "numerics",
    "spectra",
    "optics",
    "scene",
    "rendering",
    "sensor",
    "camera",
    "files",
    "measure",
    "config",
    "api",
    "study",
    "bench",
    "cli",
    "__main__",
)
# Where ``camsim.core.doors`` leads, for names where users look for them: ``from_yaml``, a frame's saving and pictures.
DOORS = {("scene", "api"), ("camera", "api"), ("camera", "files")}
OBJECTS = ("camsim.scene", "camsim.optics", "camsim.sensor", "camsim.spectra")


def module_of(path):
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@dataclass(frozen=True)
class Read:
    """What one file says of others, read once for all tests.

    imports    : every module that it imports, also inside functions
    members    : module.name of each name that it imports from a module
    attributes : what it asks of ``camsim`` after ``import camsim``
    calls      : (line, what is called by its name, whether only where the file is a script)
    kernels    : (name, all names within) of each compiled function
    objects    : what it calls its imports from modules of objects
    """

    imports: list[str] = field(default_factory=list)
    members: list[str] = field(default_factory=list)
    attributes: list[str] = field(default_factory=list)
    calls: list[tuple[int, str, bool]] = field(default_factory=list)
    kernels: list[tuple[str, set[str]]] = field(default_factory=list)
    objects: set[str] = field(default_factory=set)


@functools.cache
def read(path):
    found = Read()
    for statement in ast.parse(path.read_text(encoding="utf-8")).body:
        script = isinstance(statement, ast.If) and "__main__" in ast.unparse(statement.test)
        for node in ast.walk(statement):
            if isinstance(node, ast.Import):
                found.imports.extend(alias.name for alias in node.names)
            elif isinstance(node, ast.ImportFrom):
                assert node.level == 0, f"{path}: relative import"
                found.imports.append(node.module)
                found.members.extend(f"{node.module}.{alias.name}" for alias in node.names)
                if node.module == "camsim":
                    found.imports.extend(f"camsim.{alias.name}" for alias in node.names)
                if within(node.module, OBJECTS):
                    found.objects.update(alias.asname or alias.name for alias in node.names)
            elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "camsim":
                found.attributes.append(node.attr)
            elif isinstance(node, ast.Call):
                found.calls.append((node.lineno, dotted(node.func), script))
            elif isinstance(node, ast.FunctionDef) and any("kernel(" in ast.unparse(m) for m in node.decorator_list):
                found.kernels.append((node.name, {name.id for name in ast.walk(node) if isinstance(name, ast.Name)}))
    return found


def dotted(node):
    """Return a name such as ``sys.exit``, nothing for what is no name."""
    if isinstance(node, ast.Attribute):
        return f"{dotted(node.value)}.{node.attr}"
    return node.id if isinstance(node, ast.Name) else ""


def floor(module):
    return FLOORS.index(module.split(".")[1])


def within(module, packages):
    return any(module == package or module.startswith(package + ".") for package in packages)


def imported_modules():
    """Modules of the package and those that each imports, also inside functions and for type checkers alone.

    ``from camsim import Airy`` and ``import camsim`` followed by ``camsim.Airy`` are imports of Airy's own module.
    """
    stub = ast.parse((PACKAGE / "__init__.pyi").read_text(encoding="utf-8"))
    home = {
        alias.name: f"camsim.{node.module}"
        for node in stub.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    modules = {module_of(path): path for path in SOURCES}
    graph = {}
    for module, path in modules.items():
        said = read(path)
        found = {home.get(imported.removeprefix("camsim."), imported) for imported in said.imports}
        found |= {home.get(name, f"camsim.{name}") for name in said.attributes}
        found |= set(said.members)
        for line, called, _ in said.calls:
            assert called not in ("importlib.import_module", "__import__") or module == "camsim.core.doors", (
                f"{module}:{line}: {called}: what a string names cannot be followed"
            )
        graph[module] = (found & set(modules)) - {module, "camsim"}
    return graph


def graph():
    """What each module imports; a package's own ``__init__``, which gathers what lies within, is no circle."""
    return {
        module: {other for other in others if not module.startswith(other + ".")}
        for module, others in imported_modules().items()
        if module != "camsim"
    }


def circle():
    """Modules that import one another in a circle; none where imports go down only."""
    try:
        list(graphlib.TopologicalSorter(graph()).static_order())
    except graphlib.CycleError as error:
        return error.args[1]
    return []


def doors():
    """Floors that ``camsim.core.doors`` leads from and to."""
    return {
        (module_of(path).split(".")[1], place.split(".")[0])
        for path in SOURCES
        for place in re.findall(r'above\("([\w.]+)"\)', path.read_text(encoding="utf-8"))
    }


def upward():
    """Imports of a higher floor."""
    return [
        f"{module_of(path)} imports {imported}"
        for path in SOURCES
        if module_of(path) != "camsim"
        for imported in read(path).imports
        if imported.startswith("camsim.") and floor(imported) > floor(module_of(path))
    ]


if __name__ == "__main__":
    folders = [path for path in PACKAGE.iterdir() if path.is_dir() and path.name != "__pycache__"]
    print(f"modules: {len(graph())}, folders: {len(folders)}, files beside them: {len(list(PACKAGE.glob('*.py')))}")
    print(f"imports of a higher floor: {upward() or 'none'}")
    print(f"circles: {' → '.join(circle()) or 'none'}")
    print("doors:", ", ".join(f"{low} → {high}" for low, high in sorted(doors())))
