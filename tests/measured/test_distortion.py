"""Distortion and lateral colour of marks that were displaced by a known law, and of captures that displace none."""

import dataclasses
import math

import numpy as np
import pytest
from scipy import special

import camsim
from camsim.errors import UnsupportedError
from camsim.measure import Picture, Plane, picture_of_frame
from camsim.measure.distortion import measure_distortion
from camsim.measure.distortion.marks import Marks, locate_mark
from camsim.measure.distortion.result import radial_fit
from camsim.measure.picture import mosaic_planes
from tests.colour_data import aligned

ROWS, COLS, SPACING, HALF = 120, 160, 20.0, 0.5 * math.hypot(120, 160)
LAW = {"R": (1.001, -0.03, 0.01), "G": (1.0, -0.03, 0.01), "B": (0.999, -0.03, 0.01)}
SHIFT = (0.2, -0.1)
Y, X = np.indices((ROWS, COLS)) + 0.5 - 0.5 * np.array([ROWS, COLS])[:, None, None]
BAYER = np.add.outer(np.arange(ROWS) % 2, np.arange(COLS) % 2)


def captured(chart, sensor="d40-like", *changes):
    region = f"region={{rows: {ROWS}, cols: {COLS}}}"
    return camsim.load("dot-grid", sensor=sensor, overrides=[region, f"scene.shapes=[{chart}]", *changes])


def bent(x, y, channel):
    scale, k1, k2 = LAW[channel]
    r2 = (x * x + y * y) / HALF**2
    factor = scale + k1 * r2 + k2 * r2**2
    return x * factor + SHIFT[0], y * factor + SHIFT[1]


def displaced(kind, noise=0.0):
    """A Bayer mosaic under the law: dots drawn where it puts them, squares looked up where each photosite was."""
    mosaic, rng = np.full((ROWS, COLS), 900.0), np.random.default_rng(2)
    for k, channel in enumerate("RGB"):
        one = k == BAYER
        if kind == "checkerboard":
            mosaic[one] = 500.0 + 400.0 * squares(*straight(X[one], Y[one], channel))
            continue
        for v in np.arange(-2, 2.1) * SPACING:
            for u in np.arange(-3, 3.1) * SPACING:
                cx, cy = bent(u, v, channel)
                near = (np.hypot(X - cx, Y - cy) < 16) & one
                mosaic[near] -= 800.0 * blurred_disc(np.hypot(X[near] - cx, Y[near] - cy), 5.0, 0.8)
    return mosaic + noise * rng.standard_normal(mosaic.shape)


def straight(x, y, channel):
    """Undo the law, by iteration."""
    u, v = x, y
    for _ in range(30):
        bx, by = bent(u, v, channel)
        u, v = u + x - bx, v + y - by
    return u, v


def squares(u, v):
    """Edges through multiples of the spacing, each a soft step."""
    parts = []
    for at in (u, v):
        line = np.round(at / SPACING)
        parts.append(special.erf((at - SPACING * line) / 1.1) * (-1.0) ** line)
    return parts[0] * parts[1]


def blurred_disc(radius, disc, sigma):
    r, weight = np.polynomial.legendre.leggauss(80)
    r, weight = 0.5 * disc * (r + 1), 0.5 * disc * weight
    ring = np.exp(-0.5 * ((radius[:, None] - r) / sigma) ** 2) * special.i0e(radius[:, None] * r / sigma**2)
    return (ring * r * weight).sum(axis=1) / sigma**2


