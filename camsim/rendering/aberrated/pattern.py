"""The difference's pattern, wavelengths fused: its transfer on a window's frequencies, what it shows beside lines."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy

from camsim.arrays import C128, F64
from camsim.nonuniform import along_line, at_points
from camsim.optics import OpticalSystem
from camsim.optics.difference import Difference
from camsim.quadrature import quintic_cells
from camsim.rendering.aberrated.settings import Settings
from camsim.rendering.fast_length import fast_length
from camsim.rendering.fourier.blocks import Block
from camsim.rendering.fourier.lens import footprint_transfer
from camsim.rendering.fourier.sampled_lens import fold
from camsim.rendering.fourier.taper import taper, tapered

FEW_LINES = 6  # along which the pattern's projections take less than the plane that holds all
LINE_PRECISION = 0.01  # of a line's response: of what it may be wrong by


@dataclass(frozen=True, kw_only=True, eq=False)
class ShortPattern:
    """Patterns of several weight sets, cut off.

    wavelength_nm : (j,);  contrast: (spectra, channels, j) against the background
    precision     : of a pattern, relative to all of the light
    """

    rest: Difference
    system: OpticalSystem
    pitch_um: float
    settings: Settings
    wavelength_nm: F64
    contrast: F64
    precision: float

    @functools.cached_property
    def sets(self) -> tuple[F64, F64]:
        """Weights (b, j) that patterns are added up with, and (spectra, channels, b) of these in every signal.

        A pattern for each signal or one for each wavelength, whichever are fewer.
        """
        spectra, channels, count = self.contrast.shape
        if spectra * channels > count:
            return np.eye(count), np.ascontiguousarray(self.contrast)
        flat = self.contrast.reshape(-1, count)
        return flat, np.eye(len(flat)).reshape(spectra, channels, -1)

    @functools.cached_property
    def lattice(self) -> tuple[int, int, F64]:
        """Points along a period, points to either side of the middle that the pattern is kept on, and their places."""
        settings = self.settings
        size = fast_length(math.ceil(2.04 * settings.cut * settings.period) + 1)
        step = settings.period / size
        reach = math.floor(settings.outer / step)
        return size, reach, step * np.arange(-reach, reach + 1.0)

    @functools.cached_property
    def samples(self) -> F64:
        """Patterns (b, y, x) on the lattice, tapered, times a cell's area."""
        settings, (size, _, axis) = self.settings, self.lattice
        along = (
            tapered(np.abs(axis), settings.reach, settings.outer, taper(settings.sharpness)) * settings.period / size
        )
        total = np.zeros((len(self.sets[0]), axis.size, axis.size))
        place_um = axis * self.pitch_um
        for nm, weights in zip(self.wavelength_nm, self.sets[0].T, strict=True):
            pattern = self.rest.point_spread_on(place_um, place_um, float(nm), 30.0 * self.precision)
            pattern *= along * self.pitch_um**2
            pattern *= along[:, None]
            for own, weight in zip(total, weights, strict=True):
                if weight != 0.0:
                    own += weight * pattern
        return total

    @functools.cached_property
    def transfers(self) -> C128:
        """Half planes i ≥ 0 (b, rows, columns) of the patterns' transfers; rows go round."""
        size = self.lattice[0]
        return np.stack([scipy.fft.rfft2(fold(fold(own, size, 0), size, 1), workers=-1) for own in self.samples])

    @functools.cached_property
    def _blocks(self) -> dict[Block, F64]:
        return {}

    def on_block(self, block: Block) -> F64:
        """Return the transfers with OLPF and photosite on a block of a window's frequencies: (b, count_j, 2, count_i).

        They are the same for all windows, and kept.
        """
        if block not in self._blocks:
            tile = self.settings.tile(0, 0, self.settings.side, self.settings.side)
            # The half plane i ≥ 0 is there; a block lies wholly in it or in its mirror image.
            back = block.first_i < 0
            i, j = block.first_i + np.arange(block.count_i), block.first_j + np.arange(block.count_j)
            row, low, high = (-j if back else j) % self.transfers.shape[1], np.abs(i).min(), np.abs(i).max() + 1
            foot = footprint_transfer(self.system, block, tile, self.pitch_um)
            across, down, both = (part.view(complex)[..., 0] for part in foot)
            footprint = across * down[:, None] * (both if both.size else 1.0)
            values = np.empty((len(self.transfers), block.count_j, 2, block.count_i))
            for own, transfer in zip(values, self.transfers, strict=True):
                taken = transfer[:, low:high][row]
                taken = (taken[:, ::-1].conj() if back else taken) * footprint
                own[:, 0], own[:, 1] = taken.real, taken.imag
            self._blocks[block] = values
        return self._blocks[block]

    def responses(self, normals: F64, allowed: float) -> F64:
        """Return what is seen from −near … near of straight edges: quintics (normals, b, cells, 6).

        normals : (o, 2), to the side that the light is on

        An edge's response is the running integral of the line spread, whose transform is the transfer along the normal.
        Beyond its reach it is nothing: the constant of the integral.
        """
        settings = self.settings
        cells = math.ceil(2.0 * settings.near / settings.step)
        if not len(normals):
            return np.empty((0, len(self.sets[0]), cells, 6))
        farthest = math.sqrt(2.0) * settings.outer + settings.extent
        count = fast_length(math.ceil(2.0 * farthest / settings.step) + 8, real=True)
        period = count * settings.step
        f = np.arange(1, min(math.ceil(settings.cut * period), count // 2)) / period
        fx, fy = np.multiply.outer(normals[:, 0], f), np.multiply.outer(normals[:, 1], f)
        footprint = self.system.footprint_otf(fx / self.pitch_um, fy / self.pitch_um)
        index = np.arange(-2, cells + 3) % count
        turn = np.exp(-2j * np.pi * f * settings.near)
        out = np.empty((len(normals), len(self.samples), cells, 6))
        for b, transfer in enumerate(self._along(normals, f, max(LINE_PRECISION * allowed, 1e-13))):
            spectrum = np.zeros((len(normals), count // 2 + 1), complex)
            spectrum[:, 1 : 1 + f.size] = transfer * footprint * turn / (2j * np.pi * f * period)
            running = scipy.fft.irfft(spectrum, n=count, axis=1, norm="forward")
            # The side where nothing is seen yet lies half a period back.
            silent = running[:, [(count // 2 + round(settings.near / settings.step)) % count]]
            out[:, b] = quintic_cells((running - silent)[:, index])
        return out

    def _along(self, normals: F64, frequency: F64, precision: float) -> Iterator[C128]:
        """Yield each pattern's transfer (normals, frequencies) at 1, 2 … times the first frequency along normals."""
        samples, axis = self.samples, self.lattice[2]
        # Opposite normals have one line.
        back = (normals[:, 0] < 0.0) | ((normals[:, 0] == 0.0) & (normals[:, 1] < 0.0))
        lines, which = np.unique(np.where(back[:, None], -normals, normals) + 0.0, axis=0, return_inverse=True)
        found = np.empty((len(samples), len(lines), frequency.size), complex)
        if len(lines) > FEW_LINES:
            step = 2.0 * np.pi * (axis[1] - axis[0])
            fx, fy = (step * np.multiply.outer(line, frequency).ravel() for line in lines.T)
            for own, plane in zip(found, samples, strict=True):
                points = at_points((fy, fx), plane.astype(complex), precision=precision, sign=-1)
                own[:] = points.reshape(own.shape)
        else:
            flat, turn = samples.reshape(len(samples), -1), 2.0 * np.pi * frequency[0]
            for n, (x, y) in enumerate(lines):
                phases = turn * np.add.outer(y * axis, x * axis).ravel()
                found[:, n] = along_line(phases, flat, frequency.size, precision=precision)
        whole = found[:, which.ravel()]
        yield from np.where(back[:, None], whole.conj(), whole)
