"""``camsim`` in processes forked from one that has imported what its commands import, and has computed nothing.

Each is a process of its own, as a user's is, but begins a second of CPU time later in its life. What a command may not
import is judged elsewhere (test_first_use.py), in processes that begin at the beginning; so is the script itself.
"""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

IMPORTED = ["camsim.cli.take", "camsim.capturing", "camsim.measure", "scipy.special", "matplotlib.figure"]
"""Not ``camsim.cli.app``, which notes when it began."""

_PROCESSES = multiprocessing.get_context("forkserver")
_PROCESSES.set_forkserver_preload(IMPORTED)


def _of_all_tests(environment: Mapping[str, str]) -> dict[str, str]:
    return {name: value for name, value in environment.items() if not name.startswith("PYTEST_")}


_ENVIRONMENT = _of_all_tests(os.environ)


def can_run(environment: Mapping[str, str]) -> bool:
    """Whether a process would begin with this environment: the tests' own, as it was when they began."""
    return _of_all_tests(environment) == _ENVIRONMENT


def run(arguments: tuple[str, ...], folder: Path, *, timeout_s: float) -> subprocess.CompletedProcess[str]:
    """Run ``camsim`` in a folder."""
    with tempfile.TemporaryDirectory() as said:
        process = _PROCESSES.Process(target=_camsim, args=(arguments, str(folder), said))
        process.start()
        process.join(timeout_s)
        if process.exitcode is None:
            process.kill()
            raise subprocess.TimeoutExpired(list(arguments), timeout_s)
        stdout, stderr = ((Path(said) / name).read_text(encoding="utf-8") for name in ("stdout", "stderr"))
    return subprocess.CompletedProcess(["camsim", *arguments], process.exitcode, stdout, stderr)


def _camsim(arguments: tuple[str, ...], folder: str, said: str) -> None:
    """Be ``camsim``: its folder, its words, its standard streams."""
    for number, name in ((1, "stdout"), (2, "stderr")):
        file = os.open(os.path.join(said, name), os.O_WRONLY | os.O_CREAT)
        os.dup2(file, number)
        os.close(file)
    os.chdir(folder)
    sys.argv = ["camsim", *arguments]
    from camsim.cli import main

    main()