def test_a_mark_is_as_sure_as_it_is_said(rng):
    """Its stated error is the scatter of its place over frames of noise; nothing is off but by that."""
    y, x = np.indices((15, 15)) - 7.0
    dot = Marks(
        kind="dot-grid", places_um=np.zeros((1, 2)), reach_um=7.0, size_um=4.0, turn_rad=0.0, surfaces=(0.1, 0.9)
    )
    clean = 900.0 - 800.0 * blurred_disc(np.hypot(x - 0.2, y + 0.3).ravel(), 4.0, 0.8)
    found = np.array(
        [locate_mark(x.ravel(), y.ravel(), clean + rng.normal(0.0, 60.0, clean.size), dot, 1.0) for _ in range(80)]
    )
    scatter = math.sqrt(0.5 * (found[:, 0].var() + found[:, 1].var()))
    assert scatter == pytest.approx(found[:, 2].mean(), rel=0.2)
    np.testing.assert_allclose(found[:, :2].mean(axis=0), (0.2, -0.3), atol=0.02)


def test_the_polynomial_is_as_sure_as_it_is_said(rng):
    """Its stated errors are the scatter over noise; of marks at one distance k1 and k2 are not told apart."""
    places = np.stack(np.meshgrid(np.arange(-3, 4) * 20.0, np.arange(-2, 3) * 20.0), axis=-1).reshape(-1, 2)
    truth, solved, said = np.array([0.2, -0.1, 1e-3, -0.03, 0.01]), [], []
    r2 = np.sum(places**2, axis=1) / HALF**2
    moves = places * (truth[2] + truth[3] * r2 + truth[4] * r2**2)[:, None] + truth[:2]
    for _ in range(100):
        found, _, covariance = radial_fit(places, moves + rng.normal(0.0, 0.02, moves.shape), HALF)
        solved.append(found)
        said.append(np.diag(covariance))
    pulls = (np.array(solved) - truth) / np.sqrt(said)
    np.testing.assert_allclose(np.sqrt(np.mean(pulls**2, axis=0)), 1.0, atol=0.2)
    turn = np.arange(12) * math.pi / 6.0
    ring = 30.0 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    _, _, covariance = radial_fit(ring, ring * 0.01, HALF)
    assert np.isfinite(np.diag(covariance)).tolist() == [True, True, False, False, False]


@pytest.mark.parametrize("kind", ["dot-grid", "checkerboard"])
def test_marks_are_found_where_a_known_law_has_put_them(kind):
    chart = {
        "dot-grid": "{kind: chart, name: dot-grid, spacing: 20, radius: 5, rows: 5, cols: 7}",
        "checkerboard": "{kind: chart, name: checkerboard, side: 20, rows: 6, cols: 8}",
    }[kind]
    capture = captured(chart)
    planes = mosaic_planes(displaced(kind, noise=1.0), ("RG", "GB"))
    report = measure_distortion(Picture(name="grid", shape=(ROWS, COLS), planes=planes), capture)
    assert (report.kind, report.reference, report.left_out) == (kind, "G1", ())
    for channel in report.channels:
        assert len(channel.marks) == 35
        for mark in channel.marks:
            x, y = bent(mark.x_pixel, mark.y_pixel, channel.channel[0])
            off = math.hypot(mark.x_pixel + mark.dx_pixel - x, mark.y_pixel + mark.dy_pixel - y)
            assert off < 0.03
        scale, k1, k2 = LAW[channel.channel[0]]
        r2 = max(mark.radius_pixel for mark in channel.marks) ** 2 / HALF**2
        assert channel.scale == pytest.approx(scale, abs=5e-4)
        assert channel.largest_distortion == pytest.approx(k1 * r2 + k2 * r2**2, abs=5e-4)
        assert (channel.shift_x_pixel, channel.shift_y_pixel) == pytest.approx(SHIFT, abs=5e-3)
        error = channel.standard_error
        assert abs(channel.k1 - k1) < 4.0 * error.k1
        assert error.largest_distortion < 5e-4
    red = report.channels[0]
    radii = [mark.radius_pixel for mark in red.marks]
    assert red.lateral_largest_pixel == pytest.approx(1e-3 * max(radii), abs=0.02)


