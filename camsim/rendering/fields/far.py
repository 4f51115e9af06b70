"""Light from far away: the pattern beyond a taper, its rings averaged, folded with pictures on a coarse lattice.

Samples are put on the lattice's points by the weights of Lagrange's interpolation, which is the same as interpolating
the pattern between them; photosites are interpolated likewise.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import fft

from camsim.arrays import F64, U8
from camsim.optics import OpticalSystem
from camsim.optics.protocols import KnowsEnergy
from camsim.rendering.fields.layer import Layer
from camsim.rendering.fields.samples import samples_of
from camsim.rendering.fourier.taper import taper, tapered

POINTS = 6  # of the interpolation along an axis
FINENESS = 8.0  # lattice points along the taper and along its inner radius, where as much light may be wrong as is
RADII = 2048
BLOCKS = 4.0  # and blocks of samples along a lattice cell


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FarLight:
    """What comes from beyond, on a lattice about a window.

    light : (channels, rows, cols) at the lattice's points
    step  : between them, pitches;  first: (2,) the first one, from the window's first photosite
    """

    light: F64
    step: float
    first: F64

    @classmethod
    def of(
        cls,
        layers: Sequence[Layer],
        *,
        density: F64,
        wavelength_nm: F64,
        system: OpticalSystem,
        pitch_um: float,
        inner: float,
        outer: float,
        sharpness: float,
        light: float,
        origin: tuple[float, float],
        shape: tuple[int, int],
    ) -> FarLight:
        """Fold all of the layers, however large, with the pattern beyond the taper from ``inner`` to ``outer``.

        light : that lies beyond, in units of what may be wrong
        """
        step = min(inner, outer - inner) / (FINENESS * max(light, 1.0) ** (1.0 / POINTS))
        corners = np.concatenate([layer.corners for layer in layers]) - np.array(origin)
        low = np.minimum(corners.min(axis=0), 0.0) - (POINTS + 1) * step
        high = np.maximum(corners.max(axis=0), [shape[1] - 1.0, shape[0] - 1.0]) + (POINTS + 1) * step
        count = np.ceil((high - low) / step).astype(int)[::-1] + POINTS
        size = [fft.next_fast_len(2 * int(n) - 1, real=True) for n in count]
        down, across = (np.minimum(np.arange(n), n - np.arange(n)) for n in size)
        distance = step * np.hypot(down[:, None], across[None, :])
        patterns = _beyond(distance, density, wavelength_nm, system, pitch_um, inner, outer, sharpness)
        total = np.zeros((density.shape[1], size[0], size[1] // 2 + 1), complex)
        plane = 0
        for layer in layers:
            places, given = _gathered(layer, step / BLOCKS, origin)
            for own in given:
                mass = fft.rfft2(_deposited((places - low) / step, own, (int(count[0]), int(count[1]))), s=size)
                for channel in range(density.shape[1]):
                    total[channel] += mass * fft.rfft2(patterns(plane, channel))
                plane += 1
        seen = fft.irfft2(total, s=size)[:, : count[0], : count[1]]
        return cls(light=seen, step=step, first=low)

    def rendered(self, channel: U8) -> F64:
        """Return the light at every photosite, (..., rows, cols), each in its own channel."""
        rows, cols = channel.shape[-2:]
        down, across = (
            _weights((np.arange(n) - low) / self.step) for n, low in ((rows, self.first[1]), (cols, self.first[0]))
        )
        image = np.empty(channel.shape)
        for k in np.unique(channel):
            lines = sum(down[1][t][:, None] * self.light[k][down[0] + t] for t in range(POINTS))
            plane = sum(across[1][t] * lines[:, across[0] + t] for t in range(POINTS))
            mine = channel == k
            image[mine] = np.broadcast_to(plane, channel.shape)[mine]
        return image


def _beyond(
    distance: F64,
    density: F64,
    wavelength_nm: F64,
    system: OpticalSystem,
    pitch_um: float,
    inner: float,
    outer: float,
    sharpness: float,
) -> Callable[[int, int], F64]:
    """Return what gives (1 − taper) × pattern of a plane and a channel: the mean over a ring, per square pitch."""
    lens = system.lens
    assert isinstance(lens, KnowsEnergy)
    # One table of the radius for all: its steps are far below the length over which what is averaged changes.
    radius = np.geomspace(inner, float(distance.max()) + 1.0, RADII)
    rings = []
    for nm in wavelength_nm.tolist():
        half = 0.5 * system.blur_um(nm) / pitch_um
        light = lens.encircled_energy((radius + half) * pitch_um, nm) - lens.encircled_energy(
            (radius - half) * pitch_um, nm
        )
        rings.append(light / (4.0 * math.pi * radius * half))
    weighed = np.einsum("pcj,jr->pcr", density, np.array(rings)) * (
        1.0 - tapered(radius, inner, outer, taper(sharpness))
    )

    def pattern(plane: int, channel: int) -> F64:
        # r³ × pattern is all but constant far out.
        table: F64 = np.interp(distance, radius, weighed[plane, channel] * radius**3, left=0.0)
        table /= np.maximum(distance, inner) ** 3
        return table

    return pattern


def _gathered(layer: Layer, size: float, origin: tuple[float, float]) -> tuple[F64, F64]:
    """Return places (n, 2) and light (planes, n) of a layer, blocks of samples no larger than ``size`` each as one."""
    block = max(1, int(size / layer.step))
    rows, cols = layer.shape
    if layer.outline is None and block > 1 and layer.degree < 2:
        coefficients = layer.coefficients(range(rows), range(cols))
        down, across = np.arange(0, rows, block), np.arange(0, cols, block)
        light = np.add.reduceat(np.add.reduceat(coefficients, down, axis=1), across, axis=2)
        tall, wide = np.minimum(block, rows - down), np.minimum(block, cols - across)
        middle = np.stack(np.meshgrid(across + 0.5 * wide, down + 0.5 * tall), axis=-1).reshape(-1, 2)
        return layer.places(middle) - np.array(origin), layer.step**2 * light.reshape(len(light), -1)
    corners = layer.corners - np.array(origin)
    found = samples_of(layer, corners.min(axis=0), corners.max(axis=0), cut=0.5 / size, allowed=1e-6, origin=origin)
    assert found is not None
    return (
        np.concatenate([found.places, found.points]),
        np.concatenate([found.strengths, found.corrections], axis=1),
    )


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
