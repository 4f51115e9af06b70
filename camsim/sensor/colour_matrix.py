"""Colour matrices of a camera: from its channels to CIE XYZ and back.

A camera's channels are not a linear combination of the eye's, so no matrix is exact for every surface. The one
fitted here is exact for white and optimal in least squares over 190 measured reflectances.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from camsim.core.arrays import F64
from camsim.errors import InvalidValueError, UnsupportedError
from camsim.sensor.cfa import filters_of
from camsim.sensor.exposure import electrons_per_reflectance
from camsim.sensor.measured_matrix import MeasuredMatrix
from camsim.sensor.quantum_efficiency import QuantumEfficiency
from camsim.spectra.cached import cached
from camsim.spectra.colour_science import colour_science
from camsim.spectra.curve import Curve, Spectrum
from camsim.spectra.integral import lumped
from camsim.spectra.light import Light, LightSamples

XYZ_D50 = np.array([0.9642, 1.0, 0.8249])
"""White of the ICC profile connection space (ICC.1:2022, 7.2.16), which DNG's forward matrices lead to."""

BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
"""XYZ to sharpened cones: Lam's Bradford transform, as in ICC.1:2022 annex E."""

MatrixOf: TypeAlias = Literal["standard", "scene"]
"""Illuminants of a DNG's matrices: CIE A and D65, or the light of the capture."""

