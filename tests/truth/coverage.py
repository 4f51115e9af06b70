"""Mean reflectance of squares by their edges: along lines through each row, what lies beyond a crossing changes."""

import numpy as np

LINES = 64  # through a row; the mean along each is exact


def coverage(start, end, step, background, rows, cols):
    """Return the image (rows, cols) of edges from start to end (n, 2), pixels from the upper left corner.

    step : (n,) what lies at the left of an edge (cross product above 0) less what lies at its right
    """
    change = np.zeros((rows, cols + 2))
    lines = (np.arange(rows * LINES) + 0.5) / LINES
    low, high = np.minimum(start[:, 1], end[:, 1]), np.maximum(start[:, 1], end[:, 1])
    first, last = np.searchsorted(lines, low), np.searchsorted(lines, high)
    for e in np.flatnonzero(last > first):
        y = lines[first[e] : last[e]]
        (x0, y0), (x1, y1) = start[e], end[e]
        x = np.clip(x0 + (y - y0) * (x1 - x0) / (y1 - y0), 0.0, cols)
        # Upwards (y is down) the left side is that of larger x.
        weight = step[e] * np.sign(y0 - y1) / LINES
        row, col = y.astype(int), x.astype(int)
        np.add.at(change, (row, col), weight * (col + 1.0 - x))
        np.add.at(change, (row, col + 1), weight * (x - col))
    return background + np.cumsum(change, axis=1)[:, :cols]
