"""Truth in four spaces: electrons, balanced camera channels, XYZ and linear sRGB.

The colours do not come from the camera's matrix: the scene is rendered again, with the observer in place of the
camera's channels. With the light's irradiance S(λ), the reflectance ρ(λ, x) and the observer x̄, ȳ, z̄,

    X(x) = k ∫ [ρ(λ, ·) ∗ h_λ](x) S(λ) x̄(λ) dλ,    k = 1 / ∫ S(λ) ȳ(λ) dλ,

h_λ being the PSF of the camera's lens, low-pass filter and photosite. Absorption by lens and filters is not
included; relative illumination is; crosstalk, which concerns the camera's channels only, is not.
"""

from __future__ import annotations

import numpy as np

from camsim.camera.capture import Capture, Progress
from camsim.core.arrays import F32, F64
from camsim.core.typed import known_name
from camsim.errors import UnsupportedError
from camsim.measure.given import check_given
from camsim.measure.truth.image import SPACES, Space, TruthImage
from camsim.rendering.render import render_channels
from camsim.sensor.colour_matrix import adaptation, as_shot_neutral, fit_white, observer

XYZ_TO_SRGB = np.array(
    [
        [3.2404542, -1.5371385, -0.4985314],
        [-0.9692660, 1.8760108, 0.0415560],
        [0.0556434, -0.2040259, 1.0572252],
    ]
)
"""IEC 61966-2-1 primaries under D65 (B. Lindbloom, brucelindbloom.com)."""

CAMERA_SPACES: tuple[Space, ...] = ("electrons", "camera-rgb")


def truth_in(capture: Capture, space: Space, *, progress: Progress | None = None) -> TruthImage:
    """Return the truth of a capture in a space; see ``SPACES``.

    Raises UnknownNameError for another space, UnsupportedError for colours under invisible light.
    """
    check_given(capture=capture)
    known_name("space", space, SPACES, "space")
    if space in CAMERA_SPACES:
        return _of_the_camera(capture, space, progress)
    return _of_the_eye(capture, space, progress)


def balanced(electrons: F32, capture: Capture) -> F32:
    """Return mean electrons (rows, cols, channels) as white-balanced linear channels, scaled so that white clips at 1.

    E_k / (g·(W − B)·n_k) with g electrons per DN, W white level, B black level and n the channels' response to a
    perfect diffuser, the largest 1. Codes D minus black level in place of E/g give the same up to noise, dark current
    and rounding, and clip at 1/n_k.
    """
    check_given(capture=capture, electrons=electrons)
    white_e: F32 = (full_scale_e(capture) * neutral_of(capture)).astype(np.float32)
    scaled: F32 = electrons / white_e
    return scaled


def full_scale_e(capture: Capture) -> float:
    """Return the electrons at which a white surface clips."""
    return capture.camera.charge_at_e(1.0, capture.exposure.iso)


def neutral_of(capture: Capture) -> F64:
    """Return (channels,) responses to a perfect diffuser, relative to the largest of them."""
    return as_shot_neutral(capture.camera.colour_response(capture.light, capture.colour_matrix))


def _of_the_camera(capture: Capture, space: Space, progress: Progress | None) -> TruthImage:
    frame = capture.frame(products=("truth",), progress=progress)
    assert frame.truth is not None
    assert frame.report.truth_error_estimate is not None
    diffuser_e = capture.camera.diffuser_electrons(capture.light, capture.time_s)
    image, diffuser = frame.truth, diffuser_e.astype(np.float32)
    if space == "camera-rgb":
        image, diffuser = balanced(image, capture), balanced(diffuser, capture)
    return TruthImage(
        image=image,
        channels=frame.channels,
        space=space,
        diffuser=tuple(diffuser.tolist()),
        error_estimate=frame.report.truth_error_estimate,
    )


def _of_the_eye(capture: Capture, space: Space, progress: Progress | None) -> TruthImage:
    camera, grid, scene = capture.camera, capture.grid, capture.exposed_scene
    samples = capture.light.samples(scene.spectra, [camera.veiling_glare], observer())
    seen = np.array([curve.at(samples.wavelength_nm) for curve in observer()])
    response = seen * samples.irradiance_w_per_m2_nm * samples.weight_nm
    white = response.sum(axis=1)
    if not white[1] > 0.0:
        raise UnsupportedError(
            f"the eye sees nothing of the light, {capture.light.name}; ask for camera-rgb or electrons", key="space"
        )
    response, white = response / white[1], white / white[1]
    rendering = render_channels(
        scene,
        camera.optics,
        grid,
        response=camera.veil.spared(response, samples.wavelength_nm),
        wavelength_nm=samples.wavelength_nm,
        channel=np.broadcast_to(np.uint8(1), (grid.rows, grid.cols)),
        tolerance=capture.tolerance,
        method=capture.method,
        every_channel=True,
        strict=capture.strict,
        progress=progress,
    )
    assert rendering.planes is not None
    assert rendering.planes_error is not None
    veil = camera.veil.light(scene, response, samples.wavelength_nm, capture.tolerance)
    xyz = rendering.planes + veil[:, None, None]
    if capture.window.falls_off:
        xyz = xyz * capture.window.falloff(grid)
    matrix: F64 = np.eye(3) if space == "xyz" else XYZ_TO_SRGB @ adaptation(white, fit_white("D65"))
    if space == "srgb":
        # White is exactly (1, 1, 1); the table's seven digits miss it by 1e-4.
        matrix /= (matrix @ white)[:, None]
    return TruthImage(
        image=np.einsum("sc,crk->rks", matrix, xyz).astype(np.float32),
        channels=("X", "Y", "Z") if space == "xyz" else ("R", "G", "B"),
        space=space,
        diffuser=tuple(np.einsum("sc,c->s", matrix, white).tolist()),
        error_estimate=rendering.planes_error,
    )
