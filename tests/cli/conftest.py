from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from . import forked

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

# From where a file is about to be written on, the system takes no more than its first thousand bytes.
FULL_DISK = """\
import resource
import camsim.files.atomic as atomic
replacing = atomic.replacing
def limited(path):
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
    return replacing(path)
atomic.replacing = limited"""

Run = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The folder in which ``camsim`` is started; it holds a small scene."""
    (tmp_path / "small.yaml").write_text(SCENE, encoding="utf-8")
    return tmp_path


def run_camsim(
    folder: Path,
    *arguments: str,
    code: str = "",
    env: Mapping[str, str] | None = None,
    before: Callable[[], None] | None = None,
) -> subprocess.CompletedProcess[str]:
    """Start ``camsim`` in a process of its own, as a user does, after lines of Python that change something in it.

    before : what the process does before it becomes ``camsim``
    """
    environment = {**os.environ, **(env or {})}
    if before is None and forked.can_run(environment):
        return forked.run(arguments, folder, environment, before=code, timeout_s=600)
    start = [sys.executable, "-c", f"{code}\nfrom camsim.cli import main\nmain()"] if code else [COMMAND]
    return subprocess.run(
        [*start, *arguments],
        cwd=folder,
        env=environment,
        preexec_fn=before,
        capture_output=True,
        encoding="utf-8",
        timeout=600,
        check=False,
    )


@pytest.fixture
def camsim(folder: Path) -> Run:
    """Start ``camsim`` in the folder; a traceback is nothing that it may say."""

    def run(*arguments: str, **how: Any) -> subprocess.CompletedProcess[str]:
        done = run_camsim(folder, *arguments, **how)
        assert "Traceback" not in done.stderr, done.stderr
        return done

    return run


@pytest.fixture
def patched(folder: Path) -> Run:
    """Start ``camsim`` after a line of Python has changed something in it."""

    def run(code: str, *arguments: str) -> subprocess.CompletedProcess[str]:
        return run_camsim(folder, *arguments, code=code)

    return run
