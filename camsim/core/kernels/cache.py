"""Disk cache of compiled kernels, in the user's cache folder, with a key computed from the sources."""

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
from numba.core.runtime import _nrt_python  # type: ignore[attr-defined]

KEPT = 8  # cached versions of a kernel, so that several branches can be used in turn
_ROOT = str(Path(__file__).resolve().parents[3])
_IMPORTS = re.compile(rb"\n[ \t]*(?:from|import) (camsim[\w.]*)")


class _Locator(_CacheLocator):
    """Location and names of a kernel's cached files."""

    def __init__(self, function: Callable[..., Any], file: str) -> None:
        self._key = _key(file)
        self._line = function.__code__.co_firstlineno

    def get_cache_path(self) -> str:
        """Return the folder."""
        return nb.config.CACHE_DIR or str(  # type: ignore[attr-defined]
            Path(platformdirs.user_cache_dir("camsim")) / "kernels"
        )

    def get_source_stamp(self) -> str:
        """Return the key, which is also in the file name, so that versions coexist."""
        return self._key

    def get_disambiguator(self) -> str:
        """Return the part of the name that distinguishes versions of a function."""
        return f"{self._line}-{self._key[:16]}"

    @classmethod
    def from_function(cls, function: Callable[..., Any], file: str) -> _Locator:
        """Return the locator, whether or not its folder can be written."""
        return cls(function, file)


class _Cached(CompileResultCacheImpl):
    _locator_classes = [_Locator]  # noqa: RUF012 (as Numba has it)

    def reduce(self, cres: Any) -> Any:
        """Return the data to cache: machine code, and of Numba's bitcode only the names of the entry points.

        Numba also caches its bitcode, for kernels that inline this one; ours inline it from its source. Reading it
        would take longer than the rest of a kernel. So would the environments of all functions taken in: to make them,
        Numba imports the modules of its compiler. Machine code reads nothing but their constants.
        """
        (name, kind, (machine_code, _)), *rest, taken_in = super().reduce(cres)  # type: ignore[no-untyped-call]
        called = cres.fndesc.llvm_func_name, cres.fndesc.llvm_cpython_wrapper_name
        names = "\n".join(f'define void @"{entry}"() {{ ret void }}' for entry in called)
        code = name, kind, (machine_code, llvm.parse_assembly(names).as_bitcode())
        return code, *rest, tuple(environment for environment in taken_in if environment.consts)


class Cache(FunctionCache):
    """Disk cache of one kernel; unreadable entries are ignored, and failures to write as well.

    Numba's cache considers only the function's file, whereas kernels inline functions of other modules.
    """

    _impl_class = _Cached

    @property
    def index(self) -> Path:
        """The index file of the cached versions."""
        return Path(self._cache_file._index_path)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the cached kernel; None if there is none that can be read.

        Numba's method first initialises the compiler, which takes a third of a second and is not needed for cached
        kernels. Only the functions of Numba's run-time that manage memory are made known here.
        """
        try:
            _make_memory_known()
            return self._load_overload(sig, target_context)  # type: ignore[no-untyped-call]
        except Exception:  # a truncated pickle may raise anything
            with contextlib.suppress(OSError):
                self.index.unlink()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Cache a compiled kernel if the folder is writable, and remove its oldest versions."""
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
def _make_memory_known() -> None:
    """Give the addresses of the functions that kernels call to allocate, free and take arrays."""
    for name, address in _nrt_python.c_helpers.items():
        llvm.add_symbol(name if name.startswith("_") else f"NRT_{name}", address)


@functools.cache
def _key(file: str) -> str:
    """Return the hash of the sources of a module and of all its imports, and of the versions of Python and Numba."""
    made_by = nb.__version__, sys.version, nb.config.BOUNDSCHECK  # type: ignore[attr-defined]
    digests = (_read(name)[0] for name in sorted(_sources(file)))
    return hashlib.sha256(b"".join([repr(made_by).encode(), *digests])).hexdigest()


def _sources(file: str) -> set[str]:
    """Return the files of a module and of camsim's modules that it imports, directly or indirectly."""
    found, waiting = set[str](), [os.path.realpath(file)]
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting += _read(path)[1]
    return found


@functools.cache
def _read(file: str) -> tuple[bytes, list[str]]:
    """Return the hash of a file, and the files of camsim's modules that it imports; cached."""
    source = Path(file).read_bytes()
    files = map(_file_of, set(_IMPORTS.findall(b"\n" + source)))
    return hashlib.sha256(source).digest(), [path for path in files if path is not None]


@functools.cache
def _file_of(module: bytes) -> str | None:
    """Return a module's file; None if the name is not that of a module."""
    place = os.path.join(_ROOT, *module.decode().split("."))
    return next(filter(os.path.isfile, (os.path.join(place, "__init__.py"), f"{place}.py")), None)
