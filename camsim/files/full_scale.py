"""Range of the samples of a file: the largest integer, and whether an alpha channel is opaque."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from camsim.errors import InputError


def largest_sample(dtype: np.dtype[Any], bits: int | None = None) -> float:
    """Return the largest value that samples can have: by ``bits`` or the type for integers, 1 for floats.

    >>> largest_sample(np.dtype("u2"), 12), largest_sample(np.dtype("u1")), largest_sample(np.dtype("f4"))
    (4095.0, 255.0, 1.0)
    """
    if dtype.kind not in "ui":
        return 1.0
    return float(np.iinfo(dtype).max) if bits is None else float((1 << bits - (dtype.kind == "i")) - 1)


def opaque(image: npt.NDArray[Any], largest: float) -> npt.NDArray[Any]:
    """Return an image, (rows, cols) or (rows, cols, colours), without an opaque alpha channel.

    Raises InputError if it is not opaque. Values above 1 mean a further colour, such as white's electrons.

    >>> opaque(np.array([[[0.3, 1.0]]]), 1.0)
    array([[0.3]])
    """
    if image.ndim != 3 or image.shape[2] not in (2, 4) or (image[..., -1] > largest).any():
        return image
    refuse_transparent(image[..., -1], largest)
    return image[..., 0] if image.shape[2] == 2 else image[..., :-1]


def refuse_transparent(alpha: npt.NDArray[Any], largest: float) -> None:
    """Raise InputError unless an alpha channel is opaque everywhere."""
    if not (alpha >= largest).all():
        raise InputError("it is transparent in places (alpha), and nobody knows what lies behind; flatten it first")
