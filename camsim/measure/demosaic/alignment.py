"""Shift of a result against its truth: least squares on brightness (Lucas and Kanade)."""

from __future__ import annotations

import numpy as np
import scipy

from camsim.core.arrays import F32, F64
from camsim.measure.demosaic.subject import Subject, Used

SHIFTED_PX = 0.1
"""Shift from which a result is reported as shifted; methods without a shift stay below 0.05."""

_BLUR, _STEPS, _LARGEST, _EDGE = 1.5, 8, 1024, 12
_DIGITS = 4
"""Decimals of the result: the last step is smaller."""

_SURE = 5.0
"""Standard errors from 0 within which a shift may be due to noise."""

_WEAK = 1e-3
"""Least information relative to the best-determined direction: parallel edges determine no shift along them."""

_TOGETHER = 5
"""Side of blocks of photosites with correlated errors: methods interpolate from neighbours."""


def best_shift(found: F32, subject: Subject) -> tuple[float, float]:
    """Return the shift (x, y) of the result against the truth, pixels right and down; 0 if it is undetermined.

    Blurred pictures are compared, to suppress demosaicing errors of single photosites; gain and offset are free. The
    residuals give the error of the shift by noise and demosaicing; a shift within it, or of nearly uniform ground, is
    not reported.
    """
    return _shift_of(found, subject, list(range(found.shape[2])))


def channel_shifts(found: F32, subject: Subject) -> list[tuple[float, float]]:
    """Return the shift of each channel of the result against the same channel of the truth."""
    return [_shift_of(found, subject, [channel]) for channel in range(found.shape[2])]


def _shift_of(found: F32, subject: Subject, channels: list[int]) -> tuple[float, float]:
    rows, cols = (slice(max(0, (size - _LARGEST) // 2), (size + _LARGEST) // 2) for size in subject.shape)
    wanted, seen = (image[rows, cols][..., channels].sum(axis=2, dtype=np.float64) for image in (subject.truth, found))
    smooth, blurred = (scipy.ndimage.gaussian_filter(image, _BLUR) for image in (wanted, seen))
    inner = slice(_EDGE, -_EDGE), slice(_EDGE, -_EDGE)
    where = np.zeros(wanted.shape, bool)
    where[inner] = subject.used[rows, cols][inner]
    slopes = np.stack([-np.asarray(np.gradient(smooth, axis=axis))[where] for axis in (0, 1)], axis=1)
    level = np.stack([smooth[where], np.ones(len(slopes))], axis=1)
    inverse = _inverse(slopes, level)
    if inverse is None:
        return 0.0, 0.0
    known, ways = np.linalg.eigh(np.linalg.inv(inverse[:2, :2]))
    ways = ways[:, known > _WEAK * known[-1]]
    slopes = np.einsum("ni,ij->nj", slopes, ways)
    inverse = _inverse(slopes, level)
    if inverse is None:
        return 0.0, 0.0
    solving = np.einsum("ij,nj->in", inverse, np.concatenate([slopes, level], axis=1))
    shift = np.zeros(2)
    for _ in range(_STEPS):
        solved = np.einsum("in,n->i", solving, _moved(blurred, shift)[where])
        gain, offset = solved[-2:]
        if not abs(gain) > 1e-6:
            return 0.0, 0.0
        step = np.clip(np.einsum("ij,j->i", ways, solved[:-2]) / gain, -1.0, 1.0)
        shift += step
        if np.abs(step).max() < 10.0**-_DIGITS:
            break
    left = _moved(seen, shift) - gain * wanted - offset
    if not _stated(np.einsum("ij,i->j", ways, shift), float(gain), _covariances(solving[:-1], where, left)):
        return 0.0, 0.0
    down, right = (round(float(way), _DIGITS) + 0.0 for way in shift)
    return right, down


def _inverse(slopes: F64, level: F64) -> F64 | None:
    """Return the inverse of the normal equations; None if they are singular."""
    system = np.concatenate([slopes, level], axis=1)
    matrix = np.einsum("ni,nj->ij", system, system)
    return None if np.linalg.cond(matrix) > 1e14 else np.linalg.inv(matrix)


def _moved(image: F64, shift: F64) -> F64:
    """Return a picture moved back by a shift."""
    moved: F64 = scipy.ndimage.shift(image, -shift, order=3, mode="nearest")
    return moved


def _covariances(solving: F64, where: Used, left: F64) -> list[F64]:
    """Return the covariance of solutions for errors correlated in blocks, in rows and in columns.

    solving : (n, photosites) weights of the blurred picture in the solutions;  left: residuals of the sharp one
    """
    pulls = []
    for row in solving:
        weight = np.zeros(left.shape)
        weight[where] = row
        # The blur is symmetric: these are the weights of photosites in the sharp picture.
        pulls.append(scipy.ndimage.gaussian_filter(weight, _BLUR, mode="constant") * left)
    near = [_TOGETHER * scipy.ndimage.uniform_filter(pull, _TOGETHER, mode="constant") for pull in pulls]
    parts = [np.stack(near).reshape(len(near), -1), *(np.stack([p.sum(axis=axis) for p in pulls]) for axis in (1, 0))]
    return [np.einsum("an,bn->ab", part, part) for part in parts]


def _stated(shift: F64, scale: float, covariances: list[F64]) -> bool:
    """Return whether a shift is precise, or significant, by each of the covariances of (scale · shift, scale)."""
    for covariance in covariances:
        if not scale > _SURE * float(np.sqrt(covariance[-1, -1])):
            return False
        chance = _SURE**2 * covariance[:-1, :-1] / scale**2
        beyond = float(np.linalg.eigvalsh(np.outer(shift, shift) - chance)[-1]) > 0.0
        if not beyond and float(np.sqrt(np.trace(chance))) > SHIFTED_PX:
            return False
    return True
