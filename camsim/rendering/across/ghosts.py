"""Rows before 0 and past the end of transfers over |f|, for six-point look-ups."""

from __future__ import annotations

import numpy as np

from camsim.arrays import C128

GHOSTS = np.array([[21.0, -70.0, 105.0, -84.0, 35.0, -6.0], [6.0, -15.0, 20.0, -15.0, 6.0, -1.0]])


def with_ghosts(values: C128) -> C128:
    """Return values (…, |f|, angles), 0 first, with two more before and three after it, for a six-point look-up.

    Along a ray a transfer is smooth up to 0 and no further: before it a polynomial through the first six goes on.
    """
    before = np.einsum("gk,...ka->...ga", GHOSTS, values[..., :6, :])
    return np.concatenate([before, values, np.zeros_like(values[..., :3, :])], axis=-2)


def six_between(values: C128) -> C128:
    """Return values half way between rows (…, |f|, angles), 0 first."""
    more, count = with_ghosts(values), values.shape[-2] - 1
    weights = np.array([3.0, -25.0, 150.0, 150.0, -25.0, 3.0]) / 256.0
    found: C128 = sum(w * more[..., k : k + count, :] for k, w in enumerate(weights))
    return found
