"""Files and Frames in, Pictures out: linear numbers with their levels, whoever wrote them.

Read are DNG (compressed ones with the package imagecodecs), TIFF, PNG, EXR, NPY and NPZ. Raw files of camera makers
(CR3, NEF, ARW …) are not: a message says how to convert them.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from camsim.arrays import F64
from camsim.errors import InputError, InvalidValueError
from camsim.files.reading import read_file
from camsim.frame import Frame
from camsim.measure.picture import Picture, Plane, mosaic_planes
from camsim.sensor.cfa import BAYER, PATTERNS

_CFA_LETTERS = {0: "R", 1: "G", 2: "B", 3: "C", 4: "M", 5: "Y", 6: "W"}
_NAMES = {1: ("Y",), 2: ("Y", "A"), 3: ("R", "G", "B"), 4: ("R", "G", "B", "A")}
_UNCOMPRESSED = 1

Gamma = float | str | None


def picture_of_frame(frame: Frame, product: str = "mosaic") -> Picture:
    """Return a frame's mosaic, ``electrons`` (with noise), ``mean_electrons`` (without) or ``truth`` to measure in."""
    if product == "truth":
        if frame.truth is None:
            raise InvalidValueError("frame: holds no truth; ask for products=('truth',) when exposing")
        planes = _planes(frame.truth, frame.channels)
    elif product == "mosaic":
        planes = mosaic_planes(
            frame.mosaic,
            frame.cfa_pattern,
            black=frame.black_level_dn + np.asarray(frame.black_offsets_dn, np.float64),
            white=frame.white_level_dn,
            lowest=0.0,
        )
    elif product in ("electrons", "mean_electrons"):
        planes = mosaic_planes(getattr(frame, product), frame.cfa_pattern)
    else:
        raise InvalidValueError(f"product {product!r}: give mosaic, electrons, mean_electrons or truth")
    return Picture(
        name=frame.report.scene,
        shape=(frame.mosaic.shape[0], frame.mosaic.shape[1]),
        planes=planes,
        pitch_um=frame.pitch_um,
        description=frame.description,
    )


def read_picture(
    path: str | os.PathLike[str], *, gamma: Gamma = None, cfa: str | None = None, layer: str | None = None
) -> Picture:
    """Read an image file.

    gamma : undo an encoding: an exponent such as 2.2, or "srgb"; 1 says that the numbers are linear already
    cfa   : the colour filter array of a file that does not say it, such as RGGB
    layer : of an EXR or NPZ that holds several, such as mean or noisy

    Raises InputError for what cannot be read, InvalidValueError for data that is not linear.
    """
    file = Path(path)
    shown = repr(str(path))
    if not file.is_file():
        raise InputError(f"cannot read {shown}: there is no such file")
    reader = _READERS.get(file.suffix.lower())
    if reader is None:
        raise InputError(
            f"cannot read {shown}: a file of the kind {file.suffix or '(no suffix)'} cannot be measured; give "
            f"{', '.join(_READERS)} (raw files of camera makers: convert them to uncompressed DNG, dnglab or Adobe's "
            "converter does)"
        )
    record = _record(file)
    if record.get("product") == "preview" and gamma is None:
        raise InvalidValueError(
            f"{shown}: is a developed preview (tone curve, white balance, demosaiced), and linear data is needed; "
            "measure the capture's mosaic instead (.dng, .tiff or FILE.png:mosaic)"
        )
    try:
        picture: Picture = reader(file, record, gamma, cfa, layer)
    except (OSError, ValueError, KeyError, IndexError, TypeError, RuntimeError, AttributeError) as error:
        raise InputError(f"cannot read {shown}: {type(error).__name__}: {str(error).splitlines()[0][:200]}") from error
    return picture


def _record(file: Path) -> Mapping[str, Any]:
    """Return what a file of ours says about itself; nothing for files of others."""
    try:
        return read_file(file).record
    except InputError:
        return {}


def _picture(
    file: Path, planes: Sequence[Plane], shape: Sequence[int], record: Mapping[str, Any], pitch_um: float | None = None
) -> Picture:
    description = record.get("description")
    if isinstance(description, Mapping):
        camera = description.get("camera")
        pitch_um = float(camera["pitch_um"]) if isinstance(camera, Mapping) and "pitch_um" in camera else pitch_um
    return Picture(
        name=file.name,
        shape=(int(shape[0]), int(shape[1])),
        planes=tuple(planes),
        pitch_um=pitch_um,
        description=description if isinstance(description, Mapping) else None,
    )


