"""Every block of the README and of every page runs as printed, and what pages name is there."""

import re
import shlex
import subprocess
from pathlib import Path

import matplotlib
import numpy as np
import pytest
import typer
from PIL import Image

import camsim
from camsim.cli.app import app
from tests.blocks import blocks_of, run_page

ROOT = Path(__file__).parents[2]
PAGES = {
    str(path.relative_to(ROOT)): path.read_text(encoding="utf-8")
    for path in (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md")))
}
# The gallery's blocks are the shipped scenes and their twins: tests/measured/test_gallery.py takes them.
RUN = [name for name, text in PAGES.items() if blocks_of(text) and name != "docs/gallery.md"]
TARGETS = set(re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), flags=re.MULTILINE))


@pytest.fixture
def desk(tmp_path, monkeypatch):
    """A folder with what pages take for granted: a photograph, a drawing, curves."""
    monkeypatch.chdir(tmp_path)
    matplotlib.use("Agg")
    Image.fromarray(np.arange(72, dtype=np.uint8).reshape(4, 6, 3) * 3).save("photo.png")
    square = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1 1"><rect width="1" height="1"/></svg>'
    Path("drawing.svg").write_text(square, encoding="utf-8")
    np.save("cube.npy", np.full((4, 6, 3), 0.4))
    np.savez("passes.npz", image=np.full((4, 6, 3), 0.4), normals=np.zeros((4, 6, 3)))
    np.save("psf.npy", np.outer(np.hanning(9), np.hanning(9)))
    np.save("otf.npy", np.outer(np.bartlett(9), np.bartlett(9)))
    Path("darks").mkdir()
    np.save("darks/dark-1.npy", np.full((4, 6), 64, np.uint16))
    np.save("bias.npy", np.eye(4, 6))
    Path("hot.csv").write_text("row,col,e_per_s\n3,4,2000\n", encoding="utf-8")
    Path("measured").mkdir()
    Path("measured/ir-cut.csv").write_text("nm,T\n380,0\n420,0.9\n640,0.9\n700,0\n", encoding="utf-8")
    Path("qe.csv").write_text("nm,R,G,B\n380,0,0,0\n480,0.05,0.2,0.5\n600,0.5,0.2,0.02\n700,0,0,0\n", encoding="utf-8")
    return tmp_path


@pytest.mark.parametrize("page", RUN)
def test_every_block_runs(page, desk):
    run_page(PAGES[page], desk, {"__name__": "page", "camsim": camsim})
    matplotlib.pyplot.close("all") if hasattr(matplotlib, "pyplot") else None


def test_the_demo_takes_the_pictures_of_the_readme(desk):
    recipe = subprocess.run(["make", "-n", "-C", ROOT, "demo", "BIN=."], capture_output=True, text=True, check=True)
    lines = [line for line in recipe.stdout.replace("\\\n", " ").splitlines() if "camsim capture" in line]
    Path("out").mkdir()
    for line in lines:
        quick = ["--set", "region={rows: 8, cols: 8}", "--set", "render.tolerance=1e-2"]
        assert not app([*shlex.split(line)[1:], *quick], standalone_mode=False)
    made = {f"docs/demo-{path.name}" for path in Path("out").glob("*.png")}
    assert len(made) == 3
    assert made <= set(re.findall(r"\]\(([^)]+)\)", PAGES["README.md"]))


def test_the_gallery_shows_the_shipped_files():
    page = PAGES["docs/gallery.md"]
    twins = {path.stem for path in (ROOT / "scenes").glob("*.py")}
    files = [path.read_text(encoding="utf-8") for path in (ROOT / "scenes").glob("*.yaml")]
    assert set(re.findall(r"^```\{literalinclude\} \.\./scenes/(\S+)\.py$", page, flags=re.MULTILINE)) == twins
    for block in blocks_of(page):
        assert block.language == "yaml"
        assert any(block.body.strip() in text for text in files)


@pytest.mark.parametrize("page", list(PAGES))
def test_what_a_page_names_is_there(page):
    """Links lead to files; scripts, make targets and commands in the text exist; blocks that run elsewhere do."""
    text, folder = PAGES[page], (ROOT / page).parent
    for link in re.findall(r"\]\(((?!http)[^)#\s]+)\)", text):
        assert (folder / link).exists() or (ROOT / link).exists(), link
    words = [block.elsewhere for block in blocks_of(text) if block.elsewhere]
    printed = [block.body.replace("\\\n", " ") for block in blocks_of(text) if block.language in ("", "sh")]
    words += [line.strip() for body in printed for line in body.splitlines()]
    words += re.findall(r"`([^`\n]+)`", re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL))
    for said in words:
        for target in re.findall(r"^make ([\w-]+)", said):
            assert target in TARGETS, said
        for module in re.findall(r"^python -m (bench\.[\w.]+)", said):
            assert list(ROOT.glob(module.replace(".", "/") + "*")), said
        for file in re.findall(
            r"^(?:python |pytest )?((?:camsim|tests|bench|docs|scenes|sensors)/[\w/.-]+\.(?:py|md|yaml|jsonl))", said
        ):
            assert (ROOT / file).exists() or "NAME" in file, said
        if said.startswith("camsim ") and "…" not in said:
            _assert_a_command(said)


def _assert_a_command(said):
    """Its command and its options are those of the program."""
    command = typer.main.get_command(app)
    words = shlex.split(said, comments=True)[1:]
    while words and words[0] in getattr(command, "commands", {}):
        command = command.commands[words.pop(0)]
    known = {name for option in command.params for name in option.opts} | {"--help"}
    assert not hasattr(command, "commands") or not words or words[0].isupper() or words[0] in known, said
    for word in words:
        assert not word.startswith("-") or word == "-" or word in known, said
