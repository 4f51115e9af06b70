"""The tags of a DNG: those that raw programs were found to need, from one metadata object.

Their meaning is that of Adobe's Digital Negative specification 1.4.
"""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from camsim.core.arrays import F64
from camsim.errors import OutputError
from camsim.files.describe import XMP_NAMESPACE, ascii_text, software
from camsim.files.tiff_ifd import Tag, ascii_string, byte, double, long, rational, short, srational

CFA_CODES = {"R": 0, "G": 1, "B": 2, "C": 3, "M": 4, "Y": 5, "W": 6}
"""Codes of TIFF/EP and the DNG specification."""

CFA, LINEAR_RAW = 32803, 34892
STANDARD_LIGHT_A, D65 = 17, 21
BAYER = (("RG", "GB"), ("BG", "GR"), ("GR", "BG"), ("GB", "RG"))
RGB = ("R", "G", "B")
_MAKE = "camsim"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Colour:
    """Relation of the channels to XYZ.

    fits    : at most two of (code of a light, (channels, 3) from XYZ to the camera, (3, channels) from the balanced
              camera to XYZ under D50)
    neutral : (channels,) response to white in the scene's light
    """

    fits: Sequence[tuple[int, F64, F64]]
    neutral: F64


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Metadata:
    """Metadata of the image of a file.

    shape                : rows and columns
    photometric, samples : kind of image, and samples per pixel
    cfa_pattern, channels : filters and channels of the mosaic; also set for other images
    black_dn, white_dn   : black levels, tiled over the image, and the code at which the signal clips
    linear_dn            : data numbers of codes 0, 1, …, the unit of levels and noise; empty: codes are linear
    noise                : (S, O) of the noise profile; None if absent or unknown
    colour               : None for one channel
    date                 : as EXIF writes it; None if unknown
    xmp                  : see ``xmp_packet``; None for a file that carries no record
    """

    shape: tuple[int, int]
    photometric: int
    samples: int
    cfa_pattern: tuple[str, ...]
    channels: tuple[str, ...]
    black_dn: Sequence[Sequence[float]]
    white_dn: int
    noise: tuple[float, float] | None
    linear_dn: Sequence[int] = ()
    colour: Colour | None
    camera_name: str
    serial: str | None
    date: str | None
    xmp: bytes | None

    def tags(self, identity: bytes) -> tuple[Tag, ...]:
        """Return all tags except those of the image's layout and of EXIF; ``identity``: identifier of the codes."""
        return (
            *self._image_tags(),
            *self._level_tags(),
            *self._identity_tags(identity),
            *_rendering_tags(),
            *(() if self.colour is None else self._colour_tags(self.colour)),
        )

    def _image_tags(self) -> tuple[Tag, ...]:
        rows, cols = self.shape
        return (
            long(254, 0),  # NewSubfileType: the main image
            long(256, cols),
            long(257, rows),
            short(258, *[16] * self.samples),  # BitsPerSample
            short(262, self.photometric),
            short(274, 1),  # Orientation: row 0 at the top, column 0 at the left
            short(277, self.samples),  # SamplesPerPixel
            short(284, 1),  # PlanarConfiguration
            *(self._cfa_tags() if self.photometric == CFA else ()),
        )

    def _cfa_tags(self) -> tuple[Tag, ...]:
        pattern = self.cfa_pattern
        if unknown := [letter for letter in self.channels if letter not in CFA_CODES]:
            raise OutputError(
                f"a DNG has no code for the colour filters {', '.join(unknown)}; write a .tiff, .exr or .npy instead"
            )
        return (
            short(33421, len(pattern), len(pattern[0])),  # CFARepeatPatternDim
            byte(33422, [CFA_CODES[letter] for row in pattern for letter in row]),  # CFAPattern
            byte(50710, [CFA_CODES[letter] for letter in self.channels]),  # CFAPlaneColor
            short(50711, 1),  # CFALayout: rectangular
        )

    def _level_tags(self) -> tuple[Tag, ...]:
        rows, cols = self.shape
        # Demosaicing needs at least two neighbours; a crop keeps whole periods of the array (2 or 6). The truth is
        # cropped like its mosaic, so that the two align when developed.
        usual, smallest = (6, 6) if len(self.cfa_pattern) == 6 else (4, 2)
        shortest = min(rows, cols)
        margin = usual if shortest >= 24 else smallest if shortest > 2 * smallest else 0
        return (
            *((short(50712, *self.linear_dn),) if len(self.linear_dn) else ()),  # LinearizationTable
            short(50713, len(self.black_dn), len(self.black_dn[0])),  # BlackLevelRepeatDim
            rational(50714, *[level for row in self.black_dn for level in row for _ in range(self.samples)]),
            long(50717, *[self.white_dn] * self.samples),
            rational(50718, 1, 1),  # DefaultScale
            rational(50719, margin, margin),  # DefaultCropOrigin: column, row
            rational(50720, cols - 2 * margin, rows - 2 * margin),  # DefaultCropSize
            rational(50780, 1),  # BestQualityScale
            long(50829, 0, 0, rows, cols),  # ActiveArea: top, left, bottom, right
            *((double(51041, *self.noise * len(self.channels)),) if self.noise else ()),
        )

    def _identity_tags(self, identity: bytes) -> tuple[Tag, ...]:
        model = ascii_text(self.camera_name) or "camera"
        return (
            ascii_string(271, _MAKE),
            ascii_string(272, model),
            ascii_string(305, software()),
            *(() if self.date is None else (ascii_string(306, self.date),)),
            *(() if self.xmp is None else (byte(700, self.xmp),)),
            byte(50706, [1, 4, 0, 0]),  # DNGVersion
            byte(50707, [1, 1, 0, 0]),  # DNGBackwardVersion
            # Prefixed by camsim's make: readers have tables for exact names of real cameras.
            ascii_string(50708, f"{_MAKE} {model}"),
            *(() if self.serial is None else (ascii_string(50735, self.serial),)),
            byte(50781, identity),  # RawDataUniqueID
        )

    def _colour_tags(self, colour: Colour) -> tuple[Tag, ...]:
        """Matrices and white balance; a mono file has none, and Adobe warns of those it need not have."""
        numbers = zip(colour.fits, (50721, 50722), (50778, 50779), (50964, 50965), strict=False)
        return (
            *(
                tag
                for (light, to_camera, forward), matrix, calibration, back in numbers
                for tag in (
                    srational(matrix, *_row_by_row(to_camera)),
                    short(calibration, light),
                    srational(back, *_row_by_row(forward)),
                )
            ),
            rational(50727, *[1.0] * len(self.channels)),  # AnalogBalance: no gains per channel
            rational(50728, *_row_by_row(colour.neutral)),
            ascii_string(50936, _MAKE),  # ProfileName
            long(50941, 3),  # ProfileEmbedPolicy: no restrictions
        )


