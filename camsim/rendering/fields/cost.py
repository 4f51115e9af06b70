"""What pictures take: a window's seconds and bytes, layer by layer."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64
from camsim.errors import InvalidValueError
from camsim.optics import OpticalSystem
from camsim.optics.protocols import KnowsReach
from camsim.rendering.fields.layer import Layer
from camsim.rendering.fields.points import PointLayer
from camsim.rendering.fourier.patterns import STRIP_BYTES, made_bytes, pattern_of, rows_at_once, samples_of
from camsim.rendering.fourier.prices import PER_PUPIL_NODE
from camsim.rendering.fourier.spread import Kernel
from camsim.rendering.fourier.task import PART_OF_MEMORY, TRANSFER_BYTES
from camsim.rendering.fourier.tile import Tile
from camsim.rendering.fourier.window import SAMPLE_BYTES, line_seconds
from camsim.words import both

STRIP_POINTS = 2_500_000  # frequencies that are spread to at a time
PREFERRED_BYTES, MOST_OVERHEAD = 4e8, 1.3  # of a tile, where more of them do not take much longer
OF_ALL = 0.5  # of the memory, that all transfers at once may take: patterns are computed once then

# Seconds of one core, measured.
PER_POINT_WEIGHT, PER_POINT, PER_SAMPLE, PER_SAMPLE_STRIP = 8e-9, 1.6e-7, 2e-7, 1.2e-7
PER_LATTICE_SAMPLE, PER_WAVE, PER_POINT_CURVE = 4e-8, 3e-8, 2e-9
PER_TRANSFORMED, PER_TILE = 4e-8, 5e-3


class Taken(NamedTuple):
    """Seconds of one core, and bytes held."""

    seconds: float
    held_bytes: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Prices:
    """What layers behind a lens take, tile by tile.

    steps : of the layers' samples once they are refined
    shape : planes of all layers, channels, wavelengths
    """

    layers: Sequence[Layer | PointLayer]
    steps: Sequence[float]
    kernel: Kernel
    shape: tuple[int, int, int]
    memory_limit_bytes: float

    def fields(self, tile: Tile) -> int:
        """Return how many transfers of a lens that is not round are held at a time: if they fit, all that there are.

        That is one for each wavelength, or for each plane in each channel; in parts it is wavelengths.
        """
        planes, channels, wavelengths = self.shape
        all_of_them = min(planes * channels, wavelengths)
        fitting = self.memory_limit_bytes / (TRANSFER_BYTES * samples_of(self.kernel, tile))
        return all_of_them if all_of_them <= OF_ALL * fitting else max(1, int(PART_OF_MEMORY * fitting))

    def of(self, tiles: Iterable[tuple[tuple[F64, F64], Tile, Sequence[bool]]]) -> Taken:
        """Return what tiles take: the box of each one's samples, and which layers are lattices there."""
        planes, channels, wavelengths = self.shape
        seconds, memory, made = 0.0, 0.0, set[tuple[int, int]]()
        for box, tile, aligned in tiles:
            transfers, held = 1, 0.0
            if self.kernel.round:
                seconds += line_seconds(self.kernel, wavelengths, tile.outer[0]) if tile.periods not in made else 0.0
                made.add(tile.periods)
            else:
                fields = self.fields(tile) if self.kernel.tapered else wavelengths
                transfers = fields if fields == min(planes * channels, wavelengths) else wavelengths
                if self.kernel.tapered:
                    own = _of_transfers(self.kernel, tile, wavelengths, transfers, fields)
                    held = own.held_bytes
                    # Tiles of one size share them.
                    seconds += own.seconds if tile.periods not in made or fields < transfers else 0.0
                    made.add(tile.periods)
            each = [
                taken(layer, step, box, tile, channels=channels, transfers=transfers, aligned=along)
                for layer, step, along in zip(self.layers, self.steps, aligned, strict=True)
            ]
            seconds += PER_TILE + sum(one.seconds for one in each)
            memory = max(memory, held + sum(one.held_bytes for one in each))
        return Taken(seconds, memory)


def unknown_reach(system: OpticalSystem, extent: F64) -> str:
    """Return why a pattern is wanted so far out, photosites, where stages do not say how far they go."""
    stages = (system.lens, *system.more)
    unknown = [type(stage).__name__ for stage in stages if not isinstance(stage, KnowsReach)]
    if not unknown:
        return ""
    far = " × ".join(f"{apart:.0f}" for apart in extent)
    return (
        f": how far {both(unknown)} spreads light is not known (reach_um(lost_fraction, wavelength_nm) would say it), "
        f"so that all of the scene counts, {far} photosites; give a smaller scene"
    )


