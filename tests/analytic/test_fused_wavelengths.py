"""Few wavelengths stand for many: what a lens does at each, summed over every one of them."""

import numpy as np
import pytest

from camsim.rendering.spectral import Signals, fuse
from tests.truth import rays

WAVELENGTH_NM = np.linspace(400.0, 700.0, 6001)


@pytest.mark.parametrize("phase", [0.1, 10.0, 40.0, 100.0, 300.0, 900.0])
@pytest.mark.parametrize("allowed", [3e-5, 3e-8, 3e-11])
def test_fused_wavelengths_follow_the_rings(phase, allowed):
    """Light within r of a point, in Lord Rayleigh's form, under a lamp with lines; ``phase`` is the range of 2πr/λN."""
    lamp = 1.0 + 9.0 * (np.arange(6001) % 1000 == 7)
    density = (lamp * np.exp(-0.5 * ((WAVELENGTH_NM - 540.0) / 60.0) ** 2) / 6001)[None, None]
    signals = Signals(wavelength_nm=WAVELENGTH_NM, density=density, scale=np.ones(1))
    radius_over_n = phase / (2 * np.pi * (1 / 400.0 - 1 / 700.0))
    nodes_nm, weights = fuse(signals, phase=phase, allowed=allowed)
    assert nodes_nm.size < 0.5 * phase + 60
    whole = density[0, 0] @ rays.rayleigh_energy(radius_over_n, WAVELENGTH_NM)
    assert weights[0, 0] @ rays.rayleigh_energy(radius_over_n, nodes_nm) == pytest.approx(whole, abs=allowed)
    assert weights.sum() == pytest.approx(density.sum(), rel=1e-12)
