"""Tables of colour-science in the user's cache folder: reading one takes a millisecond, importing the package 1 s."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
import os
import tempfile
from collections.abc import Callable
from importlib import metadata
from pathlib import Path
from typing import TypeVar

import platformdirs

T = TypeVar("T")
_version = functools.cache(metadata.version)  # reads a package's metadata, which is slow


def cached(make: Callable[[], T]) -> Callable[[], T]:
    """Cache the result of a function on disk, per version of colour-science and of the function's source.

    The result consists of dicts, lists, strings and numbers, which are restored exactly. A damaged file is recreated;
    without write access nothing is cached.
    """

    @functools.cache
    def known() -> T:
        source = Path(make.__code__.co_filename).read_bytes()
        of = f"{make.__qualname__} {_version('colour-science')} {hashlib.sha256(source).hexdigest()}"
        key = hashlib.sha256(of.encode()).hexdigest()[:16]
        file = platformdirs.user_cache_path("camsim") / "curves" / f"{make.__name__.strip('_')}-{key}.json"
        with contextlib.suppress(OSError, ValueError):
            digest, _, text = file.read_text(encoding="utf-8").partition("\n")
            if digest == _digest(text):
                there: T = json.loads(text)
                return there
        made = make()
        with contextlib.suppress(OSError):
            _write(file, json.dumps(made))
        return made

    return known


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _write(file: Path, text: str) -> None:
    """Write a file atomically, safe against concurrent writers."""
    file.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=file.parent)
    with open(handle, "w", encoding="utf-8") as stream:
        stream.write(f"{_digest(text)}\n{text}")
    os.replace(name, file)
