"""The exact Fourier engine: any lens, any photosite (docs/fourier.md has its error model).

The transform of the regions is known exactly, edge by edge. Times the transfer of every stage, added up over the
aliases of the photosites' lattice, and one inverse transform per channel: that is the image, with a kernel tapered to
0 before the period could wrap it round (fourier_plan.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy import fft

from camsim.arrays import F64, I64, U8
from camsim.errors import InvalidValueError
from camsim.optics import OpticalSystem
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.fourier_edges import add_fields, add_round
from camsim.rendering.fourier_lens import (
    Fields,
    footprint_transfer,
    kernel_of,
    plain_fields,
    round_curves,
    tapered_fields,
)
from camsim.rendering.fourier_plan import PART, FourierPlan, Kernel, Tile, Work, blocks, plan_fourier
from camsim.rendering.fourier_scene import Regions, clamped
from camsim.rendering.kernels import ONE_AT_A_TIME

FINEST, COARSEST = 1e-11, 1e-2
MEMORY_LIMIT_BYTES = 2e9


def fourier_image(
    *,
    start: F64,
    end: F64,
    left: I64,
    right: I64,
    density: F64,
    base: F64,
    wavelength_nm: F64,
    system: OpticalSystem,
    pitch_um: float,
    origin: tuple[float, float],
    channel: U8,
    tolerance: float,
    memory_limit_bytes: float = MEMORY_LIMIT_BYTES,
    progress: Callable[[float], None] = lambda done: None,
) -> F64:
    """Render every photosite in its own channel.

    start, end    : (n, 2) the edges, pitches; the regions they bound are closed
    left, right   : (n,) spectrum on either side of each, 0 the background
    density       : (spectra, channels, j) what each spectrum gives each channel at each wavelength
    base          : (channels,) the background
    wavelength_nm : (j,)
    origin        : x, y of the first photosite's centre, pitches
    channel       : (rows, cols) index of each photosite's channel
    tolerance     : largest error, in the unit of ``density``
    progress      : told the fraction done
    returns       : (rows, cols)

    Raises InvalidValueError for a tolerance out of range, or where it would take more memory than the limit.
    """
    check_tolerance(tolerance)
    image = base[channel]
    if not len(start) or not np.any(density[1:] != density[0]):
        progress(1.0)
        return image
    if not system.chromatic:
        density, wavelength_nm = density.sum(axis=2, keepdims=True), wavelength_nm[:1]
    work = _Work(system, pitch_um, wavelength_nm, density, tolerance)
    start, end = start - origin, end - origin
    kernel = kernel_of(system, wavelength_nm, pitch_um, tolerance)
    plan = work.plan(kernel, start, end, channel, memory_limit_bytes)
    if plan.memory_bytes > memory_limit_bytes:
        raise InvalidValueError(
            f"method: fourier would take {plan.memory_bytes / 1e9:.1f} GB for this frame and scene, and its limit is "
            f"{memory_limit_bytes / 1e9:.1f} GB; render a smaller region, allow a larger tolerance, or use boundary"
        )
    for done, tile in enumerate(plan.tiles):
        part = (slice(tile.row, tile.row + tile.rows), slice(tile.col, tile.col + tile.cols))
        first = np.array([tile.col, tile.row], float)
        low, high = np.array(tile.low), np.array(tile.high)
        begins, ends, kept = clamped(start - first, end - first, low, high)
        if not kept.size:
            continue  # all that could be seen lies elsewhere
        regions = Regions.of(begins, ends, left[kept] - 1, right[kept] - 1, tile, plan, len(density) - 1, tolerance)
        image[part] += work.image(tile, plan, kernel, regions, channel[part])
        progress((done + 1) / len(plan.tiles))
    return image


def fourier_cost(
    *,
    start: F64,
    end: F64,
    density: F64,
    wavelength_nm: F64,
    system: OpticalSystem,
    pitch_um: float,
    origin: tuple[float, float],
    channel: U8,
    tolerance: float,
    memory_limit_bytes: float = MEMORY_LIMIT_BYTES,
) -> tuple[float, float, float]:
    """Return the expected time (s, one core), memory (bytes) and number of frequencies.

    Arguments as for ``fourier_image``.
    """
    if not len(start):
        return 0.0, 8.0 * channel.size, 0.0
    if not system.chromatic:
        density, wavelength_nm = density[..., :1], wavelength_nm[:1]
    work = _Work(system, pitch_um, wavelength_nm, density, tolerance)
    kernel = kernel_of(system, wavelength_nm, pitch_um, tolerance)
    plan = work.plan(kernel, start - origin, end - origin, channel, memory_limit_bytes)
    return plan.seconds, plan.memory_bytes, sum(tile.points for tile in plan.tiles)


def check_tolerance(tolerance: float) -> None:
    """Refuse what the engine cannot promise."""
    if not FINEST <= tolerance <= COARSEST:
        raise InvalidValueError(
            f"tolerance: {tolerance:g} is outside {FINEST:g} … {COARSEST:g}, what the Fourier engine renders to"
        )


@dataclass(frozen=True, slots=True, eq=False)
class _Work:
    """What stays the same over the tiles of one rendering; fields as in ``fourier_image``."""

    system: OpticalSystem
    pitch_um: float
    wavelength_nm: F64
    density: F64
    tolerance: float

    def plan(self, kernel: Kernel, start: F64, end: F64, channel: U8, memory_limit_bytes: float) -> FourierPlan:
        """Choose tiles and settings."""
        corners = np.concatenate([start, end])
        spots, photosite = np.abs(self.system.spots_um()).max(axis=0), self.system.photosite.half_extent_um
        spectra, channels, wavelengths = self.density.shape
        longest = 2.0 * (sum(channel.shape) + 4.0 * kernel.reach)  # that an edge may be once it is clamped
        return plan_fourier(
            kernel,
            shape=(channel.shape[0], channel.shape[1]),
            low=corners.min(axis=0),
            high=corners.max(axis=0),
            footprint=(float(spots[0] + photosite[0]) / self.pitch_um, float(spots[1] + photosite[1]) / self.pitch_um),
            work=Work(
                edges=len(start),
                length=float(np.minimum(np.hypot(*(end - start).T), longest).sum()),
                spectra=spectra - 1,
                channels=channels,
                wavelengths=wavelengths,
            ),
            tolerance=self.tolerance,
            memory_limit_bytes=memory_limit_bytes,
        )

    def image(self, tile: Tile, plan: FourierPlan, kernel: Kernel, regions: Regions, channel: U8) -> F64:
        """Return the tile's image, each photosite in its own channel, less the background."""
        image = np.empty(channel.shape)
        present = np.unique(channel)
        for first in range(0, present.size, plan.channels):
            some = present[first : first + plan.channels]
            total = self._spectrum(tile, plan, kernel, regions, (self.density[1:] - self.density[0])[:, some])
            for k, values in zip(some, total, strict=True):
                plane = _inverse(values.view(complex)[..., 0], tile)
                mine = channel == k
                image[mine] = plane[mine]
        return image

    def _spectrum(self, tile: Tile, plan: FourierPlan, kernel: Kernel, regions: Regions, contrast: F64) -> F64:
        """Return the image's transform on the photosites' grid of frequencies: (channels, py, px//2 + 1, 2).

        contrast : (spectra, channels, j) against the background
        """
        # Filled here: threads that touch fresh pages at once wait for one another.
        total = np.full((contrast.shape[1], tile.periods[1], tile.periods[0] // 2 + 1, 2), 0.0)
        if kernel.round:
            curves, per_frequency = round_curves(
                self.system, self.wavelength_nm, contrast, self.pitch_um, kernel, tile, plan
            )
            for block in blocks(tile, plan.block_points):
                transforms = regions.transforms(block)
                footprint = footprint_transfer(self.system, block, tile, self.pitch_um)
                corner, place = (block.first_i, block.first_j), (block.column, block.row)
                with ONE_AT_A_TIME:
                    add_round(
                        total,
                        transforms,
                        regions.areas,
                        footprint,
                        curves,
                        per_frequency,
                        corner,
                        tile.periods,
                        tile.cut,
                        place,
                    )
            return total
        for fields, weights in self._fields(tile, plan, kernel, contrast):
            for block in blocks(tile, plan.block_points):
                transforms = regions.transforms(block)
                footprint = footprint_transfer(self.system, block, tile, self.pitch_um)
                values = fields(block)
                corner, place = (block.first_i, block.first_j), (block.column, block.row)
                with ONE_AT_A_TIME:
                    add_fields(
                        total,
                        transforms,
                        regions.areas,
                        footprint,
                        values,
                        weights,
                        corner,
                        tile.periods,
                        tile.cut,
                        place,
                    )
        return total

    def _fields(self, tile: Tile, plan: FourierPlan, kernel: Kernel, contrast: F64) -> Iterator[tuple[Fields, F64]]:
        """Yield what gives the lens on a block, and the weights of its wavelengths."""
        if not kernel.tapered:
            yield plain_fields(self.system, self.wavelength_nm, self.pitch_um, tile), np.ascontiguousarray(contrast)
            return
        precision = ErrorBudget(self.tolerance).allowed("pupil")
        for j, wavelength in enumerate(self.wavelength_nm):
            one = tapered_fields(self.system, float(wavelength), self.pitch_um, tile, plan, precision=precision)
            yield one, np.ascontiguousarray(contrast[:, :, j : j + 1])


def _inverse(values: F64, tile: Tile) -> F64:
    """Return the tile's photosites from their frequencies (py, px//2 + 1); ``values`` is lost.

    First down the columns, some at a time, of which only the tile's rows are kept; then along those.
    """
    px, py = tile.periods
    # A short kernel's period may be less than the tile: what repeats is then the empty background.
    rows, cols = np.arange(tile.rows) % py, np.arange(tile.cols) % px
    lines = np.empty((tile.rows, values.shape[1]), complex)
    step = max(1, PART // py)
    for first in range(0, values.shape[1], step):
        part = np.ascontiguousarray(values[:, first : first + step])
        lines[:, first : first + step] = fft.ifft(part, axis=0, overwrite_x=True, workers=-1)[rows]
    image = np.empty((tile.rows, tile.cols))
    step = max(1, PART // px)
    for first in range(0, tile.rows, step):
        image[first : first + step] = fft.irfft(lines[first : first + step], n=px, axis=1, workers=-1)[:, cols]
    return image
