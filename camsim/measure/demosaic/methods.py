"""Demosaicing methods: camsim's bilinear, those of colour-demosaicing and LibRaw, and external programs.

All receive balanced linear light, as from a raw developer, and return the same: 1 where white clips.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType
from typing import Any

import numpy as np

from camsim.camera.frame import Frame
from camsim.core.arrays import F32
from camsim.errors import CamsimError, UnsupportedError, in_brief
from camsim.files import save
from camsim.files.preview import demosaic
from camsim.measure.given import check_given
from camsim.sensor.cfa import BAYER, PATTERNS
from camsim.sensor.colour_matrix import as_shot_neutral

_RGB = 3
_LEAST_FOR_LIBRAW = 22
_LEAST_FOR_PASSES = 512
"""Least photosites per side for LibRaw's X-Trans interpolation, which works in tiles of that size."""
_X_TRANS = {"linear": "LINEAR", "VNG": "VNG", "X-Trans, one pass": "PPG", "X-Trans, three passes": "AHD"}
_PASSES = ("PPG", "AHD")
_BAYER = {"linear": "LINEAR", "VNG": "VNG", "PPG": "PPG", "AHD": "AHD", "DCB": "DCB", "DHT": "DHT", "AAHD": "AAHD"}
_COLOUR_DEMOSAICING = {
    "bilinear": "demosaicing_CFA_Bayer_bilinear",
    "Malvar 2004": "demosaicing_CFA_Bayer_Malvar2004",
    "Menon 2007": "demosaicing_CFA_Bayer_Menon2007",
}


@dataclass(frozen=True, slots=True)
class Method:
    """A demosaicing method: its name, and a function from a frame to (rows, cols, 3) in which white clips at 1."""

    name: str
    run: Callable[[Frame], F32]


def signal(frame: Frame) -> F32:
    """Return (rows, cols) codes minus black level, white-balanced and scaled so that white clips at 1."""
    span_dn = frame.white_level_dn - frame.black_level_dn
    light = frame.signal_dn / span_dn / as_shot_neutral(frame.colour)[frame.channel_index]
    balanced: F32 = light.astype(np.float32)
    return balanced


def methods(frame: Frame) -> tuple[list[Method], list[str]]:
    """Return the published methods that fit a frame's filters, and a sentence for each group that is left out."""
    check_given(frame=frame)
    found = [Method("camsim: bilinear", _bilinear)]
    why: list[str] = []
    for group in (_by_colour_demosaicing, _by_libraw):
        try:
            found += group(frame)
        except CamsimError as error:
            why.append(str(error))
    return found, why


def _bilinear(frame: Frame) -> F32:
    planes: F32 = np.moveaxis(demosaic(signal(frame), frame.channel_index, _RGB), 0, 2)
    return planes


def _by_colour_demosaicing(frame: Frame) -> Iterator[Method]:
    if "".join(frame.cfa_pattern) not in BAYER:
        raise UnsupportedError("knows Bayer arrays only", stage="colour-demosaicing")
    _refuse_missing("colour_demosaicing", "colour-demosaicing")

    def method(function: str) -> Callable[[Frame], F32]:
        def run(frame: Frame) -> F32:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                image = getattr(_colour_demosaicing(), function)(signal(frame), "".join(frame.cfa_pattern))
            return np.asarray(image, np.float32)

        return run

    return (Method(f"colour-demosaicing: {name}", method(each)) for name, each in _COLOUR_DEMOSAICING.items())


def _colour_demosaicing() -> ModuleType:
    """Import colour-demosaicing without warnings on names moved in scipy and matplotlib."""
    with np.printoptions(), np.errstate(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import colour_demosaicing
    module: ModuleType = colour_demosaicing
    return module


def _by_libraw(frame: Frame) -> Iterator[Method]:
    pattern = "".join(frame.cfa_pattern)
    x_trans = len(frame.cfa_pattern) == len(PATTERNS["x-trans"]) and sorted(pattern) == sorted(
        "".join(PATTERNS["x-trans"])
    )
    if pattern not in BAYER and not x_trans:
        raise UnsupportedError("knows Bayer and X-Trans arrays only", stage="LibRaw")

    def method(name: str, algorithm: str) -> Method:
        one = f"LibRaw: {name}"
        least = _LEAST_FOR_PASSES if x_trans and algorithm in _PASSES else _LEAST_FOR_LIBRAW

        def run(frame: Frame) -> F32:
            if min(frame.shape) < least:
                message = f"needs {least} photosites a side, and the picture has {min(frame.shape)}"
                raise UnsupportedError(message, stage=one)
            return _developed_by_libraw(frame, algorithm, stage=one)

        return Method(one, run)

    named = _X_TRANS if x_trans else _BAYER
    return (method(name, algorithm) for name, algorithm in named.items())


def _developed_by_libraw(frame: Frame, algorithm: str, *, stage: str) -> F32:
    import rawpy

    neutral = as_shot_neutral(frame.colour)
    # Its multipliers are for R, G, B and the second green; it divides them by the smallest.
    red, green, blue = (float(1.0 / neutral[frame.channels.index(name)]) for name in "RGB")
    with TemporaryDirectory() as folder:
        file = Path(folder) / "mosaic.dng"
        save(frame, file)
        options: dict[str, Any] = {
            "demosaic_algorithm": rawpy.DemosaicAlgorithm[algorithm],
            "user_wb": [red, green, blue, green],
            "output_color": rawpy.ColorSpace.raw,
            "output_bps": 16,
            "gamma": (1, 1),
            "no_auto_bright": True,
            "adjust_maximum_thr": 0.0,
            "user_flip": 0,
        }
        try:
            with rawpy.imread(str(file)) as raw:
                image = raw.postprocess(**options)
        except rawpy.LibRawError as error:
            raise UnsupportedError(f"gave up: {in_brief(error)}", stage=stage) from None
    if image.shape[:2] != frame.shape:
        raise UnsupportedError(f"gave {image.shape[:2]} pixels of {frame.shape}", stage=stage)
    # Its 1 is the file's white minus the lowest black level, which equals white minus black without an offset.
    scaled: F32 = image.astype(np.float32) * np.float32(1.0 / 65535.0)
    return scaled


def _refuse_missing(module: str, package: str) -> None:
    if find_spec(module) is None:
        raise UnsupportedError("is not installed: python -m pip install 'camsim-spectral[judge]'", stage=package)
