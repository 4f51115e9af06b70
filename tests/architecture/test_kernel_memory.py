"""Kernels that make no arrays count no references to arrays; those that do give back what they took."""

import numpy as np
import pytest
from numba.core.errors import TypingError
from numba.core.runtime import _nrt_python, rtsys

from camsim.core.kernels import kernel


@kernel(allocates=True)
def halves(values):
    return values[: len(values) // 2], values[len(values) // 2 :]


@kernel(allocates=True)
def swapped(values):
    first, second = halves(values)
    both = np.empty(len(values))
    both[: len(second)] = second
    both[len(second) :] = first
    return both


@kernel()
def largest(values):
    found = values[0]
    for value in values[1:]:
        found = max(found, value)
    return found


@kernel(allocates=True)
def largest_of_swapped(values):
    return largest(swapped(values))


@pytest.fixture
def counted():
    """Memory that is taken and given back is counted."""
    _nrt_python.memsys_enable_stats()
    yield
    _nrt_python.memsys_disable_stats()


def test_all_memory_is_given_back(counted):
    values = np.arange(6.0)
    assert swapped(values).tolist() == [3.0, 4.0, 5.0, 0.0, 1.0, 2.0]
    before = rtsys.get_allocation_stats()
    for _ in range(100):
        assert largest_of_swapped(values) == 5.0
        swapped(values)
        halves(values)
    after = rtsys.get_allocation_stats()
    assert after.alloc - before.alloc == after.free - before.free > 100
    assert values.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]


def test_a_kernel_that_returns_arrays_says_so():
    @kernel()
    def tail(values):
        return 1.0, values[1:]

    @kernel(allocates=True)
    def counting(values):
        return len(tail(values)[1])

    for call in tail, counting:
        with pytest.raises(TypeError, match=r"tail returns arrays: it and what calls it need allocates=True"):
            call(np.ones(3))


def test_only_such_a_kernel_calls_it():
    @kernel()
    def counting(values):
        return len(swapped(values))

    with pytest.raises(TypeError, match="swapped returns arrays: it and what calls it need allocates=True"):
        counting(np.ones(3))


def test_a_kernel_that_makes_arrays_says_so():
    @kernel()
    def zeros():
        return np.zeros(3).sum()

    with pytest.raises(TypingError, match="zeros"):
        zeros()