def odd_cfa(pattern: tuple[str, ...]) -> str | None:
    """Return a text on programs that misread a DNG of a colour filter array; None if all read it.

    >>> odd_cfa(("GB", "RG")) is None
    True
    >>> odd_cfa(("RGBW",))[:82]
    'raw developers misread a DNG of the colour filter array RGBW: dcraw, LibRaw, RawTh'
    """
    pattern = tuple(row.upper() for row in pattern)
    letters = set("".join(pattern))
    period = len(pattern), len(pattern[0])
    if len(letters) == 1 or pattern in BAYER or (period == (6, 6) and letters == set(RGB)):
        return None
    displayed = " / ".join(pattern)
    unknown = sorted(letters - set(CFA_CODES))
    if unknown or max(period) > 255:
        return f"a DNG cannot hold the colour filter array {displayed}; write a .tiff, .exr or .npy instead"
    return (
        f"raw developers misread a DNG of the colour filter array {displayed}: dcraw, LibRaw, RawTherapee and "
        "darktable "
        "take it for another one and Adobe's SDK does not interpolate it; write a .tiff, .exr or .npy instead"
    )


def xmp_packet(properties: Mapping[str, str], record: str) -> bytes:
    """Return an XMP packet in camsim's namespace: short properties, and a record as JSON."""
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


def _rendering_tags() -> tuple[Tag, ...]:
    """Return the tags for no further rendering: no gain, no extra noise, linear throughout."""
    return (
        srational(50730, 0),  # BaselineExposure
        rational(50731, 1),  # BaselineNoise
        rational(50732, 1),  # BaselineSharpness
        rational(50734, 1),  # LinearResponseLimit
    )


def _row_by_row(matrix: F64) -> list[float]:
    """Return numbers to nine digits, which are equal on all processors."""
    values: list[float] = matrix.ravel().round(9).tolist()
    return values
