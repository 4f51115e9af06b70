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
from typing import NamedTuple

import numpy as np
import scipy

from camsim.arrays import F64, U8
from camsim.optics import OpticalSystem
from camsim.optics.protocols import KnowsEnergy
from camsim.rendering.fast_length import fast_length
from camsim.rendering.fields.far_kernels import POINTS, deposit, deposit_rows, read
from camsim.rendering.fields.gathered import Gathered
from camsim.rendering.fields.layer import Layer
from camsim.rendering.fields.points import PointLayer
from camsim.rendering.fourier.taper import taper, tapered
from camsim.rendering.modes import mixed
from camsim.rendering.spectral import Signals, fuse

MODES_OFF = 0.02  # planes made fewer, of what may be wrong
FUSED_OFF = 1e-6  # relative: wavelengths
FINENESS = 6.0  # lattice points along the taper and its inner radius, where as much light may be wrong as is there
RADII = 512  # of a shell's table
GROWTH = 2.0  # from one shell to the next


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shell:
    """What a ring of the pattern throws on a window, on a lattice.

    lattice : (channels, …);  step: between its points;  first: x, y of the first, from the window's first photosite
    """

    lattice: F64
    step: float
    first: F64

    def add(self, row: int, channel: U8, image: F64) -> None:
        """Add it to photosites (..., rows, cols) from a row of the window on."""
        images = channel.reshape(-1, *channel.shape[-2:])
        read(self.lattice, self.step, self.first, row, images, image.reshape(images.shape))


