"""From a picture of a dot grid or a checkerboard to distortion and lateral colour."""

from __future__ import annotations

import math

import numpy as np

from camsim.errors import UnsupportedError
from camsim.exposing import Capture
from camsim.measure.distortion.marks import Marks, locate_mark, marks_of
from camsim.measure.distortion.result import (
    ChannelDistortion,
    DistortionReport,
    MarkPlace,
    half_diagonal_pixel,
    radial_fit,
)
from camsim.measure.geometry import Roi
from camsim.measure.picture import Channel, Picture

_LEAST_MARKS = 4


def measure_distortion(picture: Picture, capture: Capture) -> DistortionReport:
    """Measure where the marks of the capture's chart are seen, in every channel.

    A mark is looked for within half a dot's spacing, or 0.7 of a square, of its place. Raises UnsupportedError for a
    scene without a dot grid or a checkerboard, and where fewer than four marks are found.
    """
    marks = marks_of(capture.scene)
    if marks is None:
        raise UnsupportedError("the scene has no chart dot-grid or checkerboard", stage=picture.name)
    found: dict[str, dict[int, MarkPlace]] = {}
    left_out = []
    for channel in picture.select("all"):
        placed, missed = _places(channel, picture, capture, marks)
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


def _places(channel: Channel, picture: Picture, capture: Capture, marks: Marks) -> tuple[dict[int, MarkPlace], int]:
    """Return the marks found, by number, and how many that lie whole in the picture were not."""
    left, top = capture.grid.first_centre
    pitch_um = capture.camera.pitch_um
    reach = marks.reach_um / pitch_um
    found, missed = {}, 0
    for number, (x_um, y_um) in enumerate(marks.places_um.tolist()):
        # In pixels of the picture.
        x, y = x_um / pitch_um - left + 0.5, y_um / pitch_um - top + 0.5
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
            dx_pixel=place[0],
            dy_pixel=place[1],
            error_pixel=place[2],
        )
    return found, missed


def _channel(name: str, found: dict[str, dict[int, MarkPlace]], reference: str, picture: Picture) -> ChannelDistortion:
    marks = tuple(found[name].values())
    half = half_diagonal_pixel(picture.full_frame)
    (shift_x, shift_y, scale, k1, k2), left = radial_fit(marks, half)
    farthest = max(mark.radius_pixel for mark in marks) / half
    away = [
        math.hypot(mark.dx_pixel - other.dx_pixel, mark.dy_pixel - other.dy_pixel)
        for number, mark in found[name].items()
        if (other := found[reference].get(number)) is not None
    ]
    lateral = None if name == reference or not away else np.array(away)
    return ChannelDistortion(
        channel=name,
        marks=marks,
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
