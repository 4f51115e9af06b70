"""DNG: a raw file that raw developers open in the right colours.

The tags are those that six raw programs were found to need; their meaning is that of Adobe's Digital Negative
specification 1.4. Bayer and X-Trans arrays are written as CFA, mono as linear raw of one sample.
"""

from __future__ import annotations

import html
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from camsim.arrays import F64, U16
from camsim.errors import OutputError
from camsim.files.describe import (
    ascii_text,
    description_hash,
    error_text,
    exif_datetime,
    record_json,
    software,
)
from camsim.files.dng_image import Image, LosslessTiles, Strip
from camsim.files.reading import XMP_NAMESPACE
from camsim.files.tiff_ifd import (
    Tag,
    ascii_string,
    byte,
    directories,
    double,
    long,
    rational,
    refuse_over_4_gib,
    short,
    srational,
    undefined,
)
from camsim.frame import Frame
from camsim.sensor.colour_matrix import as_shot_neutral, fit, fit_to_scene

_CFA_CODES = {"R": 0, "G": 1, "B": 2, "C": 3, "M": 4, "Y": 5, "W": 6}
"""Of TIFF/EP and the DNG specification."""

_BAYER = (("RG", "GB"), ("BG", "GR"), ("GR", "BG"), ("GB", "RG"))
_RGB = ("R", "G", "B")
_CFA, _LINEAR_RAW = 32803, 34892
_STANDARD_LIGHT_A, _D65 = 17, 21
_RECOMMENDED_EXPOSURE_INDEX = 2
_MAKE = "camsim"

TRUTH_WHITE_DN = 65535
"""Code of the truth at which the camera itself would clip."""

_PIECE_ROWS = 256


@dataclass(frozen=True, slots=True, kw_only=True)
class _Content:
    """What the one image of a file is.

    product, photometric, samples : what it is, and how many numbers a pixel has
    black_dn, white_dn            : codes of no light, repeated over the image, and the code at which the signal clips
    noise                         : (S, O) of the noise profile; None for what has no noise
    """

    product: str
    photometric: int
    samples: int
    black_dn: tuple[tuple[int, ...], ...]
    white_dn: int
    noise: tuple[float, float] | None


class MosaicWriter:
    """A DNG of a mosaic that is written while the mosaic is computed, so that memory need not hold it.

    mono          : whether every photosite has the same filter
    compress      : as lossless JPEG, see ``dng_image``
    allow_odd_cfa : write an array that developers misread all the same; ``odd_cfa`` says which programs fail
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
        """Write everything that the frame says; its own photosites are not looked at."""
        why = odd_cfa(frame.cfa_pattern)
        if why and not self._allow_odd_cfa:
            raise OutputError(why)
        content = _Content(
            product="mosaic",
            photometric=_LINEAR_RAW if is_mono(frame) else _CFA,
            samples=1,
            black_dn=tuple(tuple(frame.black_level_dn + offset for offset in row) for row in frame.black_offsets_dn),
            white_dn=frame.white_level_dn,
            noise=noise_profile(frame),
        )
        _finish(frame, content, self._image)


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

    A developer treats it as it treats the mosaic, so that the two can be compared after development. What is
    brighter than the camera's white is cut there; the exact electrons are for .exr and .npy.
    """
    truth = frame.truth
    assert truth is not None
    if len(frame.channels) > 1 and frame.channels != _RGB:
        raise OutputError(
            f"a DNG of the truth holds red, green and blue, and this camera has {', '.join(frame.channels)}; "
            "write an .exr or .npy instead"
        )
    rows, cols, samples = truth.shape
    saturation_e = (frame.white_level_dn - frame.black_level_dn) * frame.electrons_per_dn
    codes_per_e = np.float32(TRUTH_WHITE_DN / saturation_e)
    content = _Content(
        product="truth",
        photometric=_LINEAR_RAW,
        samples=samples,
        black_dn=((0,),),
        white_dn=TRUTH_WHITE_DN,
        noise=None,
    )
    with path.open("wb") as file:
        image = Image(file, LosslessTiles(cols, components=1) if compress else Strip())
        for first in range(0, rows, _PIECE_ROWS):
            codes = np.rint(np.clip(truth[first : first + _PIECE_ROWS] * codes_per_e, 0, TRUTH_WHITE_DN))
            image.take((codes if samples > 1 else codes[:, :, 0]).astype(np.uint16))
        _finish(frame, content, image)


def is_mono(frame: Frame) -> bool:
    """Whether every photosite has the same filter."""
    return len(frame.channels) == 1


