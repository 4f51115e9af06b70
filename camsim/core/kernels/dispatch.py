"""How kernels are compiled: whole where Python calls them, as little as can be where another kernel takes them in."""

# Numba's own modules have no types.
# mypy: disable-error-code="no-untyped-call, attr-defined"

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, TypeVar

import numba as nb
from numba.core import compiler, event, sigutils, types, typing
from numba.core.codegen import JITCodeLibrary
from numba.core.registry import CPUDispatcher
from numba.core.targetconfig import ConfigStack

from camsim.core.kernels.cache import Cache

F = TypeVar("F", bound=Callable[..., Any])


def kernel(*, allocates: bool = False, **options: Any) -> Callable[[F], F]:
    """Compile a function as ``numba.njit`` with these options would, and keep what was compiled for the next process.

    allocates : it makes arrays, or returns some; only such a kernel may call another that returns arrays

    It is kept in the user's cache folder (``NUMBA_CACHE_DIR`` when that is set) under a key made of the sources: of the
    function's own module and of all camsim's modules that it imports, directly or not. It lets go of the interpreter.
    A kernel that makes no arrays counts no references to those that it is given: whoever calls it holds them.

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
    """Whether a kernel was compiled in this process, or another has left it."""
    if not isinstance(compiled, _Kernel) or compiled.signatures:  # with NUMBA_DISABLE_JIT it is Python
        return True
    return compiled.cache is not None and compiled.cache.index.exists()


@contextlib.contextmanager
def compiling(tell: Callable[[str], None]) -> Iterator[None]:
    """Tell the name of each kernel when it begins to be compiled; what lies in the cache is not told.

    >>> told = []
    >>> @kernel()
    ... def thrice(x):
    ...     return 3 * x
    >>> with compiling(told.append):
    ...     nine = thrice(3)
    >>> told
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
    """A dispatcher that gives other kernels its code before it is optimised.

    Numba optimises a function and makes machine code of it before another one takes it in, and there all of that is
    done again, with each caller of the caller once more: of a first capture's 90 s this was 40. Here it is done once,
    in the kernel that Python calls, with all that it takes in. Nor has a kernel that is only taken in a wrapper for
    Python, which for records of forty arrays is longer than most kernels.

    References are counted (``_nrt``, Numba's run-time) where memory is taken, and nowhere else: in large functions
    Numba does not see that what counts up and down again is for nothing. An edge seen from a photosite took 0.3 µs for
    it, of 1.7.
    """

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        super().__init__(function, targetoptions={"nopython": True, "nogil": True, "no_cfunc_wrapper": True, **options})
        self._taken_in: dict[tuple[Any, ...], Any] = {}

    @functools.cached_property
    def cache(self) -> Cache | None:
        """What lies on the disk of this kernel; None for one that was typed in. Few kernels are ever asked for it."""
        return Cache(self.py_func) if Path(self.py_func.__code__.co_filename).is_file() else None

    def _compilation_chain_init_hook(self) -> None:
        """Look for no extensions of Numba's: none of our types is theirs, and every installed package is asked."""

    def compile(self, sig: Any) -> Any:
        """Compile for types, or load what was compiled; Python calls it."""
        if self.cache is not None:
            self._cache = self.cache  # what cache=True would set to Numba's own
        compiled = super().compile(sig)
        for done in self.overloads.values():
            self._refuse_arrays(done.signature)
        return compiled

    def get_call_template(self, args: Any, kws: Any) -> tuple[Any, ...]:
        """Return the types of a call by another kernel.

        A number that is known is of its type and no more: a count that begins at 1 is Literal[int](1) at first and
        int64 in the end, and what is called with it would be taken in twice. True and False have a version each.
        """
        _, args = self._compiler.fold_argument_types(args, kws)
        args = _numbers_by_type(args)
        name = self.py_func.__name__
        signature = self._to_take_in(args).signature
        self._refuse_arrays(signature, taken_by=ConfigStack.top_or_none())
        return typing.make_concrete_template(name, key=name, signatures=[signature]), self._compiler.pysig, args, {}

    def get_overload(self, sig: Any) -> Any:
        """Return the key under which Numba finds what another kernel calls."""
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
        """Refuse to hand out arrays that nobody counts: they would never be given back, or too early.

        taken_by : flags of the kernel that is compiled and calls it; None: no kernel does
        """
        counted = self.targetoptions["_nrt"] and (taken_by is None or taken_by.nrt)
        if not counted and _has_arrays(signature.return_type):
            raise TypeError(f"{self.py_func.__qualname__} returns arrays: it and what calls it need allocates=True")


def _has_arrays(kind: Any) -> bool:
    return isinstance(kind, types.Array) or (isinstance(kind, types.BaseTuple) and any(_has_arrays(k) for k in kind))


def _numbers_by_type(args: Iterable[Any]) -> tuple[Any, ...]:
    return tuple(arg.literal_type if isinstance(arg, types.IntegerLiteral) else arg for arg in args)


class _Source(JITCodeLibrary):
    """Code that is not optimised as a whole, and of which no machine code is made."""

    def _optimize_functions(self, ll_module: Any) -> None:
        """Simplify each function, so that there is less to take in; Numba does so with all that are only named too."""
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
