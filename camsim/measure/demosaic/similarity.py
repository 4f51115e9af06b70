"""Similarity measures: PSNR in linear light, SSIM and MS-SSIM of developed pictures."""

from __future__ import annotations

import math
from functools import cache
from types import ModuleType

import numpy as np

from camsim.core.arrays import F32
from camsim.errors import UnsupportedError
from camsim.measure.demosaic.subject import Used

SCALES = (0.0448, 0.2856, 0.3001, 0.2363, 0.1333)
"""Exponents of MS-SSIM's five scales (Wang, Simoncelli and Bovik 2003)."""

_WINDOW = 11
_ROWS_AT_ONCE = 512
_FLAT = 1e6
"""K1 large enough that SSIM's luminance factor is 1, leaving contrast and structure."""


def psnr_db(found: F32, truth: F32, used: Used) -> tuple[float, tuple[float, ...]]:
    """Return CPSNR and the PSNR of each channel, dB; the peak is 1, and equal pictures give infinity."""
    squares = np.zeros(truth.shape[2])
    for k in range(truth.shape[2]):
        difference = found[..., k][used].astype(np.float64) - truth[..., k][used]
        squares[k] = np.mean(difference * difference)
    return _db(float(squares.mean())), tuple(_db(float(square)) for square in squares)


def _db(mean_square: float) -> float:
    return -10.0 * math.log10(mean_square) if mean_square > 0.0 else math.inf


def ssim(found: F32, truth: F32, used: Used) -> float:
    """Return SSIM (Wang et al. 2004: Gaussian window of 1.5 px, K 0.01 and 0.03), the mean over channels of sRGB."""
    maps = (_map(found[..., k], truth[..., k], 0.01)[used].mean() for k in range(truth.shape[2]))
    return float(np.mean([float(mean) for mean in maps]))


def ms_ssim(found: F32, truth: F32, used: Used) -> float:
    """Return MS-SSIM (Wang, Simoncelli and Bovik 2003), the mean over channels; NaN below 176 px a side.

    Contrast and structure at five scales, each half as fine as the last (means of 2 × 2), brightness at the coarsest.
    """
    rows, cols = (np.flatnonzero(used.any(axis=axis)) for axis in (1, 0))
    window = slice(rows[0], rows[-1] + 1), slice(cols[0], cols[-1] + 1)
    if min(rows[-1] - rows[0], cols[-1] - cols[0]) + 1 < _WINDOW * 2 ** (len(SCALES) - 1):
        return math.nan
    means = []
    for k in range(truth.shape[2]):
        # An excluded border stays excluded; clipped photosites contribute through the blur.
        a, b, product = found[..., k][window], truth[..., k][window], 1.0
        for number, weight in enumerate(SCALES):
            last = number == len(SCALES) - 1
            inner = _inner(_map(a, b, 0.01 if last else _FLAT))
            product *= max(float(inner.mean()), 0.0) ** weight
            a, b = _halved(a), _halved(b)
        means.append(product)
    return float(np.mean(means))


def _inner(values: F32) -> F32:
    """Return the part computed from complete windows."""
    half = _WINDOW // 2
    return values[half:-half, half:-half]


def _halved(image: F32) -> F32:
    rows, cols = (size // 2 * 2 for size in image.shape)
    cut = image[:rows, :cols]
    mean: F32 = 0.25 * (cut[::2, ::2] + cut[1::2, ::2] + cut[::2, 1::2] + cut[1::2, 1::2])
    return mean


def _map(a: F32, b: F32, k1: float) -> F32:
    """Return SSIM at every photosite, computed in bands of rows to limit memory."""
    rows = len(a)
    out = np.empty(a.shape, np.float32)
    for first in range(0, rows, _ROWS_AT_ONCE):
        last = min(first + _ROWS_AT_ONCE, rows)
        # Padded so that no window of the band's rows is cut, and the last band is large enough for one.
        top, bottom = max(first - _WINDOW, 0), min(last + _WINDOW, rows)
        _, found = scikit_metrics().structural_similarity(
            a[top:bottom],
            b[top:bottom],
            data_range=1.0,
            gaussian_weights=True,
            sigma=1.5,
            use_sample_covariance=False,
            K1=k1,
            full=True,
        )
        out[first:last] = found[first - top : last - top]
    return out


@cache
def scikit_metrics() -> ModuleType:
    """Import scikit-image's metrics; raises UnsupportedError if it is not installed."""
    try:
        from skimage import metrics
    except ImportError:
        raise UnsupportedError(
            "needs scikit-image, which is not installed: python -m pip install 'camsim-spectral[judge]'",
            key="demosaic",
        ) from None
    module: ModuleType = metrics
    return module
