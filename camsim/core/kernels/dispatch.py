"""Compilation of kernels: fully if Python calls them, only to unoptimised code if another kernel inlines them."""

# Numba's own modules have no types.
# mypy: disable-error-code="no-untyped-call, attr-defined"

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, TypeVar

import numba as nb
import numpy as np
from numba.core import compiler, event, sigutils, types, typing
from numba.core.codegen import JITCodeLibrary
from numba.core.registry import CPUDispatcher
from numba.core.targetconfig import ConfigStack
from numba.core.typing.typeof import typeof
from numba.np import numpy_support

from camsim.core.kernels.cache import Cache

F = TypeVar("F", bound=Callable[..., Any])


def kernel(*, allocates: bool = False, **options: Any) -> Callable[[F], F]:
    """Compile a function as ``numba.njit`` with these options would, and cache it on disk.

    allocates : whether it creates or returns arrays; only such a kernel may call another that returns arrays

    The cache is in the user's cache folder (or ``NUMBA_CACHE_DIR`` if set), with a key computed from the sources of the
    function's module and of all camsim's modules that it imports, directly or indirectly. A kernel releases the GIL.
    One that creates no arrays does not count references to its arguments, which the caller holds.

    >>> @kernel()
    ... def twice(x):
    ...     return 2 * x
    >>> twice(21)
    42
    """

    def compiled(function: F) -> F:
        if nb.config.DISABLE_JIT:
            return function
        dispatcher: Any = _Kernel(function, {"_nrt": allocates, **options})
        made: F = dispatcher
        return made

    return compiled


def is_cached(compiled: Any) -> bool:
    """Return whether a kernel was compiled in this process or is in the disk cache."""
    if not isinstance(compiled, _Kernel) or compiled.signatures:  # with NUMBA_DISABLE_JIT it is Python
        return True
    return compiled.cache is not None and compiled.cache.index.exists()


@contextlib.contextmanager
def compiling(tell: Callable[[str], None]) -> Iterator[None]:
    """Report the name of each kernel when its compilation begins; cached kernels are not reported.

    >>> stated = []
    >>> @kernel()
    ... def thrice(x):
    ...     return 3 * x
    >>> with compiling(stated.append):
    ...     nine = thrice(3)
    >>> stated
    ['dispatch.thrice']
    """

    class Stated(event.Listener):
        def on_start(self, event: Any) -> None:
            function = event.data["dispatcher"].py_func
            tell(f"{function.__module__.rpartition('.')[2]}.{function.__name__}")

        def on_end(self, event: Any) -> None:
            pass

    with event.install_listener("numba:compile", Stated()):
        yield


