"""YAML as camsim reads it: 1.2 scalars, positions, and what is refused, with either of PyYAML's parsers."""

import json
import math
import random
from pathlib import Path
from typing import Any

import pytest
import yaml

from camsim.config import yaml_source
from camsim.config.scalars import resolve
from camsim.errors import ConfigError
from tests.tables import rows

WORDS = "no Yes on off y nan inf 1_000 12:30:00 2000-01-01 1e e5 . 1.2.3 0b11 << ="  # to YAML 1.1 most are more
PARSERS = [loader for loader in ("CSafeLoader", "SafeLoader") if hasattr(yaml, loader)]


@pytest.fixture(autouse=True, params=PARSERS)
def parser(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(yaml_source, "_LOADER", getattr(yaml, request.param))


def parsed(text: str | bytes) -> Any:
    data = text.encode() if isinstance(text, str) else text
    return yaml_source.parse(data, "x.yaml", Path())


def faults(text: str | bytes) -> list[str]:
    try:
        return [str(fault) for fault in parsed(text).faults]
    except ConfigError as error:
        return str(error).splitlines()


@pytest.mark.parametrize(
    ("text", "value"), [*rows("scalars.txt", "scalars"), *((word, repr(word)) for word in WORDS.split())]
)
def test_scalars_follow_yaml_1_2(text: str, value: str) -> None:
    found = parsed("key: " + text.replace("\\n", "\n")).tree["key"]
    assert repr(found) == value


def test_nan_is_a_number() -> None:
    assert math.isnan(parsed("key: .nan").tree["key"])


def test_what_python_writes_for_a_number_is_read_back_exactly() -> None:
    rng = random.Random(3)
    for _ in range(2000):
        number = rng.choice([1, -1]) * 10 ** rng.uniform(-300, 300)
        assert resolve(repr(number)) == number
        # Between the file and the schema the tree is JSON.
        assert json.loads(json.dumps({"x": resolve(repr(number))})) == {"x": number}


def test_positions_are_lines_and_columns_from_one() -> None:
    document = parsed("# é\r\na:\n  'b': [1, {c: µ, d: 2}]\n  e:\n    - 7\n")
    for path, named, value in [
        (("a",), (2, 1), (3, 3)),
        (("a", "b"), (3, 3), (3, 8)),
        (("a", "b", 0), (3, 9), (3, 9)),
        (("a", "b", 1, "c"), (3, 13), (3, 16)),
        (("a", "b", 1, "d"), (3, 19), (3, 22)),
        (("a", "e", 0), (5, 7), (5, 7)),
    ]:
        node = document.find(path)
        assert (node.named.line, node.named.column) == named, path
        assert (node.place.line, node.place.column) == value, path
    # What is missing is named at the key of what should hold it.
    fault = document.fault(("a", "b", 1, "x", "y"), "missing")
    assert str(fault) == "x.yaml:3:12: a.b.1.x.y: missing"


def test_a_byte_order_mark_is_no_character() -> None:
    document = parsed("\ufeffa: 1")
    assert document.tree == {"a": 1}
    assert document.find(("a",)).named.column == 1


NO_TEXT = [
    [b"a: 1\nb: caf\xe9\n", "x.yaml:2:7: byte 0xe9 is not UTF-8; save the file as UTF-8"],
    ["a: 1".encode("utf-16"), "x.yaml:1:1: byte 0xff is not UTF-8; save the file as UTF-8"],
    [b"#" * (16 * 2**20 + 1), "x.yaml: larger than 16 MB, the most that is read"],
]


@pytest.mark.parametrize("case", [*rows("wrong-files.txt", "YAML"), *NO_TEXT], ids=lambda case: case[1][:40])
def test_what_is_refused(case: list[Any]) -> None:
    text, *expected = case
    assert faults(text.encode().decode("unicode_escape") if isinstance(text, str) else text) == expected


def test_yaml_1_2_may_say_so() -> None:
    assert parsed("%YAML 1.2\n---\na: 010\n").tree == {"a": 10}


def test_a_bomb_of_brackets() -> None:
    """Some versions of libyaml look ahead, and give up at the thousandth."""
    (fault,) = faults("[" * 200_000)
    assert fault in ("x.yaml:1:65: nested more than 64 deep", "x.yaml:1:1001: nested more than 64 deep")


@pytest.mark.parametrize("depth", [63, 64])
def test_the_deepest_that_is_read(depth: int) -> None:
    assert faults("[" * depth + "]" * depth) == []


def test_any_bytes_give_a_tree_or_a_fault() -> None:
    """Whatever a file holds, the answer is a document or a ConfigError, never another exception."""
    rng = random.Random(7)
    good = "camsim: scene/1\na: [1, {b: 'x', c: \"y\"}]\nd: |\n  text\ne: >-\n  more\n- &x *x !t ? : %\t#"
    for _ in range(1500):
        data = bytearray(good.encode())
        for _ in range(rng.randint(1, 6)):
            at = rng.randrange(len(data))
            data[at : at + rng.randint(0, 3)] = rng.randbytes(rng.randint(0, 3))
        faults(bytes(data))


def test_missing_and_unreadable_files(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"^gone\.yaml: no such file$"):
        yaml_source.read(tmp_path / "gone.yaml", "gone.yaml")
    with pytest.raises(ConfigError, match=r"^here: cannot be read: is a directory$"):
        yaml_source.read(tmp_path, "here")
