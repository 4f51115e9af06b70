"""The far form of many edges at many points: as whole images, against frequency sums."""

import numpy as np
import pytest

import camsim


@pytest.mark.parametrize(
    "olpf", [[], [camsim.FourSpotOlpf(split_um=3.0, split_y_um=1.0, rotate_deg=20.0)]], ids=["square", "lopsided"]
)
def test_crowds_equal_the_fourier_engine(olpf):
    """Two greys, so that sums carry pairs of spectra."""
    rng = np.random.default_rng(8)
    shapes = [
        camsim.Rectangle(
            width_um=rng.uniform(4, 8),
            height_um=rng.uniform(4, 8),
            centre_um=((i % 24 - 11.5) * 12.0, (i // 24 - 11.5) * 12.0),
            rotate_deg=rng.uniform(0, 90),
            reflectance=(0.0, 0.5)[i % 2],
        )
        for i in range(24 * 24)
    ]
    images = [
        camsim.render(
            camsim.Scene(background=1.0, shapes=shapes),
            [camsim.Airy(f_number=4.0), camsim.SquarePhotosite(side_um=4.0), *olpf],
            camsim.Grid(rows=40, cols=48, pitch_um=4.0),
            wavelength_nm=550.0,
            tolerance=tolerance,
            method=method,
        ).image
        for method, tolerance in (("fourier", 1e-7), ("boundary", 1e-3), ("boundary", 1e-5))
    ]
    assert np.abs(images[1] - images[0]).max() < 1e-3
    assert np.abs(images[2] - images[0]).max() < 1e-5
