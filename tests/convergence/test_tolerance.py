"""A stated tolerance is kept: whole images against settings that share nothing with the ones under test."""

import numpy as np
import pytest

import camsim

PITCH_UM = 4.88
TOLERANCES = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6]


def image(f_number, optics, tolerance, channel_scene="square"):
    shapes = {
        "square": [camsim.Rectangle(width_um=40 * PITCH_UM, height_um=40 * PITCH_UM, rotate_deg=4, reflectance=0.0)],
        "crowd": [
            camsim.Disc(radius_um=60.0, centre_um=(40.0, 10.0), reflectance=0.1),
            camsim.Polygon(points_um=[(-150, -130), (20, -90), (-60, 100)], reflectance=0.7),
            camsim.Rectangle(width_um=250, height_um=3, rotate_deg=31, reflectance=0.0),
        ],
    }[channel_scene]
    return camsim.render(
        camsim.Scene(background=1.0, shapes=shapes),
        [camsim.Airy(f_number=f_number), *optics],
        camsim.Grid(rows=72, cols=80, pitch_um=PITCH_UM),
        wavelength_nm=550.0,
        tolerance=tolerance,
    )


@pytest.mark.parametrize("scene", ["square", "crowd"])
@pytest.mark.parametrize("f_number", [1.4, 8.0, 32.0])
@pytest.mark.parametrize(
    "optics",
    [
        [camsim.SquarePhotosite(side_um=0.0)],
        [camsim.SquarePhotosite(side_um=PITCH_UM)],
        [camsim.SquarePhotosite(side_um=PITCH_UM), camsim.FourSpotOlpf(split_um=0.75 * PITCH_UM)],
    ],
    ids=["point", "box", "box+olpf"],
)
def test_error_stays_below_every_tolerance(scene, f_number, optics):
    exact = image(f_number, optics, 1e-7, scene).image
    for tolerance in TOLERANCES:
        rendering = image(f_number, optics, tolerance, scene)
        error = np.abs(rendering.image - exact).max()
        assert error <= tolerance
        assert rendering.error_estimate <= tolerance


def test_a_crowd_of_corners_keeps_the_tolerance():
    """What a hundred corners in sight each leave out adds up; the settings allow for it."""
    rng = np.random.default_rng(3)
    shapes = [
        camsim.Rectangle(
            width_um=3.9 * PITCH_UM,
            height_um=3.9 * PITCH_UM,
            centre_um=((16 * (i % 8) - 56) * PITCH_UM, (16 * (i // 8) - 56) * PITCH_UM),
            rotate_deg=rng.uniform(0, 90),
            reflectance=0.0,
        )
        for i in range(64)
    ]

    def many_squares(tolerance):
        return camsim.render(
            camsim.Scene(background=1.0, shapes=shapes),
            [camsim.Airy(f_number=8.0), camsim.SquarePhotosite(side_um=PITCH_UM)],
            camsim.Grid(rows=128, cols=128, pitch_um=PITCH_UM),
            wavelength_nm=550.0,
            tolerance=tolerance,
        ).image

    exact = many_squares(1e-7)
    for tolerance in TOLERANCES:
        assert np.abs(many_squares(tolerance) - exact).max() <= tolerance
