"""The transfer of a lens that is not round, after the taper: its pattern on a lattice, transformed by FFT.

What a spectrum gives a channel at all wavelengths is one pattern: so patterns are weighed and added up before they are
transformed, and there are as many transfers as there are sums.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence

import numpy as np
import scipy

from camsim.arrays import C128, F64
from camsim.kernels import shared
from camsim.kernels.folded import add_folded
from camsim.kernels.threads import MANY
from camsim.optics import OpticalSystem
from camsim.rendering.fourier.blocks import Block
from camsim.rendering.fourier.lens import Fields, parts
from camsim.rendering.fourier.patterns import lattices_of
from camsim.rendering.fourier.plan import Sizes
from camsim.rendering.fourier.taper import taper, tapered
from camsim.rendering.fourier.tile import Tile
from camsim.rendering.psf import point_spread_rows

ROWS = 16  # added up at a time: what stays in a cache


def fields_of(transfers: list[C128]) -> Fields:
    """Return what gives transfers, half planes as of ``tapered_transfers``: block → (transfers, j, i, 2)."""
    rows, columns = transfers[0].shape

    def fields(block: Block) -> F64:
        i = block.first_i + np.arange(block.count_i)
        j = block.first_j + np.arange(block.count_j)
        if i[0] >= 0 and i[-1] < columns and 2 * np.abs(j).max() <= rows:
            some = slice(i[0], i[-1] + 1)
            # Rows go round once at the most. (``take`` would copy all rows of these columns first.)
            first = j[0] % rows
            before = min(j.size, rows - first)
            taken = np.empty((len(transfers), j.size, i.size), complex)
            for own, transfer in zip(taken, transfers, strict=True):
                own[:before] = transfer[first : first + before, some]
                own[before:] = transfer[: j.size - before, some]
            return parts(taken)
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
    axes = [own.step * np.arange(own.first, own.first + own.samples, dtype=float) for own in lattices]
    sizes, steps = [own.size for own in lattices], [own.step for own in lattices]
    shape = taper(tile.sharpness)
    hems = [
        tapered(np.abs(place - middle), inner, outer, shape) * step
        for place, middle, inner, outer, step in zip(axes, tile.middle, tile.inner, tile.outer, steps, strict=True)
    ]
    folded = [np.zeros((sizes[1], sizes[0])) for _ in weights]
    column, row = (own.first for own in lattices)
    for first in range(0, axes[1].size, plan.pattern_rows):
        some = slice(first, min(first + plan.pattern_rows, axes[1].size))
        hem = hems[1][some] * pitch_um**2
        axes_um = axes[0] * pitch_um, axes[1][some] * pitch_um
        for nm, shares in zip(wavelength_nm.tolist(), weights.T.tolist(), strict=True):
            for own, pattern in point_spread_rows(system, *axes_um, nm, precision=precision):
                begin, _, step = own.indices(hem.size)
                place = row + first + begin, column, step
                add_rows = functools.partial(_add_rows, folded, pattern, (hem[own], hems[0]), shares, place)
                # Rows that fall on one row of the period are added up by one thread.
                shared(len(pattern), add_rows, most=MANY if len(pattern) * step <= sizes[1] else 1)
                del pattern, add_rows  # before the next is made
    transfers: list[C128] = []
    while folded:
        transfers.append(scipy.fft.rfft2(folded.pop(0), workers=-1))
    return transfers


def _add_rows(
    folded: Sequence[F64],
    pattern: F64,
    hems: tuple[F64, F64],
    shares: Sequence[float],
    place: tuple[int, int, int],
    begin: int,
    stop: int,
) -> None:
    """Add some rows of a pattern, tapered, to all sums that have a share of it.

    hems : down and across;  place: numbers of the first row and column, and how many from row to row
    """
    (down, across), (first, column, step) = hems, place
    for low in range(begin, max(stop, begin + 1), ROWS):  # once for no rows: what is not compiled yet is then
        some = slice(low, min(low + ROWS, stop))
        for total, share in zip(folded, shares, strict=True):
            if share:
                add_folded(total, pattern[some], down[some], across, share, first + step * low, column, step)
