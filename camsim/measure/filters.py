"""Colour filter arrays by name, and mosaics from their planes."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from camsim.errors import InvalidValueError
from camsim.sensor.cfa import BAYER, PATTERNS


def filter_rows(cfa: str) -> tuple[str, ...]:
    """Return the rows of a colour filter array by its name, its letters, or rows of letters.

    >>> filter_rows("rggb"), filter_rows("RRGG/RRGG/GGBB/GGBB")[0]
    (('RG', 'GB'), 'RRGG')
    """
    if cfa.lower() in PATTERNS:
        return PATTERNS[cfa.lower()]
    rows = tuple(cfa.upper().split("/"))
    if len(rows) > 1 and rows[0].isalpha() and all(row.isalpha() and len(row) == len(rows[0]) for row in rows):
        return rows
    if cfa.upper() not in BAYER:
        raise InvalidValueError(
            f"{cfa!r}; give one of {', '.join((*BAYER, *PATTERNS))}, or rows of letters such as RRGG/RRGG/GGBB/GGBB",
            key="cfa",
        )
    return cfa.upper()[:2], cfa.upper()[2:]


def mosaic_of(image: npt.NDArray[Any], rows: tuple[str, ...]) -> npt.NDArray[Any]:
    """Return the mosaic that four planes of a 2 × 2 array make, in the order of its positions; other images unchanged.

    image : (4, n, m) or (n, m, 4)

    >>> mosaic_of(np.arange(4).reshape(1, 1, 4), ("RG", "GB")).tolist()
    [[0, 1], [2, 3]]
    """
    if image.ndim != 3 or 4 not in (image.shape[0], image.shape[2]) or [len(row) for row in rows] != [2, 2]:
        return image
    planes = image if image.shape[2] != 4 else np.moveaxis(image, 2, 0)
    mosaic = np.empty((2 * planes.shape[1], 2 * planes.shape[2]), image.dtype)
    for (row, col), plane in zip(np.ndindex(2, 2), planes, strict=True):
        mosaic[row::2, col::2] = plane
    return mosaic
