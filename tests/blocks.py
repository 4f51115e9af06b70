"""The blocks of a page, run as a reader runs them: from its top to its end, in one folder.

A comment before a block says what the tests do otherwise: ``<!-- tests: add OPTIONS -->`` ends each of its commands, to
keep it short; ``<!-- tests: elsewhere PLACE -->`` names the test or the make target that runs it. A block that begins
with a comment such as ``# study.yaml`` is that file.
"""

from __future__ import annotations

import json
import re
import runpy
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from camsim.cli.app import app
from camsim.config.schema import SceneFile, SensorFile

_BLOCK = re.compile(
    r"^(?:<!-- tests: (?P<note>[^\n]*) -->\n)?```(?P<language>[^\n]*)\n(?P<body>.*?)^```$", re.MULTILINE | re.DOTALL
)
_NAMED = re.compile(r"# (?P<name>[\w-]+\.(?:yaml|csv|py))\n")
_NOT_RUN = ("", "text", "eval-rst")  # what a program prints, what the site is built of
_DIRECTIVE = re.compile(r"\{[\w-]+\}.*")


@dataclass(frozen=True)
class Block:
    """One block: its language, its text, and what the comment before it says to the tests."""

    language: str
    body: str
    note: str

    @property
    def elsewhere(self) -> str:
        """Where it runs, if not with its page."""
        return self.note.removeprefix("elsewhere ").split(",")[0] if self.note.startswith("elsewhere ") else ""

    @property
    def added(self) -> list[str]:
        """What each of its commands gets besides."""
        return shlex.split(self.note.removeprefix("add ")) if self.note.startswith("add ") else []

    @property
    def file(self) -> str:
        """The file that it is, if it says so."""
        named = _NAMED.match(self.body)
        return named["name"] if named else ""


def blocks_of(text: str) -> list[Block]:
    """Return the blocks of a page, in their order; what the site itself is built of is none."""
    found = (Block(match["language"], match["body"], match["note"] or "") for match in _BLOCK.finditer(text))
    return [block for block in found if not _DIRECTIVE.fullmatch(block.language)]


def run_page(text: str, folder: Path, here: dict[str, Any]) -> None:
    """Run every block of a page in a folder, in which the process must already be; names live on down the page."""
    for number, block in enumerate(blocks_of(text)):
        if block.elsewhere:
            continue
        if block.file:
            (folder / block.file).write_text(block.body, encoding="utf-8")
        if block.language == "python":
            if not block.file:
                exec(compile(block.body, f"block {number}", "exec", dont_inherit=True), here)
        elif block.language == "yaml":
            _validate(block, folder)
        elif block.language == "console":
            for line in commands(block):
                _run(line, block.added)
        else:
            assert block.language in _NOT_RUN, f"block {number}: nothing runs {block.language!r}"


def commands(block: Block) -> Iterator[list[str]]:
    """Yield the words of each command of a block."""
    for line in block.body.splitlines():
        assert line.startswith("$ "), f"not a command: {line}"
        yield shlex.split(line[2:], comments=True)


def _run(words: list[str], added: list[str]) -> None:
    program, *arguments = words
    if program == "python":
        runpy.run_path(arguments[0], run_name="__main__")
        return
    assert program == "camsim", f"nothing runs {program}: say where it runs (tests: elsewhere …)"
    assert not app([*arguments, *added], prog_name="camsim", standalone_mode=False), " ".join(words)


def _validate(block: Block, folder: Path) -> None:
    """Let camsim judge a file, or a part of one in a file that is otherwise good."""
    tree = yaml.safe_load(block.body)
    name = block.file or "part.yaml"
    if "camsim" not in tree:
        (folder / name).write_text(json.dumps(_whole(tree)), encoding="utf-8")
    elif not block.file:
        (folder / name).write_text(block.body, encoding="utf-8")
    _run(["camsim", "validate", name], [])


def _whole(tree: dict[str, Any]) -> dict[str, Any]:
    if tree.get("lens") == "none":
        return {"camsim": "scene/1", "sensor": "d40-like", **tree}
    if "shapes" in tree:
        tree = {"scene": {"unit": "pixel", "background": {"reflectance": 0.5}, **tree}}
    if tree.keys() <= SceneFile.model_fields.keys():
        return SCENE | tree
    assert tree.keys() <= SensorFile.model_fields.keys(), f"a part of no file: {', '.join(tree)}"
    return SENSOR | tree


SCENE = {
    "camsim": "scene/1",
    "sensor": "d40-like",
    "lens": {"kind": "airy", "f_number": 8},
    "light": {"illuminant": "D55", "illuminance_lux": 5000},
    "exposure": {"time_s": 0.01, "iso": 200},
    "region": {"rows": 8, "cols": 8},
    "scene": {"unit": "pixel", "background": {"reflectance": 0.5}},
}
SENSOR = {
    "camsim": "sensor/1",
    "name": "one of the tests",
    "serial": 1,
    "frame": {"rows": 64, "cols": 64, "pitch_um": 4},
    "photosite": {"kind": "square", "fill_factor": 1},
    "cfa": {"kind": "bayer", "pattern": "RGGB"},
    "quantum_efficiency": {"curves": "Nikon 5100 (NPL)", "per": "energy", "peak": 0.5},
    "charge": {"full_well_e": 10000},
    "readout": {
        "bit_depth": 12, "black_level_dn": 64, "base_iso": 100, "electrons_per_dn": 2.5, "read_noise_e": 2
    },
}  # fmt: skip
