"""Colour matrices of a camera: from its channels to CIE XYZ and back.

A camera's channels are no linear combination of the eye's, so no matrix is right for every surface. The one
fitted here is right for white, exactly, and the best in the mean over 190 measured reflectances.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from camsim.arrays import F64
from camsim.errors import InvalidValueError, UnsupportedError
from camsim.spectra.colour_science import colour_science

XYZ_D50 = np.array([0.9642, 1.0, 0.8249])
"""White of the ICC profile connection space (ICC.1:2022, 7.2.16), which DNG's forward matrices lead to."""

BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
"""XYZ to sharpened cones: Lam's Bradford transform, as in ICC.1:2022 annex E."""

MatrixOf: TypeAlias = Literal["standard", "scene"]
"""Which lights a DNG's matrices are for: CIE A and D65, or the capture's own."""

_WAVELENGTH_NM = np.arange(380.0, 781.0)
_DARKEST_NEUTRAL = 1e-3
_LEAST_RANK = 1e-6


@dataclass(frozen=True, eq=False)
class ColourResponse:
    """How the channels see light: what colour matrices and the white balance are made from.

    channels        names, such as ("R", "G", "B")
    wavelength_nm   (n,) nodes, increasing
    sensitivity     (channels, n) response per unit radiant energy, lens and filters included, any scale
    light           (n,) relative spectral power of the scene's light
    matrix          which lights a file's colour matrices are to be for
    """

    channels: tuple[str, ...]
    wavelength_nm: F64
    sensitivity: F64
    light: F64
    matrix: MatrixOf = "standard"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ColourFit:
    """Linear relation of camera and XYZ under one light, exact for a perfect diffuser.

    neutral         (channels,) response to the perfect diffuser, the largest 1
    white_xyz       (3,) the perfect diffuser's XYZ, Y = 1
    camera_to_xyz   (3, channels) takes ``neutral`` to ``white_xyz``
    """

    neutral: F64
    white_xyz: F64
    camera_to_xyz: F64

    @property
    def xyz_to_camera(self) -> F64:
        """(channels, 3): DNG's ColorMatrix. White gives ``neutral``, whose largest is 1."""
        matrix: F64 = np.asarray(np.linalg.pinv(self.camera_to_xyz), dtype=np.float64)
        return matrix

    @property
    def forward(self) -> F64:
        """(3, channels): DNG's ForwardMatrix, white-balanced camera to XYZ adapted to D50 (Bradford).

        Every row sums to D50's white, so that a balanced grey is a grey.
        """
        matrix: F64 = adaptation(self.white_xyz, XYZ_D50) @ (self.camera_to_xyz * self.neutral)
        return matrix

    def seen_under(self, white_xyz: F64) -> ColourFit:
        """Return the same relation with XYZ adapted (Bradford) to another white, as if the light had been that."""
        to_xyz: F64 = adaptation(self.white_xyz, white_xyz) @ self.camera_to_xyz
        return ColourFit(neutral=self.neutral, white_xyz=white_xyz, camera_to_xyz=to_xyz)


def adaptation(from_xyz: F64, to_xyz: F64) -> F64:
    """(3, 3) matrix that takes colours seen under one white to the other, after Bradford.

    >>> (adaptation(np.array([1.0985, 1.0, 0.3558]), XYZ_D50) @ [1.0985, 1.0, 0.3558]).round(4).tolist()
    [0.9642, 1.0, 0.8249]
    """
    cones = (BRADFORD @ to_xyz) / (BRADFORD @ from_xyz)
    matrix: F64 = np.linalg.solve(BRADFORD, cones[:, None] * BRADFORD)
    return matrix


def as_shot_neutral(response: ColourResponse) -> F64:
    """Response of the channels to a perfect diffuser in the scene's light; (channels,), the largest is 1.

    A channel that is blind in this light (a laser's, say) gets a thousandth: developers divide by it.
    """
    weight = _widths(response.wavelength_nm) * response.light
    neutral: F64 = response.sensitivity @ weight
    largest = float(neutral.max())
    if not largest > 0:
        raise InvalidValueError("no channel of the camera responds to the scene's light: there is no white balance")
    return np.maximum(neutral / largest, _DARKEST_NEUTRAL)


def fit(response: ColourResponse, light: str) -> ColourFit:
    """Fit camera to XYZ under CIE illuminant ``light`` ("A" or "D65"), preserving white.

    Least squares in XYZ (CIE 1931 2°) over the 190 reflectances of the Academy's rawtoaces, as shipped by
    colour-science, with one constraint: a perfect diffuser comes out exactly. The scene's own light plays no
    part.

    Raises UnsupportedError when the channels are not independent (one wavelength, two equal channels).
    """
    return _fit(*_key(response), light)