@pytest.mark.parametrize("kind", ["dot-grid", "checkerboard"])
def test_a_capture_without_distortion_has_none(kind):
    chart = {
        "dot-grid": "{kind: chart, name: dot-grid, spacing: 24, radius: 6, rows: 4, cols: 5, rotate_deg: 3}",
        "checkerboard": "{kind: chart, name: checkerboard, side: 24, rows: 4, cols: 5, rotate_deg: 3}",
    }[kind]
    capture = captured(chart, "d40-like", "noise.enabled=false", "render.tolerance=1e-3", "lens.f_number=8")
    said: list[tuple[str, float]] = []
    report = measure_distortion(picture_of_frame(capture.frame()), capture, progress=lambda *word: said.append(word))
    assert len(said) >= 4 * 9
    assert said == sorted(said)
    assert 0.0 == said[0][1] < said[-1][1] < 1.0
    for channel in report.channels:
        assert len(channel.marks) >= 9
        assert all(math.hypot(mark.dx_pixel, mark.dy_pixel) < 0.02 for mark in channel.marks)
        assert all(mark.theory_dx_pixel == mark.theory_dy_pixel == 0.0 for mark in channel.marks)
        assert channel.scale == pytest.approx(1.0, abs=3e-4)


@pytest.mark.parametrize("change", ["crosstalk", "photosite"])
def test_theory_knows_what_else_moves_a_picture(change):
    """Half of the charge goes to the right, half below that; or a photosite is a triangle beside its middle."""
    chart = "{kind: chart, name: dot-grid, spacing: 28, radius: 8, rows: 3, cols: 5}"
    capture = captured(chart, "mono-345", "noise.enabled=false", "render.tolerance=1e-3")
    pitch_um = capture.camera.pitch_um
    if change == "crosstalk":
        stage, right, down = camsim.Crosstalk(kernel=((0, 0, 0), (0, 0, 0.5), (0, 0, 0.5))), 1.0, 0.5
    else:
        half = 0.5 * pitch_um
        stage = camsim.PolygonPhotosite(points_um=((-half, -half), (half, -half), (-half, half)))
        right = down = 1.0 / 6.0  # its own middle is so far above on the left
    moved = dataclasses.replace(capture, camera=capture.camera.replace(**{change: stage}))
    (grey,) = measure_distortion(picture_of_frame(moved.frame(), "mean_electrons"), moved).channels
    assert (grey.theory.shift_x_pixel, grey.theory.shift_y_pixel) == pytest.approx((right, down), abs=1e-3)
    assert grey.off_theory_rms_pixel < 0.01


def field_lens(wavelength_nm, **law):
    waves = np.zeros((len(wavelength_nm), 2, 1)).tolist()
    return camsim.FieldLens(f_number=5.6, wavelength_nm=wavelength_nm, zernike=[4], waves=waves, **law)


def test_a_field_lens_has_its_own_law_beside_what_is_seen():
    """Barrel distortion of 3 px in the corners and lateral colour; dots drawn where these put them, not by the lens."""
    lateral = [[0, 4], [0, -4]]
    lens = field_lens([500, 600], height_um=[0, 400], distortion_powers=[-0.12], lateral_colour_um=lateral)
    chart = "{kind: chart, name: dot-grid, spacing: 20, radius: 5, rows: 5, cols: 7}"
    capture = captured(chart, None, "light={line_nm: 525, illuminance_lux: 2000}")
    capture = dataclasses.replace(capture, camera=capture.camera.replace(lens=lens))
    image, falls = np.full((ROWS, COLS), 900.0), {}
    for v in np.arange(-2, 2.1) * SPACING:
        for u in np.arange(-3, 3.1) * SPACING:
            # A quarter of the way from 500 to 600 nm: half of 4 µm at 400 µm, outwards.
            factor = (1.0 - 0.12 * ((u * u + v * v) * (3.45 / 400.0) ** 2)) * (1.0 + 2.0 / 400.0)
            falls[u, v] = np.array([u, v]) * (factor - 1.0)
            away = np.hypot(X - u * factor, Y - v * factor)
            near = away < 16
            image[near] -= 800.0 * blurred_disc(away[near], 5.0, 0.8)
    report = measure_distortion(
        Picture(name="grid", shape=(ROWS, COLS), planes=(Plane(name="Y", samples=image),)), capture
    )
    (grey,) = report.channels
    assert len(grey.marks) == 35
    assert grey.off_theory_rms_pixel < 0.01
    for mark in grey.marks:
        at = falls[round(mark.x_pixel, 6), round(mark.y_pixel, 6)]
        assert (mark.theory_dx_pixel, mark.theory_dy_pixel) == pytest.approx(tuple(at), abs=2e-3)
        assert (mark.dx_pixel, mark.dy_pixel) == pytest.approx(tuple(at), abs=0.02)
    assert max(abs(mark.dx_pixel) for mark in grey.marks) > 2.0
    assert grey.k1 == pytest.approx(grey.theory.k1, rel=0.02)


