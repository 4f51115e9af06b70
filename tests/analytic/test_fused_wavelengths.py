"""Few wavelengths stand for many: what a lens does at each, summed over every one of them."""

import numpy as np
import pytest

from camsim.rendering.modes import spanning
from camsim.rendering.spectral import Signals, fuse, kinds
from tests.truth import rays

WAVELENGTH_NM = np.linspace(400.0, 700.0, 6001)


@pytest.mark.parametrize(("phase", "allowed"), [(0.1, 3e-8), (40.0, 3e-11), (300.0, 3e-8), (900.0, 3e-5)])
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


@pytest.mark.parametrize("off", [1e-4, 1e-8, 1e-12])
def test_spectra_are_mixtures_of_few(rng, off):
    """Of four wavelengths all are mixtures of four; of four that lie close together of two, but for so much."""
    nm = np.linspace(549.0, 551.0, 4)
    surfaces = rng.uniform(0.0, 1.0, (10, 1)) + np.sin(nm / 40.0 + rng.uniform(0.0, 6.0, (10, 1)))
    contrast = surfaces[:, None] * rng.uniform(0.0, 0.3, (3, 4))
    mixture = spanning(contrast, off)
    assert len(mixture) <= (2 if off > 1e-6 else 4)
    assert np.abs(np.einsum("ms,mt,tcj->scj", mixture, mixture, contrast) - contrast).max() <= off + 1e-15
    greys = rng.uniform(0.0, 1.0, (5, 1, 1)) * contrast[:1]
    shares, few = kinds(greys)
    assert len(few) == len(spanning(greys, off)) == 1
    assert not shares[0].any()
    assert shares[1:, 0, None, None] * few == pytest.approx(greys, rel=1e-12)
