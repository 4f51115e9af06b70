"""Work distributed among threads: kernels that release the GIL, each called for a block of the work.

Numba's parallel loops are compiled twice, and its work queue, the only thread layer that is always available, may not
be entered by two threads. Python's threads are started once, since starting them for each call took as long as
rendering a small window. The caller works on blocks as well, and does not wait for a helper that has not begun: so
nested calls, or calls from many threads, never wait for one another.
"""

from __future__ import annotations

import functools
import os
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import pairwise
from typing import TypeVar

import numba as nb

Item = TypeVar("Item")
Done = TypeVar("Done")

MANY = 1 << 20  # threads: any number
BLOCKS = 8  # per thread, for balance of the load


def shared(count: int, work: Callable[[int, int], object], *, least: int = 1, most: int = MANY) -> None:
    """Call ``work(first, end)`` for blocks that make up 0 … count, on as many threads as Numba would use.

    least : smallest size of a block;  most: largest number of threads

    Calls must write to disjoint places, with results that do not depend on the division into blocks. Then the result
    does not depend on the number of threads.

    >>> import numpy as np
    >>> squares = np.zeros(5)
    >>> def work(first, end):
    ...     squares[first:end] = np.arange(first, end) ** 2
    >>> shared(5, work)
    >>> squares
    array([ 0.,  1.,  4.,  9., 16.])
    """
    threads = _cores()
    blocks = min(count // least, threads * BLOCKS)
    helpers = 0
    if threads > 1 and blocks > 1:
        pool, idle = _helpers(threads - 1)
        while helpers < min(threads, blocks, most) - 1 and idle.acquire(blocking=False):
            helpers += 1
    if not helpers:
        work(0, count)
        return
    waiting = deque(pairwise([count * block // blocks for block in range(blocks + 1)]))

    def taken() -> None:
        while True:
            try:
                block = waiting.popleft()
            except IndexError:
                return
            work(*block)

    def helped() -> None:
        try:
            taken()
        finally:
            idle.release()

    begun: list[Future[None]] = []
    try:
        work(0, 0)  # compiles the kernel if necessary, once, with the caller's stack
        begun += [pool.submit(helped) for _ in range(helpers)]
        taken()
    finally:
        waiting.clear()
        for _ in range(helpers - len(begun)):
            idle.release()
        for helper in begun:
            if helper.cancel():
                idle.release()
            else:
                helper.result()


def _cores() -> int:
    """Return the largest number of threads."""
    threads: int = nb.config.NUMBA_NUM_THREADS  # type: ignore[attr-defined]
    return threads


@functools.cache
def _helpers(threads: int) -> tuple[ThreadPoolExecutor, threading.Semaphore]:
    """Return the pool of helper threads and the semaphore that counts idle ones, cached."""
    return ThreadPoolExecutor(threads), threading.Semaphore(threads)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_helpers.cache_clear)  # threads stay behind in the parent


def ahead(work: Callable[[Item], Done], items: Iterable[Item], most: int) -> Iterator[Done]:
    """Yield ``work(item)`` in order, while threads work ahead on the next items, at most ``most`` at a time.

    >>> list(ahead(str.upper, "abc", 2))
    ['A', 'B', 'C']
    """
    threads = min(_cores(), most)
    if threads == 1:
        yield from map(work, items)
        return
    places = threading.Semaphore(1), _helpers(_cores() - 1)[1]

    def placed(item: Item) -> Done:
        # One takes the place of the waiting caller, others that of a helper: no more threads than cores are active.
        one = next((place for place in places if place.acquire(blocking=False)), None)
        try:
            return work(item)
        finally:
            if one is not None:
                one.release()

    with ThreadPoolExecutor(threads) as pool:
        begun: deque[Future[Done]] = deque()
        for item in items:
            begun.append(pool.submit(placed, item))
            if len(begun) == most:
                yield begun.popleft().result()
        while begun:
            yield begun.popleft().result()


def use_one_thread() -> None:
    """Restrict the kernels of this process to one thread from now on."""
    nb.config.NUMBA_NUM_THREADS = 1  # type: ignore[attr-defined]
