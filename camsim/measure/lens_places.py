"""A field-varying lens: the optics at a place of the picture, and the mapping of scene points to the sensor.

With x̄ the centroid of a PSF, its OTF is 1 − 2πi f·x̄ near 0, so x̄ follows from the OTF near 0; it includes lateral
colour and coma. A channel has the mean over its wavelengths.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from camsim.camera.body import Body
from camsim.camera.capture import Capture
from camsim.core.arrays import F64, distinct
from camsim.errors import UnsupportedError
from camsim.measure.neighbours import neighbours
from camsim.optics import OpticalSystem
from camsim.optics.protocols import Varies
from camsim.spectra.curve import Spectrum, spectrum_at

_PASSES = 50
_SETTLED_UM = 1e-6
_STAYS_PIXEL = 0.1
_WAVELENGTHS = 9
_NEAR_ZERO = 1e-3
"""Frequency relative to the cut-off at which the phase of an OTF is evaluated."""

_STEPS = np.array([-1.0, 0.0, 1.0])
"""Offsets of the photosites that crosstalk comes from, which shift its light down or right."""


def system_at(camera: Body, x_um: float, y_um: float) -> OpticalSystem:
    """Return the optical system at a place of the sensor."""
    system = camera.optics
    return replace(system, lens=system.lens.at(x_um, y_um)) if isinstance(system.lens, Varies) else system


def fallen_um(camera: Body, points_um: F64) -> F64:
    """Return where points (n, 2) of the scene fall on the sensor after the lens's distortion."""
    lens = camera.lens
    return lens.distorted(points_um) if isinstance(lens, Varies) and lens.distorts else points_um


def scene_place_um(camera: Body, points_um: F64) -> F64:
    """Return the points (n, 2) of the scene imaged to places of the sensor: distortion inverted by iteration."""
    found = points_um
    for _ in range(_PASSES):
        off = fallen_um(camera, found) - points_um
        if not np.any(np.abs(off) > _SETTLED_UM):
            break
        found = found - off
    return found


def middles_um(
    capture: Capture, places_um: F64, surfaces: tuple[Spectrum, Spectrum], channels: Sequence[str] | None = None
) -> dict[str, F64]:
    """Return the centroids (n, 2) of the PSF in each channel, relative to places of the sensor.

    surfaces : the two surfaces at the edges; their difference weights the wavelengths
    channels : channels of a picture, G1 and G2 separate; those that the camera lacks are omitted; None: the camera's

    The centroid is shifted by an asymmetric PSF, an asymmetric photosite and crosstalk.
    """
    camera = capture.camera
    samples = camera.samples(capture.light, surfaces)
    dark, light = (spectrum_at(surface, samples.wavelength_nm) for surface in surfaces)
    weight = camera.image_per_reflectance(samples) * np.abs(light - dark)
    seen = samples.wavelength_nm[weight.max(axis=0) > 0.0]
    names = camera.cfa.channels if channels is None else channels
    shares = {name: one for name in names if (one := neighbours(camera, name)) is not None}
    if not seen.size:
        return {name: np.zeros_like(places_um) for name in shares}
    nm = distinct(np.linspace(float(seen.min()), float(seen.max()), _WAVELENGTHS))
    places = places_um if isinstance(camera.lens, Varies) else np.zeros((1, 2))
    centres = np.array([[_middle_um(camera, place, float(each)) for each in nm] for place in places.tolist()])
    share = np.array([np.interp(samples.wavelength_nm, nm, row) for row in np.eye(nm.size)])  # (wavelengths, samples)
    # For each of the camera's channels, times its light.
    one = np.einsum("kn,cn,mkx->cmx", share, weight, centres)
    down, right = np.meshgrid(_STEPS, _STEPS, indexing="ij")
    from_um = camera.pitch_um * np.stack([right, down])
    found = {}
    for name, part in shares.items():
        held = np.einsum("ijc,c->ij", part, weight.sum(axis=1))
        moved = np.einsum("ijc,cmx->mx", part, one) + np.einsum("ij,xij->x", held, from_um)
        found[name] = np.broadcast_to(moved / max(float(held.sum()), 1e-300), places_um.shape)
    return found


def _middle_um(camera: Body, place_um: Sequence[float], wavelength_nm: float) -> list[float]:
    system = system_at(camera, *place_um)
    f = _NEAR_ZERO * system.cutoff_per_um(wavelength_nm)
    fx, fy = np.array([f, 0.0]), np.array([0.0, f])
    otf = system.point_otf(fx, fy, wavelength_nm) * system.footprint_otf(fx, fy)
    middle: list[float] = (-np.imag(otf) / (2.0 * np.pi * f)).tolist()
    return middle


def refuse_distortion(capture: Capture, stage: str, what: str) -> None:
    """Raise UnsupportedError if the lens distorts the picture."""
    grid, pitch_um = capture.grid, capture.camera.pitch_um
    first = np.array(grid.first_centre) * pitch_um
    size = np.array([grid.cols - 1, grid.rows - 1]) * pitch_um
    corners = np.array([first + size * share for share in ((0, 0), (0, 1), (1, 0), (1, 1))])
    moved = float(np.hypot(*(fallen_um(capture.camera, corners) - corners).T).max()) / pitch_um
    if moved > _STAYS_PIXEL:
        raise UnsupportedError(
            f"the lens moves the scene by up to {moved:.3g} px here, and {what} measured where it stays in place; "
            "give the lens no distortion, or measure edges (camsim measure mtf)",
            stage=stage,
        )
