"""Images filtered along their rows and columns, without scipy.ndimage, which takes a quarter of a second to import."""

from __future__ import annotations

from typing import Literal

import numpy as np

from camsim.core.arrays import F64

_ROWS_AT_ONCE = 32  # so that partial sums stay in a processor's cache


def bell(sigma: float, *, truncate: float = 4.0) -> F64:
    """Return the weights of a Gaussian that is cut off at ``truncate`` standard deviations; their sum is 1."""
    reach = int(truncate * sigma + 0.5)
    weights: F64 = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    weights /= weights.sum()
    return weights


def filtered(image: F64, down: F64, across: F64, *, beyond: Literal["symmetric", "edge"] = "symmetric") -> F64:
    """Return an image with each value replaced by a weighted sum of those around it.

    down, across : odd numbers of weights along columns and rows; their products are the weights
    beyond       : what continues the image: its mirror image, or its outermost values

    >>> filtered(np.array([[0.0, 0.0, 1.0]]), np.ones(1), np.array([-0.5, 0.0, 0.5]))
    array([[0. , 0.5, 0.5]])
    """
    rows, cols = image.shape
    wide = np.pad(image, [(weights.size // 2,) * 2 for weights in (down, across)], mode=beyond)
    found = np.zeros(image.shape)
    for first in range(0, rows, _ROWS_AT_ONCE):
        last = min(first + _ROWS_AT_ONCE, rows)
        part = np.zeros((last - first, wide.shape[1]))
        for k, weight in enumerate(down.tolist()):
            part += weight * wide[first + k : last + k]
        for k, weight in enumerate(across.tolist()):
            found[first:last] += weight * part[:, k : k + cols]
    return found
