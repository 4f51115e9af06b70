"""Faults of a result as a whole besides its levels: mirrored, enlarged, overflowed, one channel shifted."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from camsim.core.arrays import F32, F64
from camsim.measure.demosaic.alignment import channel_shifts
from camsim.measure.demosaic.scaling import Fault
from camsim.measure.demosaic.subject import CHANNELS, Subject

_ALIKE, _UNLIKE = 0.9, 0.5
"""Correlations of brightness: at least for the same picture, at most for another."""

_APART_PX = 0.25
"""Shift of a channel from the others to report; interpolating methods stay below a tenth of a pixel."""

_EQUAL, _LEAST_OVER = 0.98, 0.002

_TURNS: dict[str, Callable[[F64], F64]] = {
    "mirrored left to right": lambda image: image[:, ::-1],
    "mirrored top to bottom": lambda image: image[::-1],
    "turned by 180°": lambda image: image[::-1, ::-1],
}


def turned(found: F32, subject: Subject) -> Fault | None:
    """Return the fault of a result that is the truth mirrored or rotated; None otherwise."""
    wanted = subject.truth.sum(axis=2, dtype=np.float64)
    seen = found.sum(axis=2, dtype=np.float64)
    if _correlation(seen, wanted) > _UNLIKE:
        return None
    for how, turn in _TURNS.items():
        if _correlation(turn(seen), wanted) > _ALIKE:
            return Fault("flipped", f"it is the truth {how}; write its rows and columns as the mosaic has them")
    return None


def overflowed(found: F32, subject: Subject) -> Fault | None:
    """Return the fault of integer overflow, bright values wrapped around to dark ones; None otherwise."""
    end = float(found.max())
    places = subject.used
    true, seen = subject.truth[places].astype(np.float64), found[places].astype(np.float64)
    over = 0
    for k in range(len(CHANNELS)):
        t, r = true[:, k], seen[:, k]
        dim = t <= np.quantile(t, 0.25)
        exposed = dim & (t > 0.0)
        if not exposed.any() or end <= 0.0:
            continue
        expected = t * float(np.median(r[exposed] / t[exposed]))
        beyond = expected > 1.1 * end
        again = np.abs(r - expected % end) < 0.15 * end
        clipped = r > 0.9 * end
        if beyond.mean() > _LEAST_OVER and np.mean(again[beyond] & ~clipped[beyond]) > 0.6:
            over += int(np.count_nonzero(beyond))
    if not over:
        return None
    return Fault(
        "overflowed", f"{over} of its numbers began again at 0 beyond {end:g}; clip them before they are stored"
    )


def enlarged(found: F32, subject: Subject) -> Fault | None:
    """Return the fault of planes of half the size, with each pixel repeated 2 × 2; None otherwise."""
    for row, col in np.ndindex(2, 2):
        if _in_fours(found[row:, col:]) > _EQUAL and _in_fours(subject.truth[row:, col:]) < _UNLIKE:
            return Fault("enlarged", "its pixels are alike in fours: planes of half the size, enlarged by 2")
    return None


def channel_shifted(image: F32, subject: Subject) -> Fault | None:
    """Report channels shifted against the others."""
    shifts = np.array(channel_shifts(image, subject))
    apart = shifts - np.median(shifts, axis=0)
    stated = [
        f"{name} {x:+.2f} px to the right and {y:+.2f} px below"
        for name, (x, y) in zip(CHANNELS, apart, strict=True)
        if np.hypot(x, y) > _APART_PX
    ]
    return Fault("channel shifted", f"against the other channels lies {', '.join(stated)}") if stated else None


def _in_fours(image: F32) -> float:
    """Return the share of 2 × 2 blocks that are equal in all channels."""
    rows, cols = (size // 2 * 2 for size in image.shape[:2])
    parts = [image[row:rows:2, col:cols:2] for row, col in np.ndindex(2, 2)]
    same = np.all([part == parts[0] for part in parts[1:]], axis=(0, 3))
    return float(same.mean())


def _correlation(a: F64, b: F64) -> float:
    spread = float(np.std(a) * np.std(b))
    return float(np.mean((a - a.mean()) * (b - b.mean()))) / spread if spread > 0.0 else 1.0