def fit_to_scene(response: ColourResponse) -> ColourFit:
    """Fit as :func:`fit`, but under the capture's own light, and return it in the form of D65.

    Raw developers use the D65 matrix whatever the light. So the fit under the scene's light is given as one that
    takes the light's white to D65's: balanced by ``neutral``, it is then right for the scene.
    """
    power = np.interp(_WAVELENGTH_NM, response.wavelength_nm, response.light, left=0, right=0)
    return _fit(*_key(response), power.tobytes()).seen_under(_surfaces("D65").white_xyz)


def fit_for_development(response: ColourResponse) -> ColourFit:
    """Return the one fit that developers use: D65's, or the scene's in D65's form when that was asked for."""
    return fit_to_scene(response) if response.matrix == "scene" else fit(response, "D65")


def _key(response: ColourResponse) -> tuple[bytes, bytes, int]:
    return response.wavelength_nm.tobytes(), response.sensitivity.tobytes(), len(response.channels)


@functools.lru_cache(maxsize=32)
def _fit(wavelength_bytes: bytes, sensitivity_bytes: bytes, channels: int, light: str | bytes) -> ColourFit:
    surfaces = _surfaces(light)
    nodes = np.frombuffer(wavelength_bytes)
    curves = np.frombuffer(sensitivity_bytes).reshape(channels, -1)
    sensitivity = np.array([np.interp(surfaces.wavelength_nm, nodes, curve, left=0, right=0) for curve in curves])

    white = sensitivity @ surfaces.light
    scale = white.max() if white.max() > 0 else 1.0
    neutral: F64 = white / scale
    camera = (surfaces.reflectance * surfaces.light) @ sensitivity.T / scale

    spread = np.linalg.svd(camera, compute_uv=False)
    if not spread[-1] > _LEAST_RANK * spread[0]:
        under, way_out = ("over 380-780 nm", "write a .tiff, .exr or .npy instead")
        if isinstance(light, bytes):
            under, way_out = ("under the scene's light", "use colour_matrix: standard")
        raise UnsupportedError(
            f"the camera's {channels} channels are not independent of one another {under}, "
            f"so no colour matrix exists; {way_out}"
        )
    inverse = np.linalg.inv(camera.T @ camera)
    free = inverse @ camera.T @ surfaces.xyz
    # Lagrange multipliers, one each for X, Y and Z, move the free fit to where white is exact.
    missing = surfaces.white_xyz - neutral @ free
    towards = inverse @ neutral
    matrix: F64 = (free + np.outer(towards, missing / (neutral @ towards))).T
    return ColourFit(neutral=neutral, white_xyz=surfaces.white_xyz, camera_to_xyz=matrix)


@dataclass(frozen=True, slots=True, eq=False)
class _Surfaces:
    """What is fitted to: reflectance (190, n) in a light (n,), and its XYZ (190, 3) where white has Y = 1."""

    wavelength_nm: F64
    reflectance: F64
    light: F64
    xyz: F64
    white_xyz: F64


@functools.lru_cache(maxsize=8)
def _surfaces(light: str | bytes) -> _Surfaces:
    """Sum over the surfaces in a CIE illuminant, or in a light given by its power at ``_WAVELENGTH_NM``."""
    colour = colour_science()
    wavelength_nm = _WAVELENGTH_NM
    training = colour.characterisation.read_training_data_rawtoaces_v1()
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]

    def sampled(nodes: F64, curves: F64) -> F64:
        return np.array([np.interp(wavelength_nm, nodes, curve) for curve in curves])

    reflectance = sampled(training.wavelengths, training.values.T)
    if isinstance(light, bytes):
        power = np.frombuffer(light)
    else:
        illuminant = colour.SDS_ILLUMINANTS[light]
        power = np.interp(wavelength_nm, illuminant.wavelengths, illuminant.values)
    weights = sampled(observer.wavelengths, observer.values.T) * power
    weights = weights / max(weights[1].sum(), np.finfo(np.float64).tiny)
    return _Surfaces(wavelength_nm, reflectance, power, reflectance @ weights.T, weights.sum(axis=1))


def _widths(wavelength_nm: F64) -> F64:
    """Trapezoid weights of the nodes; a single node has weight 1."""
    return np.gradient(wavelength_nm) if wavelength_nm.size > 1 else np.ones(1)
