"""Tables of colour-science in the user's cache folder: reading one takes a millisecond, importing the package 1 s."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
import os
import tempfile
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import TypeVar

import platformdirs

T = TypeVar("T")


@functools.cache
def _package() -> bytes:
    """Return the first file of colour-science, which has its version; looking for that in the metadata takes longer."""
    spec = find_spec("colour")
    assert spec is not None
    assert spec.origin is not None
    return Path(spec.origin).read_bytes()


def cached(make: Callable[[], T]) -> Callable[[], T]:
    """Cache the result of a function on disk, per version of colour-science and of the function's source.

    The result consists of dicts, lists, strings and numbers, which are restored exactly. A damaged file is recreated;
    without write access nothing is cached.
    """

    @functools.cache
    def known() -> T:
        source = Path(make.__code__.co_filename).read_bytes()
        key = hashlib.sha256(make.__qualname__.encode() + _package() + source).hexdigest()[:16]
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
