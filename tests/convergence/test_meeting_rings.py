"""Rings that meet in step: targets of circles a wave apart, dashes and teeth about a photosite, behind any pupil."""

import functools
import math

import numpy as np
import pytest
import scipy

import camsim

PITCH_UM = 4.0
F_NUMBER = PITCH_UM / 0.55  # λN is a pitch
COMA = camsim.Wavefront(f_number=F_NUMBER, zernike_waves=((7, 0.05),), reference_nm=550.0)
MOST = 0.5  # of the tolerance
"""Random phases for rings in step were 2 … 13 times the tolerance off."""


def rendered(shapes, tolerance, *, lens=None, method="auto", size=3):
    return camsim.render(
        camsim.Scene(background=0.0, shapes=shapes),
        [lens or camsim.Airy(f_number=F_NUMBER), camsim.SquarePhotosite(side_um=0.0)],
        camsim.Grid(rows=size, cols=size, pitch_um=PITCH_UM),
        wavelength_nm=550.0,
        tolerance=tolerance,
        method=method,
    )


def target(radius, count, step=1.0):
    """Discs one over the other, white and black in turns, from the outermost on: (radius, reflectance)."""
    return [
        (radius + k * step + out, grey)
        for k in range(count - 1, -1, -1)
        for out, grey in ((0.5 * step, 1.0), (0.0, 0.0))
    ]


def discs(rings):
    return [camsim.Disc(radius_um=r * PITCH_UM, reflectance=grey) for r, grey in rings]


def encircled(radius):
    """Rayleigh: 1 − J0² − J1² of an Airy pattern's light lies within a radius."""
    v = math.pi * np.asarray(radius)
    return 1.0 - scipy.special.j0(v) ** 2 - scipy.special.j1(v) ** 2


@pytest.mark.parametrize("method", ["boundary", "fourier"])
@pytest.mark.parametrize(
    ("radius", "count", "step", "tolerance"),
    [(15.0, 20, 1.0, 1e-3), (40.0, 60, 1.0, 1e-4), (25.0, 8, 2.0, 1e-5)],
)
def test_circles_a_wave_apart(radius, count, step, tolerance, method):
    rings = target(radius, count, step)
    found = rendered(discs(rings), tolerance, method=method)
    edges = np.array([r for r, _ in rings])
    exact = float(np.sum(encircled(edges[::2]) - encircled(edges[1::2])))
    assert abs(found.image[1, 1] - exact) <= MOST * tolerance
    assert found.error_estimate <= tolerance


@functools.cache
def _transfers():
    """Nodes and weights over 0 … 1 of the cut-off, and (nodes, directions) the OTF behind coma.

    Pupils shifted by 2f have a lens in common, |y| ≤ √(1 − f²) and |x| ≤ √(1 − y²) − f.
    """
    x, w = np.polynomial.legendre.leggauss(500)
    turned = 0.25 * math.pi * (1.0 + x)
    f, weight = np.sin(turned), 0.25 * math.pi * w * np.cos(turned)
    u, v = np.polynomial.legendre.leggauss(28)
    rise = 0.5 * math.pi * u
    directions = 2.0 * math.pi * (np.arange(24) + 0.5) / 24
    otf = np.zeros((f.size, directions.size))
    for k, shift in enumerate(f):
        half = math.sqrt(1.0 - shift * shift)
        y = half * np.sin(rise)[:, None]
        wide = np.sqrt(1.0 - y * y) - shift
        area = 0.5 * math.pi * half * np.cos(rise)[:, None] * v[:, None] * wide * v
        for j, angle in enumerate(directions):
            ahead, behind = (_coma(wide * u + side, y, angle) for side in (shift, -shift))
            otf[k, j] = float(np.sum(area * np.cos(2.0 * math.pi * (ahead - behind)))) / math.pi
    return f, weight, otf, directions


def _coma(x, y, angle):
    """Noll's seventh polynomial, 0.05 waves of it, seen along a direction."""
    return 0.05 * math.sqrt(8.0) * (3.0 * (x * x + y * y) - 2.0) * (x * math.cos(angle) - y * math.sin(angle))


