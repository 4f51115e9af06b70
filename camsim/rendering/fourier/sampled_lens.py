"""The transfer of a lens that is not round, after the taper: its pattern on a lattice, transformed by FFT.

What a spectrum gives a channel at all wavelengths is one pattern: so patterns are weighed and added up before they are
transformed, and there are as many transfers as there are sums.
"""

from __future__ import annotations

import math

import numpy as np
import scipy

from camsim.arrays import C128, F64
from camsim.optics import OpticalSystem
from camsim.rendering.fast_length import fast_length
from camsim.rendering.fourier.blocks import Block, Tile
from camsim.rendering.fourier.lens import Fields, parts
from camsim.rendering.fourier.plan import Sizes
from camsim.rendering.fourier.taper import taper, tapered
from camsim.rendering.psf import point_spread_of


def fields_of(transfers: list[C128]) -> Fields:
    """Return what gives transfers, half planes as of ``tapered_transfers``: block → (transfers, j, i, 2)."""
    rows, columns = transfers[0].shape

    def fields(block: Block) -> F64:
        i = block.first_i + np.arange(block.count_i)
        j = block.first_j + np.arange(block.count_j)
        # The half plane i ≥ 0 is there; the rest is its mirror image.
        mirrored = i < 0
        place = np.where(mirrored[None], -j[:, None], j[:, None]) % rows, np.minimum(np.abs(i), columns - 1)[None]
        taken = np.stack([transfer[place] for transfer in transfers])
        # Where the band ends sooner along x or along y there is nothing beyond.
        taken[:, 2 * np.abs(j) > rows] = 0.0
        taken[:, :, np.abs(i) >= columns] = 0.0
        return parts(np.where(mirrored, taken.conj(), taken))

    return fields


def tapered_transfers(
    system: OpticalSystem,
    wavelength_nm: F64,
    weights: F64,
    pitch_um: float,
    tile: Tile,
    plan: Sizes,
    *,
    cuts: tuple[float, float],
    precision: float,
) -> list[C128]:
    """Return half planes i ≥ 0 of sums of a lens's transfers, tapered to a rectangle; rows go round.

    weights : (transfers, n) what each takes of the pattern at every wavelength
    cuts    : the highest frequencies along x and along y, cycles/pitch
    """
    axes: list[F64] = []
    steps: list[float] = []
    sizes: list[int] = []
    for period, outer, cut in zip(tile.periods, tile.outer, cuts, strict=True):
        size = fast_length(math.ceil(2.04 * cut * period) + 1)
        step = period / size
        reach = math.floor(outer / step)
        axes.append(step * np.arange(-reach, reach + 1.0))
        steps.append(step)
        sizes.append(size)
    shape = taper(plan.sharpness)
    hems = [
        tapered(np.abs(place), inner, outer, shape) * step
        for place, inner, outer, step in zip(axes, tile.inner, tile.outer, steps, strict=True)
    ]
    folded = [np.zeros((sizes[1], sizes[0])) for _ in weights]
    reach = axes[1].size // 2
    strips = math.ceil(axes[0].size * axes[1].size * (1 + len(weights) // 8) / plan.pattern_samples)
    rows = min(sizes[1], math.ceil(axes[1].size / strips))  # of a strip no two fall on one of the period
    for first in range(0, axes[1].size, rows):
        some = slice(first, min(first + rows, axes[1].size))
        sums = np.zeros((len(weights), some.stop - some.start, axes[0].size))
        for nm, shares in zip(wavelength_nm.tolist(), weights.T.tolist(), strict=True):
            pattern = point_spread_of(system, axes[0] * pitch_um, axes[1][some] * pitch_um, nm, precision=precision)
            for total, share in zip(sums, shares, strict=True):
                if share:
                    total += pattern if share == 1.0 else share * pattern
        for own, total in zip(folded, sums, strict=True):
            total *= hems[0] * pitch_um**2
            total *= hems[1][some, None]
            own[np.arange(some.start - reach, some.stop - reach) % sizes[1]] += fold(total, sizes[0], 1)
        del sums
    transfers: list[C128] = []
    while folded:
        transfers.append(scipy.fft.rfft2(folded.pop(0), workers=-1))
    return transfers


def fold(values: F64, size: int, axis: int) -> F64:
    """Add up samples −n … n modulo ``size``, the one at 0 first."""
    reach = values.shape[axis] // 2
    moved = np.moveaxis(values, axis, 0)
    out = np.zeros((size, *moved.shape[1:]))
    first = -reach
    while first <= reach:
        place = first % size
        last = min(reach, first + size - 1 - place)
        out[place : place + last - first + 1] += moved[first + reach : last + reach + 1]
        first = last + 1
    return np.moveaxis(out, 0, axis)
