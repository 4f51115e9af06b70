"""The difference's pattern, wavelengths fused: its transfer on a window's frequencies, what it shows beside lines."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
import scipy

from camsim.arrays import F64
from camsim.kept import cached_property
from camsim.kernels import shared
from camsim.optics import OpticalSystem
from camsim.optics.difference import Difference
from camsim.quintics import quintic_cells
from camsim.rendering.aberrated.plane import PlaneTransfers
from camsim.rendering.aberrated.settings import Settings
from camsim.rendering.aberrated.transfers import ShortTransfers, transfers_of
from camsim.rendering.aberrated.window_kernels import with_footprint
from camsim.rendering.angular import AT_ONCE
from camsim.rendering.fast_length import fast_length
from camsim.rendering.fourier.blocks import Block
from camsim.rendering.fourier.lens import footprint_transfer


@dataclass(frozen=True, kw_only=True, eq=False)
class ShortPattern:
    """Patterns of several weight sets about their move, cut off.

    wavelength_nm : (j,);  contrast: (spectra, channels, j) against the background
    lines         : directions in which it will be asked what they show
    precision     : of a pattern, relative to all of the light
    """

    rest: Difference
    system: OpticalSystem
    pitch_um: float
    settings: Settings
    wavelength_nm: F64
    contrast: F64
    lines: int
    precision: float

    @cached_property
    def sets(self) -> tuple[F64, F64]:
        """Weights (b, j) that patterns are added up with, and (spectra, channels, b) of these in every signal.

        A pattern for each signal or one for each wavelength, whichever are fewer.
        """
        spectra, channels, count = self.contrast.shape
        if spectra * channels > count:
            return np.eye(count), np.ascontiguousarray(self.contrast)
        flat = self.contrast.reshape(-1, count)
        return flat, np.eye(len(flat)).reshape(spectra, channels, -1)

    @cached_property
    def transfers(self) -> ShortTransfers | PlaneTransfers:
        """What they are made of: harmonics, or where those are many, what takes less."""
        wavelengths, weights = tuple(self.wavelength_nm.tolist()), self.sets[0].tobytes()
        by_angle = transfers_of(self.rest, self.pitch_um, self.settings, wavelengths, weights, self.precision)
        if not by_angle.steep:
            return by_angle
        plane = PlaneTransfers(by_angle)
        return by_angle if by_angle.seconds(self.lines) < plane.seconds(self.lines) else plane

    @cached_property
    def fields(self) -> F64:
        """The transfers with OLPF and photosite on a window's frequencies, as ``window_kernels.Table`` has them.

        They are the same for all windows.
        """
        tile = self.settings.tile(0, 0, self.settings.side, self.settings.side)
        period = self.settings.period
        fields = self.transfers.on_window()
        count = fields.shape[4]
        both = Block(first_i=0, count_i=count, first_j=1 - count, count_j=2 * count - 1, column=0)
        footprint = footprint_transfer(self.system, both, tile, self.pitch_um)
        shared(count, functools.partial(with_footprint, fields, footprint, period), least=-(-AT_ONCE // count))
        return fields

    def responses(self, normals: F64) -> F64:
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
        out = np.empty((len(normals), len(self.sets[0]), cells, 6))
        for b, transfer in enumerate(self.transfers.at((normals[:, :1] * f).ravel(), (normals[:, 1:] * f).ravel())):
            spectrum = np.zeros((len(normals), count // 2 + 1), complex)
            spectrum[:, 1 : 1 + f.size] = transfer.reshape(fx.shape) * footprint * turn / (2j * np.pi * f * period)
            running = scipy.fft.irfft(spectrum, n=count, axis=1, norm="forward")
            # The side where nothing is seen yet lies half a period back.
            silent = running[:, [(count // 2 + round(settings.near / settings.step)) % count]]
            out[:, b] = quintic_cells((running - silent)[:, index])
        return out
