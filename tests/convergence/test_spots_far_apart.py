"""Low-pass filters whose spots lie far apart: what is seen is the mean of what each spot sees."""

import numpy as np
import pytest

import camsim

GRID = camsim.Grid(rows=26, cols=32, pitch_um=4.0)


def fields(x_um, y_um):
    """What is summed point by point, somewhat off the middle."""
    return {
        "picture": camsim.Picture(
            planes=np.random.default_rng(4).random((5, 7)), width_um=70.0, centre_um=(20.0 + x_um, 10.0 + y_um)
        ),
        "gradient": camsim.RadialGradient(radius_um=10.0, centre_um=(5.0 + x_um, 3.0 + y_um)),
        "point": camsim.PointSource(photosites=3.0, centre_um=(13.0 + x_um, y_um - 7.0)),
    }


ROUND, COMA = {4: 0.0}, {8: 0.1, 4: 0.05}


@pytest.mark.parametrize(
    ("kind", "waves", "plates", "split"),
    [
        ("picture", COMA, "two", 75.0),
        ("picture", ROUND, "four", 11.3),
        ("gradient", COMA, "four", 25.0),
        ("point", ROUND, "four", 25.0),
    ],
)
def test_spots_far_apart(kind, waves, plates, split):
    """Of right images the estimate was up to 13 000: they are the mean of those at every spot."""
    olpf = (camsim.TwoSpotOlpf if plates == "two" else camsim.FourSpotOlpf)(split_um=4.0 * split)
    lens, photosite = camsim.Wavefront(f_number=8.0, zernike_waves=waves), camsim.SquarePhotosite(side_um=3.7)

    def seen(optics, at, tolerance):
        scene = camsim.Scene(background=0.4, shapes=[fields(*at)[kind]])
        return camsim.render(scene, optics, GRID, wavelength_nm=550.0, tolerance=tolerance)

    mean = np.mean([seen([lens, photosite], at, 1e-5).image for at in olpf.spots_um().tolist()], axis=0)
    found = seen([lens, olpf, photosite], (0.0, 0.0), 1e-4)
    assert np.abs(found.image - mean).max() <= 0.5e-4
    assert found.error_estimate <= 0.5e-4
