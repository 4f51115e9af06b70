"""What all tests share; that this file is here also makes the modules beside it importable (truth, examples, …)."""

import functools
import gc
import os

# As the program sets them (camsim.cli): threads of OpenMP and of BLAS otherwise spin after each piece of work, on
# the very cores that other tests wait for. Read when the libraries load, so they come before NumPy.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
os.environ.setdefault("OPENBLAS_THREAD_TIMEOUT", "4")

import numpy as np
import pytest
import typer.main
import typer.testing


def pytest_ignore_collect(collection_path):
    """No doctests in files like this one: there are several of the name, and no two can be imported as modules."""
    return True if collection_path.name == "conftest.py" else None


def pytest_collection_finish():
    """What collecting made stays to the end: a look for garbage through it takes a second."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True, scope="session")
def _commands_are_made_once():
    """From their signatures they take 50 ms, at each of a thousand calls."""
    made = functools.cache(typer.main.get_command)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(typer.main, "get_command", made)
        patch.setattr(typer.testing, "_get_command", made)
        yield


@pytest.fixture
def rng():
    """A generator of its own for every test."""
    return np.random.default_rng(20070521)
