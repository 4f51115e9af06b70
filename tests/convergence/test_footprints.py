"""Lopsided photosites, plates turned, single and wide, obstructed lenses, curves: edges against Fourier transforms."""

import numpy as np
import pytest

import camsim

OUTLINE = [(-40.3, -29.0), (36.4, -39.1), (43.2, 24.7), (6.5, 10.4), (-26.0, 40.3)]
SCENE = camsim.Scene(background=1.0, shapes=[camsim.Polygon(points_um=OUTLINE, reflectance=0.1)])
GRID = camsim.Grid(rows=26, cols=32, pitch_um=4.0)

FOOTPRINTS = {
    "rectangle": [camsim.RectangularPhotosite(width_um=4.0, height_um=2.5)],
    "one plate": [camsim.SquarePhotosite(side_um=4.0), camsim.TwoSpotOlpf(split_um=3.0)],
    "one plate, turned": [
        camsim.SquarePhotosite(side_um=4.0),
        camsim.TwoSpotOlpf(split_um=3.0, rotate_deg=45.0),
    ],
    "unequal splits": [
        camsim.RectangularPhotosite(width_um=3.3, height_um=4.0),
        camsim.FourSpotOlpf(split_um=3.0, split_y_um=1.5),
    ],
    "unequal splits, turned": [
        camsim.RectangularPhotosite(width_um=4.0, height_um=3.0),
        camsim.FourSpotOlpf(split_um=3.0, split_y_um=2.0, rotate_deg=20.0),
    ],
}


def rendered(optics, tolerance, method):
    return camsim.render(SCENE, optics, GRID, wavelength_nm=550.0, tolerance=tolerance, method=method)


@pytest.mark.parametrize(
    ("footprint", "f_number"),
    [(one, n) for i, one in enumerate(FOOTPRINTS) for k, n in enumerate((2.8, 22.0)) if (i + k) % 2],
)
def test_any_footprint(footprint, f_number):
    optics = [camsim.Airy(f_number=f_number), *FOOTPRINTS[footprint]]
    exact = rendered(optics, 1e-7, "fourier").image
    for tolerance in (1e-3, 1e-5, 1e-6):
        assert np.abs(rendered(optics, tolerance, "boundary").image - exact).max() <= tolerance


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


@pytest.mark.parametrize(("f_number", "obstruction"), [(1.4, 0.3), (8.0, 0.6), (22.0, 0.05)])
def test_central_obstruction(f_number, obstruction):
    optics = [camsim.AnnularAiry(f_number=f_number, obstruction=obstruction), camsim.SquarePhotosite(side_um=4.0)]
    exact = rendered(optics, 1e-7, "fourier").image
    for tolerance in (1e-3, 1e-5, 1e-6):
        assert np.abs(rendered(optics, tolerance, "boundary").image - exact).max() <= tolerance


CURVES = {
    "few points": [(0.0, 1.0), (0.05, 0.6), (0.1, 0.3), (0.2, 0.0)],
    "many points": [(f, max(1.0 - 4.0 * f, 0.0) ** 1.5) for f in np.linspace(0.0, 0.25, 26)],
    "sharp": [(0.0, 1.0), (0.3, 0.7), (0.6, 0.45), (0.9, 0.2), (1.2, 0.0)],
}


@pytest.mark.parametrize("curve", CURVES)
def test_a_transfer_given_as_a_curve(curve):
    frequency, values = zip(*CURVES[curve], strict=True)
    optics = [camsim.RadialOtf(freq_per_um=frequency, values=values), camsim.SquarePhotosite(side_um=4.0)]
    exact = rendered(optics, 1e-7, "fourier").image
    for tolerance in (1e-3, 1e-4, 1e-5, 1e-6):
        assert np.abs(rendered(optics, tolerance, "boundary").image - exact).max() <= tolerance
