"""The size of doors: what a kernel is given, how far an argument is carried unread."""

import ast
import textwrap
from collections import Counter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / "camsim"
MOST_GIVEN, MOST_CALLS = 10, 4


def name_of(path):
    return path.relative_to(PACKAGE.parent).as_posix()


def parameters(function):
    given = function.args
    return [a.arg for a in (*given.posonlyargs, *given.args, *given.kwonlyargs)]


def kernels(tree):
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and any("kernel" in ast.unparse(d) for d in node.decorator_list):
            yield node


def test_no_kernel_is_given_much():
    found = {
        f"{name_of(path)}: {node.name}": len(parameters(node))
        for path in sorted(PACKAGE.rglob("*.py"))
        for node in kernels(ast.parse(path.read_text(encoding="utf-8")))
    }
    assert len(found) > 40
    assert {name: count for name, count in found.items() if count > MOST_GIVEN} == {}


class Functions:
    """Functions of some modules by (module, name), methods as Class.name, and whom each hands its parameters on to."""

    def __init__(self, sources):
        self.found, self.home = {}, {}
        for module, text in sources.items():
            tree = ast.parse(text)
            self.home[module] = {
                alias.asname or alias.name: (node.module, alias.name)
                for node in ast.walk(tree)
                if isinstance(node, ast.ImportFrom)
                for alias in node.names
            }
            for node in tree.body:
                if isinstance(node, ast.FunctionDef):
                    self.found[module, node.name] = node
                if isinstance(node, ast.ClassDef):
                    for inner in node.body:
                        if isinstance(inner, ast.FunctionDef):
                            self.found[module, f"{node.name}.{inner.name}"] = inner
        within = {key: list(ast.walk(node)) for key, node in self.found.items()}
        self.calls = {key: [node for node in nodes if isinstance(node, ast.Call)] for key, nodes in within.items()}
        self.uses = {
            key: Counter(node.id for node in nodes if isinstance(node, ast.Name)) for key, nodes in within.items()
        }

    def called(self, key, call):
        """The function that a call is of, None for one that is not among these."""
        module, name = key
        if isinstance(call.func, ast.Name):
            here = (module, call.func.id)
            there = self.home[module].get(call.func.id)
            return here if here in self.found else there if there in self.found else None
        if isinstance(call.func, ast.Attribute) and isinstance(call.func.value, ast.Name) and "." in name:
            method = (module, f"{name.split('.')[0]}.{call.func.attr}")
            return method if call.func.value.id in ("self", "cls") and method in self.found else None
        return None

    def handed_on(self, key, parameter):
        """Where a parameter goes that is used for nothing but to be handed on: (function, parameter), else None."""
        targets, counted = set(), 0
        for call in self.calls[key]:
            other = self.called(key, call)
            for place, value in [*enumerate(call.args), *((k.arg, k.value) for k in call.keywords)]:
                if not (isinstance(value, ast.Name) and value.id == parameter):
                    continue
                if other is None:
                    return None
                names = parameters(self.found[other])
                names = names[1:] if names[:1] in (["self"], ["cls"]) else names
                if isinstance(place, int) and place >= len(names):
                    return None
                targets.add((other, names[place] if isinstance(place, int) else place))
                counted += 1
        return targets.pop() if counted == self.uses[key][parameter] and len(targets) == 1 else None

    def carried(self, key, parameter):
        """The road of a parameter: this function and all that it is handed on to."""
        road = [(key, parameter)]
        while (following := self.handed_on(*road[-1])) and following not in road:
            road.append(following)
        return road

    def longest(self):
        """All roads of more than so many calls."""
        for key, node in self.found.items():
            for parameter in parameters(node):
                road = self.carried(key, parameter)
                if len(road) - 1 > MOST_CALLS:
                    yield " → ".join(f"{name}({what})" for (_, name), what in road)


def test_no_argument_is_carried_far_unread():
    sources = {name_of(p)[:-3].replace("/", "."): p.read_text(encoding="utf-8") for p in sorted(PACKAGE.rglob("*.py"))}
    functions = Functions(sources)
    assert len(functions.found) > 700
    assert list(functions.longest()) == []


CARRIED = """
def a(x, y):
    return b(x, y=y)
def b(x, y):
    return c(y, x) + y
def c(y, x):
    return d(x)
def d(x):
    return e(x)
def e(x):
    return f(x)
def f(x):
    return x + 1
"""


@pytest.mark.parametrize(("read_in", "far"), [("f", True), ("c", False)])
def test_the_script_sees_what_is_carried(read_in, far):
    text = CARRIED if read_in == "f" else CARRIED.replace("return d(x)", "return d(x) * x")
    found = list(Functions({"m": textwrap.dedent(text)}).longest())
    assert found == (["a(x) → b(x) → c(x) → d(x) → e(x) → f(x)"] if far else [])
