"""Grouping of cells of similar gradient direction: the kernel of ``find``."""

from __future__ import annotations

import math

import numpy as np

from camsim.core.arrays import F64
from camsim.core.kernels import kernel


@kernel(allocates=True)
def grow(angle: F64, strong: np.ndarray, rows: np.ndarray, cols: np.ndarray, tolerance: float) -> np.ndarray:
    """Label groups of neighbouring cells whose gradients point the same way, strongest cells first."""
    label = np.zeros(strong.shape, np.int32)
    queue = np.empty((rows.size, 2), np.int32)
    count = 0
    for start in range(rows.size):
        if label[rows[start], cols[start]]:
            continue
        count += 1
        label[rows[start], cols[start]] = count
        queue[0, 0], queue[0, 1] = rows[start], cols[start]
        head, tail = 0, 1
        sum_x, sum_y = math.cos(angle[rows[start], cols[start]]), math.sin(angle[rows[start], cols[start]])
        while head < tail:
            r, c = queue[head, 0], queue[head, 1]
            head += 1
            mean = math.atan2(sum_y, sum_x)
            for i in range(max(r - 1, 0), min(r + 2, strong.shape[0])):
                for j in range(max(c - 1, 0), min(c + 2, strong.shape[1])):
                    if not strong[i, j] or label[i, j]:
                        continue
                    off = abs(angle[i, j] - mean)
                    if min(off, 2.0 * math.pi - off) <= tolerance:
                        label[i, j] = count
                        queue[tail, 0], queue[tail, 1] = i, j
                        tail += 1
                        sum_x += math.cos(angle[i, j])
                        sum_y += math.sin(angle[i, j])
    return label
