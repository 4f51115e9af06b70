"""Samples of transfers added up over wavelengths, on frequencies that all of them have in common."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from camsim.arrays import C128, F64
from camsim.kernels import shared
from camsim.optics.airy import NM_PER_UM
from camsim.products import product
from camsim.quadrature import chebyshev, interpolation
from camsim.rendering.across.ghosts import six_between

FINEST = 960  # steps of |f| to the cut-off
TIMES = (2, 4, 6, 8, 10, 12, 16, 20)  # of which so many may be one
TOGETHER = 64  # frequencies, in one product of matrices


def fusing_of(frequency_per_um: F64, f_number: float, wavelength_nm: F64, own: F64, shifts: int) -> F64:
    """Return (sets, frequencies, nodes · shifts): what samples weigh in fused transfers.

    own : (sets, wavelengths, nodes)
    """
    sets, _, nodes = own.shape
    out = np.empty((sets, frequency_per_um.size, nodes, shifts))
    scaled = np.multiply.outer(f_number * wavelength_nm / NM_PER_UM, frequency_per_um)
    weighs, x = np.ascontiguousarray(np.moveaxis(own, 1, 2)).reshape(sets * nodes, -1), chebyshev(shifts)

    def work(first: int, stop: int) -> None:
        for begin in range(first * TOGETHER, min(stop * TOGETHER, frequency_per_um.size), TOGETHER):
            part = slice(begin, begin + TOGETHER)
            nu = scaled[:, part]
            at = np.zeros((*nu.shape, shifts))
            at[nu < 1.0] = interpolation(x, 2.0 * np.sqrt(1.0 - nu[nu < 1.0]) - 1.0)
            found = product(weighs, at.reshape(len(nu), -1)).reshape(sets, nodes, -1, shifts)
            out[:, part] = np.swapaxes(found, 1, 2)

    shared(-(-frequency_per_um.size // TOGETHER), work)
    return out.reshape(sets, frequency_per_um.size, -1)


def fused_of(fusing: F64, samples: C128) -> C128:
    """Return (radii, sets, frequencies, angles)."""
    sets, frequencies, _ = fusing.shape
    radii, _, angles = samples.shape
    out = np.empty((radii, sets, frequencies, 2 * angles))
    every = np.swapaxes(samples.view(np.float64), 0, 1).reshape(fusing.shape[2], -1)

    def work(first: int, stop: int) -> None:
        for begin in range(first * TOGETHER, min(stop * TOGETHER, frequencies), TOGETHER):
            part = slice(begin, begin + TOGETHER)
            for s in range(sets):
                out[:, s, part] = np.swapaxes(product(fusing[s, part], every).reshape(-1, radii, 2 * angles), 0, 1)

    shared(-(-frequencies // TOGETHER), work)
    fused: C128 = out.view(np.complex128)
    return fused


def times_of(values: C128, cut: float, allowed: float, heard: Callable[[F64], F64]) -> int:
    """Return how many steps of |f| may be one for a six-point look-up to keep what is allowed.

    values : (radii, sets, FINEST + 1, angles)
    """
    best = 1
    for times in TIMES:
        between = slice(times // 2, None, times)
        right = values[..., between, :]
        error = np.abs(six_between(values[..., ::times, :])[..., : right.shape[-2], :] - right)
        frequency = cut / FINEST * np.arange(FINEST + 1.0)[between]
        if float((error * heard(frequency)[:, None]).max()) > allowed:
            break
        best = times
    return best
