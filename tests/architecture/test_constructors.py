"""What classes tell type checkers about their constructors follows from their fields."""

import ast
import inspect
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from bench.constructors import PACKAGE, constructor, files, names_of, taken_for, validating, written
from camsim.sensor.electronics import ElectronicChanges


def classes() -> Iterator[tuple[type, str, str]]:
    """Yield each class with what it tells and what it should."""
    for path in files():
        names = names_of(path)
        for node in validating(ast.parse(path.read_text(encoding="utf-8"))):
            stated = written(node)
            told = "" if stated is None else ast.unparse(stated)
            yield names[node.name], told, ast.unparse(constructor(node, names))


CLASSES = list(classes())


def test_constructors_take_what_the_fields_keep() -> None:
    wrong = [made for made, stated, wanted in CLASSES if stated != wanted]
    assert wrong == [], "python -m bench.constructors writes them"
    assert len(CLASSES) > 60


@pytest.mark.parametrize(("made", "stated"), [(made, stated) for made, stated, _ in CLASSES])
def test_what_is_told_is_what_runs(made: type, stated: str) -> None:
    """The electronic stages of a camera are told as those that ``replace`` exchanges."""
    apart = ElectronicChanges.__annotations__ if "**electronics" in stated else ()
    runs = [p for p in inspect.signature(made).parameters.values() if p.name not in apart]
    assert list(parameters(stated)) == [(p.name, p.kind is p.KEYWORD_ONLY, p.default is not p.empty) for p in runs]


def test_type_checkers_see_numpys_numbers_in_each_type() -> None:
    """tests/typing/right.py has an argument of every type that takes numbers, given NumPy's."""
    text = (Path(__file__).parents[1] / "typing" / "right.py").read_text(encoding="utf-8").partition("# NumPy's")[2]
    calls = [node for node in ast.walk(ast.parse(f"#{text}")) if isinstance(node, ast.Call)]
    given = {(ast.unparse(call.func).removeprefix("camsim."), key.arg) for call in calls for key in call.keywords}
    taking: dict[str, set[tuple[str, str | None]]] = {}
    for made, stated, _ in CLASSES:
        for node in ast.walk(ast.parse(stated)):
            if isinstance(node, ast.arg) and node.annotation:
                taking.setdefault(ast.unparse(node.annotation), set()).add((made.__name__, node.arg))
    numbers = {kind for kind in taking if re.search(r"Number|Whole|Truth|Place|Segments", kind)}
    assert {kind for kind in numbers if not taking[kind] & given} == set()
    assert len(numbers) > 20


def parameters(block: str) -> Iterator[tuple[str, bool, bool]]:
    """Yield (name, by keyword only, has a default) of the function in a block."""
    said = next(node for node in ast.walk(ast.parse(block)) if isinstance(node, ast.FunctionDef)).args
    for index, argument in enumerate(said.args[1:], 1):
        yield argument.arg, False, index >= len(said.args) - len(said.defaults)
    for argument, default in zip(said.kwonlyargs, said.kw_defaults, strict=True):
        yield argument.arg, True, default is not None


@pytest.mark.parametrize(
    ("file", "stages", "changes"),
    [("camera/body.py", "Body", "Changes"), ("sensor/electronics.py", "Electronics", "ElectronicChanges")],
)
def test_a_camera_exchanges_what_its_fields_keep(file: str, stages: str, changes: str) -> None:
    kept, exchanged = (annotations(file, name) for name in (stages, changes))
    names = names_of(PACKAGE / file)
    assert {name: ast.unparse(kind) for name, kind in exchanged.items()} == {
        name: taken_for(kind, names) for name, kind in kept.items()
    }


def annotations(file: str, name: str) -> dict[str, ast.expr]:
    """Return the annotated names of a class."""
    tree = ast.parse((PACKAGE / file).read_text(encoding="utf-8"))
    node = next(node for node in tree.body if isinstance(node, ast.ClassDef) and node.name == name)
    return {ast.unparse(part.target): part.annotation for part in node.body if isinstance(part, ast.AnnAssign)}
