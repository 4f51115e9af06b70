"""The fit of colour matrices: exact for white, and no matrix that keeps white is better."""

import dataclasses

import numpy as np
import pytest
from scipy import linalg

from camsim.errors import InvalidValueError, UnsupportedError
from camsim.sensor.colour_matrix import XYZ_D50, ColourResponse, adaptation, as_shot_neutral, fit
from camsim.sensor.quantum_efficiency import QuantumEfficiency
from camsim.spectra.colour_science import colour_science
from camsim.spectra.curve import Curve
from camsim.spectra.light import Light

NODES_NM = np.arange(380.0, 781.0, 5.0)


EQUAL_ENERGY = Light(Curve((380.0, 780.0), (1.0, 1.0)), irradiance_w_per_m2=1.0)


def response(sensitivity: np.ndarray, nodes_nm: np.ndarray = NODES_NM, light: Light = EQUAL_ENERGY) -> ColourResponse:
    """Channels of these sensitivities per unit energy."""
    curves = tuple((letter, Curve(nodes_nm, curve)) for letter, curve in zip("RGBW", sensitivity, strict=False))
    return ColourResponse(quantum_efficiency=QuantumEfficiency(curves, per="energy", peak=0.5), light=light)


def nikon() -> np.ndarray:
    return colour_science().MSDS_CAMERA_SENSITIVITIES["Nikon 5100 (NPL)"].values.T


def eye() -> np.ndarray:
    colour = colour_science()
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy()
    return observer.align(colour.SpectralShape(380, 780, 5)).values.T


