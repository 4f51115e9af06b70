"""Pictures whose light lies in rings about a place: how far they hear an aberrated lens's rings in step.

Far away such a lens differs from a round one by rings, Re a(r)·exp(2πi·f·r), another a in every direction. Edges hear
few of them, but a picture of rings as wide about one place hears all there, a zone plate many. What a picture V hears
of the rings within a shell of radii and a sector of directions, at all places, is a convolution. In frequencies the
shell is, by stationary phase,

    exp(iπ/4)/√k · ∫ a(r)·√r·exp(2πi·(f − k)·r) dr      in the rings' own direction:

few of them, about |k| = f. As a may turn with the direction, what sectors hear adds up in size.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from camsim.arrays import C64, C128, F64, I64
from camsim.optics import OpticalSystem
from camsim.optics.protocols import KnowsRim
from camsim.rendering.fast_length import fast_length
from camsim.rendering.fields.cover import cover_of
from camsim.rendering.fields.layer import Layer
from camsim.rendering.fields.points import PointLayer
from camsim.rendering.fields.quiet import heard_by
from camsim.rendering.grid import Grid

SECTORS = 16
BESIDE = 4.0  # over the shell's radius: how far from f frequencies are heard
PER_RING = 4.0  # nodes along the radius, of the fastest
FINER = 16  # frequencies of a shell's transform, than it has nodes along the radius
OF_A_WAVE = 1.0 / math.pi  # of the light where rings are bright: what black and white rings send in step
SHORT, FARTHEST = 20.0, 4096.0  # λN: as far as which a pattern may always be taken; as rings of 10⁸ samples may lie
ASKED = 4096  # radii at which it is asked how loud rings may be
MOST = 100_000_000  # samples that are listened to
LITTLE_MORE = 1.3  # times as far, which is no reason to listen


@dataclass(frozen=True, slots=True, kw_only=True)
class FarRings:
    """The rings of a lens's difference, at all wavelengths.

    system : whose lens is the difference;  orders: frequencies of its rings times λN
    wavelength_nm : (j,);  density: (planes, channels, j) of pictures
    """

    system: OpticalSystem
    orders: tuple[float, ...]
    wavelength_nm: F64
    density: F64
    pitch_um: float

    @property
    def blur(self) -> F64:
        """λN (j,), pitches."""
        return self.system.blurs_um(self.wavelength_nm) / self.pitch_um

    @property
    def frequencies(self) -> tuple[float, float]:
        """The lowest and the highest of the rings, cycles/pitch."""
        blur = self.blur
        return min(self.orders) / float(blur.max()), max(self.orders) / float(blur.min())

    def light(self, r: F64) -> F64:
        """Return a(r) at all wavelengths (j, n), 1/pitch²: a line r λN away hears a·√r/2π λN² of them."""
        lens = self.system.lens
        assert isinstance(lens, KnowsRim)
        heard = [lens.rings_beyond(r * self.pitch_um, nm, 1.0) for nm in self.wavelength_nm.tolist()]
        light: F64 = 2.0 * math.pi * np.array(heard) / np.sqrt(r / self.blur[:, None]) / self.blur[:, None] ** 2
        return light

    def waves(self, r: F64) -> C128:
        """Return (j, n) the rings at all wavelengths."""
        turns = 2j * math.pi * r / self.blur[:, None]
        waves: C128 = self.light(r) * sum(np.exp(order * turns) for order in self.orders)
        return waves

    def at_most(self, layers: Sequence[Layer], r: F64) -> F64:
        """Return (n,) what pictures hear of rings beyond radii, if they are in step with all wavelengths'.

        r : evenly apart in log r, some of all radii
        """
        passed = max(heard_by(layers, self.system, self.pitch_um, f) for f in self.frequencies)
        ring = 2.0 * math.pi * r**2 * np.abs(self.density @ self.waves(r)).sum(axis=0).max(axis=0)
        heard: F64 = OF_A_WAVE * passed * np.cumsum(ring[::-1])[::-1] * math.log(r[1] / r[0])
        return heard

    def shells(self, nearest: float, count: int) -> tuple[F64, C64]:
        """Return frequencies k (m,) and shells' transforms (planes, channels, count, m).

        Shell n is loudest at ``nearest``·2ⁿ, ends where the next but one begins, and all together are 1 from there on.
        """
        low, high = self.frequencies
        r = np.arange(0.5 * nearest, nearest * 2.0**count, 1.0 / (PER_RING * high))
        place = np.log2(r / nearest) - np.arange(count)[:, None]
        hems = np.where(np.abs(place) < 1.0, np.cos(0.5 * math.pi * place) ** 2, 0.0)
        waves = np.sqrt(r) * self.waves(r)
        size = fast_length(FINER * r.size, real=False)
        k: F64 = np.arange(float(size)) * (PER_RING * high / size)
        band = (k > max(low - BESIDE / nearest, 0.0)) & (k < high + BESIDE / nearest)
        back: C128 = np.exp(-2j * math.pi * k[band] * r[0]) / np.sqrt(k[band]) / (PER_RING * high)
        found: C64 = np.empty((*self.density.shape[:2], count, back.size), np.complex64)
        for at in np.ndindex(self.density.shape[:2]):
            found[at] = scipy.fft.fft(hems * (self.density[at] @ waves), size, axis=1)[:, band] * back
        return k[band], found


def in_step_until(
    layers: Sequence[Layer | PointLayer], rings: FarRings, grid: Grid, *, nearest: float, within: float, allowed: float
) -> float:
    """Return as far as rings are heard, pitches, that are farther than ``nearest`` and together louder than allowed.

    within : the distance of the farthest sample
    """
    planes = np.split(rings.density, np.cumsum([layer.planes for layer in layers])[:-1])
    pictures = [(layer, own) for layer, own in zip(layers, planes, strict=True) if isinstance(layer, Layer)]
    blur = rings.blur
    nearest, within = max(nearest, SHORT * float(blur.min())), min(within, FARTHEST * float(blur.max()))
    if not pictures or within < LITTLE_MORE * nearest:
        return min(nearest, within)
    r = np.geomspace(nearest, within, ASKED)
    loud = np.flatnonzero(rings.at_most([layer for layer, _ in pictures], r) > allowed)
    if not loud.size:
        return nearest
    farthest = float(r[min(loud[-1] + 1, r.size - 1)])
    windows = [_near(layer, grid, farthest) for layer, _ in pictures]
    samples = sum(len(own) * len(rows) * len(cols) for (_, own), (rows, cols) in zip(pictures, windows, strict=True))
    if farthest <= LITTLE_MORE * nearest or samples > MOST:
        return farthest
    heard = np.zeros(math.ceil(math.log2(farthest / nearest)) + 1)
    for (layer, own), window in zip(pictures, windows, strict=True):
        if all(window):
            heard += _heard(layer, window, dataclasses.replace(rings, density=own), nearest, heard.size)
    loud = np.flatnonzero(np.cumsum(heard[::-1])[::-1] > allowed)
    return min(nearest * 2.0 ** (int(loud[-1]) + 1), farthest) if loud.size else nearest


def _near(layer: Layer, grid: Grid, distance: float) -> tuple[range, range]:
    """Return rows and columns of the samples that lie as near as that to the frame."""
    low = np.array(grid.first_centre) - distance
    high = low + np.array([grid.cols, grid.rows]) - 1.0 + 2.0 * distance
    box = layer.samples_at(np.array([low, (low[0], high[1]), high, (high[0], low[1])]))
    (left, top), (right, bottom) = np.floor(box.min(axis=0)).astype(int), np.ceil(box.max(axis=0)).astype(int)
    return range(max(top, 0), min(bottom, layer.shape[0])), range(max(left, 0), min(right, layer.shape[1]))


def _seen(layer: Layer, rows: range, cols: range) -> F64:
    """Return samples (planes, rows, cols), 0 where nothing is seen of them."""
    seen = layer.coefficients(rows, cols)
    if layer.outline is not None:
        start, end = (side - [cols.start, rows.start] for side in layer.outline)
        cover = cover_of((start, end), (len(rows), len(cols)))
        cover.whole[tuple(cover.cut.T)] = True
        seen *= cover.whole
    return seen


class _Sector(NamedTuple):
    """Frequencies of the rings in some directions: which (n,) of the lattice of all, of the sector's box, of all |k|.

    transfer : (n,) of samples and footprint
    """

    of_all: I64
    of_box: I64
    of_band: I64
    transfer: C128


def _heard(layer: Layer, window: tuple[range, range], rings: FarRings, nearest: float, shells: int) -> F64:
    """Return how much rows and columns of samples hear of every shell, anywhere."""
    k, transforms = rings.shells(nearest, shells)
    seen = _seen(layer, *window)
    count = np.array([fast_length(side, real=False) for side in seen.shape[:0:-1]])  # along u and v
    apart = 1.0 / (count * layer.step)
    box, sectors = _sectors(layer, rings, k, count, apart)
    parts: list[list[C64]] = [[] for _ in sectors]
    for plane in seen:
        lattice = scipy.fft.fft2(plane.astype(np.float32), count[::-1], workers=-1).ravel()
        for own, part in zip(sectors, parts, strict=True):
            part.append((own.transfer * lattice[own.of_all]).astype(np.complex64))
    heard = np.zeros((transforms.shape[1], shells))
    for channel, shell in np.ndindex(heard.shape):
        light = np.zeros(box)
        for own, part in zip(sectors, parts, strict=True):
            waves = np.zeros(box, np.complex64)
            waves.ravel()[own.of_box] = sum(
                plane * transform[own.of_band]
                for plane, transform in zip(part, transforms[:, channel, shell], strict=True)
            )
            light += np.abs(scipy.fft.ifft2(waves, norm="forward", overwrite_x=True, workers=-1))
        heard[channel, shell] = math.prod(apart) * light.max()
    loudest: F64 = heard.max(axis=0)
    return loudest


def _sectors(
    layer: Layer, rings: FarRings, k: F64, count: np.ndarray, apart: F64
) -> tuple[tuple[int, int], list[_Sector]]:
    """Return the sectors of a band of |k| (m,), and rows and columns of the box that each of them fits in.

    count : (2,) frequencies of all along u and v;  apart: (2,) by how much
    """
    half, band = math.pi / SECTORS, (float(k[0]), float(k[-1]))
    middles = 2.0 * half * np.arange(SECTORS)
    rim = middles[:, None, None] + half * np.array([-1.0, 0.0, 1.0])
    corners = np.stack([way(rim) * np.array(band)[:, None] for way in (np.cos, np.sin)]).reshape(2, SECTORS, -1)
    first = np.floor(corners.min(axis=2).T / apart).astype(np.int64)
    sides = (np.ceil(corners.max(axis=2).T / apart).astype(np.int64) - first).max(axis=0) + 1
    across, down = (fast_length(int(side), real=False) for side in sides)
    sectors = []
    for middle, (left, top) in zip(middles, first, strict=True):
        i, j = left + np.arange(across), top + np.arange(down)
        u, v = i * apart[0], (j * apart[1])[:, None]
        turned = np.angle((u + 1j * v) * np.exp(-1j * middle))
        size = np.hypot(u, v)
        own = (size >= band[0]) & (size <= band[1]) & (turned >= -half) & (turned < half)
        row, col = np.nonzero(own)
        u, v = u[col], v[row, 0]
        fx, fy = (u * layer.axes[0, axis] + v * layer.axes[1, axis] for axis in (0, 1))
        passed = rings.system.footprint_otf(fx / rings.pitch_um, fy / rings.pitch_um)
        spline = np.sinc(u * layer.step) * np.sinc(v * layer.step)
        sectors.append(
            _Sector(
                of_all=(j[row] % count[1]) * count[0] + i[col] % count[0],
                of_box=row * across + col,
                of_band=np.rint((size[own] - k[0]) / (k[1] - k[0])).astype(np.int64),
                transfer=layer.step**2 * spline ** (layer.degree + 1) * passed,
            )
        )
    return (down, across), sectors
