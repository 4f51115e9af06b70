"""By how much a result is shifted against its truth: least squares on brightness (Lucas and Kanade)."""

from __future__ import annotations

import numpy as np
import scipy

from camsim.arrays import F32, F64
from camsim.measure.demosaic.subject import Subject, Used

SHIFTED_PX = 0.1
"""From here on a result is called shifted; methods that put colours where they belong stay below 0.05."""

_BLUR, _STEPS, _LARGEST, _EDGE = 1.5, 8, 1024, 12
_DIGITS = 4
"""After the point: the last step is smaller than that."""


def best_shift(found: F32, subject: Subject) -> tuple[float, float]:
    """Return (x, y) in pixels by which the result lies to the right of and below the truth; 0 where nothing tells it.

    A blur hides what demosaicing does to single photosites; gain and offset are free.
    """
    rows, cols = (slice(max(0, (size - _LARGEST) // 2), (size + _LARGEST) // 2) for size in subject.shape)
    wanted, blurred = (
        scipy.ndimage.gaussian_filter(image[rows, cols].sum(axis=2, dtype=np.float64), _BLUR)
        for image in (subject.truth, found)
    )
    inner = slice(_EDGE, -_EDGE), slice(_EDGE, -_EDGE)
    used = subject.used[rows, cols][inner]
    shift = np.zeros(2)
    for _ in range(_STEPS):
        moved = scipy.ndimage.shift(blurred, shift, order=3, mode="nearest")[inner]
        system = _system(moved, used)
        target = wanted[inner][used]
        matrix, right = np.einsum("ni,nj->ij", system, system), np.einsum("ni,n->i", system, target)
        if np.linalg.cond(matrix) > 1e14:
            return 0.0, 0.0
        solved = np.linalg.solve(matrix, right)
        if not abs(solved[2]) > 1e-6:
            return 0.0, 0.0
        step = np.clip(solved[:2] / solved[2], -1.0, 1.0)
        shift += step
        if np.abs(step).max() < 10.0**-_DIGITS:
            break
    down, right = (round(-float(way), _DIGITS) + 0.0 for way in shift)
    return right, down


def _system(moved: F64, used: Used) -> F64:
    slopes = [-np.asarray(np.gradient(moved, axis=axis))[used] for axis in (0, 1)]
    columns: F64 = np.stack([*slopes, moved[used], np.ones(slopes[0].size)], axis=1)
    return columns
