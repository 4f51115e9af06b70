"""The lens as the Fourier engine multiplies by it: its transfer after the taper, a curve if it is round, or a field.

A round lens is tapered in the plane and projected on a line: by the projection theorem the projection's cosine
transform is the plane's transform along any direction. Both sums are trapezoidal and as good as exact, because the
tapered pattern is band-limited. Any other lens is sampled on a lattice: see sampled_lens.py.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Iterable, Iterator

import numpy as np
import scipy

from camsim.arrays import C128, F64
from camsim.kernels import kernel, shared
from camsim.optics.protocols import Round, Separable
from camsim.optics.system import OpticalSystem
from camsim.radial_profile import DEGREE, MIDDLE, Profile
from camsim.rendering.fast_length import fast_length
from camsim.rendering.fourier.blocks import Block
from camsim.rendering.fourier.joint import joint_transfer
from camsim.rendering.fourier.kernels import Curves, Factors, SceneBlock
from camsim.rendering.fourier.spread import Kernel
from camsim.rendering.fourier.taper import taper, tapered
from camsim.rendering.fourier.tile import Tile

OVERSAMPLED = 16  # of the transfer's curve; with 8 points 2.4e-9 of what oscillates fastest, which is the faintest
CURVE_POINTS = 8
NOTHING = 1e-16  # of a transfer: as much as passes beyond a cut-off


@kernel()
def _project(
    cells: F64, cells_per_pitch: float, outer: float, step_x: float, step_y: float, out: F64, begin: int, end: int
) -> None:
    """Fill in some of (count, columns): Σ over y of a round pattern, at x = 0, step_x, …

    cells : (cells, DEGREE + 1, columns) of ``Profile.powers``
    """
    for i in range(begin, end):
        x = i * step_x
        deepest = int(math.sqrt(max(outer * outer - x * x, 0.0)) / step_y)
        for m in range(deepest + 1):
            y = m * step_y
            place = math.sqrt(x * x + y * y) * cells_per_pitch
            cell = min(int(place), len(cells) - 1)
            t = place - cell - MIDDLE
            share = step_y if m == 0 else 2.0 * step_y
            for q in range(out.shape[1]):
                value = cells[cell, DEGREE, q]
                for d in range(DEGREE - 1, -1, -1):
                    value = value * t + cells[cell, d, q]
                out[i, q] += share * value


def round_curves(
    pattern: Round,
    wavelength_nm: F64,
    weights: F64,
    pitch_um: float,
    kernel: Kernel,
    tile: Tile,
) -> Curves:
    """Return the transfer of a round lens over |k|: coefficients of t⁰ … t⁷ on 0 ≤ t < 1 in every cell.

    weights : (spectra, channels, j)
    """
    inner, outer = tile.inner[0], tile.outer[0]
    flat = weights.reshape(-1, wavelength_nm.size)

    def light(radius_um: F64) -> F64:
        values = np.zeros((radius_um.size, len(flat)))
        for j, wavelength in enumerate(wavelength_nm):
            seen = pattern.point_spread(radius_um, float(wavelength)) * pitch_um**2
            values += seen[:, None] * flat[:, j]
        return values

    along = Profile.of(light, kernel.blur * pitch_um, outer * pitch_um)
    hem = tapered(along.radius_um / pitch_um, inner, outer, taper(tile.sharpness))
    cells = along._replace(values=along.values * hem[..., None]).powers

    highest = tile.cut + kernel.passes - kernel.cutoff  # the samples' own, whatever of it is taken
    step_x, step_y = 0.49 / highest, 0.97 / highest
    samples = math.ceil(outer / step_x) + 1
    line = np.zeros((samples, len(flat)))
    shared(samples, functools.partial(_project, cells, pitch_um / along.cell_um, outer, step_x, step_y, line))
    length = fast_length(max(1024, OVERSAMPLED * samples), real=True)
    padded = np.zeros((len(flat), length + 1))
    padded[:, :samples] = line.T
    transfer = scipy.fft.dct(padded, type=1, axis=1) * step_x
    whole = np.concatenate([transfer[:, 3:0:-1], transfer], axis=1)
    cells_per_frequency = 2.0 * length * step_x
    used = math.ceil(tile.cut * cells_per_frequency) + 1
    window = np.lib.stride_tricks.sliding_window_view(whole[:, : used + CURVE_POINTS - 1], CURVE_POINTS, axis=1)
    curves = np.einsum("qcx,dx->cqd", window, _THROUGH)
    return Curves(curves.reshape(-1, *weights.shape[:2], CURVE_POINTS), cells_per_frequency)


# Rows: coefficients of t^0 … t^7 of the polynomial through values at −3 … 4.
_THROUGH = np.linalg.inv(np.vander(np.arange(-3.0, 5.0), CURVE_POINTS, increasing=True))

Fields = Callable[[Block], F64]


def plain_fields(system: OpticalSystem, wavelength_nm: F64, pitch_um: float, tile: Tile) -> Fields:
    """Return what gives the transfer of a lens whose pattern dies away by itself: block → (wavelengths, j, i, 2)."""

    def fields(block: Block) -> F64:
        fx, fy = frequencies(block, tile, pitch_um)
        out = np.empty((wavelength_nm.size, block.count_j, block.count_i), complex)
        for j, wavelength in enumerate(wavelength_nm):
            out[j] = system.lens.otf(fx, fy, float(wavelength))
        return parts(out)

    return fields


def passing(fields: Fields, blocks: Iterable[tuple[Block, SceneBlock]]) -> Iterator[tuple[Block, SceneBlock, F64]]:
    """Yield of blocks those rows that a lens lets pass anything of, the scene there, and the lens's transfers.

    A thin pattern's band is as much longer one way than the other; blocks are of a round one.
    """
    for block, scene in blocks:
        values = fields(block)
        rows = np.flatnonzero(np.abs(values).max(axis=(0, 2, 3)) > NOTHING)
        if rows.size == block.count_j:
            yield block, scene, values
        elif rows.size:
            first, stop = int(rows[0]), int(rows[-1]) + 1
            own = dataclasses.replace(block, first_j=block.first_j + first, count_j=stop - first)
            transforms = np.ascontiguousarray(scene.transforms[:, first:stop])
            yield own, SceneBlock(transforms, scene.areas), np.ascontiguousarray(values[:, first:stop])


def frequencies(block: Block, tile: Tile, pitch_um: float) -> tuple[F64, F64]:
    """Return the block's fx (1, count_i) and fy (count_j, 1), cycles/µm."""
    fx = (block.first_i + np.arange(block.count_i)) / (tile.periods[0] * pitch_um)
    fy = (block.first_j + np.arange(block.count_j)) / (tile.periods[1] * pitch_um)
    return fx[None], fy[:, None]


