"""The core of the paper's Table II: images of the edge, and what the measurement says of them."""

import numpy as np
import pytest

from bench.paper.table_two import COLS, ROWS, closed_form, error_percent, measure_table
from tests.edges import gaussian_edge, gaussian_sigma


class Lines:
    def __init__(self):
        self.lines = []

    def add(self, kind, **values):
        self.lines.append({"kind": kind, **values})


def test_the_closed_form_is_the_error_function():
    edge = gaussian_edge(ROWS, COLS, 4.0, gaussian_sigma(0.25), shift_px=0.2, dark=0.1, bright=0.9)
    np.testing.assert_allclose(closed_form(0.25, 0.2), edge, atol=1e-14)
    assert error_percent(edge, 0.25) < 0.02
    assert error_percent(edge, 0.25 * 1.01) == pytest.approx(1.0, abs=0.03)


def test_a_quick_table_has_the_order_the_paper_found():
    lines = Lines()
    measure_table(lines, methods=("boundary", "importance", "strips"), quick=True)
    mean = {line["label"]: line["mean_percent"] for line in lines.lines}
    assert set(mean) == {"boundary", "importance, 121 samples", "importance, 2025 samples", "strips", "closed form"}
    assert mean["importance, 121 samples"] > 10 * mean["importance, 2025 samples"] > 10 * 0.02
    assert max(mean["boundary"], mean["strips"], mean["closed form"]) < 0.02
