"""Planes of a cube in bands, by a name that pickles: there are several modules called conftest."""

from collections.abc import Callable

import numpy as np


def rows_of_plane(planes: list[np.ndarray], k: int, take: Callable[[np.ndarray], None]) -> float:
    for row in range(0, len(planes[k]), 7):
        take(planes[k][row : row + 7])
    return 3.2e-7
