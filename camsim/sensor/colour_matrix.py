"""Colour matrices of a camera: XYZ to camera and back (filled in by the files helper)."""

from __future__ import annotations

from dataclasses import dataclass

from camsim.arrays import F64


@dataclass(frozen=True, eq=False)
class ColourResponse:
    """How the channels see light: what colour matrices and the white balance are made from.

    channels        names, such as ("R", "G", "B")
    wavelength_nm   (n,) nodes, increasing
    sensitivity     (channels, n) response per unit radiant energy, lens and filters included, any common scale
    light           (n,) relative spectral power of the scene's light
    """

    channels: tuple[str, ...]
    wavelength_nm: F64
    sensitivity: F64
    light: F64
