"""A picture thinned for low frequencies: light on a coarser lattice, with the picture's transform up to a frequency.

The picture is summed over a Kaiser–Bessel kernel φ at each of its points, c_m = ∫ picture(x)·φ(x/D − m)·dx, along rows
and columns. The sum's transform is the picture's times φ's, but for aliases, which φ suppresses. Splines are cut at
the picture's border. The next coarser lattice is made from the one before.
"""

from __future__ import annotations

import functools
import math
from typing import Any, NamedTuple

import numpy as np
import scipy

from camsim.core.arrays import F64, distinct
from camsim.numerics.quadrature import gauss_legendre, gauss_order
from camsim.rendering.fields.layer import Layer, basis, mirrored
from camsim.scene import Picture

HIGHEST = 0.25  # cycles per coarse sample: the highest frequency
PER_SAMPLE = 8  # spacings are multiples of a sample's 1/8, so that frames with nearly the same lens share lattices
FEWEST = 7  # coarse samples across the kernel
EXACT = 1e-11  # relative error of the quadrature of splines
MOST_KEPT = 8


class Thinned(NamedTuple):
    """Light (planes, rows, cols) on a lattice along the picture's axes; lengths in the picture's samples.

    whole : the same (rows, cols) of a picture of ones
    first : of both axes, the position of the first coarse sample from the picture's corner
    steps : spacings, first those of the lattices that this one was made from;  width: of the kernel, coarse samples
    """

    light: F64
    whole: F64
    first: float
    steps: tuple[float, ...]
    width: int

    def within(self, count: int, low: float, high: float) -> range:
        """Return which of ``count`` coarse samples lie between two positions, with one on either side."""
        first, last = ((end - self.first) / self.steps[-1] for end in (low, high))
        return range(max(math.floor(first), 0), min(math.ceil(last) + 1, count))

    def part(self, layer: Layer, rows: range, cols: range) -> F64:
        """Return the light of a layer's planes (planes, rows, cols) at a part of the samples."""
        part = slice(rows.start, rows.stop), slice(cols.start, cols.stop)
        whole = self.whole[part]
        light = self.light[:, *part] - layer.offset[:, None, None] * whole
        return np.concatenate([light, whole[None]]) if layer.ones else light

    def passes(self, frequency: F64) -> F64:
        """Return the factor that gives the picture's transform along an axis, at frequencies in cycles per sample."""
        beta = _beta(self.width)
        passes = np.ones_like(frequency)
        for step in self.steps:
            x = np.sqrt(np.maximum(beta**2 - (math.pi * self.width * step * frequency) ** 2, 1.0))
            passes *= x / np.sinh(x)
        return passes * (scipy.special.i0(beta) / self.width) ** len(self.steps)


class _Samples:
    """A layer's samples, equal to any others of the same numbers; cached lattices must not hold the layer."""

    def __init__(self, layer: Layer) -> None:
        assert isinstance(layer.picture, Picture)
        self.layer: Layer | None = layer
        self.key = layer.picture.sha256, layer.picture.planes.shape, layer.degree

    def __hash__(self) -> int:
        return hash(self.key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Samples) and self.key == other.key


def spacing(layer: Layer, cut: float) -> float:
    """Return the spacing of coarse samples for frequencies up to ``cut`` cycles/pitch, in samples of the picture."""
    return math.floor(PER_SAMPLE * HIGHEST / (cut * layer.step)) / PER_SAMPLE


def thinned(layer: Layer, cuts: tuple[float, ...], precision: float) -> Thinned:
    """Return a picture that nothing hides, with transforms up to the last of some falling ``cuts``, cycles/pitch."""
    samples, width = _Samples(layer), FEWEST
    while (x := math.pi * width * math.sqrt(1.0 - 2.0 * HIGHEST)) / math.sinh(x) > 0.5 * precision:
        width += 1
    made = _thinned(samples, tuple(spacing(layer, cut) for cut in cuts), width)
    samples.layer = None
    return made


@functools.lru_cache(maxsize=MOST_KEPT)
def _thinned(samples: _Samples, steps: tuple[float, ...], width: int) -> Thinned:
    layer, step = samples.layer, steps[-1]
    assert layer is not None
    if len(steps) == 1:
        planes, light_at = [*layer.splines, np.ones(layer.shape)], [_sums(n, layer.degree) for n in layer.shape]
    else:
        finer = _thinned(samples, steps[:-1], width)
        planes, shape = [*finer.light, finer.whole], finer.whole.shape
        light_at = [(np.arange(n) * steps[-2] + finer.first, _same(n)) for n in shape]
    down, across = (_gather(place / step, width) @ light for place, light in light_at)
    light = np.stack([(across @ np.ascontiguousarray((down @ plane).T)).T for plane in planes])
    light.flags.writeable = False
    first = step * math.ceil(float(light_at[0][0][0]) / step - 0.5 * width)
    return Thinned(light[:-1], light[-1], first, steps, width)


def _same(count: int) -> Any:
    return scipy.sparse.eye_array(count, format="csr")


def _beta(width: int) -> float:
    return math.pi * width * (1.0 - HIGHEST)


def _gather(place: F64, width: int) -> Any:
    """Return the matrix that sums light at rising places (n,), in coarse samples, over the kernel at coarse samples."""
    first = np.ceil(place - 0.5 * width).astype(np.int64)
    points = first[:, None] + np.arange(width)
    across = 2.0 / width * (place[:, None] - points)
    beta = _beta(width)
    kernel = scipy.special.i0(beta * np.sqrt(np.maximum(1.0 - across**2, 0.0))) / scipy.special.i0(beta)
    rows, cols = points - first[0], np.broadcast_to(np.arange(place.size)[:, None], points.shape)
    shape = int(points[-1, -1] - first[0]) + 1, place.size
    return scipy.sparse.csr_array((kernel.ravel(), (rows.ravel(), cols.ravel())), shape)


def _sums(count: int, degree: int) -> tuple[np.ndarray, Any]:
    """Return places (n,) along a line of samples, and the matrix that gives the light there of spline coefficients."""
    half = 0.0 if degree == 0 else 0.5
    ends = distinct(np.concatenate([[0.0], np.arange(count) + half, [float(count)]]))
    x, w = gauss_legendre(gauss_order(math.pi * HIGHEST, EXACT) + degree)
    place = ends[:-1, None] + np.diff(ends)[:, None] * 0.5 * (1.0 + x)
    weight = np.diff(ends)[:, None] * 0.5 * w
    knot = np.floor(0.5 * (ends[:-1] + ends[1:]) - half)
    values = weight * basis(degree, place - half - knot[:, None])
    first = knot.astype(np.int64) - max((degree + 1) // 2 - 1, 0)
    indices = mirrored(range(-degree, count + degree), count)[first + degree + np.arange(degree + 1)[:, None]]
    rows, cols = np.broadcast_to(np.arange(place.size).reshape(place.shape), values.shape), indices[:, :, None]
    entries = values.ravel(), (rows.ravel(), np.broadcast_to(cols, values.shape).ravel())
    return place.ravel(), scipy.sparse.csr_array(entries, (place.size, count))
