"""An error says by its arguments what it is about, and nobody reads that out of its sentence."""

import ast
import re
from pathlib import Path

import pytest

import camsim
from camsim.errors import CamsimError, UnknownNameError

SOURCES = sorted(Path(camsim.__file__).parent.rglob("*.py"))
PLACED = {"InvalidValueError", "UnsupportedError"}
PLACELESS = {
    "spectra/curve.py",  # of a parameter's value: ``judge`` says which parameter
    *("scene/svg/colours.py", "scene/svg/outline.py", "scene/svg/view.py"),  # of an element, whose line is told with it
    "config/build_optics.py",  # of a file's contents, built at the key that names the file
    "measure/reading.py",  # of a file's contents, told with its name by who opened it
    "bench/diagram.py",  # of the whole command
    "rendering/boundary/engine.py",  # what the optics refused, told again
    "rendering/paper/engine.py",
}


def raised(path: Path) -> list[ast.Call]:
    """Return the errors of camsim's own that a file raises, as calls."""
    calls = [node.exc for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Raise)]
    named = [call for call in calls if isinstance(call, ast.Call) and isinstance(call.func, ast.Name)]
    return [call for call in named if call.args and getattr(call.func, "id", "") in PLACED]


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.name)
def test_every_refusal_names_its_parameter_or_its_stage(path: Path) -> None:
    for call in raised(path):
        place = {keyword.arg for keyword in call.keywords}
        if path.relative_to(SOURCES[0].parent).as_posix() not in PLACELESS:
            assert place & {"key", "stage"}, f"{path}:{call.lineno}: {ast.unparse(call)}"
        begins = call.args[0].values[0] if isinstance(call.args[0], ast.JoinedStr) else call.args[0]
        if isinstance(begins, ast.Constant):
            assert not re.match(r"[a-z_]+: ", begins.value), f"{path}:{call.lineno}: the place stands in the sentence"


def test_the_sentence_is_composed_in_one_form() -> None:
    assert str(CamsimError("17; must be 1..16", key="bit_depth", stage="Adc")) == "Adc.bit_depth: 17; must be 1..16"
    assert str(CamsimError("is missing", key="lens")) == "lens: is missing"
    assert str(CamsimError("it is cut short", stage="a.dng")) == "a.dng: it is cut short"
    error = UnknownNameError("illuminant", "D56", ["D55", "D65", "A"], key="spectrum", stage="Light")
    assert (error.key, error.stage, error.near[0]) == ("spectrum", "Light", "D55")
    assert str(error).startswith("Light.spectrum: unknown illuminant 'D56'; did you mean 'D55'")