# Range of the measured reflectances, in which matrices are fitted; whole nanometres as in the tables.
_MEASURED = Curve((380.0, 780.0), (1.0, 1.0))
_DARKEST_NEUTRAL = 1e-3
_LEAST_RANK = 1e-6
_NOISE = 0.01
"""Noise of a channel relative to white (photon noise and rounding) that the fit allows for."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ColourResponse:
    """Spectral response of the channels: the input of colour matrices and white balance.

    quantum_efficiency : that of the channels, in the order of the channels
    light     : light on the scene
    passes    : transmissions in the light path (lens, filters), multiplied
    crosstalk : (channels, channels) share that each channel receives from every channel; None: no crosstalk. In
                ``of_filters`` (filters, channels)
    matrix    : illuminants of a file's colour matrices
    measured  : matrices measured on a chart, in place of the fitted ones
    """

    quantum_efficiency: QuantumEfficiency
    light: Light
    passes: tuple[Spectrum, ...] = ()
    crosstalk: tuple[tuple[float, ...], ...] | None = None
    matrix: MatrixOf = "standard"
    measured: tuple[MeasuredMatrix, ...] = ()

    @property
    def lights(self) -> tuple[str, ...]:
        """CIE illuminants of the standard matrices; if matrices were measured, A only if one was measured under A."""
        return ("A", "D65") if not self.measured or any(one.light == "A" for one in self.measured) else ("D65",)

    @property
    def channels(self) -> tuple[str, ...]:
        """Names, such as ("R", "G", "B")."""
        return self.quantum_efficiency.channels

    @property
    def of_filters(self) -> ColourResponse:
        """The response of each colour of filters: channels behind filters of one colour (G and g) are their mean."""
        filters = filters_of(self.channels)
        if len(filters) == len(self.channels):
            return self
        each = np.array([[letter.upper() == colour for letter in self.channels] for colour in filters], np.float64)
        mixed = np.eye(len(self.channels)) if self.crosstalk is None else np.array(self.crosstalk)
        means = np.einsum("fc,ck->fk", each / each.sum(axis=1, keepdims=True), mixed)
        return dataclasses.replace(self, crosstalk=tuple(map(tuple, means.tolist())))

    def to(self, light: Light, *others: Iterable[Spectrum]) -> tuple[LightSamples, F64]:
        """Return a light at its nodes, and (channels, n) the response of each channel there, on any scale.

        others : further curves that the nodes must resolve besides those of the camera, as in ``Light.samples``
        """
        curves = [curve for _, curve in self.quantum_efficiency.curves]
        samples = light.samples(*others, *([spectrum] for spectrum in self.passes), curves)
        # At f/0.5 the whole half space is collected: sensor irradiance equals scene irradiance.
        electrons = electrons_per_reflectance(
            samples,
            f_number=0.5,
            transmission=1.0,
            filters=self.passes,
            quantum_efficiency=self.quantum_efficiency,
            photosite_area_um2=1.0,
            time_s=1.0,
        )
        return samples, electrons if self.crosstalk is None else np.array(self.crosstalk) @ electrons


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ColourFit:
    """Linear relation of camera and XYZ under one light, exact for a perfect diffuser.

    neutral         (channels,) response to the perfect diffuser, the largest 1
    white_xyz       (3,) the perfect diffuser's XYZ, Y = 1
    camera_to_xyz   (3, channels) takes ``neutral`` to ``white_xyz``
    xyz_to_camera   (channels, 3) the inverse: DNG's ColorMatrix. Takes white to ``neutral``, whose largest is 1
    """

    neutral: F64
    white_xyz: F64
    camera_to_xyz: F64
    xyz_to_camera: F64

    @property
    def forward(self) -> F64:
        """(3, channels): DNG's ForwardMatrix, white-balanced camera to XYZ adapted to D50 (Bradford).

        Every row sums to D50's white, so that a balanced grey stays grey.
        """
        matrix: F64 = adaptation(self.white_xyz, XYZ_D50) @ (self.camera_to_xyz * self.neutral)
        return matrix

    def seen_under(self, white_xyz: F64) -> ColourFit:
        """Return the same relation with XYZ adapted (Bradford) to another white."""
        to_xyz: F64 = adaptation(self.white_xyz, white_xyz) @ self.camera_to_xyz
        to_camera: F64 = self.xyz_to_camera @ adaptation(white_xyz, self.white_xyz)
        return ColourFit(neutral=self.neutral, white_xyz=white_xyz, camera_to_xyz=to_xyz, xyz_to_camera=to_camera)


def adaptation(from_xyz: F64, to_xyz: F64) -> F64:
    """(3, 3) matrix that takes colours seen under one white to the other, after Bradford.

    >>> (adaptation(np.array([1.0985, 1.0, 0.3558]), XYZ_D50) @ [1.0985, 1.0, 0.3558]).round(4).tolist()
    [0.9642, 1.0, 0.8249]
    """
    cones = (BRADFORD @ to_xyz) / (BRADFORD @ from_xyz)
    matrix: F64 = np.linalg.solve(BRADFORD, cones[:, None] * BRADFORD)
    return matrix


def as_shot_neutral(response: ColourResponse) -> F64:
    """Response (channels,) to a perfect diffuser in the scene's light, relative to the largest channel.

    A channel without response to this light (a laser, say) gets 0.001, as developers divide by it.
    """
    _, electrons = response.to(response.light)
    neutral = electrons.sum(axis=1)
    largest = float(neutral.max())
    if not largest > 0:
        ends = [nm for _, curve in response.quantum_efficiency.curves for nm in curve.wavelength_nm]
        message = (
            f"no channel of the camera responds to the scene's light, {response.light.name}: there is no white "
            f"balance; its curves go from {min(ends):g} to {max(ends):g} nm: take a light or a sensor that meet, or "
            "write the codes without colours (.tiff, .npy, .exr)"
        )
        raise InvalidValueError(message, key="light")
    balanced: F64 = np.maximum(neutral / largest, _DARKEST_NEUTRAL)
    return balanced


def fit(response: ColourResponse, light: str) -> ColourFit:
    """Fit camera to XYZ under CIE illuminant ``light`` ("A" or "D65"), preserving white.

    Least squares in XYZ (CIE 1931 2°) over the 190 reflectances of the Academy's rawtoaces, as shipped by
    colour-science, with one constraint: a perfect diffuser comes out exactly. The light of the scene has no
    effect. With more than three channels noise is included: the fourth differs little from the others, and a fit
    of surfaces alone would amplify that difference 20 times.

    If matrices were measured on a chart (``measured``), the one for that light, or else the first one not for A, is
    returned in place of a fit, adapted to the light's white.

    Raises UnsupportedError when the channels are not independent (one wavelength, two equal channels).
    """
    if response.measured:
        return _measured(response, light)
    return _fit(response, _standard(light), "over 380-780 nm", "write a .tiff, .exr or .npy instead")


def _measured(response: ColourResponse, light: str) -> ColourFit:
    same = [one for one in response.measured if one.light == light]
    [one, *_] = same or [one for one in response.measured if one.light != "A"] or response.measured
    channels = filters_of(response.channels)
    to_xyz = one.matrix[:, ["RGB".index(letter) for letter in channels]]
    white_xyz = np.array(one.white_xyz, np.float64)
    neutral = np.asarray(np.linalg.solve(to_xyz, white_xyz), np.float64)
    largest = float(neutral.max())
    stated = ColourFit(
        neutral=neutral / largest, white_xyz=white_xyz, camera_to_xyz=to_xyz * largest,
        xyz_to_camera=np.asarray(np.linalg.inv(to_xyz), np.float64) / largest,
    )  # fmt: skip
    return stated if same else stated.seen_under(fit_white(light))


def fit_to_scene(response: ColourResponse) -> ColourFit:
    """Fit like :func:`fit`, but under the light of the capture, and return the result adapted to D65.

    Raw developers use the D65 matrix whatever the light. So the fit under the scene's light is adapted such
    that the white of that light becomes D65's: balanced by ``neutral``, it is then correct for the scene.
    """
    fitted = _fit(response, response.light, "under the scene's light", "use colour_matrix: standard")
    return fitted.seen_under(fit_white("D65"))


def fit_for_development(response: ColourResponse) -> ColourFit:
    """Return the fit that developers use: that for D65, or the scene's adapted to D65 if requested."""
    return fit_to_scene(response) if response.matrix == "scene" else fit(response, "D65")


