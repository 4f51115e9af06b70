"""A truth: an image with its space and unit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

from camsim.core.arrays import F32

Space: TypeAlias = Literal["electrons", "camera-rgb", "xyz", "srgb"]

SPACES: Mapping[Space, str] = {
    "electrons": "mean electrons of every channel, before noise",
    "camera-rgb": "linear camera channels, white-balanced; 1: the level at which white clips",
    "xyz": "CIE 1931 XYZ through the spectra; Y = 1: a perfect diffuser",
    "srgb": "linear sRGB of those XYZ, adapted from the scene's white to D65; 1: a perfect diffuser",
}
"""Spaces of a truth, and their units."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TruthImage:
    """All channels at every photosite, without noise and without a filter array.

    image          : (rows, cols, channels) float32
    channels       : names of the channels, such as ("R", "G", "B") or ("X", "Y", "Z")
    space          : see ``SPACES``
    diffuser       : (channels,) values of a perfect diffuser on the optical axis
    error_estimate : the largest error found of the rendering, relative to a perfect diffuser
    """

    image: F32
    channels: tuple[str, ...]
    space: Space
    diffuser: tuple[float, ...]
    error_estimate: float

    @property
    def unit(self) -> str:
        """Unit of the values."""
        return SPACES[self.space]

    def __repr__(self) -> str:
        rows, cols = self.image.shape[:2]
        return f"TruthImage({rows} × {cols}, {', '.join(self.channels)}, {self.space}: {self.unit})"