def footprint_transfer(system: OpticalSystem, block: Block, tile: Tile, pitch_um: float) -> Factors:
    """Return the transfer of OLPF and photosite on a block."""
    fx, fy = frequencies(block, tile, pitch_um)
    zero = np.zeros((1, 1))
    across, down = np.ones(fx.shape, complex), np.ones(fy.shape, complex)
    for stage in (system.olpf, system.photosite):
        if isinstance(stage, Separable) and stage.separable:
            across *= stage.otf(fx, zero, 0.0)
            down *= stage.otf(zero, fy, 0.0)
    both = joint_transfer(system, fx[0], fy[:, 0])
    return Factors(across=parts(across.ravel()), down=parts(down.ravel()), both=parts(both))


class Footprints:
    """OLPF and photosite on blocks; where they are a product they take no memory, are kept, and serve other tiles."""

    def __init__(self, system: OpticalSystem, pitch_um: float) -> None:
        self._system, self._pitch_um = system, pitch_um
        self._products: dict[tuple[Block, tuple[int, int]], Factors] = {}

    def on(self, block: Block, tile: Tile) -> Factors:
        """Return them on a block of a tile's frequencies."""
        key = block, tile.periods
        found = self._products.get(key)
        if found is None:
            found = footprint_transfer(self._system, block, tile, self._pitch_um)
            if not found.both.size:
                self._products[key] = found
        return found


def parts(values: C128) -> F64:
    """Return complex numbers as real and imaginary part, along a last axis."""
    return np.ascontiguousarray(values).view(np.float64).reshape(*values.shape, 2)
