"""Where compiled kernels are kept for the next process: in the user's cache folder, under a key made of the sources."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
import numba as nb
import platformdirs
from numba.core.caching import CompileResultCacheImpl, FunctionCache, _CacheLocator
from numba.core.runtime.nrt import rtsys

KEPT = 8  # versions of a kernel: as many branches may be worked on in turns
_ROOT = str(Path(__file__).resolve().parents[3])
_IMPORTS = re.compile(rb"\n[ \t]*(?:from|import) (camsim[\w.]*)")


class _Locator(_CacheLocator):
    """Where a kernel's compiled forms lie, and what names them."""

    def __init__(self, function: Callable[..., Any], file: str) -> None:
        self._key = _key(file)
        self._line = function.__code__.co_firstlineno

    def get_cache_path(self) -> str:
        """Return the folder."""
        return nb.config.CACHE_DIR or str(  # type: ignore[attr-defined]
            Path(platformdirs.user_cache_dir("camsim")) / "kernels"
        )

    def get_source_stamp(self) -> str:
        """Return the key, which is in the name too: versions lie side by side."""
        return self._key

    def get_disambiguator(self) -> str:
        """Return what tells versions of a function apart."""
        return f"{self._line}-{self._key[:16]}"

    @classmethod
    def from_function(cls, function: Callable[..., Any], file: str) -> _Locator:
        """Return the locator, whether or not its folder can be written."""
        return cls(function, file)


class _Cached(CompileResultCacheImpl):
    _locator_classes = [_Locator]  # noqa: RUF012 (as Numba has it)

    def reduce(self, cres: Any) -> Any:
        """Return what is kept: machine code, and for Numba's own code only the names of what Python calls.

        Numba keeps its own code too, for kernels that take this one in; ours take it from its source. To read it would
        take longer than all else of a kernel.
        """
        (name, kind, (machine_code, _)), *rest = super().reduce(cres)  # type: ignore[no-untyped-call]
        called = cres.fndesc.llvm_func_name, cres.fndesc.llvm_cpython_wrapper_name
        names = "\n".join(f'define void @"{entry}"() {{ ret void }}' for entry in called)
        return (name, kind, (machine_code, llvm.parse_assembly(names).as_bitcode())), *rest


class Cache(FunctionCache):
    """What was compiled of one kernel, on the disk. What cannot be read there is none, what cannot be written is lost.

    Numba's own cache knows no file but the function's own, while kernels take in functions of others.
    """

    _impl_class = _Cached

    @property
    def index(self) -> Path:
        """The file that lists what was compiled."""
        return Path(self._cache_file._index_path)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return what was compiled before; None where there is none that can be read.

        Numba's own makes itself ready to compile first: a third of a second, which kernels that are there do not need.
        What is in place when they run is the part of Numba's run-time that gives and takes memory.
        """
        try:
            rtsys.initialize(target_context)
            return self._load_overload(sig, target_context)  # type: ignore[no-untyped-call]
        except Exception:  # a pickle that was cut short may raise anything
            with contextlib.suppress(OSError):
                self.index.unlink()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled, if the folder lets us, and the newest of its other versions."""
        with contextlib.suppress(OSError, EOFError):
            super().save_overload(sig, data)  # type: ignore[no-untyped-call]
            self._forget_oldest()

    def _forget_oldest(self) -> None:
        name = self.index.name.rsplit("-", 2)[0]
        versions = sorted(self.index.parent.glob(f"{name}-*.nbi"), key=lambda path: path.stat().st_mtime)
        for old in versions[:-KEPT]:
            for file in self.index.parent.glob(f"{old.stem}.*"):
                file.unlink()


@functools.cache
def _key(file: str) -> str:
    """Return the hash of a module's source and of all that it imports, and of what compiles them."""
    made_by = nb.__version__, sys.version, nb.config.BOUNDSCHECK  # type: ignore[attr-defined]
    digests = (_read(name)[0] for name in sorted(_sources(file)))
    return hashlib.sha256(b"".join([repr(made_by).encode(), *digests])).hexdigest()


def _sources(file: str) -> set[str]:
    """Return a module's file and those of camsim's modules that it imports, directly or not."""
    found, waiting = set[str](), [os.path.realpath(file)]
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting += _read(path)[1]
    return found


@functools.cache
def _read(file: str) -> tuple[bytes, list[str]]:
    """Return the hash of one file, which many modules import, and the files of camsim's modules that it imports."""
    source = Path(file).read_bytes()
    files = map(_file_of, set(_IMPORTS.findall(b"\n" + source)))
    return hashlib.sha256(source).digest(), [path for path in files if path is not None]


@functools.cache
def _file_of(module: bytes) -> str | None:
    """Return a module's file; None where the name is not one of a module."""
    place = os.path.join(_ROOT, *module.decode().split("."))
    return next(filter(os.path.isfile, (os.path.join(place, "__init__.py"), f"{place}.py")), None)
