"""The MTF of a Siemens star: at radius r its sectors have cycles/(2π·r), and their contrast is the MTF."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from camsim.camera.capture import Capture
from camsim.camera.exposed_rows import Window
from camsim.core.arrays import F64
from camsim.errors import UnsupportedError
from camsim.measure.given import check_given
from camsim.measure.lens_places import refuse_distortion
from camsim.measure.neighbours import neighbours
from camsim.measure.picture import Channel, Picture, Plane
from camsim.measure.straight import straightened
from camsim.measure.target.dark import dark_e
from camsim.measure.target.result import TargetMtf, TargetReport, curve
from camsim.measure.theory import CameraOtf
from camsim.scene.charts import Chart
from camsim.spectra.curve import Spectrum, spectrum_at

_HALF_RING_PX = 1.5
_RIM_PX = 6.0
_RINGS = 40
_HARMONICS, _FINER = (1, 3), (5, 7)
_LEAST_PHOTOSITES = 30
_LEAST_CONTRAST, _CLIPPED = 1e-3, 0.002
FUNDAMENTAL = 4.0 / math.pi
"""Fundamental of hard sectors, relative to their contrast."""


def measure_star(picture: Picture, capture: Capture) -> TargetReport:
    """Measure the Siemens star of a capture's scene, in every channel.

    Photosites of a ring are fitted at their exact angles: mean, fundamental and third harmonic, each with a radial
    gradient, so that a ring may be wide. Contrast is fundamental over mean, relative to that of the two surfaces in
    the channel; exposure has no effect. Raises UnsupportedError for a scene without a star.
    """
    check_given(picture=picture, capture=capture)
    picture = straightened(picture, capture)
    stars = [shape for shape in capture.scene.shapes if isinstance(shape, Chart) and shape.name == "siemens-star"]
    if not stars:
        raise UnsupportedError(
            "the scene has no chart siemens-star; any other scene can be measured as a texture", stage=picture.name
        )
    refuse_distortion(capture, picture.name, "a star is")
    star = stars[-1].parameters
    light = capture.scene.background if star["light"] is None else star["light"]
    channels = []
    for channel in picture.select("all"):
        found = _channel(channel, picture, capture, star, light)
        if found is not None:
            channels.append(found)
    if not channels:
        raise UnsupportedError(
            "the star shows no ring that a channel can follow; give it fewer cycles, a larger radius or more light",
            stage=picture.name,
        )
    return TargetReport(file=picture.name, method="star", full_frame=picture.full_frame, channels=tuple(channels))


def _channel(
    channel: Channel, picture: Picture, capture: Capture, star: Mapping[str, Any], light: Spectrum
) -> TargetMtf | None:
    """Return the curve of a channel; None if no ring can be fitted, or the surfaces are equal in it."""
    contrast = surface_contrast(channel.planes[0], capture, star["dark"], light)
    whole = CameraOtf.of(capture)
    sides = {"dark": star["dark"], "bright": light}
    seen_as: dict[str, Any] = {"channel": channel.name, **sides, "place_um": star["centre_um"]}
    shift = whole.shift_pixel(channel.nyquist_cycles_per_pixel, **seen_as)
    left, top = capture.grid.first_centre
    x, y = (centre_um / capture.camera.pitch_um for centre_um in star["centre_um"])
    middle = x + shift[0] - left, y + shift[1] - top
    radii = _radii(channel, picture, capture, star, middle)
    if contrast is None or not radii[1] > radii[0] + 2.0 * _HALF_RING_PX:
        return None
    radius, phase, signal, falloff = _polar(channel, picture, capture, star, middle)
    per_radius = int(star["cycles"]) / (2.0 * math.pi)
    # Uniformly spaced frequencies, each of a ring around its radius.
    frequency = np.linspace(per_radius / radii[1], per_radius / radii[0], _RINGS)
    rings = np.array([_ring(radius, phase, signal, falloff, per_radius / f, f) for f in frequency.tolist()])
    seen = np.isfinite(rings[:, 0])
    if not seen.any():
        return None
    # Light from beyond the rim is included in the outer rings' means, but not in their contrast.
    mean = float(np.median(rings[seen, 2] / rings[seen, 3])) * rings[:, 3]
    # The cosine is largest at the centre of dark sectors.
    mtf, error = -rings[:, 0] / (mean * FUNDAMENTAL * contrast), rings[:, 1] / (mean * FUNDAMENTAL * abs(contrast))
    theory = whole.over_directions(frequency, **seen_as, about_pixel=shift)
    return curve(channel.name, frequency, mtf, error, channel.nyquist_cycles_per_pixel, theory)


def surface_contrast(plane: Plane, capture: Capture, dark: Spectrum, light: Spectrum) -> float | None:
    """Return the contrast of two surfaces in a plane's channel, difference over sum; None if both look equal in it.

    Crosstalk is included. The sum contains the common offset: veiling glare, and dark charge if the plane includes
    it.
    """
    camera, channel = capture.camera, plane.name
    shares = neighbours(camera, channel)
    if shares is None:
        return None
    samples, held = camera.samples(capture.light, (dark, light)), shares.sum(axis=(0, 1))
    response_e = capture.time_s * np.einsum("c,cn->n", held, camera.image_per_reflectance(samples))
    low, high = (float(np.sum(response_e * spectrum_at(s, samples.wavelength_nm))) for s in (dark, light))
    under = float(held @ capture.veil_e) + dark_e(plane, capture)
    return (high - low) / (high + low + 2.0 * under) if abs(high - low) > _LEAST_CONTRAST * (high + low) else None


def _radii(
    channel: Channel, picture: Picture, capture: Capture, star: Mapping[str, Any], middle: tuple[float, float]
) -> tuple[float, float]:
    """Return the innermost and outermost radius, pixels, of complete rings within the channel's Nyquist frequency."""
    (x, y), pitch_um = middle, capture.camera.pitch_um
    whole = min(x, y, picture.shape[1] - 1 - x, picture.shape[0] - 1 - y) - _HALF_RING_PX
    finest = int(star["cycles"]) / (2.0 * math.pi * channel.nyquist_cycles_per_pixel)
    inner = max(star["inner_radius_um"] / pitch_um + _RIM_PX, finest, 2.0 * _HALF_RING_PX)
    return inner, min(star["radius_um"] / pitch_um - _RIM_PX, whole)


