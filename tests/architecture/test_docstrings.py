"""Every public name says what it is: its parameters with their units, shapes of arrays, and an example that runs."""

import inspect
import re
from dataclasses import fields
from pathlib import Path

import pytest

import camsim
from bench.reference import PAGES, written
from camsim.sensor.electronics import Electronics

UNIT = re.compile(r"_(um|mm|nm|um2|deg|s|e|c|dn|lux|k|iso|m2|waves|per_\w+|photosite)$")
# What a name says by itself wherever it stands.
PLAIN = {
    *("reflectance", "dark", "light", "low", "high", "transmission"),
    *("rows", "cols", "seed", "path", "name", "shapes"),
}


def public():
    """Yield every public name with what it names."""
    for prefix in ("", "charts.", "measure.", "bench."):
        module = getattr(camsim, prefix[:-1]) if prefix else camsim
        for name in sorted(getattr(module, "__all__", None) or dir(module)):
            value = getattr(module, name)
            if not name.startswith("_") and callable(value) and name not in ("meanings", "parameters"):
                yield prefix + name, value


PUBLIC = {
    name: value
    for name, value in public()
    if name not in ("charts.Chart", "charts.meanings", "charts.parameters")  # camsim.Chart; what reads charts' own
}
# Results that a function of their module gives: that function's example shows them.
RESULTS = {name for name, value in PUBLIC.items() if "." in name and inspect.isclass(value)}
# Made by a capture or a rendering and by nobody else.
MADE = {"Frame", "Report", "Rendering"}


@pytest.mark.parametrize("name", list(PUBLIC))
def test_it_says_what_it_is(name):
    value = PUBLIC[name]
    said = inspect.getdoc(value) or ""
    assert len(said) > 10, "no docstring"
    if name not in RESULTS:
        assert ">>>" in said, "no example"
    if name in RESULTS | MADE or (inspect.isclass(value) and not hasattr(value, "__dataclass_fields__")):
        return
    # What it shares with another is told there.
    for other in re.findall(r"(?:as of|see) ``(\w+)``", said):
        said += inspect.getdoc(getattr(camsim, other, None)) or ""
    stages = (
        {field.name for field in fields(Electronics)} if name in ("Camera", "Sensor") else set()
    )  # told by their classes
    for parameter in inspect.signature(value).parameters.keys() - stages:
        plain = parameter in PLAIN or UNIT.search(parameter) or parameter.startswith("_")
        assert plain or re.search(rf"\b{parameter}\b", said), f"nothing is said of {parameter}"


@pytest.mark.parametrize("name", [name for name, value in PUBLIC.items() if inspect.isclass(value)])
def test_its_methods_say_what_they_give(name):
    for key, member in vars(PUBLIC[name]).items():
        function = member.__func__ if isinstance(member, classmethod | staticmethod) else member
        function = function.fget if isinstance(function, property) else function
        if key.startswith("_") or not inspect.isfunction(function):
            continue
        said = inspect.getdoc(getattr(PUBLIC[name], key)) or ""
        assert said, f"{key}: no docstring"


def test_there_is_a_place_for_every_name_in_the_reference():
    pages = (Path(__file__).parents[2] / "docs" / "reference").glob("*.md")
    text = "".join(page.read_text(encoding="utf-8") for page in pages)
    listed = re.findall(r"^\.\. auto\w+:: camsim\.([\w.]+)$", text, flags=re.MULTILINE)
    assert sorted(listed) == sorted(PUBLIC)


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_pages_of_the_reference_have_each_name_with_its_first_sentence(page):
    """Also where nothing but the repository is seen; ``index.md`` is a table by itself."""
    text = page.read_text(encoding="utf-8")
    assert ("<!-- names -->" in text) != (page.stem == "index")
    assert text == written(text), "run: python -m bench.reference"
