"""Colours of patches measured on captures whose colours are known another way."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import ndimage

import camsim
from camsim.errors import UnsupportedError
from camsim.measure import Picture, picture_of_frame
from camsim.measure.colour import measure_colour
from camsim.measure.colour.areas import margin_pixel
from camsim.measure.colour.picture import halves
from camsim.measure.picture import mosaic_planes
from camsim.sensor.colour_matrix import as_shot_neutral, fit_for_development
from camsim.spectra.colour_science import colour_science
from camsim.spectra.named import reflectance_names
from tests.colour_data import aligned, patches, white_xyz

NODES_NM = np.arange(380.0, 781.0, 5.0)
SETTINGS = ["region={rows: 56, cols: 72}", "render.tolerance=1e-3", "lens.f_number=2"]
CHART = "scene.shapes=[{kind: chart, name: colorchecker, width: 250, centre: [%s]}]"


def captured(*changes, centre="81, 40.5", name="colorchecker-card"):
    """A window upon four patches of a large chart."""
    return camsim.load(name, overrides=[*SETTINGS, CHART % centre, *changes])


def test_a_camera_that_sees_as_the_eye_does_has_no_errors():
    """Channels that are mixtures of x̄, ȳ, z̄: the matrix is exact, and the reference is colour-science's."""
    capture = captured("noise.enabled=false", "light.illuminant=A", "files.colour_matrix=scene")
    eye = aligned("observer", "CIE 1931 2 Degree Standard Observer").T
    seen = {"R": 0.8 * eye[0] + 0.3 * eye[1], "G": 0.1 * eye[0] + eye[1], "B": eye[2] + 0.1 * eye[1]}
    curves = [(letter, camsim.Curve(NODES_NM, curve, outside="zero")) for letter, curve in seen.items()]
    camera = capture.camera.replace(
        quantum_efficiency=camsim.QuantumEfficiency(curves, per="energy", peak=0.5), filters=()
    )
    capture = replace(capture, camera=camera)
    frame = capture.frame(products=("mosaic", "truth"))
    report = measure_colour(picture_of_frame(frame, "electrons"), capture)
    assert len(report.patches) >= 4
    assert report.delta_e_largest < 0.3  # what the lens spreads over the patches' rims
    white = report.white_balance
    assert white is None or white.r_over_g == pytest.approx(1.0, abs=2e-3)
    truth = measure_colour(picture_of_frame(frame, "truth"), capture)
    for mosaic, whole in zip(report.patches, truth.patches, strict=True):
        assert mosaic.lab == pytest.approx(whole.lab, abs=0.1)


def test_the_reference_is_what_sums_over_the_spectra_give():
    colour, capture = colour_science(), captured("light.illuminant=A", centre="0, -40.5")
    report = measure_colour(picture_of_frame(capture.frame()), capture)
    assert {"neutral 6.5", "neutral 5"} <= {patch.name for patch in report.patches}
    d50 = np.array([0.9642, 1.0, 0.8249])
    eye, power = aligned("observer", "CIE 1931 2 Degree Standard Observer"), aligned("light", "A")
    seen = (patches() * power) @ eye / (power @ eye[:, 1])
    adapt = colour.adaptation.matrix_chromatic_adaptation_VonKries(white_xyz("A"), d50, "Bradford")
    lab = colour.XYZ_to_Lab(seen @ adapt.T, colour.XYZ_to_xy(d50))
    expected = dict(zip(reflectance_names(), lab.tolist(), strict=False))
    for patch in report.patches:
        assert patch.reference_lab == pytest.approx(expected[patch.name], abs=0.1)
    assert report.white_balance.r_over_g == pytest.approx(1.0, abs=0.02)


def test_noise_is_that_of_a_bilinear_development():
    """Normal noise of the patches' means, spread by the tents of a Bayer array's bilinear interpolation."""
    capture = captured()
    frame = capture.frame()
    report = measure_colour(picture_of_frame(frame), capture)
    tent = np.array([[1, 2, 1], [2, 4, 2], [1, 2, 1]]) / 4.0
    cross = np.array([[0, 1, 0], [1, 4, 1], [0, 1, 0]]) / 4.0
    for patch in report.patches[:2]:
        roi, planes = patch.roi, []
        at = np.s_[roi.row : roi.row + roi.rows, roi.col : roi.col + roi.cols]
        for k in range(3):
            one = frame.channel_index == k
            signal = np.where(one, frame.mosaic.astype(float) - frame.black_level_dn, 0.0)
            planes.append(ndimage.convolve(signal, tent if k != 1 else cross, mode="constant")[at])
        # Luminance is the only figure that needs no Lab: the second row of the camera's matrix.
        forward = fit_for_development(frame.colour).forward[1]
        neutral = as_shot_neutral(frame.colour)
        luminance = np.einsum("c,crk->rk", forward / neutral, np.array(planes))
        inner = luminance[2:-2, 2:-2]
        assert patch.snr_db == pytest.approx(20 * np.log10(inner.mean() / inner.std()), abs=0.8)


def test_a_wrong_white_balance_is_measured():
    capture = captured("noise.enabled=false", centre="0, -40.5")
    frame = capture.frame()
    electrons = frame.electrons.copy()
    electrons[frame.channel_index == 0] *= 1.05
    report = measure_colour(picture_of_frame(replace(frame, electrons=electrons), "electrons"), capture)
    assert report.white_balance.r_over_g == pytest.approx(1.05, abs=3e-3)
    assert report.white_balance.b_over_g == pytest.approx(1.0, abs=3e-3)
    right = measure_colour(picture_of_frame(frame, "electrons"), capture)
    assert report.white_balance.chroma > right.white_balance.chroma + 1.0


