"""Development for comparison (balanced channels, matrix, sRGB curve, nothing else), and CIE Lab of linear light."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from camsim.core.arrays import F32, F64
from camsim.measure.truth.spaces import XYZ_TO_SRGB
from camsim.sensor.colour_matrix import XYZ_D50, adaptation, fit_white

ROWS_AT_ONCE = 128


def bands(rows: int) -> Iterator[slice]:
    """Yield slices of rows, to limit the memory of intermediate results."""
    for first in range(0, rows, ROWS_AT_ONCE):
        yield slice(first, min(first + ROWS_AT_ONCE, rows))


def developed(linear: F32, to_xyz: F64) -> F32:
    """Return (rows, cols, 3) sRGB from 0 to 1 of balanced linear light in which a perfect diffuser is 1.

    to_xyz : (3, 3) to XYZ under D50;  values above white or outside the sRGB gamut are clipped
    """
    matrix = XYZ_TO_SRGB @ adaptation(XYZ_D50, fit_white("D65")) @ to_xyz
    matrix /= matrix.sum(axis=1)[:, None]
    out = np.empty_like(linear)
    for band in bands(len(linear)):
        out[band] = srgb_curve(np.einsum("sc,rkc->rks", matrix, linear[band].astype(np.float64)))
    return out


def srgb_curve(linear: F64) -> F64:
    """Apply the curve of IEC 61966-2-1 to values clipped to 0..1.

    >>> srgb_curve(np.array([-1.0, 0.0031308, 0.2140411, 2.0])).round(3)
    array([0.  , 0.04, 0.5 , 1.  ])
    """
    clipped = np.clip(linear, 0.0, 1.0)
    curve: F64 = np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1 / 2.4) - 0.055)
    return curve


def lab_of(xyz: F64) -> F64:
    """Return (n, 3) CIE L*, a*, b* of XYZ (n, 3) under D50, white has Y = 1."""
    seen: F64 = lab(xyz[None], np.eye(3))[0]
    return seen


def lab(linear: F32 | F64, to_xyz: F64) -> F64:
    """Return (rows, cols, 3) CIE L*, a*, b* under D50 of balanced linear light; a perfect diffuser is L* = 100.

    >>> lab(np.ones((1, 1, 3), np.float32), np.diag(XYZ_D50)).round(9).tolist()
    [[[100.0, 0.0, 0.0]]]
    """
    ratio = np.einsum("sc,rkc->rks", to_xyz / XYZ_D50[:, None], linear.astype(np.float64))
    # CIE 15: the linear part below (6/29)³ extends to negative values, which noise produces.
    root = np.where(ratio > (6 / 29) ** 3, np.cbrt(ratio), ratio * (29 / 6) ** 2 / 3.0 + 4.0 / 29.0)
    out: F64 = np.empty_like(root)
    out[..., 0] = 116.0 * root[..., 1] - 16.0
    out[..., 1] = 500.0 * (root[..., 0] - root[..., 1])
    out[..., 2] = 200.0 * (root[..., 1] - root[..., 2])
    return out
