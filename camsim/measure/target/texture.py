"""The MTF of a texture with known truth: the transfer from the scene's spectrum to the picture's.

With S the spectrum of the sharp scene, and M that of a channel's photosites, both under the same window,

    H(f) = Σ Re(M·S*) / Σ |S|²,   the sums over a ring |f|.

Noise and aliasing are uncorrelated with S and average out; a power spectrum alone would count both as sharpness. S is
rendered: the same scene, four times as fine, through a known blur that is divided out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from camsim.camera.capture import Capture
from camsim.camera.exposed_rows import Window
from camsim.camera.window import Region
from camsim.core.arrays import F64
from camsim.core.words import percent
from camsim.errors import UnsupportedError
from camsim.measure.given import check_given
from camsim.measure.lens_places import refuse_distortion
from camsim.measure.picture import Picture, Plane
from camsim.measure.straight import straightened
from camsim.measure.target.dark import dark_signal
from camsim.measure.target.result import TargetMtf, TargetReport, curve
from camsim.measure.theory import CameraOtf
from camsim.optics import Gaussian, SquarePhotosite

_FINER = 4
_SIGMA_PX = 0.12
_LARGEST, _LEAST = 400, 32
_MOST_RINGS = 40
_TOLERANCE = 1e-3
_CLIPPED = 0.002
_WHOLE = 24
"""Size of which the window is a multiple, photosites: a multiple of every filter array's period."""
_HANN_SPREAD = 2.25
"""Correlated bins of the transform under a Hann window, in two dimensions: 1.5²."""


