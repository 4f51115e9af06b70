"""Systems that were once wrong, most of them unseen by the estimate, each with its neighbours (docs/attack.md)."""

import numpy as np
import pytest

from tests.attack import systems
from tests.convergence.test_tolerance import POINT, SQUARE, system_of

RECTANGLE = {
    "kind": "rectangle",
    "width": 8.0,
    "height": 4.0,
    "centre": [0.0, 0.0],
    "rotate_deg": 0.0,
    "reflectance": 0.0,
}
PHOTOSITES = {"point": POINT, "square": SQUARE, "rectangle": {"kind": "rectangle", "width": 0.5, "height": 0.9}}
OLPFS = {"plate": (0.75, 0.0), "plate down": (0.0, 0.75), "four": (0.75, 0.75), "unequal": (1.0, 0.4)}


def keeps(system, tolerance, method="auto"):
    """Render and judge every photosite."""
    rendering = systems.rendered(system, tolerance=tolerance, method=method)
    exact, unsure = systems.Truth(system).everywhere()
    assert unsure < 0.1 * tolerance
    assert np.abs(rendering.image - exact).max() <= tolerance
    assert rendering.error_estimate <= tolerance


@pytest.mark.parametrize("photosite", PHOTOSITES)
@pytest.mark.parametrize("olpf", OLPFS)
@pytest.mark.parametrize("rotate_deg", [0.0, 45.0, 20.0])
def test_photosites_straight_off_edges_and_corners(photosite, olpf, rotate_deg):
    """2.7e-4 off at 1e-8: sides on photosites' centres, spots beside them; odd and even frames, both alignments."""
    across, down = OLPFS[olpf]
    spots = {"split": across, "split_y": down, "rotate_deg": rotate_deg}
    for rows, cols in ((13, 13), (12, 13)):
        system = system_of([RECTANGLE], 0.7, photosite=PHOTOSITES[photosite], olpf=spots, rows=rows, cols=cols)
        keeps(system | {"pitch_um": 1.0}, 1e-8, "boundary")


@pytest.mark.parametrize("sigma", [0.5, 3.0, 6.0, 27.0])
@pytest.mark.parametrize(
    "photosite", [POINT, SQUARE, {"kind": "circle", "diameter": 1.0}], ids=["point", "square", "circle"]
)
def test_gaussians_larger_than_the_frame(sigma, photosite):
    """1e-3 off by the Fourier engine at any tolerance: its taper took all light for that of an Airy pattern's rings."""
    system = system_of([RECTANGLE], sigma, photosite=photosite, rows=3, cols=4)
    for tolerance in (1e-3, 1e-6, 1e-9):
        keeps(system | {"lens": {"kind": "gaussian", "blur": sigma}}, tolerance, "fourier")


def wavefront(blur, pupil, waves=()):
    opening = {"shape": "circular", "obstruction": 0.0, "blades": 0, "rotate_deg": 0.0} | pupil
    return {"kind": "wavefront", "blur": blur, "pupil": opening, "zernike_waves": waves, "defocus_waves": 0.0}


@pytest.mark.parametrize("waves", [[[22, 0.1]], [[24, 0.08], [27, -0.05]], [[40, 0.05]], [[38, 0.03], [44, 0.05]]])
@pytest.mark.parametrize("rotate_deg", [0.0, 30.0])
def test_high_orders_in_the_corners_of_a_square_pupil(waves, rotate_deg):
    """Up to 700 times the tolerance: beyond the unit circle order 8 grows as r⁸, 16 in the corners."""
    system = system_of([RECTANGLE], 0.8, rows=9, cols=9)
    keeps(system | {"lens": wavefront(0.8, {"shape": "square", "rotate_deg": rotate_deg}, waves)}, 1e-6)


def test_a_disc_under_a_square_pupil():
    """1.6e-5 off at 1e-6: sides short enough for λN along the pupil's sides, and not along its diagonals.

    The rim runs along y where the photosites lie, and so does one of the pupil's diagonals.
    """
    disc = {"kind": "disc", "radius": 25.0, "centre": [25.0, 0.0], "reflectance": 0.0}
    system = system_of([disc], 0.5, photosite=POINT, rows=3, cols=3)
    keeps(system | {"lens": wavefront(0.5, {"shape": "square", "rotate_deg": 45.0})}, 1e-7)
