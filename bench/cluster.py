"""A dask cluster of programs that are started as a user starts them, over TCP."""

from __future__ import annotations

import contextlib
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator

import psutil


@contextlib.contextmanager
def cluster(workers: int) -> Iterator[tuple[str, list[int]]]:
    """Yield the address of a dask scheduler with workers of one thread, and the process ids of scheduler and nanny."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    words = [
        ["dask_scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard"],
        ["dask_worker", address, "--nworkers", str(workers), "--nthreads", "1", "--no-dashboard"],
    ]
    nothing = subprocess.DEVNULL
    with tempfile.TemporaryDirectory() as scratch:
        programs = [
            subprocess.Popen(
                [sys.executable, "-m", f"distributed.cli.{name}", *rest], stdout=nothing, stderr=nothing, cwd=scratch
            )
            for name, *rest in words
        ]
        try:
            yield address, [program.pid for program in programs]
        finally:
            one = [
                child for p in programs if p.poll() is None for child in psutil.Process(p.pid).children(recursive=True)
            ]
            for process in (*programs, *one):
                with contextlib.suppress(psutil.NoSuchProcess):
                    process.kill()
            for program in programs:
                program.wait()