def measure_texture(picture: Picture, capture: Capture) -> TargetReport:
    """Measure how much of a scene's structure arrives in a picture of it, in every channel, averaged over directions.

    Uses the centre of large pictures, 400 photosites per side. The theory is that of a grey texture. Raises
    UnsupportedError for a picture that is small, and where the scene has no structure or noise hides it.
    """
    check_given(picture=picture, capture=capture)
    picture = straightened(picture, capture)
    if min(picture.shape) < _LEAST:
        raise UnsupportedError(
            f"{picture.shape[0]} × {picture.shape[1]} photosites are too few for a texture; give {_LEAST} a side",
            stage=picture.name,
        )
    refuse_distortion(capture, picture.name, "a texture is")
    size = [min(n, _LARGEST) // _WHOLE * _WHOLE for n in picture.shape]
    first = [(n - s) // 2 // _WHOLE * _WHOLE for n, s in zip(picture.shape, size, strict=True)]
    reference = sharp(capture, (first[0], first[1]), (size[0], size[1]))
    lattices = []
    for plane_group in picture.select("all"):
        letter = plane_group.name
        index = letter if letter in reference else letter.rstrip("0123456789")
        if index in reference and len(plane_group.planes) == 1:
            lattices.append((plane_group.planes[0], reference[index]))
    if not lattices:
        raise UnsupportedError(
            "no channel lies on one even lattice of one black level; textures are measured in Bayer arrays and mono",
            stage=picture.name,
        )
    structured = [(plane, one) for plane, one in lattices if one.contrast > _tolerance(capture)]
    if not structured:
        most = max(one.contrast for _, one in lattices)
        raise UnsupportedError(
            f"the scene has no structure to measure: its contrast here is {percent(most)} fall-off apart, and its "
            f"rendering is accurate to {percent(_tolerance(capture))}; show a texture such as dead-leaves",
            stage=capture.scene_name,
        )
    found = [_channel(plane, one.light, (first[0], first[1]), (size[0], size[1]), capture) for plane, one in structured]
    channels = tuple(channel for channel in found if channel is not None)
    if not channels:
        raise UnsupportedError("noise hides the scene's structure; give it more light", stage=picture.name)
    return TargetReport(file=picture.name, method="texture", full_frame=picture.full_frame, channels=channels)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sharp:
    """The sharp scene in a channel.

    light    : (4·rows, 4·cols), with fall-off
    contrast : standard deviation over mean without fall-off, which is smooth and unaffected by the lens's blur
    """

    light: F64
    contrast: float


def _tolerance(capture: Capture) -> float:
    return max(_TOLERANCE, capture.tolerance)


def sharp(capture: Capture, first: tuple[int, int], size: tuple[int, int]) -> dict[str, Sharp]:
    """Return the scene as each channel sees it, blurred by 0.12 px and sampled by squares of a quarter pixel."""
    camera, grid = capture.camera, capture.grid
    frame, pitch_um = grid.frame or (grid.rows, grid.cols), camera.pitch_um / _FINER
    fine = camera.replace(
        rows=_FINER * frame[0],
        cols=_FINER * frame[1],
        pitch_um=pitch_um,
        lens=Gaussian(sigma_um=_SIGMA_PX * camera.pitch_um, transmission=camera.lens.transmission),
        olpf=None,
        photosite=SquarePhotosite(side_um=pitch_um),
        extra_optics=(),
        crosstalk=None,
        falloff=None,
    )
    row, col = grid.origin[0] + first[0], grid.origin[1] + first[1]
    region = Region(_FINER * size[0], _FINER * size[1], (_FINER * row, _FINER * col))
    finer = replace(capture, camera=fine, region=region, tolerance=_tolerance(capture), method="auto")
    truth = finer.frame(products=("truth",)).truth
    assert truth is not None
    shading = Window(
        camera=fine.replace(lens=camera.lens, falloff=camera.falloff),
        grid=finer.grid,
        on_sensor=capture.light.at == "sensor",
    )
    falloff = shading.falloff(finer.grid) if shading.falls_off else 1.0
    found = {}
    for k, name in enumerate(camera.cfa.channels):
        even = truth[..., k].astype(np.float64)
        mean = float(even.mean())
        found[name] = Sharp(light=even * falloff, contrast=float(even.std()) / mean if mean > 0.0 else 0.0)
    return found


def _channel(
    plane: Plane, reference: F64, first: tuple[int, int], size: tuple[int, int], capture: Capture
) -> TargetMtf | None:
    """Return the curve of a channel; None if noise hides it."""
    begin = [(-(f - p)) % s for f, p, s in zip(first, plane.first, plane.step, strict=True)]
    where = tuple(
        slice((f + b - p) // s, (f + b - p) // s + n // s)
        for f, b, p, s, n in zip(first, begin, plane.first, plane.step, size, strict=True)
    )
    stored = plane.samples[where]
    if plane.white is not None and float(np.mean(stored >= plane.white)) > _CLIPPED:
        raise UnsupportedError(f"channel {plane.name} is clipped; expose less", stage=capture.scene_name)
    steps = math.prod(plane.step)
    seen, fy, fx = _spectrum(stored - plane.black, plane.step, [b + 0.5 for b in begin], size)
    true, _, _ = _spectrum(reference, (1.0 / _FINER,) * 2, [0.5 / _FINER] * 2, size)
    seen, rows, cols = seen * steps, *seen.shape
    # The same frequencies of the finer transform, with its blur divided out.
    true = np.roll(true, (rows // 2, cols // 2), axis=(0, 1))[:rows, :cols] / _FINER**2
    true = np.roll(true, (-(rows // 2), -(cols // 2)), axis=(0, 1))
    radius = np.hypot(fy, fx)
    true = true / (np.exp(-2.0 * (np.pi * _SIGMA_PX * radius) ** 2) * np.sinc(fx / _FINER) * np.sinc(fy / _FINER))
    # Levels differ by exposure and gain: the mean of the light, which blur preserves, gives the factor.
    scale = (float(np.mean(stored - plane.black)) - dark_signal(plane, capture)) / float(np.mean(reference))
    if not scale > 0.0:
        return None
    true = true * scale
    nyquist = 0.5 / max(plane.step)
    left, top = capture.grid.first_centre
    middle = (left + first[1] + 0.5 * (size[1] - 1), top + first[0] + 0.5 * (size[0] - 1))
    place_um = middle[0] * capture.camera.pitch_um, middle[1] * capture.camera.pitch_um
    whole = CameraOtf.of(capture)
    seen_as: dict[str, Any] = {"channel": plane.name, "dark": 0.0, "bright": 1.0, "place_um": place_um}
    shift = whole.shift_pixel(nyquist, **seen_as)
    seen = seen * np.exp(2j * np.pi * (fx * shift[0] + fy * shift[1]))
    count = min(_MOST_RINGS, int(min(size) * nyquist) // 2)
    edges = np.linspace(0.0, nyquist, count + 1)[1:]
    frequency, mtf, error = [], [], []
    for low, high in pairwise(edges.tolist()):
        ring = (radius >= low) & (radius < high)
        s, m = true[ring], seen[ring]
        power = float(np.sum(np.abs(s) ** 2))
        if not power > 0.0:
            continue
        transfer = float(np.sum((m * np.conj(s)).real)) / power
        rest = (m - transfer * s) * np.conj(s)
        frequency.append(float(np.sum(radius[ring] * np.abs(s) ** 2)) / power)
        mtf.append(transfer)
        # Each frequency occurs twice, as f and −f.
        error.append(math.sqrt(2.0 * _HANN_SPREAD * float(np.sum(rest.real**2))) / power)
    f = np.array(frequency)
    theory = whole.over_directions(f, **seen_as, about_pixel=shift)
    return curve(plane.name, f, np.array(mtf), np.array(error), nyquist, theory)


def _spectrum(
    values: F64, step: tuple[float, float], begin: list[float], size: tuple[int, int]
) -> tuple[np.ndarray, F64, F64]:
    """Return the transform of samples under a Hann window over ``size`` pixels, and its frequencies, cycles/pixel.

    begin : place of the first sample in the window, pixels
    """
    rows, cols = (b + s * np.arange(n) for b, s, n in zip(begin, step, values.shape, strict=True))
    window = np.outer(*(np.sin(np.pi * at / whole) ** 2 for at, whole in zip((rows, cols), size, strict=True)))
    even = float(np.sum(window * values)) / float(np.sum(window))
    fy, fx = (np.fft.fftfreq(n, s) for n, s in zip(values.shape, step, strict=True))
    turn = np.exp(-2j * np.pi * (np.add.outer(fy * begin[0], fx * begin[1])))
    fy, fx = np.meshgrid(fy, fx, indexing="ij")
    return np.fft.fft2(window * (values - even)) * turn, fy, fx
