"""Photosites that are rendered in parts."""

import pytest

from tests.attack import systems
from tests.attack.draw import draw


@pytest.mark.parametrize("number", [2199, 1877])
def test_parts_of_a_footprint_are_all_of_it(number):
    system = draw(71, number)
    image = systems.rendered(system, method="boundary").image
    truth = systems.Truth(system)
    for row, col in ((0, 0), (image.shape[0] - 1, image.shape[1] // 2)):
        channel = int(systems.channel(system)[row, col])
        value, error = truth.at(row, col, channel, target=1e-10)
        assert abs(image[row, col] / truth.scale[channel] - value) <= system["tolerance"] + error