def _pattern(record: Mapping[str, Any], cfa: str | None) -> tuple[str, ...]:
    """Return the rows of a colour filter array: the user's, or else the record's."""
    if cfa is None:
        pattern = record.get("cfa_pattern")
        return tuple(pattern) if pattern else ("Y",)
    if cfa.lower() in PATTERNS:
        return PATTERNS[cfa.lower()]
    rows = tuple(cfa.upper().split("/"))
    if len(rows) > 1 and rows[0].isalpha() and all(row.isalpha() and len(row) == len(rows[0]) for row in rows):
        return rows
    if cfa.upper() not in BAYER:
        raise InvalidValueError(
            f"cfa {cfa!r}: give one of {', '.join((*BAYER, *PATTERNS))}, or rows of letters such as RRGG/RRGG/GGBB/GGBB"
        )
    return cfa.upper()[:2], cfa.upper()[2:]


def _planes(image: npt.NDArray[Any], names: Sequence[str] | None, **levels: Any) -> tuple[Plane, ...]:
    """Return planes of (rows, cols) or (rows, cols, n); an alpha channel is left out."""
    if image.ndim == 2:
        image = image[:, :, None]
    if image.ndim != 3:
        raise InvalidValueError(
            f"an array of shape {image.shape} is no image; give (rows, cols) or (rows, cols, channels)"
        )
    names = names or _NAMES.get(image.shape[2]) or tuple(f"C{k + 1}" for k in range(image.shape[2]))
    return tuple(Plane(name=name, samples=image[:, :, k], **levels) for k, name in enumerate(names) if name != "A")


def _grey_or_planes(
    image: npt.NDArray[Any], record: Mapping[str, Any], cfa: str | None, **levels: Any
) -> tuple[Plane, ...]:
    if image.ndim == 2 and record.get("product", "mosaic") != "truth":
        return mosaic_planes(image, _pattern(record, cfa), **levels)
    names = record["channels"] if record.get("product") == "truth" else None
    return _planes(image, names, **levels)


def _levels(image: npt.NDArray[Any], record: Mapping[str, Any]) -> dict[str, Any]:
    """Return black, white and the lowest code; electrons and floating-point numbers have none."""
    if record.get("product") == "mosaic":
        black = record["black_level_dn"] + np.asarray(record["black_offsets_dn"], np.float64)
        return {"black": black, "white": record["white_level_dn"], "lowest": 0.0}
    if np.issubdtype(image.dtype, np.integer):
        return {"white": float(np.iinfo(image.dtype).max), "lowest": 0.0}
    return {}


def _linear(
    image: npt.NDArray[Any], gamma: Gamma, *, encoded: bool, shown: str, why: str
) -> tuple[npt.NDArray[Any], bool]:
    """Undo an encoding; refuse data that is probably encoded when nobody says how. Return whether it was changed."""
    if gamma is None:
        if encoded:
            raise InvalidValueError(
                f"{shown}: {why}, so its numbers are probably gamma-encoded and linear data is needed; measure the raw "
                "file, or undo the encoding with --gamma srgb or --gamma 2.2 (--gamma 1 if the numbers are linear)"
            )
        return image, False
    top = float(np.iinfo(image.dtype).max) if np.issubdtype(image.dtype, np.integer) else 1.0
    if gamma == 1.0:
        return image, False
    return decode(image.astype(np.float64) / top, gamma), True


def decode(encoded: F64, gamma: float | str) -> F64:
    """Undo a gamma encoding of values in 0..1.

    >>> decode(np.array([0.5]), "srgb").round(4), decode(np.array([0.5]), 2.0)
    (array([0.214]), array([0.25]))
    """
    if isinstance(gamma, str):
        if gamma.lower() != "srgb":
            raise InvalidValueError(f"gamma {gamma!r}: give srgb or an exponent such as 2.2")
        linear: F64 = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
        return linear
    if not 0.1 <= gamma <= 10.0:
        raise InvalidValueError(f"gamma {gamma:g}: give srgb or an exponent between 0.1 and 10, such as 2.2")
    power: F64 = np.sign(encoded) * np.abs(encoded) ** gamma
    return power


def _after(levels: dict[str, Any], changed: bool) -> dict[str, Any]:
    """Return the levels of decoded values, which lie in 0..1."""
    return {"white": 1.0} if changed else levels


