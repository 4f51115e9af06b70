"""Transfers of OLPF and photosite that are no product of one along x and one along y, on grids of frequencies.

What reaches no farther than a from its centre turns a transfer by no more than 2πa radians in a cycle per unit of
length, however finely frequencies lie. So it is asked at Chebyshev nodes of pieces, and interpolated to rounding:
e^{iΦt} has nothing past degree Φ + 10·∛Φ + 6 on −1 … 1.
"""

from __future__ import annotations

import functools
import math

import numpy as np

from camsim.arrays import C128, F64
from camsim.optics import OpticalStage, OpticalSystem
from camsim.optics.protocols import Separable
from camsim.products import product
from camsim.quadrature import chebyshev, interpolation

PHASE, MOST_NODES = 10.0, 38  # radians that a piece turns either way from its middle, and the nodes that it takes
NODES_IN_CYCLE = MOST_NODES * math.pi / PHASE  # and unit of length


def joint_transfer(system: OpticalSystem, fx_per_um: F64, fy_per_um: F64) -> C128:
    """Return the transfer (y, x) at evenly spaced frequencies (x,), (y,); (0, 0) where all of it is a product.

    >>> from camsim import Airy, CircularPhotosite
    >>> system = OpticalSystem(lens=Airy(f_number=8.0), photosite=CircularPhotosite(diameter_um=4.0))
    >>> fx, fy = np.linspace(0.0, 0.1, 200), np.linspace(-2.0, 2.0, 3000)
    >>> right = system.photosite.otf(fx, fy[:, None], 0.0)
    >>> bool(np.abs(joint_transfer(system, fx, fy) - right).max() < 1e-14)
    True
    """
    stages = joint_stages(system)
    if not stages:
        return np.empty((0, 0), complex)
    reach = np.abs(system.spots_um()).max(axis=0) * (system.olpf in stages)
    reach += np.array(system.photosite.half_extent_um) * (system.photosite in stages)
    (x, across), (y, down) = (_nodes(f, a) for f, a in zip((fx_per_um, fy_per_um), reach.tolist(), strict=True))
    values = np.ones((y.size, x.size), complex)
    for stage in stages:
        values *= stage.otf(x[None], y[:, None], 0.0)
    if across is not None:
        rows = values.reshape(-1, across.shape[1])
        values = np.empty((len(rows), len(across)), complex)
        values.real, values.imag = product(rows.real.copy(), across.T), product(rows.imag.copy(), across.T)
        values = np.ascontiguousarray(values.reshape(y.size, -1)[:, : fx_per_um.size])
    if down is not None:
        pieces = values.view(float).reshape(-1, down.shape[1], 2 * fx_per_um.size)
        values = np.concatenate([product(down, piece) for piece in pieces])[: fy_per_um.size].view(complex)
    return values


def joint_stages(system: OpticalSystem) -> list[OpticalStage]:
    """Return those of OLPF and photosite whose transfer is no function of fx times one of fy."""
    stages = [stage for stage in (system.olpf, system.photosite) if stage is not None]
    return [stage for stage in stages if not (isinstance(stage, Separable) and stage.separable)]


def _nodes(frequency: F64, reach: float) -> tuple[F64, F64 | None]:
    """Return frequencies to ask for, and what makes a piece of those that are wanted of a piece of these.

    Or those that are wanted, and None, where they are no more than the nodes would be.
    """
    if frequency.size < 2:
        return frequency, None
    step = float(frequency[-1] - frequency[0]) / (frequency.size - 1)
    turns = math.pi * reach * step
    count = int(min(frequency.size, PHASE / turns + 1.0)) if turns else frequency.size
    phase = turns * (count - 1)
    order = math.ceil(phase + 10.0 * math.cbrt(phase) + 6.0)
    if order >= count:
        return frequency, None
    first = frequency[0] + step * count * np.arange(-(-frequency.size // count))
    return (first[:, None] + 0.5 * step * (count - 1) * (1.0 + chebyshev(order))).ravel(), _matrix(count, order)


@functools.lru_cache(maxsize=16)
def _matrix(count: int, order: int) -> F64:
    """Return (count, order): from Chebyshev nodes to evenly spaced places from end to end."""
    return interpolation(chebyshev(order), np.linspace(-1.0, 1.0, count))
