"""``camsim`` in processes forked from one that has imported what its commands import, and has computed nothing.

Each is a process of its own, as a user's is, but begins two seconds of CPU time later in its life. What a command may
not import is judged elsewhere (test_first_use.py), in processes that begin at the beginning; so is the script itself.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

_PROCESSES = multiprocessing.get_context("forkserver")
_PROCESSES.set_forkserver_preload(["tests.cli.ready"])
_ROOT = Path(__file__).parents[2]

_READ_ONCE = ("PYTHON", "NUMBA_", "OMP_", "OPENBLAS_", "MPL")
"""What an interpreter and its libraries read when they begin. Of the others some are set by libraries themselves."""


def _read_once(environment: Mapping[str, str]) -> dict[str, str]:
    return {name: value for name, value in environment.items() if name.startswith(_READ_ONCE)}


_BEGAN_WITH = _read_once(os.environ)


def can_run(environment: Mapping[str, str]) -> bool:
    """Whether a process may begin with this environment though its libraries are there: they read the same."""
    return _read_once(environment) == _BEGAN_WITH


def run(
    arguments: tuple[str, ...], folder: Path, environment: Mapping[str, str], *, before: str, timeout_s: float
) -> subprocess.CompletedProcess[str]:
    """Run ``camsim`` in a folder, after a piece of Python."""
    with tempfile.TemporaryDirectory() as said:
        process = _PROCESSES.Process(target=_camsim, args=(arguments, str(folder), dict(environment), before, said))
        with contextlib.chdir(_ROOT):  # in which the first one's server finds what to import
            process.start()
        process.join(timeout_s)
        if process.exitcode is None:
            process.kill()
            raise subprocess.TimeoutExpired(list(arguments), timeout_s)
        stdout, stderr = ((Path(said) / name).read_text(encoding="utf-8") for name in ("stdout", "stderr"))
    return subprocess.CompletedProcess(["camsim", *arguments], process.exitcode, stdout, stderr)


def _camsim(arguments: tuple[str, ...], folder: str, environment: dict[str, str], before: str, said: str) -> None:
    """Be ``camsim``: its folder, its environment, its words, its standard streams."""
    for number, name in ((1, "stdout"), (2, "stderr")):
        file = os.open(os.path.join(said, name), os.O_WRONLY | os.O_CREAT)
        os.dup2(file, number)
        os.close(file)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.argv = ["camsim", *arguments]
    exec(before, {})
    from camsim.cli import main

    try:
        main()
    except Exception:  # what multiprocessing would print itself
        sys.excepthook(*sys.exc_info())
        sys.exit(1)
