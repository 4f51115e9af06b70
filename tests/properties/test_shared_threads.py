"""Work shared among threads: every block once, whoever calls, however often at once."""

from __future__ import annotations

import multiprocessing
import threading
from concurrent.futures import ThreadPoolExecutor

import numba as nb
import numpy as np
import pytest

from camsim.kernels import shared


@pytest.fixture(autouse=True)
def _four(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(nb.config, "NUMBA_NUM_THREADS", 4)


def counted(rows: int = 40, cols: int = 30) -> np.ndarray:
    """Return how often each of a row's blocks was done, blocks within blocks."""
    done = np.zeros((rows, cols), int)

    def row(first: int, end: int) -> None:
        for r in range(first, end):

            def some(begin: int, stop: int, own: np.ndarray = done[r]) -> None:
                own[begin:stop] += 1

            shared(cols, some)

    shared(rows, row)
    return done


def test_calls_within_calls_and_beside_calls_end() -> None:
    with ThreadPoolExecutor(6) as pool:
        for done in pool.map(lambda _: counted(), range(30)):
            assert (done == 1).all()


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