def _read_tiff(file: Path, record: Mapping[str, Any], gamma: Gamma, cfa: str | None, layer: str | None) -> Picture:
    import tifffile

    with tifffile.TiffFile(file) as tiff:
        first: Any = tiff.pages[0]
        if 50706 in first.tags:  # DNGVersion
            return _read_dng(file, tiff, record, cfa)
        if 33723 in first.tags and file.suffix.lower() not in (".tif", ".tiff"):
            raise InputError(f"cannot read {str(file)!r}: it is not a DNG; convert it to uncompressed DNG")
        image = _pixels(first, file)
        profile = 34675 in first.tags  # an ICC profile
        if getattr(first, "planarconfig", 1) == 2 and image.ndim == 3:
            image = np.moveaxis(image, 0, -1)
    ours = bool(record)
    eight = image.dtype.itemsize == 1
    image, changed = _linear(
        image,
        gamma,
        encoded=not ours and (eight or profile),
        shown=repr(str(file)),
        why="it has 8 bits" if eight else "it has a colour profile",
    )
    planes = _grey_or_planes(image, record, cfa, **_after(_levels(image, record), changed))
    return _picture(file, planes, image.shape, record)


def _pixels(page: Any, file: Path) -> npt.NDArray[Any]:
    try:
        pixels: npt.NDArray[Any] = page.asarray()
    except (ValueError, ImportError) as error:
        name = getattr(page.compression, "name", page.compression)
        raise InputError(
            f"cannot read {str(file)!r}: its image is stored as {name} of {page.bitspersample} bits ({error}); convert "
            "it to an uncompressed 16-bit file (Adobe's DNG converter does), or: python -m pip install imagecodecs"
        ) from error
    return pixels


def _read_dng(file: Path, tiff: Any, record: Mapping[str, Any], cfa: str | None) -> Picture:
    """Read the main image of a DNG: its mosaic, or linear planes."""
    page = next(
        (
            p
            for top in tiff.pages
            for p in (top, *(top.pages or ()))
            if _tag(p, 254, 0) == 0 and _tag(p, 262) in (32803, 34892)
        ),
        None,
    )
    if page is None:
        raise InputError(f"cannot read {str(file)!r}: this DNG holds no mosaic and no linear raw image")
    image = _pixels(page, file)
    if (table := _tag(page, 50712)) is not None:  # LinearizationTable
        image = np.asarray(table)[np.minimum(image, len(table) - 1)]
    top, left, bottom, right = _tag(page, 50829, (0, 0, *image.shape[:2]))  # ActiveArea
    image = image[top:bottom, left:right]
    bits = _tag(page, 258, 16)
    white = float(np.ravel(_tag(page, 50717, 2 ** int(np.ravel(bits)[0]) - 1))[0])
    if image.ndim == 3:
        return _picture(file, _planes(image, None, white=white, lowest=0.0), image.shape, record)
    if _tag(page, 262) == 34892:
        planes = mosaic_planes(image, _pattern({}, cfa), black=_black(page), white=white, lowest=0.0)
        return _picture(file, planes, image.shape, record)
    rows, cols = _tag(page, 33421, (2, 2))
    codes = [int(c) for c in np.frombuffer(bytes(_tag(page, 33422, b"\0\1\1\2")), np.uint8)]
    letters = "".join(_CFA_LETTERS.get(code, "?") for code in codes)
    pattern = tuple(letters[r * cols : (r + 1) * cols] for r in range(rows))
    planes = mosaic_planes(
        image, pattern if cfa is None else _pattern({}, cfa), black=_black(page), white=white, lowest=0.0
    )
    return _picture(file, planes, image.shape, record)


def _black(page: Any) -> F64:
    """Return the black levels, a rectangle that is repeated from the active area's corner."""
    rows, cols = _tag(page, 50713, (1, 1))  # BlackLevelRepeatDim
    raw = _tag(page, 50714, 0)
    values = np.atleast_1d(np.asarray(raw, np.float64))
    if isinstance(raw, tuple) and len(raw) == 2 * rows * cols:  # fractions
        values = values[0::2] / values[1::2]
    black: F64 = values[: rows * cols].reshape(rows, cols)
    return black


def _tag(page: Any, number: int, default: Any = None) -> Any:
    tag = page.tags.get(number)
    return default if tag is None else tag.value


