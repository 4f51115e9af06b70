"""A lens that is not round as a Fourier image multiplies by it: few transfers, and what a signal takes of each."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64
from camsim.kept import cached_property
from camsim.optics import OpticalSystem
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.fourier.blocks import Strip
from camsim.rendering.fourier.fuses import Fused, Fuses
from camsim.rendering.fourier.lens import Fields, parts, plain_fields
from camsim.rendering.fourier.plan import Sizes
from camsim.rendering.fourier.sampled_lens import fields_of, tapered_transfers
from camsim.rendering.fourier.spread import Kernel
from camsim.rendering.fourier.tile import Tile
from camsim.rendering.modes import mixed

OF_TAPER = 0.25  # of a taper's share, where there is none: what transfers that a lens has added up may be wrong by


def fused_fields(fused: Fused, pitch_um: float, tile: Tile) -> Fields:
    """Return what gives transfers that are added up already: block → (sets, j, i, 2)."""
    (px, py), cut = tile.periods, tile.cut
    counts = math.floor(cut * px) + 1, math.floor(cut * py) + 1
    whole = fused.on_half_plane((1.0 / (px * pitch_um), 1.0 / (py * pitch_um)), counts)
    strip = Strip(first_j=1 - counts[1], count_j=2 * counts[1] - 1, count_i=counts[0])
    return functools.cache(lambda block: parts(np.stack([strip.part(own, block) for own in whole])))


@dataclass(frozen=True, eq=False)
class LensFields:
    """A lens at wavelengths (j,)."""

    system: OpticalSystem
    wavelength_nm: F64
    pitch_um: float
    kernel: Kernel
    tolerance: float

    @cached_property
    def _budget(self) -> ErrorBudget:
        return ErrorBudget(self.tolerance)

    @cached_property
    def _made(self) -> dict[tuple[object, ...], Fields]:
        return {}

    def of(self, tile: Tile, plan: Sizes, contrast: F64) -> Iterator[tuple[Fields, F64]]:
        """Yield what gives transfers on a block, and weights (spectra, channels, transfers) of these.

        contrast : (spectra, channels, j) against the background
        """
        wavelength_nm, lens = self.wavelength_nm, self.system.lens
        if isinstance(lens, Fuses):
            modes, weights = self._mixed(contrast, wavelength_nm.size)
            key: tuple[object, ...] = tile.periods, tile.cut, modes.tobytes()
            if key not in self._made:
                self._made.clear()
                transfers = lens.fused(wavelength_nm, modes, OF_TAPER * self._budget.allowed("taper"))
                self._made[key] = fused_fields(transfers, self.pitch_um, tile)
            yield self._made[key], weights
            return
        if not self.kernel.tapered:
            yield plain_fields(self.system, wavelength_nm, self.pitch_um, tile), np.ascontiguousarray(contrast)
            return
        count = wavelength_nm.size
        modes, weights = self._mixed(contrast, min(plan.fields + 1, count))
        fused = len(modes) < count and len(modes) <= plan.fields
        weights = weights if fused else contrast
        for first in range(0, 1 if fused else count, plan.fields):
            some = slice(None) if fused else slice(first, first + plan.fields)
            own = modes if fused else np.eye(wavelength_nm[some].size)
            # Windows of one size on scenery all about them have the same transfers: those that were made last are kept.
            tapers = tile.middle, tile.inner, tile.outer, tile.sharpness
            key = tile.periods, tile.cut, *tapers, first, own.tobytes()
            if key not in self._made:
                self._made.clear()
                precision = self._budget.allowed("pupil")
                # Nobody else holds them: those before are gone when the next are made.
                self._made[key] = fields_of(
                    tapered_transfers(
                        self.system, wavelength_nm[some], own, self.pitch_um, tile, plan,
                        cuts=self.kernel.cuts(tile.cut), precision=precision,
                    )
                )  # fmt: skip
            yield self._made[key], np.ascontiguousarray(weights[:, :, some])

    def _mixed(self, contrast: F64, most: int) -> tuple[F64, F64]:
        """Return weights (modes, wavelengths) of few transfers, and what (spectra, channels, modes) there is of each.

        What all wavelengths give a spectrum in a channel is one transfer, and few of them may do for all of these: each
        weight is off by so little that all together are off by a thousandth of what wavelengths may be.
        """
        count = contrast.shape[2]
        off = 1e-3 * self._budget.allowed("wavelengths") / count
        modes, mixture = mixed(contrast.reshape(-1, count), off, most=most)
        return modes, np.ascontiguousarray(mixture.T.reshape(*contrast.shape[:2], -1))
