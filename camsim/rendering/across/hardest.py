"""Which of a lens's places are the hardest to follow: what is chosen for all of them is measured there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np

from camsim.arrays import F64, I64
from camsim.optics.placed import Revolves
from camsim.optics.zernike import orders

T = TypeVar("T")

STEPS = 64  # from the nearest radius to the farthest, and the lens's own, between which wavefronts are compared


def waves_at(lens: Revolves, radius_um: F64, wavelength_nm: F64) -> F64:
    """Return coefficients (k, radii · wavelengths), waves."""
    each = [lens.at(float(um), 0.0).coefficients(wavelength_nm) for um in radius_um]
    return np.ascontiguousarray(np.concatenate(each, axis=0).T)


def hardest(zernike: tuple[int, ...], waves: F64, most: int) -> I64:
    """Return numbers of those of wavefronts (k, n) that differ most from a plane, and of those that are steepest.

    most : of either.  Towards the rim polynomials of order n rise as n².
    """
    rises = _rises(zernike)
    size = (np.square(waves * rise[:, None]).sum(axis=0) for rise in (np.ones_like(rises), rises))
    return np.unique([np.argsort(-own, kind="stable")[:most] for own in size])


def heights_within(lens: Revolves, radii_um: tuple[float, float]) -> list[float]:
    """Return the lens's own radii that lie between the nearest and the farthest."""
    return [um for um in lens.height_um if radii_um[0] < um < radii_um[1]]


def changes_of(lens: Revolves, radii_um: tuple[float, float], wavelength_nm: float) -> tuple[F64, F64]:
    """Return radii (n,) from the nearest to the farthest, and how much wavefronts change up to each, as they rise."""
    radius = np.union1d(np.linspace(*radii_um, STEPS), heights_within(lens, radii_um))
    change = np.abs(np.diff(waves_at(lens, radius, np.array([wavelength_nm])), axis=1))
    rises = _rises(lens.at(float(radius[-1]), 0.0).zernike)
    return radius, np.concatenate([[0.0], np.cumsum(rises @ change)])


def knots_within(lens: Revolves, radii_um: tuple[float, float], count: int, wavelength_nm: float) -> F64:
    """Return ``count`` radii evenly from the nearest to the farthest, and of the lens's own those that are hardest."""
    even = np.unique(np.linspace(*radii_um, count))
    own = np.array(heights_within(lens, radii_um))
    if not own.size:
        return even
    waves = waves_at(lens, own, np.array([wavelength_nm]))
    return np.union1d(even, own[hardest(lens.at(float(own[0]), 0.0).zernike, waves, 1)])


def asked(every: Sequence[T], *, far: Callable[[T], float], change: Callable[[T], float]) -> list[T]:
    """Return of many the nearest to the axis, one half way, the farthest, and where the wavefront changes most.

    far, change : how far each one's middle lies from the axis, and how much the wavefront changes over it
    """
    order = sorted(every, key=far)
    return list(dict.fromkeys([order[0], order[len(order) // 2], order[-1], max(every, key=change)]))


def _rises(zernike: tuple[int, ...]) -> F64:
    return np.array([float(orders(index)[0] ** 2) for index in zernike])