class _Kernel(CPUDispatcher):
    """A dispatcher that gives other kernels its code before optimisation.

    Numba optimises a function and generates its machine code before another one inlines it, where all of that is
    repeated, and again for each caller of the caller: 40 s of a first capture's 90 s. Here it is done once, in the
    kernel that Python calls, with all that it inlines. A kernel that is only inlined also gets no wrapper for Python,
    which for records of forty arrays is longer than most kernels.

    References are counted (``_nrt``, Numba's run-time) only where memory is allocated: in large functions Numba does
    not remove redundant pairs of increments and decrements. For an edge at a photosite they took 0.3 of 1.7 µs.
    """

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        super().__init__(function, targetoptions={"nopython": True, "nogil": True, "no_cfunc_wrapper": True, **options})
        self._taken_in: dict[tuple[Any, ...], Any] = {}

    @functools.cached_property
    def cache(self) -> Cache | None:
        """Disk cache of this kernel, created on first use; None for a function without a source file."""
        return Cache(self.py_func) if Path(self.py_func.__code__.co_filename).is_file() else None

    def _compilation_chain_init_hook(self) -> None:
        """Skip Numba's search for extensions, which queries every installed package and is not needed here."""

    def typeof_pyval(self, val: Any) -> Any:
        """Return the type of an argument."""
        found = _type_of(val)
        self._types_active_call.add(found)
        return found

    def compile(self, sig: Any) -> Any:
        """Compile for types, or load from the cache; called from Python."""
        if self.cache is not None:
            self._cache = self.cache  # where cache=True would set Numba's cache
        compiled = super().compile(sig)
        for done in self.overloads.values():
            self._refuse_arrays(done.signature)
        return compiled

    def get_call_template(self, args: Any, kws: Any) -> tuple[Any, ...]:
        """Return the types of a call by another kernel.

        Literal integers are widened to their type: a count that begins at 1 is Literal[int](1) at first and int64 in
        the end, and the function called with it would be compiled twice. True and False have a version each.
        """
        _, args = self._compiler.fold_argument_types(args, kws)
        args = _numbers_by_type(args)
        name = self.py_func.__name__
        signature = self._to_take_in(args).signature
        self._refuse_arrays(signature, taken_by=ConfigStack.top_or_none())
        return typing.make_concrete_template(name, key=name, signatures=[signature]), self._compiler.pysig, args, {}

    def get_overload(self, sig: Any) -> Any:
        """Return the key under which Numba finds the function that another kernel calls."""
        return self._to_take_in(_numbers_by_type(sigutils.normalize_signature(sig)[0])).entry_point

    def _to_take_in(self, args: tuple[Any, ...]) -> Any:
        known = self._taken_in.get(args)
        if known is None:
            flags: Any = compiler.Flags()
            self.targetdescr.options.parse_as_flags(flags, {**self.targetoptions, "no_cpython_wrapper": True})
            flags.no_compile = True
            with event.trigger_event("numba:compile", data={"dispatcher": self, "args": args, "return_type": None}):
                compiled = compiler.compile_extra(
                    self.targetdescr.typing_context,
                    self.targetctx,
                    self.py_func,
                    args=args,
                    return_type=None,
                    flags=flags,
                    locals={},
                    library=_Source(self.targetctx.codegen(), self.py_func.__qualname__),
                )
            known = self._taken_in[args] = compiled._replace(entry_point=object())
            self.targetctx.insert_user_function(known.entry_point, known.fndesc, [known.library])
        return known

    def _refuse_arrays(self, signature: Any, taken_by: Any = None) -> None:
        """Refuse to return arrays without reference counts, which would leak or be freed too early.

        taken_by : flags of the kernel that is compiled and calls it; None: called from Python
        """
        counted = self.targetoptions["_nrt"] and (taken_by is None or taken_by.nrt)
        if not counted and _has_arrays(signature.return_type):
            raise TypeError(f"{self.py_func.__qualname__} returns arrays: it and what calls it need allocates=True")


def _type_of(value: Any) -> Any:
    """Return the type of an argument as Numba does, but of arrays and records of them without a search.

    Numba imports numpy.ma for an array, and compares the class of each new record with those of all its own types.
    """
    if isinstance(value, tuple):
        return types.BaseTuple.from_types([_type_of(part) for part in value], type(value))
    if type(value) is np.ndarray:
        return _array(value.dtype, value.ndim, numpy_support.map_layout(value), not value.flags.writeable)
    return typeof(value)


@functools.cache
def _array(dtype: Any, dimensions: int, layout: Any, readonly: bool) -> Any:
    """Return the type of arrays, cached, since Numba compares each that is made with all others."""
    return types.Array(numpy_support.from_dtype(dtype), dimensions, layout, readonly=readonly)


def _has_arrays(kind: Any) -> bool:
    return isinstance(kind, types.Array) or (isinstance(kind, types.BaseTuple) and any(_has_arrays(k) for k in kind))


def _numbers_by_type(args: Iterable[Any]) -> tuple[Any, ...]:
    return tuple(arg.literal_type if isinstance(arg, types.IntegerLiteral) else arg for arg in args)


class _Source(JITCodeLibrary):
    """Code that is not optimised as a whole, and for which no machine code is generated."""

    def _optimize_functions(self, ll_module: Any) -> None:
        """Simplify each defined function, so that there is less to inline; Numba includes mere declarations."""
        ll_module.data_layout = self._codegen._data_layout
        passes, builder = self._codegen._function_pass_manager()
        for function in ll_module.functions:
            if not function.is_declaration:
                passes.run(function, builder)

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True
