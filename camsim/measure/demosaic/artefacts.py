"""Demosaicing artefacts in CIE Lab: colour differences, zippers, false colours along edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import F32, F64
from camsim.measure.demosaic.develop import ROWS_AT_ONCE, lab
from camsim.measure.demosaic.subject import Subject, Used
from camsim.spectra.colour_science import colour_science

JUST_SEEN = 2.3
"""Just noticeable ΔE*ab (Lu and Tan 2003, after Mahy et al.)."""

EDGE = 5.0
"""Difference of L* to a neighbour from which a photosite counts as on an edge."""

_BINS_PER_UNIT, _MOST = 100, 200.0
_NEIGHBOURS = ((-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1))


@dataclass(frozen=True, slots=True, kw_only=True)
class Artefacts:
    """Artefacts over the photosites used.

    delta_e_mean, delta_e_95 : CIEDE2000: the mean and the 95th percentile
    zipper       : fraction of photosites whose difference to their nearest neighbour in colour changes by 2.3 ΔE*ab
                   or more (Lu and Tan, "Color filter array demosaicking: new method and performance measures", 2003)
    false_colour : mean ΔC*ab, hypot(Δa*, Δb*), on edges (L* changes by 5 or more to a neighbour); 0 without any
    """

    delta_e_mean: float
    delta_e_95: float
    zipper: float
    false_colour: float


def artefacts(found: F32, subject: Subject) -> Artefacts:
    """Measure a result (rows, cols, 3), balanced and scaled like the truth."""
    histogram = np.zeros(int(_MOST * _BINS_PER_UNIT) + 1, np.int64)
    total, zippers, chroma, edges = 0.0, 0, 0.0, 0
    rows = len(found)
    for first in range(0, rows, ROWS_AT_ONCE):
        # Padded by one row on either side, for neighbours.
        top, bottom = max(first - 1, 0), min(first + ROWS_AT_ONCE + 1, rows)
        used = subject.used[top:bottom].copy()
        used[: first - top] = False
        used[first - top + ROWS_AT_ONCE :] = False
        if not used.any():
            continue
        seen, true = lab(found[top:bottom], subject.to_xyz), lab(subject.truth[top:bottom], subject.to_xyz)
        difference = delta_e_2000(seen[used], true[used])
        total += float(difference.sum())
        places = np.minimum(difference * _BINS_PER_UNIT, histogram.size - 1).astype(np.int64)
        histogram += np.bincount(places, minlength=histogram.size)
        zippers += int(np.count_nonzero(_zipper(seen, true)[used]))
        on_edge = used & _on_edges(true[..., 0])
        edges += int(np.count_nonzero(on_edge))
        off = (seen - true)[on_edge]
        chroma += float(np.hypot(off[:, 1], off[:, 2]).sum())
    count = int(np.count_nonzero(subject.used))
    below = np.searchsorted(np.cumsum(histogram), 0.95 * count)
    return Artefacts(
        delta_e_mean=total / count,
        delta_e_95=float(below + 1) / _BINS_PER_UNIT if total > 0.0 else 0.0,
        zipper=zippers / count,
        false_colour=chroma / edges if edges else 0.0,
    )


def delta_e_2000(a: F64, b: F64) -> F64:
    """Return CIEDE2000 of pairs of Lab (…, 3), by colour-science."""
    difference: F64 = np.asarray(colour_science().difference.delta_E_CIE2000(a, b), np.float64)
    return difference


def delta_e_map(found: F32, subject: Subject) -> F32:
    """Return (rows, cols) CIEDE2000 at every photosite, including those not used."""
    out = np.empty(subject.shape, np.float32)
    for first in range(0, len(out), ROWS_AT_ONCE):
        band = slice(first, first + ROWS_AT_ONCE)
        out[band] = delta_e_2000(lab(found[band], subject.to_xyz), lab(subject.truth[band], subject.to_xyz))
    return out


def _zipper(seen: F64, true: F64) -> Used:
    """Return a mask of where the difference to the nearest neighbour in colour has changed."""
    best, then = np.full(true.shape[:2], np.inf), np.zeros(true.shape[:2])
    for down, right in _NEIGHBOURS:
        before = _distance(true, down, right)
        nearer = before < best
        best[nearer] = before[nearer]
        then[nearer] = _distance(seen, down, right)[nearer]
    zipper: Used = np.abs(then - best) >= JUST_SEEN
    zipper &= np.isfinite(best)
    return zipper


def _distance(image: F64, down: int, right: int) -> F64:
    """Return ΔE*ab to a neighbour; infinite without one."""
    rows, cols = image.shape[0], image.shape[1]
    out: F64 = np.full((rows, cols), np.inf)
    here = slice(max(-down, 0), rows - max(down, 0)), slice(max(-right, 0), cols - max(right, 0))
    there = slice(max(down, 0), rows - max(-down, 0)), slice(max(right, 0), cols - max(-right, 0))
    difference = image[here] - image[there]
    out[here] = np.sqrt(np.einsum("rkc,rkc->rk", difference, difference))
    return out


def _on_edges(lightness: F64) -> Used:
    edge = np.zeros(lightness.shape, bool)
    down, right = np.abs(np.diff(lightness, axis=0)) >= EDGE, np.abs(np.diff(lightness, axis=1)) >= EDGE
    edge[1:] |= down
    edge[:-1] |= down
    edge[:, 1:] |= right
    edge[:, :-1] |= right
    return edge
