"""Distortion and lateral colour from any picture of a dot grid at an unknown position and distance.

The dots lie in a square lattice, seen in perspective. A projection and a radial polynomial about the picture's middle,
fitted jointly to the dots of the reference channel, separate perspective from distortion; lateral colour is the
displacement of the same dots in the other channels.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import scipy

from camsim.core.arrays import F64
from camsim.errors import UnsupportedError
from camsim.measure.distortion.marks import Marks, locate_mark
from camsim.measure.geometry import Roi
from camsim.measure.given import check_given
from camsim.measure.lattice import homography, lattices, moved
from camsim.measure.picture import Channel, Picture

_LEAST, _MOST = 20, 4000
_SMALLEST = 12.0
"""Fewest samples of a channel that a dot covers."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GridDot:
    """One dot in one channel: its position in pixels, and its displacement from where a projection alone puts it."""

    channel: str
    x_pixel: float
    y_pixel: float
    dx_pixel: float
    dy_pixel: float
    error_pixel: float


@dataclass(frozen=True, slots=True, kw_only=True)
class GridChannel:
    """Lateral colour of one channel.

    lateral_rms_pixel, lateral_largest_pixel : distance to the same dots in the reference channel; None in that one
    """

    channel: str
    dots: tuple[GridDot, ...]
    lateral_rms_pixel: float | None
    lateral_largest_pixel: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class GridReport:
    """Distortion of one picture.

    k1, k2 : at (x, y) from the middle the image is displaced by (x, y)·(k1·r² + k2·r⁴), r in half diagonals of the
             picture; negative k1: barrel;  with their standard errors
    largest_distortion : k1·r² + k2·r⁴ at the farthest dot, a fraction of its radius
    rms_pixel : residuals of the reference channel's dots after projection and polynomial
    """

    file: str
    reference: str
    half_diagonal_pixel: float
    k1: float
    k2: float
    k1_error: float
    k2_error: float
    largest_distortion: float
    largest_distortion_error: float
    rms_pixel: float
    channels: tuple[GridChannel, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return the result as plain values for JSON."""
        return {"chart": "dot-grid", **asdict(self)}


def measure_grid(picture: Picture, *, progress: Callable[[str, float], None] | None = None) -> GridReport:
    """Measure distortion and lateral colour in a picture of a grid of round dots, dark on bright or bright on dark.

    The grid is square; it need not be parallel to the sensor. Raises UnsupportedError where fewer than 20 dots are
    found.
    """
    check_given(picture=picture)
    channels = picture.select("all")
    reference = next((channel for channel in channels if channel.name.startswith("G")), channels[0])
    places, marks = _grid_of(reference, picture)
    seen: dict[str, dict[tuple[int, int], tuple[float, float, float]]] = {}
    for done, channel in enumerate([reference, *(each for each in channels if each is not reference)]):
        if progress is not None:
            progress("marks", done / len(channels))
        seen[channel.name] = _located(channel, picture, places, marks)
    fitted = seen[reference.name]
    if len(fitted) < _LEAST:
        raise _refused(picture, len(fitted))
    return _report(picture, reference.name, fitted, seen)


def _refused(picture: Picture, count: int) -> UnsupportedError:
    return UnsupportedError(
        f"shows {count} dots of a grid, and {_LEAST} are needed: round, even, in a square lattice, each of "
        f"{_SMALLEST:g} photosites of a channel or more",
        stage=picture.name,
    )


def _grid_of(channel: Channel, picture: Picture) -> tuple[dict[tuple[int, int], F64], Marks]:
    """Return the centres of the dots, pixels, by grid index, and a description of the dots."""
    signal, x, y = channel.on_a_lattice(Roi(0, 0, *picture.shape))
    # Compensate for shading: compare each place with its surroundings.
    low, high = (scipy.ndimage.gaussian_filter(part, max(signal.shape) / 16.0) for part in (signal, signal**2))
    off = (signal - low) / np.sqrt(np.maximum(high - low**2, 1e-12 * float(np.abs(signal).max()) ** 2 + 1e-30))
    # Dots cover less than the surface between them.
    sign = -1.0 if float(np.mean(off**3)) < 0.0 else 1.0
    labels, count = scipy.ndimage.label(sign * off > 0.5)
    numbers = np.arange(1, count + 1)
    areas = np.asarray(scipy.ndimage.sum_labels(np.ones_like(off), labels, numbers), np.float64)
    middles = np.array(scipy.ndimage.center_of_mass(sign * off, labels, numbers)).reshape(-1, 2)
    large = areas >= _SMALLEST
    step = float(x[1] - x[0]), float(y[1] - y[0])
    pixels = np.stack([x[0] + step[0] * middles[large, 1], y[0] + step[1] * middles[large, 0]], axis=1)
    sizes = areas[large] * step[0] * step[1]
    best = next(iter(lattices(pixels, sizes, least=_LEAST, most=_MOST)), None)
    if best is None:
        raise _refused(picture, 0)
    apart = [
        float(np.hypot(*(best[col + 1, row] - middle))) for (col, row), middle in best.items() if (col + 1, row) in best
    ]
    radius = math.sqrt(float(np.median(sizes)) / math.pi)
    marks = Marks(
        kind="dot-grid", places_um=np.zeros((0, 2)), reach_um=0.5 * float(np.median(apart)), size_um=radius,
        turn_rad=0.0, surfaces=(0.0, 1.0),
    )  # fmt: skip
    return best, marks


def _located(
    channel: Channel, picture: Picture, places: dict[tuple[int, int], F64], marks: Marks
) -> dict[tuple[int, int], tuple[float, float, float]]:
    """Return x, y and their standard error of each complete dot of a channel."""
    found = {}
    reach = marks.reach_um
    size = math.ceil(2.0 * reach) + 1
    for place, (x, y) in places.items():
        row, col = math.floor(y - reach), math.floor(x - reach)
        if row < 0 or col < 0 or row + size > picture.shape[0] or col + size > picture.shape[1]:
            continue
        samples = channel.inside(Roi(row, col, size, size))
        near = np.hypot(samples.x - x, samples.y - y) <= reach
        fitted = locate_mark(samples.x[near] - x, samples.y[near] - y, samples.signal[near], marks, 1.0)
        if fitted is not None:
            found[place] = (x + fitted[0], y + fitted[1], fitted[2])
    return found


def _report(
    picture: Picture,
    reference: str,
    fitted: dict[tuple[int, int], tuple[float, float, float]],
    seen: dict[str, dict[tuple[int, int], tuple[float, float, float]]],
) -> GridReport:
    grid = np.array(list(fitted), np.float64)
    half = 0.5 * math.hypot(*picture.shape)
    middle = np.array([0.5 * picture.shape[1], 0.5 * picture.shape[0]])
    places = (np.array([place[:2] for place in fitted.values()]) - middle) / half
    start = homography(grid, places)
    start /= start[2, 2]

    def bent(p: F64) -> F64:
        flat = moved(np.append(p[:8], 1.0).reshape(3, 3), grid)
        r2 = (flat**2).sum(axis=1)[:, None]
        seen: F64 = flat * (1.0 + p[8] * r2 + p[9] * r2**2)
        return seen

    def off(p: F64) -> F64:
        missed: F64 = (bent(p) - places).ravel()
        return missed

    first = np.concatenate([start.ravel()[:8], [0.0, 0.0]])
    fit = scipy.optimize.least_squares(off, first, x_scale="jac", method="lm")
    slopes = np.asarray(fit.jac, np.float64)
    variance = 2.0 * fit.cost / max(places.size - 10, 1)
    covariance = variance * np.linalg.pinv(slopes.T @ slopes)[8:, 8:]
    projection, (k1, k2) = np.append(fit.x[:8], 1.0).reshape(3, 3), fit.x[8:].tolist()
    flat = moved(projection, grid)
    farthest = float((flat**2).sum(axis=1).max())
    powers = np.array([farthest, farthest**2])
    return GridReport(
        file=picture.name,
        reference=reference,
        half_diagonal_pixel=half,
        k1=k1,
        k2=k2,
        k1_error=math.sqrt(covariance[0, 0]),
        k2_error=math.sqrt(covariance[1, 1]),
        largest_distortion=float(powers @ np.array([k1, k2])),
        largest_distortion_error=math.sqrt(max(float(powers @ covariance @ powers), 0.0)),
        rms_pixel=half * math.sqrt(2.0 * 2.0 * fit.cost / places.size),
        channels=tuple(
            _channel(name, found, seen[reference], projection, middle, half) for name, found in seen.items()
        ),
    )


def _channel(
    name: str,
    found: dict[tuple[int, int], tuple[float, float, float]],
    reference: dict[tuple[int, int], tuple[float, float, float]],
    projection: F64,
    middle: F64,
    half: float,
) -> GridChannel:
    flat = middle + half * moved(projection, np.array(list(found), np.float64).reshape(-1, 2))
    dots = tuple(
        GridDot(
            channel=name, x_pixel=x, y_pixel=y, dx_pixel=x - float(at[0]), dy_pixel=y - float(at[1]), error_pixel=error
        )
        for (x, y, error), at in zip(found.values(), flat, strict=True)
    )
    apart = [
        math.hypot(x - reference[place][0], y - reference[place][1])
        for place, (x, y, _) in found.items()
        if place in reference
    ]
    lateral = None if found is reference or not apart else math.sqrt(sum(d * d for d in apart) / len(apart))
    return GridChannel(
        channel=name,
        dots=dots,
        lateral_rms_pixel=lateral,
        lateral_largest_pixel=None if lateral is None else max(apart),
    )
