"""Work shared among threads: every block once, whoever calls, however often at once."""

from __future__ import annotations

import copy
import multiprocessing
import pickle
import threading
from concurrent.futures import ThreadPoolExecutor

import numba as nb
import numpy as np
import pytest

from camsim.core.cached import Caching, cached_property
from camsim.core.kernels import ahead, shared


@pytest.fixture(autouse=True)
def _four(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(nb.config, "NUMBA_NUM_THREADS", 4)


def counted(rows: int = 40, cols: int = 30) -> np.ndarray:
    """Return how often each of a row's blocks was done, blocks within blocks."""
    done = np.zeros((rows, cols), int)

    def row(first: int, end: int) -> None:
        for r in range(first, end):

            def some(begin: int, stop: int, one: np.ndarray = done[r]) -> None:
                one[begin:stop] += 1

            shared(cols, some)

    shared(rows, row)
    return done


def test_calls_within_calls_and_beside_calls_end() -> None:
    with ThreadPoolExecutor(6) as pool:
        for done in pool.map(lambda _: counted(), range(30)):
            assert (done == 1).all()


def test_what_is_done_ahead_has_helpers_places() -> None:
    """Four at work on four cores share nothing with helpers; one alone does, and all places are free again."""
    begun = threading.Barrier(4)

    def helped(all_begin: bool) -> bool:
        me, blocks = threading.get_ident(), set()
        if all_begin:
            begun.wait(5.0)

        def work(first: int, end: int) -> None:
            blocks.add(threading.get_ident())
            if end > first and not all_begin:
                together.wait(5.0)

        together = threading.Barrier(4)
        shared(4 if not all_begin else 64, work)
        if all_begin:
            begun.wait(5.0)
        return blocks != {me}

    assert list(ahead(helped, [True] * 4, 4)) == [False] * 4
    for _ in range(4):
        assert list(ahead(helped, [False], 4)) == [True]


@pytest.mark.parametrize("where", ["caller", "helper"])
def test_what_goes_wrong_is_told_and_nothing_hangs(where: str) -> None:
    caller = threading.get_ident()
    helped, called = threading.Event(), threading.Event()

    def work(first: int, end: int) -> None:
        if first == end:
            return
        mine = threading.get_ident() == caller
        # Each waits until the other has a block: a helper alone may have done all of them before the caller begins.
        (called if mine else helped).set()
        (helped if mine else called).wait(5.0)
        if mine == (where == "caller"):
            raise ValueError("told")

    with pytest.raises(ValueError, match="told"):
        shared(64, work)
    assert (counted() == 1).all()


def _in_child(queue: multiprocessing.Queue[bool]) -> None:
    queue.put(bool((counted() == 1).all()))


@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_has_helpers_of_its_own() -> None:
    assert (counted() == 1).all()
    context = multiprocessing.get_context("fork")
    queue: multiprocessing.Queue[bool] = context.Queue()
    child = context.Process(target=_in_child, args=(queue,))
    child.start()
    assert queue.get(timeout=60.0)
    child.join()


class Made(Caching):
    """Something with a property that two threads are to be in at once, or never."""

    def __init__(self, together: threading.Barrier | None = None) -> None:
        self.together, self.times = together, 0

    @cached_property
    def value(self) -> int:
        self.times += 1
        if self.together:
            self.together.wait(10.0)
        return self.times


def test_a_property_of_two_instances_is_made_by_two_threads_at_once() -> None:
    """Python 3.11's own has one lock for all instances: whatever two captures both need was made by one at a time."""
    together = threading.Barrier(2)
    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(lambda made: made.value, [Made(together), Made(together)])) == [1, 1]


def test_a_property_of_one_instance_is_made_once() -> None:
    for _ in range(50):
        made, begin = Made(), threading.Barrier(4)
        with ThreadPoolExecutor(4) as pool:
            assert list(pool.map(lambda _, m=made, b=begin: b.wait(10.0) * 0 + m.value, range(4))) == [1] * 4
        assert set(vars(made)) == {"together", "times", "value"}


def test_a_copy_while_a_property_is_made_has_no_lock() -> None:
    """Captures that one thread took and another one pickled, for other processes, ended in a TypeError."""

    class Copied(Caching):
        @cached_property
        def value(self) -> dict[str, object]:
            return dict(vars(copy.deepcopy(self)), pickled=pickle.dumps(self.__getstate__()))

    assert set(Copied().value) == {"pickled"}


def test_a_property_that_fails_is_made_when_it_is_asked_for_again() -> None:
    made = Made(threading.Barrier(1))
    assert made.together is not None
    made.together.abort()
    with pytest.raises(threading.BrokenBarrierError):
        _ = made.value
    made.together = None
    assert (made.value, made.times) == (2, 2)
