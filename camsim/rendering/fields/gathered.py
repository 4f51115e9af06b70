"""A layer's light as far shells of the pattern take it: blocks of samples, each in its middle."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64
from camsim.kept import cached_property
from camsim.rendering.fields.layer import Layer
from camsim.rendering.fields.points import PointLayer
from camsim.rendering.fields.samples import samples_of

NODES_OFF = 1e-6  # relative: nodes where outlines cut
SAMPLES_AT_A_TIME = 1_000_000


class Light(NamedTuple):
    """Light at places (n,), or at all pairs of x (cols,) and y (rows,); pitches from an origin."""

    x: F64
    y: F64
    light: F64  # (modes, n), or (modes, rows, cols)


@dataclass(frozen=True, kw_only=True, eq=False)
class Gathered:
    """A layer seen from an origin, its planes mixed (modes, planes)."""

    layer: Layer | PointLayer
    mixture: F64
    origin: tuple[float, float]

    def parts(self, size: float, low: F64, high: F64) -> Iterator[Light]:
        """Yield the light of all that lies in a box, blocks up to ``size`` each as one."""
        layer, at = self.layer, np.array(self.origin)
        if isinstance(layer, PointLayer):
            yield from self._within(layer.at - at, np.einsum("mp,pn->mn", self.mixture, layer.light), low, high)
            return
        corners = layer.corners - at
        block = max(1, int(size / layer.step))
        if layer.outline is not None or layer.degree > 1 or layer.step > 4.0 * size:
            yield from self._nodes(size, low, high)
            return
        whole = (corners >= low).all() and (corners <= high).all()
        yield from self._whole if whole and block >= 2 else self._blocks(block, low, high)

    @cached_property
    def _whole(self) -> list[Light]:
        """All of it, in blocks of two: later shells are wider, and take no harm."""
        corners = self.layer.corners - np.array(self.origin)
        return list(self._blocks(2, corners.min(axis=0), corners.max(axis=0)))

    def _nodes(self, size: float, low: F64, high: F64) -> Iterator[Light]:
        found = samples_of(self.layer, low, high, cut=0.5 / size, allowed=NODES_OFF, origin=self.origin)
        if found is None:
            return
        places = np.concatenate([found.places, found.points])
        light = np.concatenate([found.strengths, found.corrections], axis=1)
        yield from self._within(places, np.einsum("mp,pn->mn", self.mixture, light), low, high)

    def _blocks(self, block: int, low: F64, high: F64) -> Iterator[Light]:
        layer, at = self.layer, np.array(self.origin)
        assert isinstance(layer, Layer)
        box = np.array([[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]])
        u, v = layer.samples_at(box + at).T
        down, across = (_begins(part, n, block) for part, n in ((v, layer.shape[0]), (u, layer.shape[1])))
        if not len(down) or not len(across):
            return
        tall, wide = np.minimum(block, layer.shape[0] - down), np.minimum(block, layer.shape[1] - across)
        cols = range(across[0], int(across[-1] + wide[-1]))
        signs = layer.axes.sum(axis=0)  # of the steps along x and y, where samples lie along the photosites' rows
        several = max(1, SAMPLES_AT_A_TIME // (block * len(cols)))
        for first in range(0, len(down), several):
            some, deep = down[first : first + several], tall[first : first + several]
            light = layer.coefficients(range(some[0], int(some[-1] + deep[-1])), cols)
            if block > 1:
                light = np.add.reduceat(light, some - some[0], axis=1)
                light = np.add.reduceat(light, across - across[0], axis=2)
            light = np.einsum("mp,pyx->myx", layer.step**2 * self.mixture, light)
            u, v = across + 0.5 * wide, some + 0.5 * deep
            if not layer.upright:
                middle = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
                yield from self._within(layer.places(middle) - at, light.reshape(len(light), -1), low, high)
                continue
            corner = layer.corner - at
            if layer.axes[0, 0] == 0.0:
                light, u, v = light.transpose(0, 2, 1), v, u
            x, y = (begin + layer.step * sign * along for begin, sign, along in zip(corner, signs, (u, v), strict=True))
            in_x, in_y = _in(x, low[0], high[0]), _in(y, low[1], high[1])
            yield Light(x[in_x], y[in_y], np.ascontiguousarray(light[:, in_y, in_x]))

    def _within(self, places: F64, light: F64, low: F64, high: F64) -> Iterator[Light]:
        """Yield what lies in the box: at its rim some reach a little beyond, farther than the pattern."""
        inside = ((places >= low) & (places <= high)).all(axis=1)
        yield Light(places[inside, 0], places[inside, 1], light[:, inside])


def _begins(places: F64, count: int, block: int) -> np.ndarray:
    """Return where blocks of samples begin that touch a box."""
    first = max(0, math.floor(float(places.min()) / block) - 1) * block
    return np.arange(first, min(count, math.ceil(float(places.max())) + block), block)


def _in(places: F64, low: float, high: float) -> slice:
    """Return which of places in order, up or down, lie in a range."""
    inside = np.flatnonzero((places >= low) & (places <= high))
    return slice(int(inside[0]), int(inside[-1]) + 1) if inside.size else slice(0, 0)