def test_a_bent_read_out_changes_no_colour():
    """A knee from a fifth of full scale on, by which ΔE2000 was 19: mean electrons come before it."""
    knee = "sensor.charge.nonlinearity={kind: table, electrons_in: [0, 8000, 40000], electrons_out: [0, 8000, 16000]}"
    capture = captured("noise.enabled=false", knee)
    frame = capture.frame()
    mosaic, before = (measure_colour(picture_of_frame(frame, each), capture) for each in ("mosaic", "mean_electrons"))
    for seen, true in zip(mosaic.patches, before.patches, strict=True):
        assert seen.lab == pytest.approx(true.lab, abs=0.3)  # codes are whole
    assert mosaic.delta_e_mean < 3.0


def test_halves_show_what_is_measured_and_what_should_be():
    capture = captured("noise.enabled=false")
    picture = picture_of_frame(capture.frame(), "electrons")
    report = measure_colour(picture, capture)
    displayed, colour = halves(picture, capture, report), colour_science()
    white = colour.XYZ_to_xy([0.9642, 1.0, 0.8249])
    assert displayed.shape == (56, 72, 3)
    for patch in report.patches:
        roi = patch.roi
        row, middle = roi.row + roi.rows // 2, roi.col + roi.cols // 2
        left, right = (displayed[row, middle + side].astype(int) for side in (-2, 2))
        assert np.abs(left - right).max() < 30
        wanted = colour.XYZ_to_sRGB(colour.Lab_to_XYZ(patch.reference_lab, white), white)
        assert right / 255 == pytest.approx(np.clip(wanted, 0, 1), abs=0.01)


def test_patches_are_found_where_a_distorting_lens_puts_them():
    """Greys looked up where each photosite's light comes from: one photosite of another's would be noise."""
    greys = {0.05: (-82, -62), 0.2: (82, -62), 0.4: (-82, 62), 0.8: (82, 62)}
    shapes = ", ".join(
        f"{{kind: rectangle, width: 130, height: 100, centre: [{x}, {y}], reflectance: {grey}}}"
        for grey, (x, y) in greys.items()
    )
    capture = captured(f"scene={{unit: um, background: {{reflectance: 0.5}}, shapes: [{shapes}]}}")
    lens = camsim.FieldLens(
        f_number=2.0,
        wavelength_nm=[550],
        zernike=[4],
        waves=[[[0.0], [0.0]]],
        height_um=[0, 230],
        distortion_powers=[-0.2],
        lateral_colour_um=[[0, 1.0]],
    )
    capture = replace(capture, camera=capture.camera.replace(lens=lens))
    rows, cols, pitch_um = 56, 72, 4.88
    y, x = (np.indices((rows, cols)) + 0.5 - 0.5 * np.array([rows, cols])[:, None, None]) * pitch_um
    u, v = x.copy(), y.copy()
    for _ in range(60):
        shrunk = 1.0 - 0.2 * (u**2 + v**2) / 230.0**2
        u, v = x / shrunk, y / shrunk
    seen = np.full((rows, cols), 0.5)
    for grey, (at_x, at_y) in greys.items():
        seen[(np.abs(u - at_x) < 65) & (np.abs(v - at_y) < 50)] = grey
    index = np.array([[0, 1], [1, 2]])[np.indices((rows, cols))[0] % 2, np.indices((rows, cols))[1] % 2]
    diffuser_e = capture.camera.diffuser_electrons(capture.light, capture.time_s)
    planes = mosaic_planes(seen * diffuser_e[index], ("RG", "GB"))
    report = measure_colour(Picture(name="greys", shape=(rows, cols), planes=planes), capture)
    assert {float(patch.name) for patch in report.patches} == set(greys)
    for patch in report.patches:
        assert patch.lab == pytest.approx((116.0 * np.cbrt(float(patch.name)) - 16.0, 0.0, 0.0), abs=1e-3)
        assert max(patch.noise_lab) < 1e-3
        # All but 4.1 px along the outline, of at least 10 rows and 15 columns.
        assert patch.photosites > 150


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (["scene.shapes=[]"], "the scene shows no patch"),
        (["exposure.time_s=10"], "clipped; expose less"),
    ],
)
def test_what_gives_no_colour_is_refused(changes, said):
    capture = captured(*changes)
    with pytest.raises(UnsupportedError, match=said):
        measure_colour(picture_of_frame(capture.frame()), capture)


def test_a_mono_camera_is_refused():
    capture = camsim.load("siemens-star", overrides=["region={rows: 8, cols: 8}", "render.tolerance=1e-2"])
    with pytest.raises(UnsupportedError, match="channels Y; colours need R, G and B"):
        measure_colour(picture_of_frame(capture.frame()), capture)


@pytest.mark.parametrize(
    ("lens", "blur_um"),
    [
        (camsim.Airy(f_number=8.0), 0.55 * 8.0),
        # Its MTF50 by its closed form, over a perfect lens's, which is 0.404 of the cut-off.
        (camsim.Gaussian(sigma_um=3.0, f_number=2.0), 0.404 * np.pi * 3.0 / np.sqrt(0.5 * np.log(2.0))),
    ],
    ids=["airy", "gaussian"],
)
def test_along_a_patch_four_blurs_and_three_pixels_are_left_out(lens, blur_um):
    capture = captured()
    capture = replace(capture, camera=capture.camera.replace(lens=lens))
    assert margin_pixel(capture) == pytest.approx(3.0 + 4.0 * blur_um / capture.camera.pitch_um, rel=0.03)
