"""What a footprint of any shape lets pass of waves at the most, against its transfer in many directions."""

import numpy as np
import pytest

from camsim.optics import Airy, CircularPhotosite, FourSpotOlpf, OpticalSystem, PolygonPhotosite, RoundedPhotosite
from camsim.rendering.envelope import Envelope

PITCH_UM = 4.0
SHAPES = {
    "circle": CircularPhotosite(diameter_um=4.0),
    "rounded": RoundedPhotosite(width_um=4.8, height_um=0.3, radius_um=0.1),
    "L": PolygonPhotosite(points_um=((-2.0, -2.0), (2.0, -2.0), (2.0, 0.0), (0.0, 0.0), (0.0, 2.0), (-2.0, 2.0))),
    "triangle": PolygonPhotosite(points_um=((-2.0, -1.6), (2.0, -1.2), (0.4, 2.0))),
}


@pytest.mark.parametrize("olpf", [(), (FourSpotOlpf(split_um=2.0),)], ids=["", "olpf"])
@pytest.mark.parametrize("highest", [1.0, 40.0])
@pytest.mark.parametrize("shape", SHAPES)
def test_nothing_passes_above_it(shape, highest, olpf, rng):
    """In no direction, of 2 000, does more pass; at the top it is at most three times what does near it."""
    system = OpticalSystem.of([Airy(f_number=8.0), *olpf, SHAPES[shape]])
    envelope, angle = Envelope.of(system, PITCH_UM, highest), np.linspace(0.0, np.pi, 2_001)

    def passes(cycles):
        per_um = cycles / PITCH_UM
        return np.abs(system.footprint_otf((per_um * np.cos(angle))[None], (per_um * np.sin(angle))[None])).max()

    some = np.concatenate([rng.uniform(0.01, 1.0, 20) * highest, [highest]])
    assert max(passes(cycles) / envelope.at(np.array([cycles]))[0] for cycles in some) < 1.0 + 1e-12
    near = max(passes(cycles) for cycles in highest + np.linspace(-0.5, 0.5, 21))
    assert envelope.at(np.array([highest]))[0] < 3.0 * near