def odd_cfa(pattern: tuple[str, ...]) -> str | None:
    """Say which programs misread a DNG of a colour filter array; None for those that all of them read.

    >>> odd_cfa(("GB", "RG")) is None
    True
    >>> odd_cfa(("RGBW",))[:82]
    'raw developers misread a DNG of the colour filter array RGBW: dcraw, LibRaw, RawTh'
    """
    letters = set("".join(pattern))
    period = len(pattern), len(pattern[0])
    if len(letters) == 1 or pattern in _BAYER or (period == (6, 6) and letters == set(_RGB)):
        return None
    shown = " / ".join(pattern)
    unknown = sorted(letters - set(_CFA_CODES))
    if unknown or max(period) > 255:
        return f"a DNG cannot hold the colour filter array {shown}; write a .tiff, .exr or .npy instead"
    return (
        f"raw developers misread a DNG of the colour filter array {shown}: dcraw, LibRaw, RawTherapee and darktable "
        "take it for another one and Adobe's SDK does not interpolate it; write a .tiff, .exr or .npy instead"
    )


def _finish(frame: Frame, content: _Content, image: Image) -> None:
    record = record_json(frame, content.product)

    def all_tags(layout: tuple[Tag, ...], identity: bytes, at: int) -> tuple[bytes, int]:
        tags = (
            *layout,
            *_image_tags(frame, content),
            *_level_tags(frame, content),
            *_identity_tags(frame, content, record, identity),
            *_rendering_tags(),
            *(() if is_mono(frame) else _colour_tags(frame)),
        )
        return directories(tags, _exif_tags(frame), at)

    image.finish(record, all_tags)


def _image_tags(frame: Frame, content: _Content) -> tuple[Tag, ...]:
    rows, cols = frame.shape
    return (
        long(254, 0),  # NewSubfileType: the main image
        long(256, cols),
        long(257, rows),
        short(258, *[16] * content.samples),  # BitsPerSample
        short(262, content.photometric),
        short(274, 1),  # Orientation: row 0 at the top, column 0 at the left
        short(277, content.samples),  # SamplesPerPixel
        short(284, 1),  # PlanarConfiguration
        *(_cfa_tags(frame) if content.photometric == _CFA else ()),
    )


def _cfa_tags(frame: Frame) -> tuple[Tag, ...]:
    pattern = frame.cfa_pattern
    if unknown := [letter for letter in frame.channels if letter not in _CFA_CODES]:
        raise OutputError(
            f"a DNG has no code for the colour filters {', '.join(unknown)}; write a .tiff, .exr or .npy instead"
        )
    return (
        short(33421, len(pattern), len(pattern[0])),  # CFARepeatPatternDim
        byte(33422, [_CFA_CODES[letter] for row in pattern for letter in row]),  # CFAPattern
        byte(50710, [_CFA_CODES[letter] for letter in frame.channels]),  # CFAPlaneColor
        short(50711, 1),  # CFALayout: rectangular
    )


def _level_tags(frame: Frame, content: _Content) -> tuple[Tag, ...]:
    rows, cols = frame.shape
    # Demosaicing needs neighbours, two at least; a crop keeps whole periods of the array (2 or 6). The truth is
    # cropped as its mosaic is, so that the two lie on one another when developed.
    usual, smallest = (6, 6) if len(frame.cfa_pattern) == 6 else (4, 2)
    shortest = min(rows, cols)
    margin = usual if shortest >= 24 else smallest if shortest > 2 * smallest else 0
    return (
        short(50713, len(content.black_dn), len(content.black_dn[0])),  # BlackLevelRepeatDim
        rational(50714, *[level for row in content.black_dn for level in row for _ in range(content.samples)]),
        long(50717, *[content.white_dn] * content.samples),
        rational(50718, 1, 1),  # DefaultScale
        rational(50719, margin, margin),  # DefaultCropOrigin: column, row
        rational(50720, cols - 2 * margin, rows - 2 * margin),  # DefaultCropSize
        rational(50780, 1),  # BestQualityScale
        long(50829, 0, 0, rows, cols),  # ActiveArea: top, left, bottom, right
        *((double(51041, *content.noise * len(frame.channels)),) if content.noise else ()),
    )


def noise_profile(frame: Frame) -> tuple[float, float]:
    """Return S and O: the variance of x is S·x + O, for x = (code − black)/(white − black) in 0..1.

    Shot noise has the variance of its electrons; O holds the read noise and the rounding's 1/12 DN².
    """
    span_dn = frame.white_level_dn - frame.black_level_dn
    shot = 1 / (frame.electrons_per_dn * span_dn)
    floor_dn2 = (frame.read_noise_e / frame.electrons_per_dn) ** 2 + 1 / 12
    return shot, floor_dn2 / span_dn**2


