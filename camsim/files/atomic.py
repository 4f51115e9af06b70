"""Atomic writing: a file is written next to its destination, then renamed."""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
from collections.abc import Iterable, Iterator
from contextvars import ContextVar
from pathlib import Path

from camsim.errors import OutputError

_STEM_LETTERS = 40
"""Letters of the name in the temporary one, so that it fits wherever the name itself does (255 bytes)."""


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a new empty file next to ``path`` to write to, and move it to ``path`` when the block succeeds.

    Until the move, whatever was at ``path`` stays as it was; after it, the new file is there in full, on
    disk. When the block fails or is interrupted the temporary file is removed. Errors of the system are raised
    as OutputError; a link is followed, so that its target is replaced and not the link.
    """
    target = Path(os.path.realpath(path))
    temporary = target.with_name(f".{target.name[:_STEM_LETTERS]}.{secrets.token_hex(4)}.part")
    with _system_errors_named(path):
        try:
            # os.open instead of tempfile, so that the umask sets the usual permissions.
            os.close(os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
            yield temporary
            _flush_to_disk(temporary)
            if (waiting := _WAITING.get()) is not None:
                waiting[target] = temporary
                return
            os.replace(temporary, target)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
        _flush_folder(target.parent)


@contextlib.contextmanager
def together() -> Iterator[None]:
    """Commit all files written in this block together when it succeeds, or none.

    A command that fails at its second file leaves no first one and overwrites nothing, so that it can be repeated.
    """
    if _WAITING.get() is not None:
        yield  # nested: committed with the outer block
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
        for temporary in waiting.values():
            temporary.unlink(missing_ok=True)


@contextlib.contextmanager
def made_together(folder: Path) -> Iterator[None]:
    """Commit all files of a new folder together, as ``together`` does; the folder is removed if it stays empty."""
    try:
        with together():
            yield
    except BaseException:
        with contextlib.suppress(OSError):
            folder.rmdir()
        raise


_WAITING: ContextVar[dict[Path, Path] | None] = ContextVar("_WAITING", default=None)
"""Files written but not yet committed, by destination."""


def _flush_folder(folder: Path) -> None:
    # The file is in place. Some file systems cannot flush folders, and some folders are not readable.
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
    """Return the reason, in words, why the system refused to write."""
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
    """Write chunks in order, without copies."""
    with path.open("wb") as file:
        for chunk in chunks:
            file.write(chunk)


def write_whole(path: str | os.PathLike[str], content: bytes) -> None:
    """Write a file atomically; on failure an existing one is unchanged. Raises OutputError."""
    with replacing(Path(path)) as temporary:
        temporary.write_bytes(content)
