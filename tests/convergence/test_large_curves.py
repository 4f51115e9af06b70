"""Curves of up to 30 000 photosites, and flat ones, their circles' centres at 10⁹: the engines' sides and the check's.

Cases: discs, rings, and ellipses in the check; sides of a narrow ring that went through the
frame; ten million sides, or a minute, for what lies where nothing is seen of it.
"""

import numpy as np
import pytest

import camsim

PITCH = 4.88


def image_of(shapes, lens, tolerance, *, rows=2, cols=3, background=0.18, method="auto", side=0.5):
    found = camsim.render(
        camsim.Scene(background=background, shapes=shapes),
        [lens, camsim.SquarePhotosite(side_um=side * PITCH)],
        camsim.Grid(rows=rows, cols=cols, pitch_um=PITCH),
        wavelength_nm=550.0,
        tolerance=tolerance,
        method=method,
    )
    assert found.error_estimate <= tolerance
    return found.image


def gaussian(sigma):
    return camsim.Gaussian(sigma_um=sigma * PITCH)


def airy(blur):
    return camsim.Airy(f_number=blur * PITCH / 0.55)


def disc(radius, off=0.0, angle=0.0):
    out = np.array([np.cos(angle), np.sin(angle)])
    return camsim.Disc(radius_um=radius * PITCH, centre_um=tuple((off - radius) * out * PITCH), reflectance=0.02)


def ellipse(radii, centre, rotate_deg, reflectance=0.9):
    return camsim.Ellipse(
        radius_x_um=radii[0] * PITCH,
        radius_y_um=radii[1] * PITCH,
        centre_um=tuple(PITCH * np.array(centre)),
        rotate_deg=rotate_deg,
        reflectance=reflectance,
    )


@pytest.mark.parametrize("method", ["boundary", "fourier"])
@pytest.mark.parametrize(("radius", "width"), [(1e2, 0.7), (5756.0, 3.7), (5756.0, 56.0)])
def test_sides_that_nothing_is_seen_of_stay_out_of_the_frame(radius, width, method):
    """A ring whose inner rim lies up to hundreds of blurs beyond: sides of it may be long, but not reach the outer."""
    ring = camsim.Ring(
        radius_um=radius * PITCH,
        inner_radius_um=(radius - width) * PITCH,
        centre_um=(-radius * PITCH, 0.0),
        reflectance=0.02,
    )
    image = image_of([ring], gaussian(0.02), 1e-5, rows=1, cols=5, method=method, side=0.1)
    within = [0.18 if width < 2.0 else 0.02, 0.18 if width < 1.0 else 0.02]
    # The rim bends away from the middle one by its square over 24 radii, on the average.
    assert image[0] == pytest.approx([*within, 0.1, 0.18, 0.18], abs=0.16 / 0.1 * 0.1**2 / 24.0 / radius + 2e-5)


FLAT = {
    "over a disc": (
        [disc(36.3, 1.5, -np.pi / 2), ellipse((4883.5, 0.6261), (1.0919, 1.01444), 11.7653)],
        gaussian(0.134),
        9e-4,
    ),
    "its centre at 10^9": ([ellipse((490595.4, 215.7), (-214.6, -16.6), 93.633)], airy(1.02), 5e-3),
    "its centre at 10^10": ([ellipse((5259336.0, 1620.07), (2.0, 1619.07), 0.0)], gaussian(0.68), 1e-6),
    "two": (
        [ellipse((2628.4, 1.682), (-0.9449, 0.794), 109.99), ellipse((72.97, 0.8067), (2.8067, 1.5), 270.0, 0.3)],
        airy(0.3),
        1e-7,
    ),
    "across each other": (
        [
            ellipse((1904288.0, 1065.16), (236.08, 1037.42), 347.189),
            ellipse((1790.5, 176.0), (1.0, 1791.0), 270.0, 0.3),
        ],
        airy(0.2),
        1e-6,
    ),
}


@pytest.mark.parametrize("name", FLAT)
def test_the_check_follows_flat_ellipses(name):
    """Both engines and the check agree, however far away the centres of its arcs lie."""
    shapes, lens, tolerance = FLAT[name]
    one, other = (image_of(shapes, lens, tolerance, rows=4, cols=5, method=m) for m in ("boundary", "fourier"))
    assert np.ptp(one) > 0.05
    assert one == pytest.approx(other, abs=2.0 * tolerance)
