"""DNG: a raw file that raw developers open in the right colours.

The tags are those that six raw programs were found to need; their meaning is that of Adobe's Digital Negative
specification 1.4. Bayer and X-Trans arrays are written as CFA, mono as linear raw of one sample.
"""

from __future__ import annotations

import hashlib
import html
from pathlib import Path

import numpy as np

from camsim.arrays import F64
from camsim.errors import OutputError
from camsim.files.atomic import write_chunks
from camsim.files.describe import (
    ascii_text,
    description_hash,
    error_text,
    exif_datetime,
    record_json,
    software,
)
from camsim.files.reading import XMP_NAMESPACE
from camsim.files.tiff_ifd import (
    Tag,
    ascii_string,
    byte,
    directory,
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

_CFA_CODES = {"R": 0, "G": 1, "B": 2}
_BAYER = (("RG", "GB"), ("BG", "GR"), ("GR", "BG"), ("GB", "RG"))
_CFA, _LINEAR_RAW = 32803, 34892
_STANDARD_LIGHT_A, _D65 = 17, 21
_RECOMMENDED_EXPOSURE_INDEX = 2
_MAKE = "camsim"


def write_dng(frame: Frame, path: Path) -> None:
    """Write the mosaic as an uncompressed DNG; raises OutputError for an array that developers misread."""
    refuse_over_4_gib(2 * frame.mosaic.size)
    codes = np.ascontiguousarray(frame.mosaic, dtype="<u2")
    image = codes.data.cast("B")
    tags = (
        *_image_tags(frame),
        *_level_tags(frame),
        *_identity_tags(frame, image),
        *_rendering_tags(),
        *(() if is_mono(frame) else _colour_tags(frame)),
    )
    write_chunks(path, (directory(tags, _exif_tags(frame), [image.nbytes]), image))


def is_mono(frame: Frame) -> bool:
    """Whether every photosite has the same filter."""
    return len(frame.channels) == 1


def _image_tags(frame: Frame) -> tuple[Tag, ...]:
    rows, cols = frame.mosaic.shape
    return (
        long(254, 0),  # NewSubfileType: the main image
        long(256, cols),
        long(257, rows),
        short(258, 16),  # BitsPerSample
        short(259, 1),  # Compression: none
        short(262, _LINEAR_RAW if is_mono(frame) else _CFA),
        short(274, 1),  # Orientation: row 0 at the top, column 0 at the left
        short(277, 1),  # SamplesPerPixel
        long(278, rows),  # RowsPerStrip
        short(284, 1),  # PlanarConfiguration
        *(() if is_mono(frame) else _cfa_tags(frame)),
    )


def _cfa_tags(frame: Frame) -> tuple[Tag, ...]:
    pattern = frame.cfa_pattern
    period = len(pattern), len(pattern[0])
    known = pattern in _BAYER or (period == (6, 6) and set("".join(pattern)) == set(_CFA_CODES))
    if not known:
        raise OutputError(
            f"raw developers misread a DNG of the colour filter array {' / '.join(pattern)}; "
            "write a .tiff, .exr or .npy instead"
        )
    return (
        short(33421, *period),  # CFARepeatPatternDim
        byte(33422, [_CFA_CODES[letter] for row in pattern for letter in row]),  # CFAPattern
        byte(50710, [0, 1, 2]),  # CFAPlaneColor
        short(50711, 1),  # CFALayout: rectangular
    )


def _level_tags(frame: Frame) -> tuple[Tag, ...]:
    rows, cols = frame.mosaic.shape
    # Demosaicing needs neighbours, two at least; a crop keeps whole periods of the array (2 or 6).
    usual, smallest = (6, 6) if len(frame.cfa_pattern) == 6 else (4, 2)
    shortest = min(rows, cols)
    margin = usual if shortest >= 24 else smallest if shortest > 2 * smallest else 0
    return (
        short(50713, 1, 1),  # BlackLevelRepeatDim
        rational(50714, frame.black_level_dn),
        long(50717, frame.white_level_dn),
        rational(50718, 1, 1),  # DefaultScale
        rational(50719, margin, margin),  # DefaultCropOrigin: column, row
        rational(50720, cols - 2 * margin, rows - 2 * margin),  # DefaultCropSize
        rational(50780, 1),  # BestQualityScale
        long(50829, 0, 0, rows, cols),  # ActiveArea: top, left, bottom, right
        double(51041, *noise_profile(frame) * (1 if is_mono(frame) else 3)),
    )


def noise_profile(frame: Frame) -> tuple[float, float]:
    """Return S and O: the variance of x is S·x + O, for x = (code − black)/(white − black) in 0..1.

    Shot noise has the variance of its electrons; O holds the read noise and the rounding's 1/12 DN².
    """
    span_dn = frame.white_level_dn - frame.black_level_dn
    shot = 1 / (frame.electrons_per_dn * span_dn)
    floor_dn2 = (frame.read_noise_e / frame.electrons_per_dn) ** 2 + 1 / 12
    return shot, floor_dn2 / span_dn**2


def _identity_tags(frame: Frame, image: memoryview) -> tuple[Tag, ...]:
    record = record_json(frame, "mosaic")
    content = hashlib.blake2b(image, digest_size=16)
    content.update(record.encode("ascii"))
    model = ascii_text(frame.camera_name) or "camera"
    return (
        ascii_string(271, _MAKE),
        ascii_string(272, model),
        ascii_string(305, software()),
        ascii_string(306, exif_datetime(frame)),
        byte(700, _xmp(frame, record)),
        byte(50706, [1, 4, 0, 0]),  # DNGVersion
        byte(50707, [1, 1, 0, 0]),  # DNGBackwardVersion
        # Our make in front: of a real camera's exact name readers have tables of their own.
        ascii_string(50708, f"{_MAKE} {model}"),
        ascii_string(50735, str(frame.serial)),
        byte(50781, content.digest()),  # RawDataUniqueID
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


def _xmp(frame: Frame, record: str) -> bytes:
    properties = {
        "Seed": str(frame.seed),
        "DescriptionSHA256": description_hash(frame),
        "ErrorEstimate": error_text(frame, "mosaic"),
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