def _polar(
    channel: Channel, picture: Picture, capture: Capture, star: Mapping[str, Any], middle: tuple[float, float]
) -> F64:
    """Return (4, n): radius in pixels, phase of the sectors, signal and fall-off of every photosite of a channel."""
    shading = Window(camera=capture.camera, grid=capture.grid, on_sensor=capture.light.at == "sensor")
    falloff = np.broadcast_to(shading.falloff(capture.grid) if shading.falls_off else 1.0, picture.shape)
    parts = []
    for plane in channel.planes:
        if plane.white is not None and float(np.mean(plane.samples >= plane.white)) > _CLIPPED:
            raise UnsupportedError(f"channel {channel.name} is clipped; expose less", stage=picture.name)
        rows, cols = (
            first + step * np.arange(n)
            for first, step, n in zip(plane.first, plane.step, plane.samples.shape, strict=True)
        )
        x, y = np.meshgrid(cols - middle[0], rows - middle[1])
        phase = int(star["cycles"]) * (np.arctan2(y, x) - math.radians(star["rotate_deg"]))
        parts.append(
            np.stack([np.hypot(x, y), phase, plane.samples - plane.black, falloff[np.ix_(rows, cols)]]).reshape(4, -1)
        )
    return np.concatenate(parts, axis=1)


def _ring(
    radius: F64, phase: F64, signal: F64, falloff: F64, middle: float, frequency: float
) -> tuple[float, float, float, float]:
    """Return in-phase fundamental of a ring, its standard error, mean and fall-off; NaN for too few photosites."""
    chosen = np.abs(radius - middle) < _HALF_RING_PX
    r, turn, values = radius[chosen] - middle, phase[chosen], signal[chosen]
    if values.size < _LEAST_PHOTOSITES:
        return math.nan, math.nan, math.nan, math.nan
    waves = [of(k * turn) for k in _HARMONICS for of in (np.cos, np.sin)]
    columns = [np.ones_like(r), *waves, r, *(wave * r for wave in waves), *(wave * r**2 for wave in waves)]
    # Harmonics of hard sectors that alias to the frequency of the fundamental.
    columns += [np.cos(k * turn) for k in _FINER if k * frequency < 1.0]
    basis = np.stack(columns, axis=1)
    inverse = np.linalg.pinv(np.einsum("ni,nj->ij", basis, basis))
    fitted = np.einsum("ij,nj,n->i", inverse, basis, values)
    rest = values - np.einsum("ni,i->n", basis, fitted)
    variance = float(np.einsum("n,n->", rest, rest)) / max(1, values.size - basis.shape[1])
    if not fitted[0] > 0.0:
        return math.nan, math.nan, math.nan, math.nan
    error = math.sqrt(max(variance * inverse[1, 1], 0.0))
    return float(fitted[1]), error, float(fitted[0]), float(falloff[chosen].mean())