def _read_png(file: Path, record: Mapping[str, Any], gamma: Gamma, cfa: str | None, layer: str | None) -> Picture:
    from PIL import Image

    Image.MAX_IMAGE_PIXELS = None
    with Image.open(file) as opened:
        info = dict(opened.info)
        mode = opened.mode
        if mode == "P":
            raise InvalidValueError(f"{str(file)!r}: is an image of a colour palette, which cannot be measured")
        image = np.asarray(opened)
    if mode.startswith("I") and image.dtype != np.uint16:
        image = image.astype(np.uint16)
    ours = record.get("product") == "mosaic"
    said = float(info.get("gamma", 1.0))
    encoded = not ours and (
        image.dtype.itemsize == 1 or abs(said - 1.0) > 0.01 or "srgb" in info or "icc_profile" in info
    )
    image, changed = _linear(
        image,
        gamma,
        encoded=encoded,
        shown=repr(str(file)),
        why="it has 8 bits" if image.dtype.itemsize == 1 else "it names a colour space",
    )
    planes = _grey_or_planes(image, record, cfa, **_after(_levels(image, record), changed))
    return _picture(file, planes, image.shape, record)


def _read_exr(file: Path, record: Mapping[str, Any], gamma: Gamma, cfa: str | None, layer: str | None) -> Picture:
    import OpenEXR

    channels = {
        name: np.asarray(channel.pixels)
        for name, channel in OpenEXR.File(str(file), separate_channels=True).channels().items()
    }
    layers: dict[str, dict[str, npt.NDArray[Any]]] = {}
    for name, pixels in channels.items():
        folder, _, last = name.rpartition(".")
        layers.setdefault(folder, {})[last] = pixels
    chosen = layer if layer is not None else "noisy" if "noisy" in layers else next(iter(layers))
    if chosen not in layers:
        raise InvalidValueError(f"{str(file)!r}: has no layer {chosen!r}; there are {', '.join(map(repr, layers))}")
    planes_here = layers[chosen]
    shape = next(iter(planes_here.values())).shape
    if record.get("product") == "electrons" or (len(planes_here) == 1 and cfa is not None):
        planes = mosaic_planes(next(iter(planes_here.values())), _pattern(record, cfa))
    else:
        order = [n for n in "RGB" if n in planes_here] + [n for n in planes_here if n not in ("R", "G", "B", "A")]
        planes = tuple(Plane(name=name, samples=planes_here[name]) for name in order)
    return _picture(file, planes, shape, record)


def _read_npy(file: Path, record: Mapping[str, Any], gamma: Gamma, cfa: str | None, layer: str | None) -> Picture:
    image = np.load(file, allow_pickle=False, mmap_mode="r")
    image, changed = _linear(image, gamma, encoded=image.dtype == np.uint8, shown=repr(str(file)), why="it has 8 bits")
    planes = _grey_or_planes(image, {}, cfa, **_after(_levels(image, {}), changed))
    return _picture(file, planes, image.shape, {})


def _read_npz(file: Path, record: Mapping[str, Any], gamma: Gamma, cfa: str | None, layer: str | None) -> Picture:
    with np.load(file, allow_pickle=False) as arrays:
        chosen = layer or ("mosaic" if "mosaic" in arrays.files else arrays.files[0])
        if chosen not in arrays.files:
            raise InvalidValueError(f"{str(file)!r}: has no array {chosen!r}; there are {', '.join(arrays.files)}")
        image = arrays[chosen]
    held = {**record, "product": chosen} if record else {}
    planes = _grey_or_planes(image, held, cfa, **_levels(image, held))
    return _picture(file, planes, image.shape, record)


def _read_jpeg(file: Path, record: Mapping[str, Any], gamma: Gamma, cfa: str | None, layer: str | None) -> Picture:
    from PIL import Image

    with Image.open(file) as opened:
        image = np.asarray(opened)
    image, changed = _linear(image, gamma, encoded=True, shown=repr(str(file)), why="it is a JPEG")
    return _picture(file, _planes(image, None, **_after(_levels(image, {}), changed)), image.shape, {})


_READERS = {
    ".dng": _read_tiff,
    ".tiff": _read_tiff,
    ".tif": _read_tiff,
    ".png": _read_png,
    ".exr": _read_exr,
    ".npy": _read_npy,
    ".npz": _read_npz,
    ".jpg": _read_jpeg,
    ".jpeg": _read_jpeg,
}
