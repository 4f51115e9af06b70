"""The schema as others see it: JSON Schema that judges the shipped files, and a page that is up to date."""

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml

from camsim.config import library
from camsim.config.reference import FILES, _tables, examples, json_schema, markdown
from camsim.config.yaml_source import read


@pytest.mark.parametrize("kind", FILES)
def test_the_schema_is_one_and_takes_every_shipped_file(kind: Any) -> None:
    schema = json_schema(kind)
    jsonschema.Draft202012Validator.check_schema(schema)
    judge = jsonschema.Draft202012Validator(schema)
    for name, path in (library.shipped(kind) if kind in library.FOLDERS else {}).items():
        assert [error.message for error in judge.iter_errors(read(path, name).tree)] == [], name


def test_the_schema_refuses_what_camsim_refuses() -> None:
    judge = jsonschema.Draft202012Validator(json_schema("sensor"))
    tree = yaml.safe_load(library.shipped("sensor")["d40-like"].read_text(encoding="utf-8"))
    for path, wrong in (
        (("readout", "bit_depth"), 17),
        (("readout", "read_noise_dn"), 3.0),
        (("cfa", "pattern"), "GGRB"),
        (("charge", "prnu"), 60),
        (("quantum_efficiency", "peak"), 42),
    ):
        broken = json.loads(json.dumps(tree))
        broken[path[0]][path[1]] = wrong
        assert list(judge.iter_errors(broken)), path
    assert not list(judge.iter_errors(tree))


def test_every_key_says_what_it_means() -> None:
    for kind in FILES:
        for name, table in json_schema(kind).get("$defs", {}).items():  # type: ignore[arg-type]
            assert table["description"], name
            for key, said in table.get("properties", {}).items():
                assert said.get("description"), (name, key)


def test_every_key_has_an_example() -> None:
    """The page shows them below their tables, and the tests of the pages let camsim judge each."""
    keys = {
        (table.__name__, key)
        for model in FILES.values()
        for _, table in _tables(model, "")
        for key in table.model_fields
        if key != "source"
    }
    displayed = {
        (name, key)
        for name, parts in examples().items()
        for part in parts
        for key in keys_in(yaml.safe_load(part))
        if (name, key) in keys
    }
    assert keys - displayed == set()
    assert {name for name, _ in keys} == set(examples())


def keys_in(tree: Any) -> set[str]:
    """All keys at any depth."""
    if isinstance(tree, list):
        return set().union(*map(keys_in, tree))
    return set(tree) | keys_in(list(tree.values())) if isinstance(tree, dict) else set()


def test_the_reference_is_up_to_date() -> None:
    page = Path(__file__).parents[2] / "docs" / "yaml-reference.md"
    assert page.read_text(encoding="utf-8") == markdown(), (
        "run: python -m camsim.config.reference > docs/yaml-reference.md"
    )
