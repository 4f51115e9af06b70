"""Light from far away: the pattern beyond a taper, its rings averaged, folded with pictures on coarse lattices.

Shell by shell, each twice as far out and on a lattice twice as coarse. Samples are put on the lattice's points by the
weights of Lagrange's interpolation, which is the same as interpolating the pattern between them; photosites are
interpolated likewise.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy import fft

from camsim.arrays import F64, U8
from camsim.optics import OpticalSystem
from camsim.optics.protocols import KnowsEnergy
from camsim.rendering.fields.layer import Layer
from camsim.rendering.fields.samples import samples_of
from camsim.rendering.fourier.taper import taper, tapered

NODES_OFF = 1e-6  # relative: nodes where outlines cut
POINTS = 8  # of the interpolation along an axis
FINENESS = 6.0  # lattice points along the taper and its inner radius, where as much light may be wrong as is there
RADII = 512  # of a shell's table
GROWTH = 2.0  # from one shell to the next

Pattern = Callable[[F64], F64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Beyond:
    """The pattern beyond a taper, and what it falls on.

    density, wavelength_nm : as of the picture's rendering;  inner, outer, sharpness: of the taper, pitches
    light : that lies beyond, in units of what may be wrong
    """

    layers: Sequence[Layer]
    density: F64
    wavelength_nm: F64
    system: OpticalSystem
    pitch_um: float
    inner: float
    outer: float
    sharpness: float
    light: float

    def rendered(self, origin: tuple[float, float], channel: U8) -> F64:
        """Return the light at every photosite (..., rows, cols) from beyond, shell by shell, each twice as far out.

        origin : x, y of the first photosite's centre, pitches
        """
        image = np.zeros(channel.shape)
        size = np.array([channel.shape[-1] - 1.0, channel.shape[-2] - 1.0])
        corners = np.concatenate([layer.corners for layer in self.layers]) - np.array(origin)
        span = float(np.hypot(*np.maximum(np.maximum(corners.max(axis=0), size - corners.min(axis=0)), 0.0)))
        tapers = [(self.inner, self.outer)]
        while tapers[-1][0] < span:
            radius = max(GROWTH * tapers[-1][0], tapers[-1][1])
            tapers.append((radius, GROWTH * radius))
        for near, far in pairwise(tapers):
            image += self._shell(near, far, origin, size, channel)
        return image

    def _shell(
        self, near: tuple[float, float], far: tuple[float, float], origin: tuple[float, float], size: F64, channel: U8
    ) -> F64:
        """Return the light of the pattern between two tapers."""
        light = max(self.light * self.inner / near[0], 1.0)
        step = min(near[0], near[1] - near[0]) / (FINENESS * light ** (1.0 / POINTS))
        # A block of side b for its samples: b²/24 times the pattern's second derivative, 12/r² of it.
        block = min(step, near[0] * math.sqrt(2.0 / light))
        rim = (POINTS + 1) * step
        corners = np.concatenate([layer.corners for layer in self.layers]) - np.array(origin)
        low = np.minimum(np.maximum(corners.min(axis=0), -far[1]), 0.0) - rim
        high = np.maximum(np.minimum(corners.max(axis=0), size + far[1]), size) + rim
        count = np.ceil((high - low) / step).astype(int)[::-1] + POINTS
        length = [fft.next_fast_len(int(n + math.ceil(far[1] / step) + 1), real=True) for n in count]
        down, across = (np.minimum(np.arange(n), n - np.arange(n)) for n in length)
        distance = step * np.hypot(down[:, None], across[None, :])
        weighed = self._averaged(near, far)
        total = np.zeros((self.density.shape[1], length[0], length[1] // 2 + 1), complex)
        plane = 0
        for layer in self.layers:
            places, given = _gathered(layer, block, low + rim, high - rim, origin)
            for own in given:
                mass = fft.rfft2(_deposited((places - low) / step, own, (int(count[0]), int(count[1]))), s=length)
                for k in range(self.density.shape[1]):
                    total[k] += mass * fft.rfft2(weighed(plane, k)(distance))
                plane += 1
        lattice = fft.irfft2(total, s=length)
        return _at_photosites(lattice, step, low, channel)

    def _averaged(self, near: tuple[float, float], far: tuple[float, float]) -> Callable[[int, int], Pattern]:
        """Return what gives the pattern between two tapers, of a plane and a channel: the mean over a ring."""
        lens = self.system.lens
        assert isinstance(lens, KnowsEnergy)
        radius, rings = np.geomspace(near[0], far[1], RADII), []
        for nm in self.wavelength_nm.tolist():
            half = 0.5 * self.system.blur_um(nm) / self.pitch_um
            within = [lens.encircled_energy((radius + sign * half) * self.pitch_um, nm) for sign in (1.0, -1.0)]
            rings.append((within[0] - within[1]) / (4.0 * math.pi * radius * half))
        first = taper(self.sharpness)
        shell = tapered(radius, *far, first) - tapered(radius, *near, first)
        # r³ × pattern is all but constant far out.
        values = np.einsum("pcj,jr->pcr", self.density, np.array(rings)) * shell * radius**3

        def pattern(plane: int, channel: int) -> Pattern:
            from scipy import interpolate  # a tenth of a second that most captures can do without

            curve = interpolate.CubicSpline(np.log(radius), values[plane, channel])

            def at(distance: F64) -> F64:
                inside = (distance >= near[0]) & (distance <= far[1])
                light = np.zeros(distance.shape)
                light[inside] = curve(np.log(distance[inside])) / distance[inside] ** 3
                return light

            return at

        return pattern


def _at_photosites(light: F64, step: float, first: F64, channel: U8) -> F64:
    """Return what a lattice of light (channels, rows, cols) is at every photosite, each in its own channel."""
    rows, cols = channel.shape[-2:]
    down, across = _weights((np.arange(rows) - first[1]) / step), _weights((np.arange(cols) - first[0]) / step)
    image = np.empty(channel.shape)
    for k in np.unique(channel):
        lines = sum(down[1][t][:, None] * light[k][down[0] + t] for t in range(POINTS))
        plane = sum(across[1][t] * lines[:, across[0] + t] for t in range(POINTS))
        mine = channel == k
        image[mine] = np.broadcast_to(plane, channel.shape)[mine]
    return image


def _gathered(layer: Layer, size: float, low: F64, high: F64, origin: tuple[float, float]) -> tuple[F64, F64]:
    """Return places (n, 2) and light (planes, n) of a layer in a box, blocks of samples up to ``size`` each as one."""
    block = max(1, int(size / layer.step))
    if layer.outline is None and layer.degree < 2 and layer.step <= 4.0 * size:
        box = np.array([[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]])
        u, v = layer.samples_at(box + np.array(origin)).T
        down, across = (_blocks(part, n, block) for part, n in ((v, layer.shape[0]), (u, layer.shape[1])))
        if not len(down) or not len(across):
            return np.empty((0, 2)), np.empty((layer.planes, 0))
        window = (
            range(down[0], min(layer.shape[0], down[-1] + block)),
            range(across[0], min(layer.shape[1], across[-1] + block)),
        )
        coefficients = layer.coefficients(*window)
        light = np.add.reduceat(np.add.reduceat(coefficients, down - down[0], axis=1), across - across[0], axis=2)
        tall, wide = np.minimum(block, layer.shape[0] - down), np.minimum(block, layer.shape[1] - across)
        middle = np.stack(np.meshgrid(across + 0.5 * wide, down + 0.5 * tall), axis=-1).reshape(-1, 2)
        places, light = layer.places(middle) - np.array(origin), layer.step**2 * light.reshape(len(light), -1)
    else:
        found = samples_of(layer, low, high, cut=0.5 / size, allowed=NODES_OFF, origin=origin)
        if found is None:
            return np.empty((0, 2)), np.empty((layer.planes, 0))
        places = np.concatenate([found.places, found.points])
        light = np.concatenate([found.strengths, found.corrections], axis=1)
    # Blocks and nodes at the rim of the box lie a little beyond it, farther than the pattern reaches.
    inside = ((places >= low) & (places <= high)).all(axis=1)
    return places[inside], light[:, inside]


def _blocks(places: F64, count: int, block: int) -> np.ndarray:
    """Return where blocks of samples begin that touch a box."""
    first = max(0, math.floor(float(places.min()) / block) - 1) * block
    return np.arange(first, min(count, math.ceil(float(places.max())) + block), block)


def _deposited(places: F64, light: F64, shape: tuple[int, int]) -> F64:
    """Return light at places (n, 2), in steps, put on a lattice (rows, cols)."""
    across, down = _weights(places[:, 0]), _weights(places[:, 1])
    grid = np.zeros(shape[0] * shape[1])
    for i in range(POINTS):
        for j in range(POINTS):
            at = (down[0] + i) * shape[1] + across[0] + j
            grid += np.bincount(at, weights=light * down[1][i] * across[1][j], minlength=grid.size)
    return grid.reshape(shape)


def _weights(places: F64) -> tuple[np.ndarray, F64]:
    """Return the first of the lattice points about each place, and Lagrange's weights (POINTS, n) of them."""
    first = np.floor(places).astype(np.int64) - (POINTS // 2 - 1)
    t = places - first
    weights = np.ones((POINTS, places.size))
    for k in range(POINTS):
        for other in range(POINTS):
            if other != k:
                weights[k] *= (t - other) / (k - other)
    return first, weights
