"""Selection of an image in a file that holds several: the one named, or the main one if that is unambiguous."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping

from camsim.errors import InputError, InvalidValueError

_SPECTRAL = re.compile(r"^(?:(.*?)\.)??((?:w|S0\.|T\.)?(\d+(?:[.,]\d+)?) ?nm)$")
"""Channels of Fichet's layout (S0.550,000000nm, T.550,000000nm) and others such as w550nm and 550nm, in any layer."""
_POLARISED = ("S1", "S2", "S3")
_COLOURS = frozenset("RGB")
_NO_GREY = frozenset(("X", "RY", "BY"))
"""Together with Y they denote coordinates (such as normals), or separate chroma."""
_BLENDERS = "Combined"
"""Blender's name of the image among its passes."""

_MOST_NAMED = 8


def split_channel(name: str) -> tuple[str, str]:
    """Return an EXR channel's layer (empty if none), and its name within it.

    >>> split_channel("R"), split_channel("ViewLayer.Combined.R"), split_channel("left.S0.550,000000nm")
    (('', 'R'), ('ViewLayer.Combined', 'R'), ('left', 'S0.550,000000nm'))
    """
    if spectral := _SPECTRAL.match(name):
        return spectral[1] or "", spectral[2]
    layer, _, channel = name.rpartition(".")
    return layer, channel


def nanometres(channel: str) -> float | None:
    """Return the wavelength in a channel's name within its layer; None for other channels.

    >>> nanometres("S0.550,500000nm"), nanometres("w420.5nm"), nanometres("R")
    (550.5, 420.5, None)
    """
    spectral = _SPECTRAL.match(channel)
    return float(spectral[3].replace(",", ".")) if spectral else None


def image_layer(layers: Mapping[str, Iterable[str]], asked: str | None) -> str:
    """Return the layer of an EXR that is its image, or the requested one.

    layers : names of the channels by layer

    The image is what has R, G and B, or Y, or bands in nm: without a layer's name, as the only one, or as Blender's
    ``Combined``.

    >>> image_layer({"Albedo": "RGB", "": "RGB"}, None), image_layer({"N": "XYZ", "left": "RGBA"}, None)
    ('', 'left')
    """
    if asked is not None:
        if asked not in layers:
            raise InvalidValueError(f"{asked!r} is not in it; {_there_are(layers)}", key="layer")
        return asked
    images = [name for name, channels in layers.items() if _is_image(name, frozenset(channels))]
    combined = [name for name in images if name.rpartition(".")[2] == _BLENDERS]
    for found in ([name for name in images if not name], images, combined, [*layers]):
        if len(found) == 1:
            return found[0]
    if not images:
        raise InputError(f"none of its layers has R, G and B, or Y; {_there_are(layers)}: give layer")
    raise InputError(_several("images", images))


def image_array(shapes: Mapping[str, tuple[int, ...]], asked: str | None) -> str:
    """Return the name of the largest array of three dimensions, or of two, or the requested one.

    >>> image_array({"mask": (4, 6), "photo": (4, 6, 3)}, None)
    'photo'
    """
    if asked is not None:
        if asked not in shapes:
            raise InvalidValueError(f"{asked!r} is not in it; there are {_named(shapes)}", key="layer")
        return asked
    for dimensions in (3, 2):
        sizes = {name: math.prod(shape) for name, shape in shapes.items() if len(shape) == dimensions}
        largest = [name for name, size in sizes.items() if size == max(sizes.values())]
        if len(largest) > 1:
            raise InputError(_several("arrays of one size", largest))
        if largest:
            return largest[0]
    raise InputError("it holds no array of (rows, cols, bands)")


def has_grey(channels: Iterable[str]) -> bool:
    """Whether a layer's channels contain a grey image.

    >>> has_grey("YA"), has_grey("XYZ")
    (True, False)
    """
    names = frozenset(channels)
    return "Y" in names and not names & _NO_GREY


def _is_image(layer: str, channels: frozenset[str]) -> bool:
    if layer.rpartition(".")[2] in _POLARISED:
        return False
    return channels >= _COLOURS or has_grey(channels) or any(nanometres(name) is not None for name in channels)


def _several(what: str, names: list[str]) -> str:
    return (
        f"it holds several {what}, {_named(names)}, and nobody knows which is meant; give layer, or save one as a "
        "separate file"
    )


def _named(names: Iterable[str]) -> str:
    every = [repr(name) for name in names]
    return ", ".join([*every[:_MOST_NAMED], *(["…"] if len(every) > _MOST_NAMED else [])])


def _there_are(layers: Mapping[str, Iterable[str]]) -> str:
    """Return a text on the layers of an EXR; channels may be without one."""
    names = [name for name in layers if name]
    bare = f"channels without a layer, {', '.join(layers[''])}" if "" in layers else ""
    if not names:
        return f"it has {bare}: leave the layer out"
    return f"there are {_named(names)}" + (f" and {bare}, which '' means" if bare else "")
