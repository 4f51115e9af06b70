"""Wavefronts of revolution: a round pattern against Hankel's integral of the pupil."""

import numpy as np
import pytest
from scipy import special

from camsim.optics import Pupil, Wavefront
from camsim.optics.zernike import zernike_sum

NM = 550.0
TERMS = [{4: 0.4}, {4: -2.0, 12: 0.6}, {0: 0.3, 24: 0.2, 40: -0.15}]


def bessel(lens, zernike, r_um):
    """Irradiance by Hankel's integral of the pupil, with Gauss's nodes along a radius."""
    x, weights = np.polynomial.legendre.leggauss(900)
    inner = lens.pupil.obstruction
    rho, weights = inner + 0.5 * (1.0 - inner) * (1.0 + x), 0.5 * (1.0 - inner) * weights
    waves = zernike_sum(tuple(zernike), list(zernike.values()), rho, np.zeros_like(rho))
    of_ring = 2.0 * np.pi * rho * weights * np.exp(2j * np.pi * waves)
    amplitude = special.j0(np.pi / lens.blur_um(NM) * np.multiply.outer(r_um, rho)) @ of_ring
    return np.abs(amplitude) ** 2 / (4.0 * lens.blur_um(NM) ** 2 * np.pi * (1.0 - inner**2))


@pytest.mark.parametrize("obstruction", [0.0, 0.5])
@pytest.mark.parametrize("zernike", TERMS, ids=str)
def test_a_round_pattern_is_hankels_integral(zernike, obstruction):
    lens = Wavefront(f_number=4.0, zernike_waves=zernike, reference_nm=NM, pupil=Pupil(obstruction=obstruction))
    r_um = lens.blur_um(NM) * np.linspace(0.0, 40.0, 401)
    along = lens.point_spread_on(r_um, np.zeros(1), NM, 1e-13)[0]
    np.testing.assert_allclose(along, bessel(lens, zernike, r_um), rtol=0, atol=1e-12 / lens.blur_um(NM) ** 2)
