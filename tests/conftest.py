"""What all tests share; that this file is here also makes the modules beside it importable (truth, examples, …)."""

import numpy as np
import pytest


def pytest_ignore_collect(collection_path):
    """No doctests in files like this one: there are several of the name, and no two can be imported as modules."""
    return True if collection_path.name == "conftest.py" else None


@pytest.fixture
def rng():
    """A generator of its own for every test."""
    return np.random.default_rng(20070521)
