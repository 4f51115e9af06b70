"""YAML as camsim reads it: 1.2 scalars, positions, and what is refused, with either of PyYAML's parsers."""

from __future__ import annotations

import json
import math
import random
from pathlib import Path
from typing import Any

import pytest
import yaml

from camsim.config import yaml_source
from camsim.config.scalars import resolve
from camsim.core.errors import ConfigError

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
    ("text", "value"),
    [
        ("1e-3", 0.001),
        ("1.0e-6", 1e-6),
        ("1E3", 1000.0),
        (".5", 0.5),
        ("5.", 5.0),
        ("+3", 3),
        ("010", 10),
        ("-07", -7),
        ("0o10", 8),
        ("0x1f", 31),
        ("1_000", "1_000"),
        ("12:30:00", "12:30:00"),
        ("2000-01-01", "2000-01-01"),
        ("no", "no"),
        ("Yes", "Yes"),
        ("on", "on"),
        ("off", "off"),
        ("y", "y"),
        ("true", True),
        ("False", False),
        ("null", None),
        ("~", None),
        ("", None),
        ("nan", "nan"),
        ("inf", "inf"),
        (".inf", math.inf),
        ("-.Inf", -math.inf),
        ("1e999", math.inf),
        ("'1e-3'", "1e-3"),
        ('"true"', "true"),
        ("|\n  12\n", "12\n"),
        ("1e", "1e"),
        ("e5", "e5"),
        (".", "."),
        ("1.2.3", "1.2.3"),
        ("0b11", "0b11"),
        ("<<", "<<"),
        ("=", "="),
    ],
)
def test_scalars_follow_yaml_1_2(text: str, value: object) -> None:
    found = parsed(f"key: {text}").tree["key"]
    assert (type(found), found) == (type(value), value)


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


FAULTS = {
    "duplicate key": ("a: 1\nb: 2\na: 3\n", ["x.yaml:3:1: a: given twice (first on line 1); keep one"]),
    "duplicate key, quoted": ("{a: 1, 'a': 2}", ["x.yaml:1:8: a: given twice (first on line 1); keep one"]),
    "anchor": (
        "a: &b 1",
        ["x.yaml:1:4: a: the anchor &b is not allowed; write the value out where it is used"],
    ),
    "alias": (
        "a: &b [1]\nc: *b\n",
        [
            "x.yaml:1:4: a: the anchor &b is not allowed; write the value out where it is used",
            "x.yaml:2:4: c: the alias *b is not allowed; write the value out",
        ],
    ),
    "tag": ("a: [!!int 3]", ["x.yaml:1:5: a.0: the tag !!int is not allowed; leave it out"]),
    "own tag": ("a: !x {}", ["x.yaml:1:4: a: the tag !x is not allowed; leave it out"]),
    "tagged key": ("!!str a: 1", ["x.yaml:1:1: a: the tag !!str is not allowed; leave it out"]),
    "list as key": ("? [a]\n: 1\nb: 2\n", ["x.yaml:1:3: a key must be a word"]),
    "two documents": (
        "a: 1\n---\nb: 2\n",
        ["x.yaml:2:1: a second document begins here; a file holds one (delete the '---')"],
    ),
    "directive": (
        "%YAML 1.1\n---\na: 1\n",
        ["x.yaml:1:1: files are read as YAML 1.2; leave the lines that begin with % out"],
    ),
    "tag directive": (
        "%TAG ! tag:x,2000:\n---\na: 1\n",
        ["x.yaml:1:1: files are read as YAML 1.2; leave the lines that begin with % out"],
    ),
    "too deep": ("a: " + "[" * 70 + "]" * 70, ["x.yaml:1:67: nested more than 64 deep"]),
    "not UTF-8": (b"a: 1\nb: caf\xe9\n", ["x.yaml:2:7: byte 0xe9 is not UTF-8; save the file as UTF-8"]),
    "UTF-16": ("a: 1".encode("utf-16"), ["x.yaml:1:1: byte 0xff is not UTF-8; save the file as UTF-8"]),
    "control character": (
        "a: 1\nb: \x07\n",
        ["x.yaml:2:4: the control character U+0007 has no place in a YAML file; delete it"],
    ),
    "escaped control character": (
        'a: "\\0"',
        ["x.yaml:1:4: a: the character U+0000 has no place here; leave it out"],
    ),
    "tab": ("a:\n\tb: 1\n", ["x.yaml:2:1: a tab in the indentation; use spaces"]),
    "tab, later": ("a:\n  b: 1\n\tc: 2\n", ["x.yaml:3:1: a tab in the indentation; use spaces"]),
    "list left open": ("a: [1, 2\nb: 3\n", ["x.yaml:1:4: a list '[' is not closed; write [a, b, c]"]),
    "table left open": (
        "a: {b: 1\n",
        ["x.yaml:1:4: a table '{' is not closed; write {key: value, key: value}"],
    ),
    "quote left open": ("a: 1\nb: 'x\nc: 2\n", ["x.yaml:2:4: the quote that opens here is never closed"]),
    "two colons": (
        "a: b: c\n",
        ["x.yaml:1:5: a second ': ' in one value; put it in quotes or mend the indentation"],
    ),
    "no colon": ("a: 1\nb\nc: 2\n", ["x.yaml:3:1: a line without ': '; write key: value"]),
    "indentation": (
        "a:\n    b: 1\n  c: 2\n",
        ["x.yaml:3:3: the indentation or a '-' does not fit the lines above; keys of one table start in one column"],
    ),
    "closing bracket too many": (
        "a: 1\nb: ]\n",
        ["x.yaml:2:4: a value or a closing bracket is missing here"],
    ),
    "stray sign": ("a: @x\n", ["x.yaml:1:4: a value cannot begin with '@'; put it in quotes"]),
    "text after the end": (
        "a: 1\n...\nb\n",
        ["x.yaml:3:1: text after the end of the document; a file holds one table"],
    ),
    "too large": (b"#" * (16 * 2**20 + 1), ["x.yaml: larger than 16 MB, the most that is read"]),
    "several at once": (
        "a: 1\na: 2\nb: !x 3\nc: [\n",
        [
            "x.yaml:2:1: a: given twice (first on line 1); keep one",
            "x.yaml:3:4: b: the tag !x is not allowed; leave it out",
            "x.yaml:5:1: a value or a closing bracket is missing here",
        ],
    ),
}


@pytest.mark.parametrize(("text", "expected"), FAULTS.values(), ids=FAULTS)
def test_what_is_refused(text: str | bytes, expected: list[str]) -> None:
    assert faults(text) == expected


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
