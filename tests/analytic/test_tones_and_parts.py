"""What rings in a pattern's encircled energy, and photosites that are rendered in parts."""

import numpy as np
import pytest

import camsim
from tests.attack import systems
from tests.attack.draw import draw


@pytest.mark.parametrize("obstruction", [0.0, 0.05, 0.9])
def test_light_far_out_is_powers_and_no_more_ringing_than_stated(obstruction):
    """Around a circle it lacks the loss 4π√(uρ) of an edge's end, on which a pattern's figures are."""
    lens = camsim.AnnularAiry(f_number=1.0, obstruction=obstruction)
    pattern = lens.pattern()
    rho = np.linspace(200.0, 1000.0, 40_001)
    powers = sum(c / rho**n for c, n in zip(pattern.powers, (1, 3, 5), strict=True))
    rings = np.abs(1.0 - lens.encircled_energy(rho, 1000.0) - powers)
    most = sum(4.0 * np.pi * np.sqrt(u) * a * rho ** (0.5 - n) for u, a, n in pattern.rings)
    assert 0.5 < (rings / most).max() < 1.01


@pytest.mark.parametrize("number", [2199, 1877])
def test_parts_of_a_footprint_are_all_of_it(number):
    system = draw(71, number)
    image = systems.rendered(system, method="boundary").image
    truth = systems.Truth(system)
    for row, col in ((0, 0), (image.shape[0] - 1, image.shape[1] // 2)):
        channel = int(systems.channel(system)[row, col])
        value, error = truth.at(row, col, channel, target=1e-10)
        assert abs(image[row, col] / truth.scale[channel] - value) <= system["tolerance"] + error
