"""Distortion and lateral colour from a picture of a dot grid or a checkerboard."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import fields

import numpy as np

from camsim.camera.capture import Capture, Progress
from camsim.core.arrays import F64
from camsim.errors import UnsupportedError
from camsim.measure.distortion.marks import Marks, locate_mark, marks_of
from camsim.measure.distortion.result import (
    ChannelDistortion,
    Displacement,
    DisplacementError,
    DistortionReport,
    MarkPlace,
    half_diagonal_pixel,
    radial_fit,
)
from camsim.measure.distortion.theory import expected_um
from camsim.measure.geometry import Roi
from camsim.measure.given import check_given
from camsim.measure.picture import Channel, Picture
from camsim.measure.straight import straightened

_LEAST_MARKS = 4


def measure_distortion(picture: Picture, capture: Capture, *, progress: Progress | None = None) -> DistortionReport:
    """Measure where the marks of the capture's chart are seen, in every channel.

    progress : called with (stage, fraction done): about 20 ms per mark

    A mark is searched within half a dot's spacing, or 0.7 of a square, of the position that the capture's lens
    predicts. Raises UnsupportedError for a scene without a dot grid or a checkerboard, or for fewer than four marks.
    """
    check_given(picture=picture, capture=capture)
    picture = straightened(picture, capture)
    marks = marks_of(capture.scene)
    if marks is None:
        raise UnsupportedError("the scene has no chart dot-grid or checkerboard", stage=picture.name)
    channels = picture.select("all")
    expected = expected_um(capture, marks, [channel.name for channel in channels])
    found: dict[str, dict[int, MarkPlace]] = {}
    left_out = []
    for done, channel in enumerate(channels):
        if channel.name not in expected:
            left_out.append(f"{channel.name}: the camera has no such channel")
            continue
        tell = functools.partial(_tell, progress, done, len(channels))
        placed, missed = _places(
            channel, picture, capture, marks, expected[channel.name] / capture.camera.pitch_um, tell
        )
        if len(placed) < _LEAST_MARKS:
            left_out.append(f"{channel.name}: {len(placed)} marks found; {_LEAST_MARKS} are the least")
            continue
        if missed:
            left_out.append(f"{channel.name}: {missed} marks in the picture could not be fitted")
        found[channel.name] = placed
    if not found:
        raise UnsupportedError(
            f"no channel shows {_LEAST_MARKS} marks ({left_out[0]}); make dots or squares larger than 8 of a channel's "
            "photosites",
            stage=picture.name,
        )
    reference = next((name for name in found if name.startswith("G")), next(iter(found)))
    return DistortionReport(
        file=picture.name,
        kind=marks.kind,
        full_frame=picture.full_frame,
        reference=reference,
        channels=tuple(_channel(name, found, reference, picture) for name in found),
        left_out=tuple(left_out),
    )


def _tell(progress: Progress | None, done: int, channels: int, part: float) -> None:
    if progress is not None:
        progress("marks", (done + part) / channels)


def _places(
    channel: Channel,
    picture: Picture,
    capture: Capture,
    marks: Marks,
    expected_pixel: F64,
    tell: Callable[[float], None],
) -> tuple[dict[int, MarkPlace], int]:
    """Return the marks found, by number, and the number of complete ones not found."""
    left, top = capture.grid.first_centre
    pitch_um = capture.camera.pitch_um
    reach = marks.reach_um / pitch_um
    found, missed = {}, 0
    for number, (x_um, y_um) in enumerate(marks.places_um.tolist()):
        tell(number / len(marks.places_um))
        # In pixels of the picture, as predicted by the lens.
        dx, dy = expected_pixel[number].tolist()
        x, y = x_um / pitch_um + dx - left + 0.5, y_um / pitch_um + dy - top + 0.5
        row, col = math.floor(y - reach), math.floor(x - reach)
        size = math.ceil(2.0 * reach) + 1
        if row < 0 or col < 0 or row + size > picture.shape[0] or col + size > picture.shape[1]:
            continue
        samples = channel.inside(Roi(row, col, size, size))
        near = np.hypot(samples.x - x, samples.y - y) <= reach
        place = locate_mark(samples.x[near] - x, samples.y[near] - y, samples.signal[near], marks, pitch_um)
        if place is None:
            missed += 1
            continue
        found[number] = MarkPlace(
            channel=channel.name,
            x_pixel=x_um / pitch_um,
            y_pixel=y_um / pitch_um,
            dx_pixel=dx + place[0],
            dy_pixel=dy + place[1],
            error_pixel=place[2],
            theory_dx_pixel=dx,
            theory_dy_pixel=dy,
        )
    return found, missed


def _channel(name: str, found: dict[str, dict[int, MarkPlace]], reference: str, picture: Picture) -> ChannelDistortion:
    marks = found[name]
    half = half_diagonal_pixel(picture.full_frame)
    (measured, error), (theory, _) = (_displacement(found, name, reference, kind, half) for kind in ("", "theory_"))
    off = [m.dx_pixel - m.theory_dx_pixel + 1j * (m.dy_pixel - m.theory_dy_pixel) for m in marks.values()]
    return ChannelDistortion(
        channel=name,
        marks=tuple(marks.values()),
        standard_error=error,
        theory=theory,
        off_theory_rms_pixel=float(np.sqrt(np.mean(np.abs(off) ** 2))),
        **{each.name: getattr(measured, each.name) for each in fields(measured)},
    )


def _displacement(
    found: dict[str, dict[int, MarkPlace]], name: str, reference: str, kind: str, half: float
) -> tuple[Displacement, DisplacementError]:
    """Return the figures of a channel, measured or theoretical, and their standard errors."""

    def move(mark: MarkPlace) -> tuple[float, float]:
        return getattr(mark, f"{kind}dx_pixel"), getattr(mark, f"{kind}dy_pixel")

    marks = list(found[name].values())
    places = np.array([(mark.x_pixel, mark.y_pixel) for mark in marks])
    fitted, left, covariance = radial_fit(places, np.array([move(mark) for mark in marks]), half)
    shift_x, shift_y, scale, k1, k2 = fitted
    farthest = max(mark.radius_pixel for mark in marks) / half
    away = [math.dist(move(found[name][n]), move(found[reference][n])) for n in found[name] if n in found[reference]]
    lateral = None if name == reference or not away else np.array(away)
    powers = np.array([farthest**2, farthest**4])
    errors = [*np.sqrt(np.diag(covariance)), math.sqrt(max(float(powers @ covariance[3:, 3:] @ powers), 0.0))]
    names = (each.name for each in fields(DisplacementError))
    error = DisplacementError(
        **{name: float(each) if math.isfinite(each) else math.nan for name, each in zip(names, errors, strict=True)}
    )
    displacement = Displacement(
        shift_x_pixel=float(shift_x),
        shift_y_pixel=float(shift_y),
        scale=1.0 + float(scale),
        k1=float(k1),
        k2=float(k2),
        largest_distortion=float(k1 * farthest**2 + k2 * farthest**4),
        rms_pixel=float(np.sqrt(np.mean(left**2))),
        lateral_rms_pixel=None if lateral is None else float(np.sqrt(np.mean(lateral**2))),
        lateral_largest_pixel=None if lateral is None else float(lateral.max()),
    )
    return displacement, error
