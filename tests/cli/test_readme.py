"""The README is the manual: its commands, its YAML and its Python run as printed."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language, text=README):
    return re.findall(rf"```{language}\n(.*?)```", text, flags=re.DOTALL)


PAGES = {path.name: blocks("python", path.read_text(encoding="utf-8")) for path in sorted((ROOT / "docs").glob("*.md"))}
EXAMPLES = [(page, number) for page, examples in PAGES.items() for number in range(len(examples))]


def camsim(arguments, folder):
    return subprocess.run(
        [sys.executable, "-c", "from camsim.cli import main; main()", *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=600,
    )


def test_commands_run_one_after_another(tmp_path):
    lines = [line[2:] for block in blocks("console") for line in block.splitlines() if line.startswith("$ camsim ")]
    assert len(lines) >= 8
    for line in lines:
        ran = camsim(shlex.split(line, comments=True)[1:], tmp_path)
        assert ran.returncode == 0, f"{line}\n{ran.stderr}"
    assert (tmp_path / "noisy.dng").read_bytes() == (tmp_path / "again.dng").read_bytes()


def test_the_yaml_is_a_scene(tmp_path):
    (scene,) = blocks("yaml")
    (tmp_path / "mine.yaml").write_text(scene, encoding="utf-8")
    ran = camsim(["capture", "mine.yaml", "--set", "region={rows: 32, cols: 32}"], tmp_path)
    assert ran.returncode == 0, ran.stderr
    assert (tmp_path / "mine.dng").exists()


@pytest.mark.parametrize("number", range(len(blocks("python"))))
def test_python_examples_run(number, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(blocks("python")[number], f"README.md, example {number}", "exec"), {"__name__": "readme"})


@pytest.mark.parametrize(("page", "number"), EXAMPLES)
def test_examples_of_the_pages_run(page, number, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if page == "mtf.md":  # it measures what the commands above it have captured
        ran = camsim(["capture", "knife-edge"], tmp_path)
        assert ran.returncode == 0, ran.stderr
    # The gallery's twins lie beside their scenes.
    here = {"__name__": "page", "__file__": str(ROOT / "scenes" / "twin.py")}
    exec(compile(PAGES[page][number], f"docs/{page}, example {number}", "exec"), here)


def test_the_pages_have_examples():
    assert {page for page, _ in EXAMPLES} >= {"bench.md", "developers.md", "limits.md", "mtf.md"}


def test_files_it_links_to_are_there():
    here = Path(__file__).parents[2]
    links = re.findall(r"\]\(((?!http)[^)#]+)\)", README)
    assert links
    for link in links:
        assert (here / link).exists(), link
