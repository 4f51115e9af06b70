"""Darks of one ISO setting and time: temporal and fixed-pattern variances, each with its error."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import F64
from camsim.measure.noise.estimate import SURE
from camsim.measure.noise.stack import Chosen, Codes

_DEFECT, _STEADY = 8.0, 4.0
"""Thresholds of a hot photosite: robust standard deviations above the others, and of its temporal noise."""
_BLOCKS = 64


@dataclass(frozen=True, slots=True, kw_only=True)
class Squared:
    """A variance and its standard error; ``null``: the standard error that it would have if there were no variance."""

    dn2: float
    sigma_dn2: float
    null_dn2: float = 0.0

    @property
    def there(self) -> bool:
        """Whether the variance is significantly above 0."""
        return self.dn2 > SURE * max(self.null_dn2, 1e-12)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DarkStatistics:
    """Statistics of darks of one setting, in data numbers; all variances include rounding.

    black_dn, black_sigma_dn : mean code, and its standard error
    cells_dn    : (rows, cols) of the filter array's period: mean codes
    temporal    : variance of a photosite over time, without that shared by its row;  temporal_rows: (rows,) of each row
    rows        : temporal variance shared by a row
    row_power   : (n,) power of row offsets over ``row_frequency`` (n,), cycles per row, DN²: σ² for white noise of σ
    columns     : variance of fixed column offsets
    pattern     : variance of fixed photosite offsets without columns;  pattern_blocks: the same by blocks of rows
    hot         : (rows, cols) mask of hot photosites
    hot_excess_dn : (n,) excess of each hot photosite over the others, in row-major order
    frames      : number of darks
    """

    frames: int
    shape: tuple[int, int]
    black_dn: float
    black_sigma_dn: float
    cells_dn: F64
    temporal: Squared
    temporal_rows: F64
    rows: Squared
    row_frequency: F64
    row_power: F64
    columns: Squared
    column_frequency: F64
    column_power: F64
    pattern: Squared
    pattern_blocks: F64
    hot: Chosen
    hot_excess_dn: F64


def dark_statistics(frames: Sequence[Codes], period: tuple[int, int]) -> DarkStatistics:
    """Reduce two or more darks (rows, cols) of one setting and time.

    period : period of the filter array, whose cells have separate means, as they may have separate black levels
    """
    count, (height, width) = len(frames), frames[0].shape
    mean = np.zeros((height, width))
    for frame in frames:
        mean += frame
    mean /= count
    cells = _cells(mean, period)
    hot, excess = _hot(frames, mean - _tiled(cells, mean.shape))
    its_rows, offsets = np.zeros(height), np.zeros((count, height))
    used = ~hot
    per_row = used.sum(axis=1)
    for k, frame in enumerate(frames):
        off = np.where(used, frame - mean, 0.0)
        row = off.sum(axis=1) / np.maximum(per_row, 1)
        its_rows += np.where(used, (off - row[:, None]) ** 2, 0.0).sum(axis=1)
        offsets[k] = row - row.mean()
    its_rows /= (count - 1) * np.maximum(per_row - 1, 1)
    mean_dn2 = float(its_rows.mean())
    its_sigma = float(its_rows.std(ddof=1)) / math.sqrt(height)
    freedom = (count - 1) * (height - 1)
    whole = float(np.sum(offsets**2)) / freedom
    chance = mean_dn2 / width
    rows = Squared(
        dn2=whole - chance, sigma_dn2=whole * math.sqrt(2.0 / freedom), null_dn2=chance * math.sqrt(2.0 / freedom)
    )
    cells = np.array([
        [float(np.mean(mean[place][used[place]])) if used[place].any() else float(cells[row, col])
         for col, place in enumerate(line)]
        for row, line in enumerate(_lattices(period))
    ])  # fmt: skip
    fixed = np.where(used, mean - _tiled(cells, mean.shape), 0.0)
    columns, blocks, of_columns = _fixed(fixed, used, its_rows / count)
    scatter = float(blocks.std(ddof=1)) / math.sqrt(blocks.size) if blocks.size > 1 else float(abs(blocks[0]))
    pattern = Squared(dn2=float(blocks.mean()), sigma_dn2=scatter, null_dn2=scatter)
    frame_means = np.array([float(frame.mean(dtype=np.float64)) for frame in frames])
    black_sigma = math.sqrt(
        max(float(frame_means.var(ddof=1)) / count, (mean_dn2 / width + max(rows.dn2, 0.0)) / (height * count))
        + max(pattern.dn2, 0.0) / fixed.size + max(columns.dn2, 0.0) / width
    )  # fmt: skip
    power = np.mean(np.abs(np.fft.rfft(offsets, axis=1)) ** 2, axis=0) / height * count / (count - 1)
    column_power = np.abs(np.fft.rfft(of_columns)) ** 2 / width
    return DarkStatistics(
        frames=count,
        shape=(height, width),
        black_dn=float(np.mean(mean[used])),
        black_sigma_dn=black_sigma,
        cells_dn=cells,
        temporal=Squared(dn2=mean_dn2, sigma_dn2=its_sigma),
        temporal_rows=its_rows,
        rows=rows,
        row_frequency=np.arange(1, height // 2 + 1) / height,
        row_power=power[1:],
        columns=columns,
        column_frequency=np.arange(1, width // 2 + 1) / width,
        column_power=column_power[1:],
        pattern=pattern,
        pattern_blocks=blocks,
        hot=hot,
        hot_excess_dn=excess,
    )


def _cells(mean: F64, period: tuple[int, int]) -> F64:
    return np.array([[float(np.median(mean[place])) for place in line] for line in _lattices(period)])


def _lattices(period: tuple[int, int]) -> list[list[tuple[slice, slice]]]:
    rows, cols = period
    return [[(slice(row, None, rows), slice(col, None, cols)) for col in range(cols)] for row in range(rows)]


def _tiled(cells: F64, shape: tuple[int, ...]) -> F64:
    tiles = -(-shape[0] // cells.shape[0]), -(-shape[1] // cells.shape[1])
    whole: F64 = np.tile(cells, tiles)[: shape[0], : shape[1]]
    return whole


def _hot(frames: Sequence[Codes], above: F64) -> tuple[Chosen, F64]:
    """Return a mask of hot photosites, and the excess of each.

    Photosites with telegraph noise or an outlier from a heavy tail are excluded by their temporal scatter.
    """
    scale = 1.4826 * float(np.median(np.abs(above - np.median(above))))
    candidates = np.nonzero(above > _DEFECT * max(scale, 0.2))
    hot = np.zeros(above.shape, dtype=bool)
    if not candidates[0].size:
        return hot, above[hot]
    seen = np.stack([frame[candidates] for frame in frames]).astype(np.float64)
    steady = above[candidates] > _STEADY * seen.std(axis=0, ddof=1)
    hot[candidates[0][steady], candidates[1][steady]] = True
    return hot, above[hot]


def _fixed(fixed: F64, used: Chosen, noise_rows: F64) -> tuple[Squared, F64, F64]:
    """Return the variance of columns, that of photosites in blocks of rows (n,), and the columns' offsets (cols,).

    noise_rows : (rows,) variance that temporal noise leaves in the mean of the darks
    """
    height, width = fixed.shape
    per_column = np.maximum(used.sum(axis=0), 1)
    # Row differences come from temporal row noise in these few frames, not from the sensor's pattern.
    centred = np.where(used, fixed - (fixed.sum(axis=1) / np.maximum(used.sum(axis=1), 1))[:, None], 0.0)
    offsets = centred.sum(axis=0) / per_column
    rest = np.where(used, centred - offsets, 0.0)
    blocks = np.array_split(np.arange(height), min(_BLOCKS, height))
    lost = (1.0 - 1.0 / height) * (1.0 - 1.0 / width)
    within = np.array([np.sum(rest[rows] ** 2) / max(used[rows].sum(), 1) for rows in blocks]) / lost
    noisy = np.array([noise_rows[rows].mean() for rows in blocks])
    spatial = float(within.mean())
    whole, noise = float(offsets.var(ddof=1)), spatial / height
    columns = Squared(
        dn2=whole - noise, sigma_dn2=whole * math.sqrt(2.0 / (width - 1)), null_dn2=noise * math.sqrt(2.0 / (width - 1))
    )
    return columns, within - noisy, offsets
