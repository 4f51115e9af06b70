"""A round lens as a Fourier image multiplies by it: curves over |k|, kept for tiles that are alike."""

from __future__ import annotations

from camsim.arrays import F64
from camsim.optics.protocols import Round
from camsim.rendering.fourier.kernels import Curves
from camsim.rendering.fourier.lens import round_curves
from camsim.rendering.fourier.spread import Kernel
from camsim.rendering.fourier.tile import Tile

MOST_KEPT = 8


class LensCurves:
    """Curves of a round pattern at wavelengths (j,), for tiles of a few sizes."""

    def __init__(self, pattern: Round, wavelength_nm: F64, pitch_um: float, kernel: Kernel) -> None:
        self._pattern, self._wavelength_nm, self._pitch_um, self._kernel = pattern, wavelength_nm, pitch_um, kernel
        self._made: dict[tuple[object, ...], Curves] = {}

    def of(self, tile: Tile, contrast: F64) -> Curves:
        """Return them for weights (spectra, channels, j) against the background."""
        key = tile.inner, tile.outer, tile.cut, tile.sharpness, contrast.tobytes()
        curves = self._made.get(key)
        if curves is None:
            curves = round_curves(self._pattern, self._wavelength_nm, contrast, self._pitch_um, self._kernel, tile)
            if len(self._made) >= MOST_KEPT:
                self._made.clear()
            self._made[key] = curves
        return curves
