"""Processes of their own: for a number of threads, for memory, for programs that would change ours.

A worker runs one function at a time and answers through a pipe. It ignores Ctrl-C, so that the bench itself can end in
order, and it can die (a peer that wants more memory than there is) without taking the bench along.
"""

from __future__ import annotations

import contextlib
import multiprocessing as mp
import os
import signal
from collections.abc import Callable, Iterator, Mapping
from multiprocessing.connection import Connection
from typing import Any, Self, TypeVar

T = TypeVar("T")
THREADS = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
# Freed memory goes back at once, so that each rendering's own peak can be told from what stayed of the last one.
GIVES_BACK = {"MALLOC_MMAP_THRESHOLD_": "65536", "MALLOC_TRIM_THRESHOLD_": "65536"}


class WorkerError(RuntimeError):
    """What was asked of a worker failed there, or the worker died."""


class Worker:
    """One process, started when first asked."""

    def __init__(self, *, threads: int, environment: Mapping[str, str] | None = None) -> None:
        self._environment = dict.fromkeys(THREADS, str(threads)) | dict(environment or {})
        self._process: mp.process.BaseProcess | None = None
        self._pipe: Connection | None = None

    def __enter__(self) -> Self:
        """Return it, to be stopped at the end."""
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def call(self, function: Callable[..., T], *arguments: Any) -> T:
        """Run a module's function there and return what it returns."""
        if self._process is None or self._pipe is None:
            self._start()
        assert self._process is not None
        assert self._pipe is not None
        try:
            self._pipe.send((function, arguments))
            good, answer = self._pipe.recv()
        except (EOFError, OSError) as error:
            self._process.join()
            code = self._process.exitcode
            self.stop()
            raise WorkerError(f"the process ended with {code}") from error
        if not good:
            raise WorkerError(answer)
        result: T = answer
        return result

    def stop(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.terminate()
            self._process.join()
        if self._pipe is not None:
            self._pipe.close()
        self._process = self._pipe = None

    def _start(self) -> None:
        context = mp.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs,), daemon=True)
        with _environment(self._environment):
            self._process.start()
        theirs.close()


@contextlib.contextmanager
def _environment(changes: Mapping[str, str]) -> Iterator[None]:
    """Change the environment that a process is born into."""
    before = {name: os.environ.get(name) for name in changes}
    os.environ.update(changes)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _serve(pipe: Connection) -> None:
    """Answer until the pipe closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    while True:
        try:
            function, arguments = pipe.recv()
        except EOFError:
            return
        try:
            answer = (True, function(*arguments))
        except Exception as error:  # to be raised by the caller
            answer = (False, f"{type(error).__name__}: {error}")
        pipe.send(answer)
