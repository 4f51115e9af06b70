"""Transfers of lenses, kept for tiles that are alike: curves, or fields by wavelength or by few sums of them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from camsim.arrays import F64
from camsim.optics import OpticalSystem
from camsim.optics.protocols import Round
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.fourier.blocks import Tile
from camsim.rendering.fourier.kernels import Curves
from camsim.rendering.fourier.lens import Fields, plain_fields, round_curves
from camsim.rendering.fourier.plan import Sizes
from camsim.rendering.fourier.sampled_lens import fields_of, tapered_transfers
from camsim.rendering.fourier.spread import Kernel
from camsim.rendering.modes import mixed

MOST_KEPT = 8  # curves


class RoundTransfers:
    """Curves of a round pattern at wavelengths (j,), for tiles of a few sizes."""

    def __init__(self, pattern: Round, wavelength_nm: F64, pitch_um: float, kernel: Kernel) -> None:
        self._pattern, self._wavelength_nm, self._pitch_um, self._kernel = pattern, wavelength_nm, pitch_um, kernel
        self._made: dict[tuple[object, ...], Curves] = {}

    def of(self, tile: Tile, plan: Sizes, contrast: F64) -> Curves:
        """Return them for weights (spectra, channels, j) against the background."""
        key = tile.inner, tile.outer, tile.cut, plan.sharpness, contrast.tobytes()
        curves = self._made.get(key)
        if curves is None:
            curves = round_curves(
                self._pattern, self._wavelength_nm, contrast, self._pitch_um, self._kernel, tile, plan
            )
            if len(self._made) >= MOST_KEPT:
                self._made.clear()
            self._made[key] = curves
        return curves


class Transfers:
    """Fields of one system at wavelengths (j,); the last that were made are kept."""

    def __init__(
        self, system: OpticalSystem, wavelength_nm: F64, pitch_um: float, tolerance: float, tapered: bool
    ) -> None:
        self._system, self._wavelength_nm, self._pitch_um = system, wavelength_nm, pitch_um
        self._tolerance, self._tapered = tolerance, tapered
        self._made: dict[tuple[object, ...], Fields] = {}

    def in_turn(self, tile: Tile, plan: Sizes, contrast: F64) -> Iterator[tuple[Fields, F64]]:
        """Yield what gives the lens on a block, and the weights of its wavelengths.

        contrast : (spectra, channels, j) against the background
        """
        wavelength_nm = self._wavelength_nm
        if not self._tapered:
            yield plain_fields(self._system, wavelength_nm, self._pitch_um, tile), np.ascontiguousarray(contrast)
            return
        budget, count = ErrorBudget(self._tolerance), wavelength_nm.size
        # What all wavelengths give a spectrum in a channel is one transfer, and few of them may do for all of these:
        # each weight is off by so little that all together are off by a thousandth of what wavelengths may be.
        off = 1e-3 * budget.allowed("wavelengths") / count
        modes, mixture = mixed(contrast.reshape(-1, count), off, most=min(plan.fields + 1, count))
        fused = len(modes) < count and len(modes) <= plan.fields
        weights = mixture.T.reshape(*contrast.shape[:2], -1) if fused else contrast
        for first in range(0, 1 if fused else count, plan.fields):
            some = slice(None) if fused else slice(first, first + plan.fields)
            own = modes if fused else np.eye(wavelength_nm[some].size)
            # Windows of one size on scenery all about them have the same transfers: those that were made last are kept.
            key = tile.periods, tile.inner, tile.outer, tile.cut, plan.sharpness, first, own.tobytes()
            if key not in self._made:
                self._made.clear()
                self._made[key] = fields_of(
                    tapered_transfers(
                        self._system,
                        wavelength_nm[some],
                        own,
                        self._pitch_um,
                        tile,
                        plan,
                        precision=budget.allowed("pupil"),
                    )
                )
            yield self._made[key], np.ascontiguousarray(weights[:, :, some])
