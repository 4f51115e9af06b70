"""Colour-science's own tables every 5 nm: what the colour tests take their truth from."""

from __future__ import annotations

import functools

import numpy as np

from camsim.spectra.colour_science import colour_science


@functools.cache
def aligned(kind: str, name: str) -> np.ndarray:
    """Return colour-science's data every 5 nm, (81,) or (81, columns)."""
    colour = colour_science()
    data = {
        "light": colour.SDS_ILLUMINANTS,
        "observer": colour.MSDS_CMFS,
        "camera": colour.MSDS_CAMERA_SENSITIVITIES,
        "patch": colour.SDS_COLOURCHECKERS["ISO 17321-1"],
    }[kind][name]
    values: np.ndarray = data.copy().align(colour.SpectralShape(380, 780, 5)).values
    return values


def patches() -> np.ndarray:
    names = colour_science().SDS_COLOURCHECKERS["ISO 17321-1"]
    return np.array([aligned("patch", name) for name in names])


def white_xyz(light: str) -> np.ndarray:
    sums = aligned("light", light) @ aligned("observer", "CIE 1931 2 Degree Standard Observer")
    return sums / sums[1]