@dataclass(frozen=True, kw_only=True, eq=False)
class Beyond:
    """The pattern beyond a taper, and what it falls on.

    density, wavelength_nm : as of the picture's rendering;  inner, outer, sharpness: of the taper, pitches
    light : that lies beyond, in units of what may be wrong
    """

    layers: Sequence[Layer | PointLayer]
    density: F64
    wavelength_nm: F64
    system: OpticalSystem
    pitch_um: float
    inner: float
    outer: float
    sharpness: float
    light: float

    def shells(self, origin: tuple[float, float], shape: tuple[int, int]) -> list[Shell]:
        """Return the light from beyond at photosites (rows, cols), shell by shell, each twice as far out.

        origin : x, y of the first photosite's centre, pitches
        """
        size = np.array([shape[1] - 1.0, shape[0] - 1.0])
        corners = np.concatenate([layer.corners for layer in self.layers]) - np.array(origin)
        span = float(np.hypot(*np.maximum(np.maximum(corners.max(axis=0), size - corners.min(axis=0)), 0.0)))
        tapers = [(self.inner, self.outer)]
        while tapers[-1][0] < span:
            radius = max(GROWTH * tapers[-1][0], tapers[-1][1])
            tapers.append((radius, GROWTH * radius))
        log_radius = np.linspace(math.log(self.inner), math.log(tapers[-1][1]), RADII * len(tapers))
        few = _few(self._averaged(np.exp(log_radius)), MODES_OFF / max(self.light, 1.0))
        first = np.cumsum([0, *(layer.planes for layer in self.layers)]).tolist()
        gathered = [
            Gathered(layer=layer, mixture=few.mixture[:, a:b], origin=origin)
            for layer, (a, b) in zip(self.layers, pairwise(first), strict=True)
        ]
        patterns = scipy.interpolate.CubicSpline(log_radius, few.patterns, axis=1)
        return [self._shell(near, far, size, gathered, patterns, few.weights) for near, far in pairwise(tapers)]

    def _shell(
        self,
        near: tuple[float, float],
        far: tuple[float, float],
        size: F64,
        gathered: Sequence[Gathered],
        patterns: Callable[[F64], F64],
        weights: F64,
    ) -> Shell:
        """Return the light of the pattern between two tapers; ``patterns``, ``weights``: see ``Few``, by log r."""
        light = max(self.light * self.inner / near[0], 1.0)
        step = min(near[0], near[1] - near[0]) / (FINENESS * light ** (1.0 / POINTS))
        # A block of side b for its samples: b²/24 times the pattern's second derivative, 12/r² of it.
        block = min(step, near[0] * math.sqrt(2.0 / light))
        rim = (POINTS + 1) * step
        corners = np.concatenate([own.layer.corners - np.array(own.origin) for own in gathered])
        low = np.minimum(np.maximum(corners.min(axis=0), -far[1]), 0.0) - rim
        high = np.maximum(np.minimum(corners.max(axis=0), size + far[1]), size) + rim
        count = np.ceil((high - low) / step).astype(int)[::-1] + POINTS
        length = [fast_length(int(n + math.ceil(far[1] / step) + 1), real=True) for n in count]
        mass = np.zeros((len(weights), *length))
        for own in gathered:
            for x, y, given in own.parts(block, low + rim, high - rim):
                put = deposit_rows if given.ndim == 3 else deposit
                put((x - low[0]) / step, (y - low[1]) / step, given, mass)
        down, across = (np.minimum(np.arange(n), n - np.arange(n)) for n in length)
        # A quarter of the pattern is all of it.
        distance = step * np.hypot(*np.meshgrid(*(np.arange(n // 2 + 1.0) for n in length), indexing="ij"))
        inside = (distance >= near[0]) & (distance <= far[1])
        radius = np.geomspace(near[0], far[1], RADII)
        first = taper(self.sharpness)
        shell = scipy.interpolate.CubicSpline(radius, tapered(radius, *far, first) - tapered(radius, *near, first))
        falls = shell(distance[inside]) / distance[inside] ** 3
        log_distance = np.log(distance[inside])
        light_of = [scipy.fft.rfft2(own, workers=-1) for own in mass]
        del mass
        totals = np.zeros((weights.shape[1], *light_of[0].shape), complex)
        pattern = np.zeros(distance.shape)
        for m, own in enumerate(patterns(log_distance)):
            pattern[inside] = own * falls
            whole = scipy.fft.rfft2(pattern[np.ix_(down, across)], workers=-1)
            for total, its in zip(totals, weights[..., m].T, strict=True):
                seen = its[0] * light_of[0]
                for weight, other in zip(its[1:], light_of[1:], strict=True):
                    seen += weight * other
                seen *= whole
                total += seen
        del light_of
        lattice = np.empty((len(totals), *count))
        for own, total in zip(lattice, totals, strict=True):
            own[...] = scipy.fft.irfft2(total, s=length, workers=-1)[: count[0], : count[1]]
        return Shell(lattice=lattice, step=step, first=low)

    def _averaged(self, radius: F64) -> F64:
        """Return r³ times the pattern's mean over a ring, (planes, channels, radii): all but constant far out.

        Few wavelengths do: without its rings the pattern is smooth in them.
        """
        lens, rings = self.system.lens, []
        assert isinstance(lens, KnowsEnergy)
        signals = Signals(wavelength_nm=self.wavelength_nm, density=self.density, scale=np.ones(self.density.shape[1]))
        wavelength_nm, density = fuse(signals, phase=0.0, allowed=FUSED_OFF)
        for nm in wavelength_nm.tolist():
            half = 0.5 * self.system.blur_um(nm) / self.pitch_um
            within = [lens.encircled_energy((radius + sign * half) * self.pitch_um, nm) for sign in (1.0, -1.0)]
            rings.append((within[0] - within[1]) / (4.0 * math.pi * radius * half))
        averaged: F64 = np.einsum("pcj,jr->pcr", density, np.array(rings)) * radius**3
        return averaged


class Few(NamedTuple):
    """Patterns of all planes in all channels as sums of few: Σ mixture[q, plane]·weights[q, channel, m]·patterns[m]."""

    mixture: F64
    weights: F64
    patterns: F64  # (m, radii)


def _few(curves: F64, off: float) -> Few:
    """Return few mixtures of the planes and few patterns for curves (planes, channels, radii), relative to the largest.

    Patterns are of length 1 and at right angles: what weights are wrong by, m of them, curves are by √m times.
    """
    planes, channels, radii = curves.shape
    allowed = 0.5 * off * float(np.abs(curves).max())
    patterns, shares = mixed(curves.reshape(-1, radii), allowed)
    by_plane = shares.T.reshape(planes, -1)
    weights, mixture = mixed(by_plane, allowed / math.sqrt(len(patterns)))
    return Few(mixture, weights.reshape(-1, channels, len(patterns)), patterns)
