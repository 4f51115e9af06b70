"""Overlaps of an aberrated pupil with itself, summed by a rule of so many nodes: steps of phase, and transfers."""

from __future__ import annotations

import functools

import numpy as np

from camsim.arrays import C128, F64
from camsim.kernels import shared
from camsim.optics.difference import Difference
from camsim.products import complex_product
from camsim.rendering.check.overlap_kernels import add_overlaps, overlap_nodes


def steps(rest: Difference, wavelength_nm: float, shift: F64, cos: F64, sin: F64, nodes: tuple[F64, F64]) -> F64:
    """Return W(x − s) − W(x + s) about the move, waves; all arrays of one shape, or shaped to be."""
    along, across = nodes
    plane = np.array(rest.moved_um) / (2.0 * rest.blur_um(wavelength_nm))
    step = 2.0 * shift * (plane[0] * cos + plane[1] * sin)
    for side in (-1.0, 1.0):
        u = along + side * shift
        step = step - side * rest.lens.waves(u * cos - across * sin, u * sin + across * cos, wavelength_nm)
    whole: F64 = step
    return whole


def transfer_of(rest: Difference, wavelength_nm: float, count: int, shift: F64, angle_rad: F64) -> C128:
    """Return transfers (shifts, angles) of the whole lens about the move at one wavelength."""
    samples = np.zeros((shift.size, angle_rad.size, 1, 2))
    add_to(rest, wavelength_nm, count, shift, angle_rad, np.ones(1), samples)
    values: C128 = samples[:, :, 0].view(complex)[..., 0]
    return values


def add_to(
    rest: Difference, wavelength_nm: float, count: int, shift: F64, angle_rad: F64, waves: F64, samples: F64
) -> None:
    """Add transfers (shifts, angles, colours, 2) at ``waves`` evenly spaced multiples of the wavefront at one."""
    along, across, share = overlap_nodes(count, shift)
    cos, sin = np.cos(angle_rad)[:, None], np.sin(angle_rad)[:, None]
    step = steps(rest, wavelength_nm, shift[:, None, None], cos, sin, (along[:, None], across[:, None]))
    shared(shift.size, functools.partial(add_overlaps, step, share, waves, samples))


def direct(rest: Difference, nm: F64, weights: F64, place: F64, count: int) -> C128:
    """Return fused transfers (sets, places) at places (|f| per µm, angle), wavelength by wavelength."""
    blur = np.array([rest.blur_um(w) for w in nm.tolist()])
    each = np.empty((nm.size, place.shape[1]), complex)
    cos, sin = np.cos(place[1])[:, None], np.sin(place[1])[:, None]

    def work(begin: int, stop: int) -> None:
        for j in range(begin, stop):
            shift = np.minimum(place[0] * blur[j], 1.0)
            along, across, share = overlap_nodes(count, shift)
            step = steps(rest, float(nm[j]), shift[:, None], cos, sin, (along, across))
            each[j] = np.sum(share * (np.exp(2j * np.pi * step) - 1.0), axis=1)

    shared(nm.size, work)
    return complex_product(weights.astype(complex), each)