def test_lateral_colour_in_daylight_is_what_the_lens_states():
    """Every wavelength's dots drawn where the lens puts them, weighed by D55 and the channels' own triangles."""
    nm = np.arange(380.0, 781.0, 20.0)
    seen = {
        letter: np.maximum(1.0 - abs(nm - peak) / 80.0, 0.0)
        for letter, peak in zip("RGB", (620, 540, 460), strict=True)
    }
    weight = {letter: curve * aligned("light", "D55")[::4] for letter, curve in seen.items()}
    lateral = [[0, 0.06 * (550 - at)] for at in (380, 550, 780)]  # 1e-4 of the height for each nm
    lens = field_lens([380, 550, 780], height_um=[0, 600], lateral_colour_um=lateral)
    capture = captured("{kind: chart, name: dot-grid, spacing: 20, radius: 5, rows: 3, cols: 7}")
    curves = [(letter, camsim.Curve(nm, curve, outside="zero")) for letter, curve in seen.items()]
    efficiency = camsim.QuantumEfficiency(curves, per="energy", peak=0.5)
    camera = capture.camera.replace(lens=lens, quantum_efficiency=efficiency, filters=())
    capture = dataclasses.replace(capture, camera=camera, light=camsim.Light("D55", illuminance_lux=2000.0))
    mosaic = np.full((ROWS, COLS), 900.0)
    for k, letter in enumerate("RGB"):
        for v in (-20.0, 0.0, 20.0):
            for u in np.arange(-3, 3.1) * SPACING:
                near = (np.hypot(X - u, Y - v) < 16) & (k == BAYER)
                for at, share in zip(nm, weight[letter] / weight[letter].sum(), strict=True):
                    if share:
                        larger = 1 + 1e-4 * (550 - at)
                        away = np.hypot(X[near] - u * larger, Y[near] - v * larger)
                        mosaic[near] -= 800.0 * share * blurred_disc(away, 5.0, 0.8)
    planes = mosaic_planes(mosaic, ("RG", "GB"))
    report = measure_distortion(Picture(name="grid", shape=(ROWS, COLS), planes=planes), capture)
    mean_nm = {letter: (nm * one).sum() / one.sum() for letter, one in weight.items()}
    for channel in report.channels:
        letter = channel.channel[0]
        assert len(channel.marks) == 21
        assert channel.theory.scale == pytest.approx(1 + 1e-4 * (550 - mean_nm[letter]), abs=1e-4)
        assert channel.scale == pytest.approx(channel.theory.scale, abs=2e-4)
        assert channel.off_theory_rms_pixel < 0.02
        if letter != "G":
            away = 1e-4 * abs(mean_nm[letter] - mean_nm["G"]) * math.hypot(60, 20)
            assert away > 0.4
            assert channel.lateral_largest_pixel == pytest.approx(away, abs=0.03)


def test_a_scene_without_marks_is_refused():
    capture = captured("{kind: disc, radius: 5, reflectance: 0.1}", None, "render.tolerance=1e-2")
    with pytest.raises(UnsupportedError, match="no chart dot-grid or checkerboard"):
        measure_distortion(picture_of_frame(capture.frame()), capture)
