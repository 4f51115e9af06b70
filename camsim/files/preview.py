"""Preview: a simple development of the mosaic, as by a raw developer."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from camsim.camera.frame import Frame
from camsim.core.arrays import F32, F64, U8, U16
from camsim.errors import CamsimError
from camsim.sensor.cfa import filters_of
from camsim.sensor.colour_matrix import XYZ_D50, as_shot_neutral, fit_for_development

ROWS_AT_ONCE = 256  # in double precision, which a whole frame would take too much memory for
_XYZ_D50_TO_SRGB = np.array(
    [
        [3.1338561, -1.6168667, -0.4906146],
        [-0.9787684, 1.9161415, 0.0334540],
        [0.0719453, -0.2289914, 1.4052427],
    ]
)
"""IEC 61966-2-1 primaries, adapted from D65 to D50 after Bradford (B. Lindbloom, brucelindbloom.com)."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Balance:
    """White balance and colour of a development.

    neutral : (channels,) response to white
    forward : (3, channels) balanced camera to XYZ under D50
    """

    neutral: F64
    forward: F64


def develop(frame: Frame) -> U8:
    """Return (rows, cols, 3) 8-bit sRGB, or (rows, cols) grey for mono; white is where the first photosites are full.

    Black level, as-shot white balance, bilinear demosaicing, the D65 forward matrix (or the scene's own) and the
    sRGB curve. No brightness is added: an underexposed capture looks dark. All channels are clipped at the
    balanced white, so that what is clipped looks white and not coloured. A camera without a colour matrix gives grey.
    """
    black_dn = frame.black_levels_dn
    balance = None
    if len(filters_of(frame.channels)) > 1:
        with contextlib.suppress(CamsimError):
            response = frame.colour.of_filters
            balance = Balance(neutral=as_shot_neutral(response), forward=fit_for_development(response).forward)
    # Black offsets reduce the range of some photosites: all are clipped at the smallest.
    span_dn = float((frame.white_levels_dn - black_dn).min())
    filters = filters_of(frame.channels)
    index = np.array([filters.index(letter.upper()) for letter in frame.channels], np.uint8)[frame.channel_index]
    return developed(frame.linear_dn, index, len(filters), black_dn=black_dn, span_dn=span_dn, balance=balance)


def developed(
    mosaic: U16, channel_index: U8, channels: int, *, black_dn: NDArray[Any], span_dn: float, balance: Balance | None
) -> U8:
    """Return a mosaic as 8-bit sRGB, or as grey without a balance.

    channel_index : index of each photosite's channel, below ``channels``
    black_dn      : (m, n) tiled over the mosaic;  span_dn: from there to white
    """
    signal = mosaic.astype(np.float32)
    for (row, col), level in np.ndenumerate(black_dn):
        signal[row :: len(black_dn), col :: black_dn.shape[1]] -= np.float32(level)
    signal /= np.float32(span_dn)
    if channels == 1:
        return _srgb_bytes(signal)
    if balance is None:
        return _srgb_bytes(demosaic(signal, channel_index, channels).mean(axis=0))
    balanced = np.clip(signal / balance.neutral.astype(np.float32)[channel_index], 0, 1)
    planes = demosaic(balanced, channel_index, channels)
    to_srgb = _XYZ_D50_TO_SRGB @ balance.forward
    to_srgb /= (_XYZ_D50_TO_SRGB @ XYZ_D50)[:, None]
    out = np.empty((*signal.shape, 3), np.uint8)
    for first in range(0, len(out), ROWS_AT_ONCE):
        rows = slice(first, first + ROWS_AT_ONCE)
        out[rows] = _srgb_bytes(np.einsum("sc,crk->rks", to_srgb, planes[:, rows].astype(np.float64)))
    return out


def demosaic(signal: F32, channel_index: U8, channels: int) -> F32:
    """Return (channels, rows, cols): each channel as recorded, elsewhere a weighted mean of neighbours.

    Bilinear on a Bayer array. On sparser arrays the triangular kernel is widened until every photosite has a
    neighbour of every channel. Works for any array, including borders.
    """

    planes = np.empty((channels, *signal.shape), dtype=np.float32)
    for channel in range(channels):
        one = (channel_index == channel).astype(np.float32)
        reach = 1
        while True:
            tent = np.minimum(np.arange(1, 2 * reach + 2), np.arange(2 * reach + 1, 0, -1)) / (reach + 1)

            def spread(values: F32, tent: F64 = tent) -> F32:
                across = scipy.ndimage.correlate1d(values, tent, axis=1, mode="constant")
                down: F32 = scipy.ndimage.correlate1d(across, tent, axis=0, mode="constant")
                return down

            weight = spread(one)
            if weight.min() > 0 or reach >= max(signal.shape):
                break
            reach += 1
        mean = spread(signal * one) / np.maximum(weight, np.finfo(np.float32).tiny)
        planes[channel] = np.where(one > 0, signal, mean)
    return planes


def _srgb_bytes(linear: NDArray[np.floating]) -> U8:
    """Apply the sRGB curve of IEC 61966-2-1 and round to 8 bits; in double precision, alike on all processors."""
    clipped = np.clip(linear, 0.0, 1.0, dtype=np.float64)
    curve = np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1 / 2.4) - 0.055)
    codes: U8 = np.rint(255 * curve).astype(np.uint8)
    return codes
