"""Veiling glare: a share of all light that a lens spreads evenly over the frame.

A photosite receives (1 − g)·image + g·mean, where the mean is that of the unblurred scene over the frame's rectangle.
For a bright field that ends with the frame, g is the veiling glare index of ISO 9358: a small black patch on it has g
times the signal of the field.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import F64
from camsim.optics import Gaussian, OpticalSystem, SquarePhotosite
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.fields.job import FieldJob
from camsim.rendering.fields.points import PointLayer
from camsim.rendering.fields.samples import splines_of
from camsim.rendering.fields.share import edges_share
from camsim.rendering.grid import Grid
from camsim.rendering.outlines import arranged
from camsim.rendering.spectral import Signals, carrying
from camsim.scene import Rectangle, Scene
from camsim.scene.outlines import Outlines
from camsim.scene.primitives import flattened
from camsim.spectra.curve import Spectrum, spectrum_at

PHASE = 1.5  # radians of half a patch: nodes enough for a spline's polynomial


@dataclass(frozen=True, slots=True, kw_only=True)
class Veil:
    """The share of light that is spread, at every wavelength, and the frame over which it is spread."""

    share: Spectrum
    frame: Grid

    @property
    def there(self) -> bool:
        """Whether the lens spreads any light as glare."""
        return self.share != 0.0

    def spared(self, response: F64, wavelength_nm: F64) -> F64:
        """Return the part of a response (channels, n) that forms the image, without the glare."""
        if not self.there:
            return response
        left: F64 = response * (1.0 - spectrum_at(self.share, wavelength_nm))
        return left

    def light(self, scene: Scene, response: F64, wavelength_nm: F64, tolerance: float) -> F64:
        """Return the glare (channels,) at every photosite, in the unit of the full response (channels, n).

        tolerance : allowed error of the scene's mean, relative to a perfect diffuser
        """
        if not self.there:
            return np.zeros(len(response))
        spread = response * spectrum_at(self.share, wavelength_nm)
        return _mean(scene, self.frame, spread, wavelength_nm, tolerance)


def _mean(scene: Scene, frame: Grid, response: F64, wavelength_nm: F64, tolerance: float) -> F64:
    """Return the mean (channels,) of a scene over a frame."""
    # Detail finer than a photosite does not change the mean: outlines and gradients are sampled as for such a blur.
    pitch_um = frame.pitch_um
    system = OpticalSystem(lens=Gaussian(sigma_um=pitch_um), photosite=SquarePhotosite(side_um=pitch_um))
    scene = _cropped(scene, frame)
    edges, share = scene.framed(scene.background), edges_share(scene)
    seen_nm = wavelength_nm[carrying(response)]
    found = arranged(edges, system, frame, seen_nm, ErrorBudget(share * tolerance), textured=edges is not scene)
    signals = Signals.of(found, response, wavelength_nm)
    start, end = found.start_um / pitch_um, found.end_um / pitch_um
    enclosed = 0.5 * (start[:, 0] * end[:, 1] - end[:, 0] * start[:, 1])
    count = len(found.spectra)
    area = np.bincount(found.left, enclosed, count) - np.bincount(found.right, enclosed, count)
    level = signals.density.sum(axis=2)
    light = area @ (level - level[0])
    if edges is not scene:
        light = light + _of_fields(scene, system, frame, response, wavelength_nm, signals.scale, tolerance)
    mean: F64 = signals.scale * (level[0] + light / (frame.rows * frame.cols))
    return mean


def _cropped(scene: Scene, frame: Grid) -> Scene:
    """Return the scene with the background's spectrum everywhere outside the frame."""
    framed = scene.framed(scene.background)
    boxes = Outlines.of(flattened(framed.shapes)).boxes
    boxes = boxes[np.isfinite(boxes).all(axis=1)]
    half_um = 0.5 * frame.pitch_um * np.array([frame.cols, frame.rows])
    far_um = 2.0 * max(float(np.abs(boxes).max(initial=0.0)), float(half_um.max()))
    about = []
    for axis in (0, 1):
        deep = far_um - half_um[axis]
        for sign in (-1.0, 1.0):
            size_um, centre_um = np.full(2, 2.0 * far_um), np.zeros(2)
            size_um[axis], centre_um[axis] = deep, sign * (half_um[axis] + 0.5 * deep)
            (width_um, height_um), centre = size_um.tolist(), tuple(centre_um.tolist())
            about.append(
                Rectangle(width_um=width_um, height_um=height_um, centre_um=centre, reflectance=scene.background)
            )
    return dataclasses.replace(scene, shapes=[*scene.shapes, *about])


def _of_fields(
    scene: Scene, system: OpticalSystem, frame: Grid, response: F64, wavelength_nm: F64, scale: F64, tolerance: float
) -> F64:
    """Return the light (channels,) of pictures, gradients and points minus the background's, in scale × pitch²."""
    job = FieldJob.of(
        scene, system, frame, response=response, wavelength_nm=wavelength_nm, scale=scale, tolerance=tolerance
    )
    half = 0.5 * np.array([frame.cols, frame.rows])
    light, first = np.zeros(len(response)), 0
    weights = job.density.sum(axis=2)
    for layer in job.layers:
        if isinstance(layer, PointLayer):
            area = layer.light[:, (np.abs(layer.at) <= half).all(axis=1)].sum(axis=1)
        else:
            found = splines_of(layer, cut=PHASE / (math.pi * layer.step), allowed=tolerance)
            area = found.light.sum(axis=(1, 2)) + found.corrections.sum(axis=1)
        light += area @ weights[first : first + layer.planes]
        first += layer.planes
    return light
