import contextlib
import gc
import io
import resource
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from camsim import files
from camsim.cli.app import run
from camsim.files import atomic

COMMAND = str(Path(sys.executable).parent / "camsim")

# Small and quick: twenty photosites of a shipped camera.
SCENE = """\
camsim: scene/1
sensor: d40-like
lens: {kind: airy, f_number: 8}
light: {line_nm: 550, illuminance_lux: 5000}
exposure: {time_s: 0.01, iso: 200}
region: {rows: 16, cols: 20}
scene:
  unit: pixel
  background: {reflectance: 0.9}
  shapes:
    - {kind: rectangle, width: 6, height: 8, rotate_deg: 4, reflectance: 0.05}
render: {tolerance: 1e-4}
noise: {enabled: true, seed: 1}
"""

Run = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The folder in which ``camsim`` is started; it holds a small scene."""
    (tmp_path / "small.yaml").write_text(SCENE, encoding="utf-8")
    return tmp_path


def run_camsim(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run ``camsim`` in a folder as a process of its own would: its words, its streams, its exit code."""
    said, told, code = io.StringIO(), io.StringIO(), 0
    with (
        pytest.MonkeyPatch.context() as patch,
        contextlib.chdir(folder),
        contextlib.redirect_stdout(said),
        contextlib.redirect_stderr(told),
    ):
        patch.setattr(sys, "argv", ["camsim", *arguments])
        patch.setattr(sys.modules["__main__"], "__package__", None)  # by which the program would be pytest
        patch.setattr(sys, "excepthook", sys.__excepthook__)  # typer sets its own
        for name in ("disable", "freeze"):  # this process goes on, with garbage to look for
            patch.setattr(gc, name, lambda: None)
        try:
            run()
        except SystemExit as ended:
            code = int(ended.code or 0)
        except Exception:
            sys.excepthook(*sys.exc_info())
            code = 1
    return subprocess.CompletedProcess(["camsim", *arguments], code, said.getvalue(), told.getvalue())


@contextlib.contextmanager
def full_disk() -> Iterator[None]:
    """From where a file is about to be written on, the system takes no more than its first thousand bytes."""
    replacing, limits = atomic.replacing, resource.getrlimit(resource.RLIMIT_FSIZE)

    def limited(path: Path) -> Any:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limits[1]))
        return replacing(path)

    try:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(atomic, "replacing", limited)
            patch.setattr(files, "replacing", limited)
            yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)


@pytest.fixture
def camsim(folder: Path) -> Run:
    """Run ``camsim`` in the folder; a traceback is nothing that it may say."""

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        done = run_camsim(folder, *arguments)
        assert "Traceback" not in done.stderr, done.stderr
        return done

    return run