def fit_white(light: str) -> F64:
    """Return the XYZ (Y = 1) of a perfect diffuser under a CIE illuminant, over the range of the fits.

    >>> fit_white("D65").round(3).tolist()
    [0.95, 1.0, 1.089]
    """
    samples = _standard(light).samples(observer(), [_MEASURED])
    power = samples.weight_nm * samples.irradiance_w_per_m2_nm * _MEASURED.at(samples.wavelength_nm)
    seen = np.einsum("kn,n->k", np.array([curve.at(samples.wavelength_nm) for curve in observer()]), power)
    white: F64 = seen / seen[1]
    return white


def _standard(light: str) -> Light:
    return Light(light, irradiance_w_per_m2=1.0)


@functools.lru_cache(maxsize=32)
def _fit(response: ColourResponse, light: Light, under: str, way_out: str) -> ColourFit:
    samples, electrons = response.to(light, observer(), [_MEASURED])
    seen = np.array([curve.at(samples.wavelength_nm) for curve in observer()])
    power = samples.weight_nm * samples.irradiance_w_per_m2_nm
    # Surfaces are linear between whole nanometres, so light lumped there gives the same integrals.
    wavelength_nm, lumps = lumped(
        samples.wavelength_nm, np.concatenate([electrons, seen * power]) * _MEASURED.at(samples.wavelength_nm)
    )
    count = len(electrons)
    white = lumps.sum(axis=1)
    scale = np.repeat([white[:count].max() or 1.0, white[count + 1] or 1.0], [count, 3])
    neutral, white_xyz = np.split(white / scale, [count])
    measured_nm, surfaces = _surfaces()
    reflectance = np.array([np.interp(wavelength_nm, measured_nm, surface) for surface in surfaces])
    # Not a matrix product: BLAS sums in an order that depends on the number of cores, which would change files.
    camera, xyz = np.split(np.einsum("rn,kn->rk", reflectance, lumps) / scale, [count], axis=1)

    spread = np.linalg.svd(camera, compute_uv=False)
    if not spread[-1] > _LEAST_RANK * spread[0]:
        raise UnsupportedError(
            f"the camera's {count} channels are not independent of one another {under}, "
            f"so no colour matrix exists; {way_out}",
            key="colour_matrix",
        )
    noise = _NOISE if count > len(white_xyz) else 0.0
    to_xyz = _least_squares(camera, xyz, neutral, white_xyz, noise=noise)
    return ColourFit(
        neutral=neutral, white_xyz=white_xyz, camera_to_xyz=to_xyz,
        xyz_to_camera=_back(to_xyz, camera, xyz, neutral, white_xyz),
    )  # fmt: skip


def _back(to_xyz: F64, camera: F64, xyz: F64, neutral: F64, white_xyz: F64) -> F64:
    """Return (n, 3) XYZ to channels: an inverse of ``to_xyz``, which for n > 3 is exact for white.

    The smallest such matrix, the pseudo-inverse, loses the component of white outside the XYZ subspace.
    """
    back: F64 = np.asarray(np.linalg.pinv(to_xyz), np.float64)
    unseen = np.linalg.svd(to_xyz)[2][len(to_xyz) :].T
    if not unseen.size:
        return back
    besides = _least_squares(xyz, (camera - xyz @ back.T) @ unseen, white_xyz, (neutral - back @ white_xyz) @ unseen)
    matrix: F64 = back + unseen @ besides
    return matrix


def _least_squares(given: F64, wanted: F64, white: F64, becomes: F64, *, noise: float = 0.0) -> F64:
    """Return the (m, n) least-squares map of ``given`` (r, n) to ``wanted`` (r, m) that takes white to ``becomes``.

    noise : standard deviation of the given numbers; the expected error is minimised
    """
    inverse = np.linalg.inv(given.T @ given + len(given) * noise**2 * np.eye(given.shape[1]))
    free = inverse @ given.T @ wanted
    # Lagrange multipliers, one for each of m, constrain the free fit to be exact for white.
    missing = becomes - white @ free
    towards = inverse @ white
    matrix: F64 = (free + np.outer(towards, missing / (white @ towards))).T
    return matrix


@functools.cache
def _surfaces() -> tuple[F64, F64]:
    """Return wavelengths (n,) and reflectances (190, n) of the fit; clipped at 0, as one is −2e-18."""
    wavelength_nm, values = map(np.array, _training())
    return wavelength_nm, np.maximum(values, 0.0)


@functools.cache
def observer() -> tuple[Curve, ...]:
    """Return x̄, ȳ and z̄ of the CIE 1931 2° observer, every nanometre."""
    wavelength_nm, values = _matching()
    return tuple(Curve(wavelength_nm, curve) for curve in values)


@cached
def _training() -> tuple[list[float], list[list[float]]]:
    training = colour_science().characterisation.read_training_data_rawtoaces_v1()
    return training.wavelengths.tolist(), training.values.T.tolist()


@cached
def _matching() -> tuple[list[float], list[list[float]]]:
    observer = colour_science().MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    return observer.wavelengths.tolist(), observer.values.T.tolist()