def through_coma(radius):
    """Light within a radius, ∫ 2πr·J1(2πrf)·⟨OTF⟩ df, the mean over all directions."""
    f, weight, otf, _ = _transfers()
    turns = 2.0 * math.pi * np.asarray(radius)[:, None]
    return np.sum(turns * scipy.special.j1(turns * f) * otf.mean(axis=1) * weight, axis=1)


@pytest.mark.parametrize(("radius", "count", "tolerance"), [(31.0, 3, 1e-4), (34.0, 20, 1e-5)])
def test_circles_behind_coma(radius, count, tolerance):
    rings = target(radius, count)
    found = rendered(discs(rings), tolerance, lens=COMA)
    edges = np.array([r for r, _ in rings])
    exact = float(np.sum(through_coma(edges[::2]) - through_coma(edges[1::2])))
    assert abs(found.image[1, 1] - exact) <= 0.6 * tolerance
    assert found.error_estimate <= tolerance


def seen_from_the_middle(corners):
    """Light of a polygon: ∮ E(r) dφ/2π along its sides, none of which is long beside a wave."""
    x, w = np.polynomial.legendre.leggauss(24)
    total = 0.0
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        place = 0.5 * (a + b) + 0.5 * np.multiply.outer(x, b - a)
        turning = (place[:, 0] * (b - a)[1] - place[:, 1] * (b - a)[0]) / np.sum(place**2, axis=1)
        total += 0.5 * float(np.sum(w * turning * encircled(np.hypot(*place.T))))
    return total / (2.0 * math.pi)


def dashes(count, radius, circles):
    """Corners (4, 2) of rectangles half a wave thick, a wave from circle to circle, half of each filled."""
    corners = []
    for r in radius + np.arange(circles):
        half = r * math.tan(0.5 * math.pi / count)
        one = np.array([(r, -half), (r + 0.5, -half), (r + 0.5, half), (r, half)])
        for angle in 2.0 * math.pi * np.arange(count) / count:
            c, s = math.cos(angle), math.sin(angle)
            corners.append(one @ np.array([(c, s), (-s, c)]))
    return corners


def wheel(teeth, radius):
    angles, half = 2.0 * math.pi * np.arange(teeth) / teeth, 0.5 * math.pi / teeth
    tooth = (0.0, -half), (0.5, -half), (0.5, half), (0.0, half)
    places = [(radius + out, at + side) for at in angles for out, side in tooth]
    return [np.array([(r * math.cos(at), r * math.sin(at)) for r, at in places])]


@pytest.mark.parametrize(("size", "method"), [(3, "fourier"), (41, "auto")])
@pytest.mark.parametrize(
    ("outlines", "tolerance"),
    [(dashes(100, 42.56, 3), 1e-5), (dashes(60, 30.0, 1), 1e-5), (wheel(120, 90.25), 1e-6)],
    ids=["dashes", "one circle", "wheel"],
)
def test_patterns_about_a_photosite(outlines, tolerance, method, size):
    """No three edges in a row touch their circle."""
    shapes = [camsim.Polygon(points_um=(PITCH_UM * one).tolist(), reflectance=1.0) for one in outlines]
    found = rendered(shapes, tolerance, method=method, size=size)
    exact = sum(map(seen_from_the_middle, outlines))
    assert abs(found.image[size // 2, size // 2] - exact) <= MOST * tolerance
    assert found.error_estimate <= tolerance


def test_a_zone_plate_of_waves_behind_coma():
    """It passes the cut-off at 32 pitches, and all of what lies about there is in step in the middle."""
    radius, finest, tolerance = 40.0, 0.8, 1e-4
    plate = camsim.SineZonePlate(radius_um=radius * PITCH_UM, finest_period_um=finest * PITCH_UM)
    found = rendered([plate], tolerance, lens=COMA)
    r = np.linspace(0.0, radius, 20_001)
    turn = math.pi * r * r / (radius * finest)
    falls = 0.5 * np.sin(turn) * 2.0 * math.pi * r / (radius * finest)
    within = np.append(0.0, through_coma(r[1:]))
    exact = (0.5 + 0.5 * math.cos(turn[-1])) * within[-1] + scipy.integrate.simpson(within * falls, x=r)
    assert abs(found.image[1, 1] - exact) <= MOST * tolerance
    assert found.error_estimate <= tolerance
