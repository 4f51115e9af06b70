"""The reference for demosaicing: truth in linear light, photosites used, and development."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy

from camsim.camera.capture import Capture
from camsim.core.arrays import F32, F64, U8
from camsim.core.typed import check
from camsim.errors import InvalidValueError, UnsupportedError
from camsim.measure.given import check_given
from camsim.measure.picture import Picture
from camsim.measure.truth.spaces import XYZ_TO_SRGB, balanced, neutral_of
from camsim.sensor.adc import full_codes
from camsim.sensor.cfa import Cfa
from camsim.sensor.colour_matrix import XYZ_D50, adaptation, fit_for_development, fit_white

CHANNELS = ("R", "G", "B")
BORDER = 8
_BESIDE_CLIPPED = 3
_LEAST = 32
_UNUSED = 0.25
"""Fraction of the range below which bits are unused: 10, 12 or 14 bits in 16."""

Used = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Subject:
    """A truth and everything needed to evaluate a result against it.

    truth   : (rows, cols, 3) linear light, white-balanced; a perfect diffuser is 1
    used    : (rows, cols) mask of photosites used: without border and clipped ones
    neutral : (3,) response to a perfect diffuser, relative to the largest
    to_xyz  : (3, 3) balanced channels to XYZ under D50
    cfa     : filters of the mosaic, letters from (0, 0) (0, 1) …; None if unknown
    level   : level of a perfect diffuser; 1 is where white clips
    clipped : number of photosites excluded as clipped
    """

    name: str
    truth: F32
    used: Used
    neutral: F64
    to_xyz: F64
    cfa: tuple[str, ...] | None
    level: float = 1.0
    clipped: int = 0

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.truth.shape[0], self.truth.shape[1]

    @property
    def channel_index(self) -> U8 | None:
        """Index of R, G or B at each photosite of the mosaic; None if unknown."""
        if self.cfa is None or set("".join(self.cfa)) != set(CHANNELS):
            return None
        return Cfa(self.cfa).channel_index(*self.shape)


def subject_of_capture(capture: Capture, truth_e: F32, *, border: int = BORDER) -> Subject:
    """Return the subject of a capture with the truth ``truth_e`` (rows, cols, channels) in electrons, as in frames.

    Raises UnsupportedError for a camera without the channels R, G and B, or without a colour matrix.
    """
    check_given(capture=capture, truth_e=truth_e)
    camera, name = capture.camera, capture.scene_name
    channels = camera.cfa.channels
    if sorted(channels) != sorted(CHANNELS):
        raise UnsupportedError(
            f"the camera has the channels {', '.join(channels)}; demosaicing is measured in R, G and B", stage=name
        )
    shape = (capture.grid.rows, capture.grid.cols, len(channels))
    if truth_e.shape != shape:
        raise InvalidValueError(f"of shape {truth_e.shape}; the capture's truth has {shape}", key="truth", stage=name)
    order = [channels.index(letter) for letter in CHANNELS]
    diffuser_e = camera.diffuser_electrons(capture.light, capture.time_s).astype(np.float32)
    # After balancing, a diffuser has the same level in all channels.
    level = float(balanced(diffuser_e, capture)[order[1]])
    clipped = np.any(truth_e >= _first_full_e(capture), axis=2)
    used = inside(shape, border, name) & ~scipy.ndimage.binary_dilation(clipped, iterations=_BESIDE_CLIPPED)
    if not used.any():
        raise UnsupportedError("nothing is left to measure, all is clipped or border; expose less", stage=name)
    return Subject(
        name=name,
        truth=(balanced(truth_e, capture)[:, :, order] / np.float32(level)).astype(np.float32),
        used=used,
        neutral=neutral_of(capture)[order],
        to_xyz=fit_for_development(camera.colour_response(capture.light, capture.colour_matrix)).forward[:, order],
        cfa=camera.cfa.window_pattern(capture.grid.origin),
        level=level,
        clipped=int(np.count_nonzero(clipped)),
    )


def _first_full_e(capture: Capture) -> float:
    """Return the electrons at which the first photosites clip: black offsets reduce the range of some."""
    adc, white_dn = capture.camera.converter, capture.white_level_dn
    offsets_dn = np.array(adc.black_offsets_dn)
    span_dn = full_codes(white_dn, offsets_dn, adc.largest_dn) - offsets_dn - adc.black_level_dn
    return capture.camera.charge_at_e(float(span_dn.min()) / (white_dn - adc.black_level_dn), capture.exposure.iso)


def subject_of_picture(
    picture: Picture, *, cfa: tuple[str, ...] | None, border: int = BORDER, white: float | None = None
) -> Subject:
    """Return the subject of any linear picture, with its channels taken as linear sRGB.

    white : value of a perfect diffuser in the picture; None: 1, or for integers the largest of their type

    Raises UnsupportedError if its numbers contradict this, and for filters other than R, G and B.
    """
    check_given(picture=picture)
    truth = planes_of(picture)
    if cfa is not None and set("".join(cfa)) != set(CHANNELS):
        raise InvalidValueError(f"{'/'.join(cfa)}; demosaicing is measured in R, G and B", key="cfa")
    if white is not None and not 0.0 < white < math.inf:
        raise InvalidValueError(f"{white:g}; must be above 0", key="white")
    peak = white or _peak(picture, truth)
    matrix = adaptation(fit_white("D65"), XYZ_D50) @ np.linalg.inv(XYZ_TO_SRGB)
    return Subject(
        name=picture.name,
        truth=truth / np.float32(peak),
        used=inside(truth.shape[:2], border, picture.name),
        neutral=np.ones(3),
        to_xyz=matrix * (XYZ_D50 / matrix.sum(axis=1))[:, None],
        cfa=cfa,
    )


def _peak(picture: Picture, truth: F32) -> float:
    """Return the white level; raises for electrons, or for codes with fewer bits than their type."""
    largest = float(truth.max())
    whole = picture.planes[0].white
    if whole is None and float(truth.mean()) > 1.0:
        why = f"its numbers go up to {largest:.4g}, and of a truth 1 is white"
    elif whole is not None and largest <= _UNUSED * whole:
        why = f"its numbers end at {largest:.4g}, and whole ones of its type at {whole:.4g}, which would be white"
    else:
        return whole or 1.0
    raise UnsupportedError(f"{why}; say with --white what a perfect diffuser has", stage=picture.name)


def planes_of(picture: Picture) -> F32:
    """Return (rows, cols, 3) minus black level of a picture with the planes R, G and B.

    Raises UnsupportedError for a picture without these, or with values that are not finite.
    """
    planes = {plane.name: plane for plane in picture.planes if plane.step == (1, 1)}
    if not set(CHANNELS) <= set(planes):
        names = ", ".join(dict.fromkeys(plane.name for plane in picture.planes))
        raise UnsupportedError(
            f"has the planes {names}, and a demosaiced picture has R, G and B at every photosite", stage=picture.name
        )
    image = np.stack([planes[name].samples for name in CHANNELS], axis=2).astype(np.float32)
    image -= np.array([planes[name].black for name in CHANNELS], np.float32)
    if not np.isfinite(image).all():
        bad = int(np.count_nonzero(~np.isfinite(image)))
        raise UnsupportedError(f"{bad} of its values are no numbers (NaN or infinite)", stage=picture.name)
    return image


def inside(shape: tuple[int, ...], border: int, name: str) -> Used:
    """Return a mask (rows, cols) without a border; raises UnsupportedError if little is left."""
    check(border, int, "border")
    if border < 0 or min(shape[:2]) - 2 * border < _LEAST:
        raise UnsupportedError(
            f"{shape[0]} × {shape[1]} photosites less a border of {border} leave too few; {_LEAST} a side are needed",
            stage=name,
        )
    used = np.zeros(shape[:2], bool)
    used[border : shape[0] - border, border : shape[1] - border] = True
    return used