def surfaces_seen(sensitivity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What a camera and the eye see of the surfaces under D65, summed here every 5 nm, white being 1."""
    colour = colour_science()
    surfaces = colour.characterisation.read_training_data_rawtoaces_v1().values.T
    power = colour.SDS_ILLUMINANTS["D65"].copy().align(colour.SpectralShape(380, 780, 5)).values
    lit = surfaces * power
    return lit @ sensitivity.T / (sensitivity @ power).max(), lit @ eye().T / (eye()[1] @ power)


@pytest.mark.parametrize("light", ["A", "D65"])
def test_a_camera_that_sees_like_the_eye_gets_the_exact_matrix(light: str) -> None:
    # Every nm, as the observer is tabulated: nothing is lost in interpolation.
    nodes_nm = np.arange(380.0, 781.0)
    observer = colour_science().MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    curves = np.array([observer[nodes_nm][:, k] for k in range(3)])
    mix = np.array([[0.9, 0.1, 0.0], [0.2, 1.0, 0.1], [0.0, 0.1, 0.6]])
    found = fit(response(mix @ curves, nodes_nm), light)
    expected = np.linalg.inv(mix)
    # Equal up to the scale that makes the largest neutral 1.
    scale = found.camera_to_xyz[0, 0] / expected[0, 0]
    np.testing.assert_allclose(found.camera_to_xyz, scale * expected, atol=1e-9)


@pytest.mark.parametrize("light", ["A", "D65"])
def test_white_is_exact(light: str) -> None:
    found = fit(response(nikon()), light)
    np.testing.assert_allclose(found.camera_to_xyz @ found.neutral, found.white_xyz, rtol=1e-12)
    np.testing.assert_allclose(found.xyz_to_camera @ found.white_xyz, found.neutral, rtol=1e-12)
    np.testing.assert_allclose(found.forward.sum(axis=1), XYZ_D50, rtol=1e-12)
    assert found.neutral.max() == 1
    assert found.white_xyz[1] == pytest.approx(1, rel=1e-12)


def test_no_matrix_that_keeps_white_is_nearer() -> None:
    """Every small change that leaves white alone is worse."""
    camera, seen = surfaces_seen(nikon())
    found = fit(response(nikon()), "D65")

    def misfit(matrix: np.ndarray) -> float:
        return float(((camera @ matrix.T - seen) ** 2).sum())

    rng = np.random.default_rng(0)
    best = misfit(found.camera_to_xyz)
    for _ in range(200):
        change = rng.normal(0, 0.02, (3, 3))
        change -= np.outer(change @ found.neutral, found.neutral) / (found.neutral @ found.neutral)
        assert misfit(found.camera_to_xyz + change) > best


def test_the_scale_of_the_curves_does_not_matter() -> None:
    one, thousand = fit(response(nikon()), "A"), fit(response(1000 * nikon()), "A")
    np.testing.assert_allclose(one.camera_to_xyz, thousand.camera_to_xyz, rtol=1e-10)


def test_four_channels_have_matrices_too() -> None:
    found = fit(response(np.vstack([nikon(), nikon().sum(axis=0) ** 0.5])), "D65")
    assert found.xyz_to_camera.shape == (4, 3)
    assert found.forward.shape == (3, 4)
    np.testing.assert_allclose(found.camera_to_xyz @ found.neutral, found.white_xyz, rtol=1e-9)
    # The pseudo-inverse gave a channel −0.03 … −0.37 of white that has 0.38 … 1 of it.
    np.testing.assert_allclose(found.xyz_to_camera @ found.white_xyz, found.neutral, rtol=1e-9)
    np.testing.assert_allclose(found.camera_to_xyz @ found.xyz_to_camera, np.eye(3), atol=1e-9)
    other = found.seen_under(XYZ_D50)
    np.testing.assert_allclose(other.xyz_to_camera @ XYZ_D50, found.neutral, rtol=1e-9)


def test_four_channels_are_fitted_to_surfaces_with_noise() -> None:
    """White is nearly a mixture of R, G and B: a fit of bare surfaces took noise of the channels 20 … 40 times.

    The mean over a hundred draws of 1 % of white, summed here: of matrices that keep white no scaled step is nearer.
    """
    drawn = (
        ([380, 570, 610, 650, 780], [0.02, 0.05, 0.9, 0.8, 0.0]),
        ([380, 480, 540, 600, 780], [0.0, 0.05, 0.9, 0.05, 0.0]),
        ([380, 450, 520, 780], [0.0, 0.8, 0.03, 0.0]),
        ([380, 420, 540, 650, 780], [0.0, 0.8, 0.95, 0.8, 0.0]),
    )
    curves = np.array([np.interp(NODES_NM, *points) for points in drawn])
    camera, seen = surfaces_seen(curves)
    rng = np.random.default_rng(0)
    noisy = np.tile(camera, (100, 1)) + rng.normal(0.0, 0.01, (100 * len(camera), 4))
    fitted = fit(response(curves), "D65")
    found, neutral = fitted.camera_to_xyz, fitted.neutral
    bare = linalg.lstsq(camera, seen)[0].T
    assert np.linalg.norm(bare, axis=1).max() > 3.0 * np.linalg.norm(found, axis=1).max()

    def misfit(matrix: np.ndarray) -> float:
        return float(((noisy @ matrix.T - np.tile(seen, (100, 1))) ** 2).sum())

    best = misfit(found)
    for _ in range(50):
        change = rng.normal(0.0, 0.1, (3, 4))
        change -= np.outer(change @ neutral, neutral) / (neutral @ neutral)
        assert misfit(found + change) > best


def test_what_four_channels_hold_besides_xyz_is_the_nearest_to_surfaces() -> None:
    """Of camera values of the surfaces no change that keeps white and the inverse is nearer."""
    curves = np.vstack([nikon(), nikon().sum(axis=0) ** 0.5])
    camera, seen = surfaces_seen(curves)
    found = fit(response(curves), "D65")
    unseen = linalg.null_space(found.camera_to_xyz)[:, 0]

    def misfit(matrix: np.ndarray) -> float:
        return float(((seen @ matrix.T - camera) ** 2).sum())

    rng = np.random.default_rng(0)
    best = misfit(found.xyz_to_camera)
    for _ in range(50):
        change = rng.normal(0.0, 0.02, 3)
        change -= change @ found.white_xyz / (found.white_xyz @ found.white_xyz) * found.white_xyz
        assert misfit(found.xyz_to_camera + np.outer(unseen, change)) > best


def test_neutral_is_the_response_to_the_light() -> None:
    """Of a line: the curves' values there, on a straight line between the table's."""
    curves = nikon()
    expected = np.array([np.interp(551.3, NODES_NM, curve) for curve in curves])
    line = Light(line_nm=551.3, irradiance_w_per_m2=7.0)
    np.testing.assert_allclose(
        as_shot_neutral(response(curves, light=line)), np.maximum(expected / expected.max(), 1e-3), rtol=1e-12
    )


def test_neutral_after_filters_and_crosstalk() -> None:
    """On flat light each channel is the sum that its row of crosstalk says, of what the filter lets through."""
    curves = nikon()
    at_line = np.array([np.interp(532.0, NODES_NM, curve) for curve in curves])
    line = Light(line_nm=532.0, irradiance_w_per_m2=1.0)
    crosstalk = ((0.9, 0.1, 0.0), (0.05, 0.9, 0.05), (0.0, 0.2, 0.8))
    mixed = dataclasses.replace(response(curves, light=line), crosstalk=crosstalk, passes=(0.3,))
    expected = np.array(crosstalk) @ at_line
    np.testing.assert_allclose(as_shot_neutral(mixed), expected / expected.max(), rtol=1e-12)


def test_a_fit_undoes_crosstalk() -> None:
    """Mixed channels are the channels times a matrix: so is the matrix back, up to the scale that makes white 1."""
    crosstalk = np.array([[0.9, 0.1, 0.0], [0.05, 0.9, 0.05], [0.0, 0.2, 0.8]])
    clean = response(nikon())
    one, other = (
        fit(given, "D65").camera_to_xyz
        for given in (clean, dataclasses.replace(clean, crosstalk=tuple(map(tuple, crosstalk.tolist()))))
    )
    undone = other @ crosstalk
    np.testing.assert_allclose(undone / undone[1, 1], one / one[1, 1], rtol=1e-9)


def test_a_blind_channel_is_not_divided_by_zero() -> None:
    curves = nikon().copy()
    curves[2] = 0
    assert as_shot_neutral(response(curves)).min() == 1e-3


def test_darkness_has_no_white_balance() -> None:
    infrared = Light(Curve((900.0, 1000.0), (1.0, 1.0)), irradiance_w_per_m2=1.0)
    with pytest.raises(InvalidValueError, match="no channel of the camera responds to the scene's light"):
        as_shot_neutral(response(nikon(), light=infrared))


@pytest.mark.parametrize("case", ["two equal", "one blind", "one line", "blind in the visible"])
def test_channels_that_are_not_independent_have_no_matrix(case: str) -> None:
    curves = nikon().copy()
    if case == "two equal":
        curves[2] = 3 * curves[1]
    elif case == "one blind":
        curves[0] = 0
    elif case == "one line":
        curves *= NODES_NM == 550
    nodes_nm = NODES_NM + 500.0 if case == "blind in the visible" else NODES_NM
    with pytest.raises(UnsupportedError, match=r"no colour matrix exists; write a \.tiff, \.exr or \.npy"):
        fit(response(curves, nodes_nm), "D65")


def test_adaptation_against_colour_science() -> None:
    colour = colour_science()
    one, other = np.array([1.0985, 1.0, 0.3558]), np.array([0.9505, 1.0, 1.0888])
    expected = colour.adaptation.matrix_chromatic_adaptation_VonKries(one, other, "Bradford")
    np.testing.assert_allclose(adaptation(one, other), expected, atol=1e-7)
