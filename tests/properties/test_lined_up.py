"""Nothing happens where photosites and edges line up: an image changes as little as the scene moves.

Ways of computing change at distances and feet that alignment hits exactly: an edge's foot on its own end, a photosite
at the very radius of a plan, a line through photosites' centres. A billionth of a pitch further on none of that is so,
and another way may be taken, each within its share of the tolerance.
"""

import itertools

import numpy as np
import pytest
from examples import PITCH_UM, WAVELENGTH_NM, grid_of, worst

import camsim

SHIFT_UM = 1e-9 * PITCH_UM
OLPFS = {
    "none": None,
    "four": camsim.FourSpotOlpf(split_um=0.75 * PITCH_UM),
    "plate": camsim.TwoSpotOlpf(split_um=0.75 * PITCH_UM),
    "four turned": camsim.FourSpotOlpf(split_um=0.75 * PITCH_UM, split_y_um=0.5 * PITCH_UM, rotate_deg=30.0),
    "plate at 45°": camsim.TwoSpotOlpf(split_um=0.75 * PITCH_UM, rotate_deg=45.0),
}
PHOTOSITES = {
    "point": camsim.SquarePhotosite(side_um=0.0),
    "square": camsim.SquarePhotosite(side_um=PITCH_UM),
    "rectangle": camsim.RectangularPhotosite(width_um=PITCH_UM, height_um=0.5 * PITCH_UM),
}
# Above its middle, which what is below repeats turned by half a turn.
HALF = grid_of(21, 41, frame=(41, 41))
# λN of 0.3 and 1 pitches: of the second the radii of a coarse plan are whole pitches.
LENSES = {"f/2.4": camsim.Airy(f_number=2.4), "f/8": camsim.Airy(f_number=8.0)}


def image(optics, tolerance, corner, angle_deg, shift_um):
    width, height = 20.0 * PITCH_UM, 10.0 * PITCH_UM
    return camsim.render(
        camsim.Scene(
            background=1.0,
            shapes=[
                camsim.Rectangle(
                    width_um=width,
                    height_um=height,
                    rotate_deg=angle_deg,
                    centre_um=(corner * PITCH_UM + shift_um, corner * PITCH_UM + 0.7 * shift_um),
                    reflectance=0.0,
                )
            ],
        ),
        optics,
        HALF,
        wavelength_nm=WAVELENGTH_NM,
        method="boundary",
        tolerance=tolerance,
    ).image


PAIRS = [(a, b) for i, a in enumerate(OLPFS) for k, b in enumerate(PHOTOSITES) if (i + k) % 2]


@pytest.mark.parametrize(
    ("tolerance", "olpf", "photosite"),
    [*((t, *pair) for t in (1e-4, 1e-6) for pair in PAIRS), (1e-7, "four turned", "rectangle")],
)
def test_an_image_moves_with_its_scene(tolerance, olpf, photosite):
    """Every second case of all: no two that differ in one thing only; at 1e-7 the most turned one."""
    stages = [stage for stage in (OLPFS[olpf], PHOTOSITES[photosite]) if stage is not None]
    one = list(OLPFS).index(olpf) + list(PHOTOSITES).index(photosite) + (tolerance < 1e-5)
    way = SHIFT_UM * (-1.0) ** list(OLPFS).index(olpf)
    for lens, corner, turn in itertools.product(range(2), range(2), range(3)):
        if (one + lens + corner + turn) % 2:
            continue
        optics = [list(LENSES.values())[lens], *stages]
        aligned, moved = (image(optics, tolerance, 0.5 * corner, 45.0 * turn, by) for by in (0.0, way))
        assert worst(aligned, moved) < tolerance


def test_photosites_at_the_very_radius_of_a_plan():
    """A half disc whose straight side is 5 λN from a row of photosites, on its negative side: 2.6e-2 off before."""
    angle = np.pi * np.arange(201) / 200
    corners = 30.0 * PITCH_UM * np.stack([np.cos(angle), np.sin(angle)], axis=1)

    def half_disc(shift_um):
        shape = camsim.Polygon(points_um=corners + np.array([0.0, shift_um]), reflectance=1.0)
        scene = camsim.Scene(background=0.0, shapes=[shape])
        optics = [camsim.Airy(f_number=8.0), camsim.SquarePhotosite(side_um=PITCH_UM)]
        return camsim.render(
            scene, optics, grid_of(61, 61), wavelength_nm=WAVELENGTH_NM, method="boundary", tolerance=1e-4
        ).image

    assert worst(half_disc(0.0), half_disc(SHIFT_UM)) < 1e-4


def test_an_edge_shorter_than_rounding_is_none():
    """Two rectangles that touch but for the last bit leave an edge without a direction."""
    width = 0.1 + 0.2  # 0.30000000000000004
    left = camsim.Rectangle(width_um=width, height_um=30.0, centre_um=(-0.5 * width, 0.0), reflectance=0.5)
    right = camsim.Rectangle(width_um=30.0, height_um=30.3, centre_um=(15.0, 0.15), reflectance=0.5)
    found = camsim.render(
        camsim.Scene(background=0.0, shapes=[left, right]),
        [camsim.Airy(f_number=8.0)],
        grid_of(9, 9),
        wavelength_nm=WAVELENGTH_NM,
    )
    assert np.isfinite(found.image).all()
    assert found.error_estimate <= found.tolerance