def _identity_tags(frame: Frame, content: _Content, record: str, identity: bytes) -> tuple[Tag, ...]:
    model = ascii_text(frame.camera_name) or "camera"
    return (
        ascii_string(271, _MAKE),
        ascii_string(272, model),
        ascii_string(305, software()),
        ascii_string(306, exif_datetime(frame)),
        byte(700, _xmp(frame, content.product, record)),
        byte(50706, [1, 4, 0, 0]),  # DNGVersion
        byte(50707, [1, 1, 0, 0]),  # DNGBackwardVersion
        # Our make in front: of a real camera's exact name readers have tables of their own.
        ascii_string(50708, f"{_MAKE} {model}"),
        ascii_string(50735, str(frame.serial)),
        byte(50781, identity),  # RawDataUniqueID
    )


def _rendering_tags() -> tuple[Tag, ...]:
    """Say that nothing is to be done to the numbers: no gain, no extra noise, linear to the end."""
    return (
        srational(50730, 0),  # BaselineExposure
        rational(50731, 1),  # BaselineNoise
        rational(50732, 1),  # BaselineSharpness
        rational(50734, 1),  # LinearResponseLimit
    )


def _colour_tags(frame: Frame) -> tuple[Tag, ...]:
    """Matrices and white balance; a mono file has none, and Adobe warns of those it need not have."""
    return (
        *_matrix_tags(frame),
        rational(50727, *[1.0] * len(frame.channels)),  # AnalogBalance: no gain of a channel's own
        rational(50728, *_row_by_row(as_shot_neutral(frame.colour))),
        ascii_string(50936, _MAKE),  # ProfileName
        long(50941, 3),  # ProfileEmbedPolicy: no restrictions
    )


def _matrix_tags(frame: Frame) -> tuple[Tag, ...]:
    """Matrices for A and D65; or one alone, for the scene's light, which developers take for D65's."""
    if frame.colour.matrix == "scene":
        fitted = fit_to_scene(frame.colour)
        return (
            srational(50721, *_row_by_row(fitted.xyz_to_camera)),
            short(50778, _D65),
            srational(50964, *_row_by_row(fitted.forward)),
        )
    under_a, under_d65 = fit(frame.colour, "A"), fit(frame.colour, "D65")
    return (
        srational(50721, *_row_by_row(under_a.xyz_to_camera)),
        srational(50722, *_row_by_row(under_d65.xyz_to_camera)),
        short(50778, _STANDARD_LIGHT_A),
        short(50779, _D65),
        srational(50964, *_row_by_row(under_a.forward)),
        srational(50965, *_row_by_row(under_d65.forward)),
    )


def _row_by_row(matrix: F64) -> list[float]:
    values: list[float] = matrix.ravel().tolist()
    return values


def _exif_tags(frame: Frame) -> tuple[Tag, ...]:
    date = exif_datetime(frame)
    index = round(frame.iso)
    return (
        rational(33434, frame.time_s),
        rational(33437, frame.f_number),
        short(34855, min(index, 65535)),  # PhotographicSensitivity; what is above goes to the index
        short(34864, _RECOMMENDED_EXPOSURE_INDEX),
        long(34866, index),
        undefined(36864, b"0230"),  # ExifVersion
        ascii_string(36867, date),
        # A scene given on the sensor has no focal length; 0 mm is what cameras write for unknown lenses.
        rational(37386, 0),
        ascii_string(42036, f"f/{frame.f_number:g}"),
    )


def _xmp(frame: Frame, product: str, record: str) -> bytes:
    properties = {
        "Seed": str(frame.seed),
        "DescriptionSHA256": description_hash(frame),
        "ErrorEstimate": error_text(frame, product),
        "Tolerance": f"{frame.report.tolerance:g}",
    }
    attributes = "".join(f'\n   camsim:{name}="{html.escape(value)}"' for name, value in properties.items())
    return f"""<?xpacket begin="\ufeff" id="W5M0MpCehiHzreSzNTczkc9d"?>
<x:xmpmeta xmlns:x="adobe:ns:meta/">
 <rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">
  <rdf:Description rdf:about="" xmlns:camsim="{XMP_NAMESPACE}"{attributes}>
   <camsim:Record>{html.escape(record)}</camsim:Record>
  </rdf:Description>
 </rdf:RDF>
</x:xmpmeta>
<?xpacket end="r"?>""".encode()
