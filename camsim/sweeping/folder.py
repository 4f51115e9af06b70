"""The folder of a sweep, for one at a time."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

from camsim.errors import OutputError
from camsim.files.atomic import reason
from camsim.sweeping.manifest import HIDDEN, remove_halves


@contextlib.contextmanager
def alone(folder: Path) -> Iterator[None]:
    """Keep the folder for one sweep at a time; the system lets go of it when the process ends, however it ends."""
    from filelock import FileLock, Timeout

    try:
        (folder / HIDDEN).mkdir(parents=True, exist_ok=True)
        lock = FileLock(folder / HIDDEN / "lock")
        lock.acquire(timeout=0)
    except Timeout:
        raise OutputError(f"another sweep is writing into {str(folder)!r}; wait for it") from None
    except OSError as error:
        raise OutputError(f"cannot write into {str(folder)!r}: {reason(error)}") from error
    try:
        remove_halves(folder)
        yield
    finally:
        lock.release()