def too_large(needed_bytes: float, limit_bytes: float, why: str) -> InvalidValueError:
    """Return the error of what takes more memory than the limit; ``why``: of ``unknown_reach``."""
    return InvalidValueError(
        f"pictures would take {needed_bytes / 1e9:.1f} GB for this frame and lens, and the limit is "
        f"{limit_bytes / 1e9:.1f} GB{why}; render a smaller region, or allow a larger tolerance",
        key="method",
    )


def quickest(
    each: Sequence[tuple[int, Taken]], row_bytes: Mapping[int, float], memory_limit_bytes: float
) -> tuple[int, Taken]:
    """Return the side of tiles that keeps within the memory, and little of it where that is not much slower.

    each : sides, with what their tiles take;  row_bytes : of each side, what a row of tiles takes besides
    """
    fitting = [one for one in each if one[1].held_bytes + row_bytes[one[0]] <= memory_limit_bytes]
    if not fitting:
        return min(each, key=lambda one: one[1].held_bytes + row_bytes[one[0]])
    most = MOST_OVERHEAD * min(taken.seconds for _, taken in fitting)
    quick = [one for one in fitting if one[1].seconds <= most]
    return next((one for one in quick if one[1].held_bytes <= PREFERRED_BYTES), quick[0])


def pattern_rows(kernel: Kernel, tile: Tile) -> int:
    """Return how many rows of a pattern are made at a time."""
    return rows_at_once(kernel, pattern_of(kernel, tile), STRIP_BYTES)


def _of_transfers(kernel: Kernel, tile: Tile, wavelengths: int, transfers: int, fields: int) -> Taken:
    """Return what transfers of a lens that is not round take: ``fields`` of them at a time, of so many in all."""
    samples, (rows, columns), own = samples_of(kernel, tile), pattern_of(kernel, tile), pattern_rows(kernel, tile)
    held = (SAMPLE_BYTES + TRANSFER_BYTES * (fields - 1)) * samples + made_bytes(kernel, own, columns)
    seconds = PER_PUPIL_NODE * kernel.pupil_nodes(*tile.spans) * math.ceil(rows / own)
    seconds += kernel.pattern_seconds * wavelengths * rows * columns + PER_TRANSFORMED * transfers * samples
    return Taken(seconds, held)


def taken(
    layer: Layer | PointLayer,
    step: float,
    box: tuple[F64, F64],
    tile: Tile,
    *,
    channels: int,
    transfers: int,
    aligned: bool,
) -> Taken:
    """Return what a layer takes on a window.

    step    : of its samples once they are refined;  box: that they lie in
    transfers : of the lens;  aligned: whether samples are a lattice
    """
    planes = layer.planes
    area = float(np.prod(np.maximum(box[1] - box[0], 0.0)))
    samples = min(area, layer.shape[0] * layer.shape[1] * layer.step**2) / step**2
    period = float(tile.periods[0] * tile.periods[1])
    if aligned:
        frequencies = period / step**2
        seconds = planes * (samples + frequencies) * PER_LATTICE_SAMPLE
        seconds += channels * tile.points * (PER_WAVE + planes * PER_POINT_CURVE)
        held = planes * (24.0 * samples + 12.0 * frequencies) + 24.0 * tile.cut * tile.periods[0] * tile.rows
        return Taken(seconds, held)
    seconds = tile.points * planes * (channels * transfers * PER_POINT_WEIGHT + PER_POINT)
    seconds += samples * (PER_SAMPLE + planes * PER_SAMPLE_STRIP * max(1.0, tile.points / STRIP_POINTS))
    held = 8.0 * channels * period + samples * (40.0 + 40.0 * planes)
    return Taken(seconds, held + 16.0 * min(STRIP_POINTS, 2.0 * tile.points) * (planes + 12))


def windows(shape: tuple[int, int], side: int) -> list[tuple[int, int, int, int]]:
    """Return windows (row, col, rows, cols) of a frame, about alike.

    >>> windows((5, 3), 4)
    [(0, 0, 3, 3), (3, 0, 2, 3)]
    """
    rows, cols = (-(-size // -(-size // side)) for size in shape)
    return [
        (row, col, min(rows, shape[0] - row), min(cols, shape[1] - col))
        for row in range(0, shape[0], rows)
        for col in range(0, shape[1], cols)
    ]
