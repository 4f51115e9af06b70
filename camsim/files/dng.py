"""DNG of a capture: a raw file that raw developers open in the right colours.

Bayer and X-Trans arrays are written as CFA, mono as linear raw of one sample. ``dng_tags`` has the tags, ``given`` the
same for arbitrary arrays.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO

import numpy as np

from camsim.camera.body import MID_GREY
from camsim.camera.frame import Frame
from camsim.core.arrays import U16
from camsim.errors import OutputError
from camsim.files.describe import description_hash, error_text, exif_datetime, record_json
from camsim.files.dng_image import Image, LosslessTiles, Strip
from camsim.files.dng_tags import CFA, D65, LINEAR_RAW, RGB, STANDARD_LIGHT_A, Colour, Metadata, odd_cfa, xmp_packet
from camsim.files.tiff_ifd import (
    Tag,
    ascii_string,
    directories,
    long,
    rational,
    refuse_over_4_gib,
    short,
    undefined,
)
from camsim.sensor.cfa import filters_of
from camsim.sensor.colour_matrix import as_shot_neutral, fit, fit_to_scene
from camsim.sensor.companding import decoding, steps_dn

_RECOMMENDED_EXPOSURE_INDEX = 2
_CODES = {"A": STANDARD_LIGHT_A, "D65": D65}

TRUTH_WHITE_DN = 65535
"""Code of the truth at which the camera would clip."""

_PIECE_ROWS = 256


class MosaicWriter:
    """A DNG of a mosaic that is written while the mosaic is computed, without holding it in memory.

    mono          : whether every photosite has the same filter
    compress      : as lossless JPEG, see ``dng_image``
    allow_odd_cfa : also write arrays that developers misread; ``odd_cfa`` names the programs that fail
    """

    def __init__(
        self, file: BinaryIO, *, cols: int, mono: bool, compress: bool = False, allow_odd_cfa: bool = False
    ) -> None:
        self._image = Image(file, LosslessTiles(cols, components=1 if mono else 2) if compress else Strip())
        self._allow_odd_cfa = allow_odd_cfa

    def take(self, codes: U16) -> None:
        """Write the next rows, (m, cols)."""
        self._image.take(codes)

    def finish(self, frame: Frame) -> None:
        """Write the metadata of the frame; its photosites are not used."""
        why = odd_cfa(frame.cfa_pattern)
        if why and not self._allow_odd_cfa:
            raise OutputError(why)
        _finish(
            frame,
            self._image,
            product="mosaic",
            photometric=LINEAR_RAW if is_mono(frame) else CFA,
            samples=1,
            black_dn=frame.black_levels_dn.tolist(),
            white_dn=_white_dn(frame),
            noise=noise_profile(frame),
            linear_dn=decoding(frame.companding).tolist() if frame.companding else (),
        )


def write_dng(frame: Frame, path: Path, *, allow_odd_cfa: bool = False, compress: bool = False) -> None:
    """Write the mosaic; raises OutputError for an array that developers misread. See ``MosaicWriter``."""
    refuse_over_4_gib(frame.mosaic.nbytes)
    with path.open("wb") as file:
        writer = MosaicWriter(
            file, cols=frame.shape[1], mono=is_mono(frame), compress=compress, allow_odd_cfa=allow_odd_cfa
        )
        writer.take(frame.mosaic)
        writer.finish(frame)


def write_truth(frame: Frame, path: Path, *, compress: bool = False) -> None:
    """Write the truth as linear raw, 16 bits a channel, never demosaiced: black 0, white where the camera clips.

    Developers treat it like the mosaic, so that the two can be compared after development. Values above the camera's
    white are clipped; use .exr and .npy for exact electrons.
    """
    truth = frame.truth
    assert truth is not None
    if len(frame.channels) > 1 and frame.channels != RGB:
        raise OutputError(
            f"a DNG of the truth holds red, green and blue, and this camera has {', '.join(frame.channels)}; "
            "write an .exr or .npy instead"
        )
    rows, cols, samples = truth.shape
    codes_per_e = np.float32(TRUTH_WHITE_DN / frame.clips_at_e)
    with path.open("wb") as file:
        image = Image(file, LosslessTiles(cols, components=1) if compress else Strip())
        for first in range(0, rows, _PIECE_ROWS):
            codes = np.rint(np.clip(truth[first : first + _PIECE_ROWS] * codes_per_e, 0, TRUTH_WHITE_DN))
            image.take((codes if samples > 1 else codes[:, :, 0]).astype(np.uint16))
        _finish(
            frame,
            image,
            product="truth",
            photometric=LINEAR_RAW,
            samples=samples,
            black_dn=((0,),),
            white_dn=TRUTH_WHITE_DN,
            noise=None,
        )


def is_mono(frame: Frame) -> bool:
    """Whether every photosite has the same filter."""
    return len(frame.channels) == 1


def noise_profile(frame: Frame) -> tuple[float, float]:
    """Return S and O: the variance of x is S·x + O, for x = (code − black)/span in 0..1.

    The span is that of the file: DNG subtracts the largest of differing black levels from the white level, for all
    photosites (specification 1.4, chapter 5). Shot noise, if any, has the variance of its electrons; O includes read
    noise and 1/12 DN² of rounding. With a non-linear read-out, the variance is not linear in x: S is right at 18 % of
    the camera's black..white.
    """
    span_dn = _white_dn(frame) - int(frame.black_levels_dn.max())
    shot = frame.shot_e2_per_e / (frame.electrons_per_dn * span_dn)
    # Companded codes are coarser at high signal: S includes that, right at mid-grey.
    step_dn = float(steps_dn(frame.companding, np.array(frame.black_level_dn + MID_GREY * span_dn)))
    shot += (step_dn**2 - 1.0) / 12.0 / (MID_GREY * span_dn**2)
    floor_dn2 = (frame.read_noise_e / frame.electrons_per_dn) ** 2 + 1 / 12
    return float(f"{shot:.9g}"), float(f"{floor_dn2 / span_dn**2:.9g}")


def _white_dn(frame: Frame) -> int:
    """Return the single white level of a DNG: where the first photosites are full.

    Raises OutputError if others are still below black there: black..white would be empty.
    """
    white_dn, black_dn = int(frame.white_levels_dn.min()), int(frame.black_levels_dn.max())
    if white_dn <= black_dn:
        raise OutputError(
            f"a DNG has one white level, and {white_dn} DN, where the first photosites are full, is not above the "
            f"black level {black_dn} of others; write a .tiff, .exr or .npy instead"
        )
    return white_dn


def _finish(
    frame: Frame,
    image: Image,
    *,
    product: str,
    photometric: int,
    samples: int,
    black_dn: Sequence[Sequence[int]],
    white_dn: int,
    noise: tuple[float, float] | None,
    linear_dn: Sequence[int] = (),
) -> None:
    record = record_json(frame, product)
    properties = {
        "Seed": str(frame.seed),
        "DescriptionSHA256": description_hash(frame),
        "ErrorEstimate": error_text(frame, product),
        "Tolerance": f"{frame.report.tolerance:g}",
    }

    def all_tags(layout: tuple[Tag, ...], identity: bytes, at: int) -> tuple[bytes, int]:
        said = Metadata(
            shape=frame.shape,
            photometric=photometric,
            samples=samples,
            cfa_pattern=tuple(row.upper() for row in frame.cfa_pattern),
            channels=filters_of(frame.channels),
            black_dn=black_dn,
            white_dn=white_dn,
            noise=noise,
            linear_dn=linear_dn,
            colour=None if is_mono(frame) else _colour(frame),
            camera_name=frame.camera_name,
            serial=str(frame.serial),
            date=exif_datetime(frame),
            xmp=xmp_packet(properties, record),
        )
        return directories((*layout, *said.tags(identity)), _exif_tags(frame), at)

    image.finish(record, all_tags)


def _colour(frame: Frame) -> Colour:
    """Return matrices for A and D65; or one for the light of the scene or a chart, which developers use as D65's."""
    response = frame.colour.of_filters
    neutral = as_shot_neutral(response)
    if response.matrix == "scene":
        lights = [(D65, fit_to_scene(response))]
    else:
        lights = [(_CODES[light], fit(response, light)) for light in response.lights]
    return Colour(fits=[(code, of.xyz_to_camera, of.forward) for code, of in lights], neutral=neutral)


def _exif_tags(frame: Frame) -> tuple[Tag, ...]:
    date = exif_datetime(frame)
    index = max(1, round(frame.iso))
    return (
        rational(33434, frame.time_s),
        rational(33437, frame.f_number),
        short(34855, min(index, 65535)),  # PhotographicSensitivity; what is above goes to the index
        short(34864, _RECOMMENDED_EXPOSURE_INDEX),
        long(34866, index),
        undefined(36864, b"0230"),  # ExifVersion
        ascii_string(36867, date),
        # A scene in sensor coordinates has no focal length; cameras write 0 mm for unknown lenses.
        rational(37386, 0),
        ascii_string(42036, f"f/{frame.f_number:g}" if frame.f_number else "none"),
    )
