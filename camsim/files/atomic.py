"""A file is there whole or not at all: written beside its place, then renamed into it."""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
from collections.abc import Iterable, Iterator
from contextvars import ContextVar
from pathlib import Path

from camsim.core.errors import OutputError

_STEM_LETTERS = 40
"""Of the name, so that the name beside fits wherever the name itself does (255 bytes)."""


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a new empty file beside ``path`` to write to, and move it to ``path`` when the block ends well.

    Until the move, whatever was at ``path`` stays as it was; after it, the new file is there in full, on
    disk. When the block fails or is interrupted the file beside is removed. What the system refuses is raised
    as OutputError; a link is followed, so that its target is replaced and not the link.
    """
    target = Path(os.path.realpath(path))
    beside = target.with_name(f".{target.name[:_STEM_LETTERS]}.{secrets.token_hex(4)}.part")
    with _system_errors_named(path):
        try:
            # os.open and not tempfile: the umask is to give the file the permissions of any new one.
            os.close(os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
            yield beside
            _flush_to_disk(beside)
            if (waiting := _WAITING.get()) is not None:
                waiting[target] = beside
                return
            os.replace(beside, target)
        except BaseException:
            beside.unlink(missing_ok=True)
            raise
        _flush_folder(target.parent)


@contextlib.contextmanager
def together() -> Iterator[None]:
    """Let the files that are written in this block be there when it ends well: all of them, or none.

    A command that fails at its second file leaves the first one neither, nor what it had overwritten: whoever mends the
    mistake can give the command again.
    """
    if _WAITING.get() is not None:
        yield  # a part of what is to be there together
        return
    waiting: dict[Path, Path] = {}
    token = _WAITING.set(waiting)
    try:
        yield
        for target in list(waiting):
            with _system_errors_named(target):
                os.replace(waiting[target], target)
            del waiting[target]
            _flush_folder(target.parent)
    finally:
        _WAITING.reset(token)
        for beside in waiting.values():
            beside.unlink(missing_ok=True)


@contextlib.contextmanager
def made_together(folder: Path) -> Iterator[None]:
    """Do so for the files of a folder that was made for them: without them it goes as well, if it is empty."""
    try:
        with together():
            yield
    except BaseException:
        with contextlib.suppress(OSError):
            folder.rmdir()
        raise


_WAITING: ContextVar[dict[Path, Path] | None] = ContextVar("_WAITING", default=None)
"""Files that are written and not in their places yet, by their places."""


def _flush_folder(folder: Path) -> None:
    # The file is in place. Not every file system flushes folders, nor every folder may be read.
    with contextlib.suppress(OSError):
        _flush_to_disk(folder)


def _flush_to_disk(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


@contextlib.contextmanager
def _system_errors_named(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise OutputError(f"cannot write {str(path)!r}: {reason(error)}") from error


def reason(error: OSError) -> str:
    """Say in the user's words why the system refused to write."""
    known = {
        errno.ENOSPC: "the disk is full",
        errno.EDQUOT: "the disk quota is used up",
        errno.EFBIG: "the file would be larger than the system allows",
        errno.EROFS: "the disk is mounted read-only",
        errno.EACCES: "its folder does not allow writing",
        errno.EPERM: "its folder does not allow writing",
        errno.ENAMETOOLONG: "the name is too long",
    }
    return known.get(error.errno or 0, error.strerror or str(error))


def write_chunks(path: Path, chunks: Iterable[bytes | memoryview]) -> None:
    """Write one piece after another, none of them copied."""
    with path.open("wb") as file:
        for chunk in chunks:
            file.write(chunk)


def write_whole(path: str | os.PathLike[str], content: bytes) -> None:
    """Write a file at once: it is there whole, or not at all and what was there stays. Raises OutputError."""
    with replacing(Path(path)) as beside:
        beside.write_bytes(content)
