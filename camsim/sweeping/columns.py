"""Columns of the manifest that are measured on the frame itself."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from camsim.errors import UnsupportedError
from camsim.frame import Frame
from camsim.measure import measure_mtf, picture_of_frame


def measured(frame: Frame, what: Sequence[str]) -> dict[str, Any]:
    """Return the columns of a frame: ``mtf`` of its edges, ``noise`` and ``signal`` of its channels."""
    columns: dict[str, Any] = {}
    if "signal" in what:
        columns |= _signal(frame)
    if "noise" in what:
        columns |= _noise(frame)
    if "mtf" in what:
        columns |= _mtf(frame)
    return columns


def _signal(frame: Frame) -> dict[str, Any]:
    """Mean light, mean code and its scatter, and the share that is clipped, of each channel."""
    columns: dict[str, Any] = {}
    codes = frame.mosaic.astype(float)
    for number, signal in enumerate(frame.report.signal):
        own = codes[frame.channel_index == number]
        columns |= {
            f"mean_{signal.name}_e": signal.mean_e,
            f"mean_{signal.name}_dn": signal.mean_dn,
            f"std_{signal.name}_dn": float(np.std(own)) if own.size else None,
            f"clipped_{signal.name}": signal.clipped_photosites / max(signal.photosites, 1),
        }
    return columns


def _noise(frame: Frame) -> dict[str, Any]:
    """Scatter of each channel's codes about what a noise-free sensor would give, in electrons, and the mean over it.

    Photosites at either end of the codes are left out. Fixed patterns count as noise: one frame cannot tell them.
    """
    offsets = np.array(frame.black_offsets_dn)
    repeats = [-(-size // own) for size, own in zip(frame.shape, offsets.shape, strict=True)]
    black = frame.black_level_dn + np.tile(offsets, repeats)[: frame.shape[0], : frame.shape[1]]
    off = (frame.mosaic.astype(float) - black) * frame.electrons_per_dn - frame.mean_electrons
    whole = (frame.mosaic > 0) & (frame.mosaic < frame.white_level_dn)
    columns: dict[str, Any] = {}
    for number, name in enumerate(frame.channels):
        own = whole & (frame.channel_index == number)
        noise = float(np.std(off[own])) if np.any(own) else math.nan
        columns[f"noise_{name}_e"] = noise if math.isfinite(noise) else None
        columns[f"snr_{name}"] = float(np.mean(frame.mean_electrons[own])) / noise if noise > 0.0 else None
    return columns


def _mtf(frame: Frame) -> dict[str, Any]:
    """MTF50 and MTF at Nyquist of each channel, the median of its edges; nothing where there is no edge to measure."""
    try:
        edges = measure_mtf(picture_of_frame(frame), channel="all").edges
    except UnsupportedError:
        return {}
    columns: dict[str, Any] = {}
    for channel in dict.fromkeys(edge.channel for edge in edges):
        own = [edge.figures for edge in edges if edge.channel == channel]
        for name in ("mtf50_cycles_per_pixel", "mtf_at_nyquist"):
            values = [value for figures in own if math.isfinite(value := getattr(figures, name))]
            columns[f"{name}_{channel}"] = float(np.median(values)) if values else None
    return columns
