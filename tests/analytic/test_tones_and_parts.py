"""What oscillates in a pattern's encircled energy, and photosites that are rendered in parts."""

import numpy as np
import pytest

import camsim
from tests.attack import systems
from tests.attack.draw import draw


@pytest.mark.parametrize("obstruction", [0.0, 0.05, 0.9])
def test_powers_and_tones_are_all_of_the_light_far_out(obstruction):
    lens = camsim.AnnularAiry(f_number=1.0, obstruction=obstruction)
    pattern = lens.pattern()
    rho = 2.0 * pattern.oscillations_from_blurs + np.linspace(0.0, 9.0, 50)
    beyond = sum(c / rho**n for c, n in zip(pattern.powers, (1, 3, 5), strict=True))
    for u, series in pattern.oscillations:
        beyond += np.real(np.exp(2j * np.pi * u * rho) * sum(a * rho ** (-2.0 - k) for k, a in enumerate(series)))
    # The next power of an Airy pattern is 5e-5·ρ⁻⁷, 5e-12 at 10 λN.
    assert np.abs(1.0 - lens.encircled_energy(rho, 1000.0) - beyond).max() < 6e-12


@pytest.mark.parametrize("number", [2199, 1877])
def test_parts_of_a_footprint_are_all_of_it(number):
    system = draw(71, number)
    image = systems.rendered(system, method="boundary").image
    truth = systems.Truth(system)
    for row, col in ((0, 0), (image.shape[0] - 1, image.shape[1] // 2)):
        channel = int(systems.channel(system)[row, col])
        value, error = truth.at(row, col, channel, target=1e-10)
        assert abs(image[row, col] / truth.scale[channel] - value) <= system["tolerance"] + error
