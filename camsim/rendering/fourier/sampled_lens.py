"""The transfer of a lens that is not round, after the taper: its pattern on a lattice, transformed by FFT.

What a spectrum gives a channel at all wavelengths is one pattern: so patterns are weighed and added up before they are
transformed, and there are as many transfers as there are sums.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import scipy

from camsim.arrays import C128, F64
from camsim.optics import OpticalSystem
from camsim.rendering.fourier.blocks import Block, Tile
from camsim.rendering.fourier.lens import Fields, parts
from camsim.rendering.fourier.plan import Sizes
from camsim.rendering.fourier.taper import taper, tapered
from camsim.rendering.fourier.task import lattices_of
from camsim.rendering.psf import point_spread_of

ROWS = 256  # added up at a time: what is held besides


def fields_of(transfers: list[C128]) -> Fields:
    """Return what gives transfers, half planes as of ``tapered_transfers``: block → (transfers, j, i, 2)."""
    rows, columns = transfers[0].shape

    def fields(block: Block) -> F64:
        i = block.first_i + np.arange(block.count_i)
        j = block.first_j + np.arange(block.count_j)
        if i[0] >= 0 and i[-1] < columns and 2 * np.abs(j).max() <= rows:
            some = slice(i[0], i[-1] + 1)
            return parts(np.stack([np.take(transfer[:, some], j % rows, axis=0) for transfer in transfers]))
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
    lattices = lattices_of(cuts, tile)
    axes = [step * np.arange(-reach, reach + 1.0) for _, step, reach in lattices]
    sizes, steps = [own.size for own in lattices], [own.step for own in lattices]
    shape = taper(plan.sharpness)
    hems = [
        tapered(np.abs(place), inner, outer, shape) * step
        for place, inner, outer, step in zip(axes, tile.inner, tile.outer, steps, strict=True)
    ]
    folded = [np.zeros((sizes[1], sizes[0])) for _ in weights]
    reach = axes[1].size // 2
    rows = math.ceil(axes[1].size / math.ceil(axes[0].size * axes[1].size / plan.pattern_samples))
    for first in range(0, axes[1].size, rows):
        some = slice(first, min(first + rows, axes[1].size))
        for nm, shares in zip(wavelength_nm.tolist(), weights.T.tolist(), strict=True):
            pattern = point_spread_of(system, axes[0] * pitch_um, axes[1][some] * pitch_um, nm, precision=precision)
            pattern *= hems[0] * pitch_um**2
            pattern *= hems[1][some, None]
            for own, share in zip(folded, shares, strict=True):
                if share:
                    add_folded(own, pattern, (first - reach, -(axes[0].size // 2)), share)
            del pattern  # before the next is made
    transfers: list[C128] = []
    while folded:
        transfers.append(scipy.fft.rfft2(folded.pop(0), workers=-1))
    return transfers


def add_folded(total: F64, values: F64, first: tuple[int, int], share: float) -> None:
    """Add a share of samples to those of a period, modulo its sides; ``first``: row and column of the first one."""
    for row, down in _pieces(first[0], values.shape[0], total.shape[0]):
        for column, across in _pieces(first[1], values.shape[1], total.shape[1]):
            for begin in range(down.start, down.stop, ROWS):
                some = slice(begin, min(begin + ROWS, down.stop))
                place = slice(row + begin - down.start, row + some.stop - down.start)
                own = values[some, across]
                total[place, column : column + own.shape[1]] += own if share == 1.0 else share * own


def _pieces(first: int, count: int, size: int) -> Iterator[tuple[int, slice]]:
    """Yield the places of a period that samples in a row begin at, and which of them go on from there."""
    done = 0
    while done < count:
        place = (first + done) % size
        stop = min(count, done + size - place)
        yield place, slice(done, stop)
        done = stop
