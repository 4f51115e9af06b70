"""What all tests share; that this file is here makes tests/*.py importable (truth, tolerances, examples)."""

import numpy as np
import pytest


@pytest.fixture
def rng():
    """A generator of its own for every test."""
    return np.random.default_rng(20070521)
