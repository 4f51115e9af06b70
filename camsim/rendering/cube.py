"""Spectral cube: the scene's radiance per wavelength, blurred by the optics and sampled at the photosites."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import F32, F64
from camsim.errors import InvalidValueError, UnsupportedError
from camsim.optics import OpticalSystem
from camsim.rendering.grid import Grid
from camsim.rendering.render import render_channels
from camsim.rendering.veil import Veil
from camsim.scene import Scene
from camsim.spectra.curve import check_wavelengths
from camsim.spectra.light import Light

USUAL_NM = tuple(float(w) for w in range(400, 701, 10))
"""Wavelengths of a cube unless others are named."""

MOST_PLANES = 1000  # a plane for every nanometre that a sensor may see


@dataclass(frozen=True, slots=True, eq=False)
class SpectralCube:
    """Radiance at every photosite and wavelength; a plane is computed on request and not cached.

    wavelength_nm : (n,) increasing
    units         : "W.m^-2.sr^-1.nm^-1", or "W.m^-2.sr^-1" of a light of one line
    bands         : (k, take) renders wavelength k, gives ``take`` the radiance in ``units`` band by band, from the
                    top, and returns the error found, relative to a perfect diffuser

    Blurred by lens, low-pass filter and photosite; the transmission of the lens and its filters is not applied.
    """

    wavelength_nm: tuple[float, ...]
    units: str
    bands: Callable[[int, Callable[[F32], None]], float]

    def plane(self, k: int) -> tuple[F32, float]:
        """Return the plane of one wavelength, (rows, cols), and the error found."""
        parts: list[F32] = []
        error = self.bands(k, parts.append)
        return np.concatenate(parts), error


def radiance_cube(
    scene: Scene,
    system: OpticalSystem,
    grid: Grid,
    *,
    light: Light,
    veil: Veil,
    wavelength_nm: Sequence[float] | None,
    tolerance: float,
    method: str = "auto",
    strict: bool = False,
) -> SpectralCube:
    """Return the cube of a scene of diffusers in a light; ``wavelength_nm`` None: 400 to 700 nm every 10, or the line.

    A diffuser of reflectance ρ under an irradiance E has the radiance ρ·E/π.
    """
    if light.at == "sensor":
        raise UnsupportedError(
            "the light's level is given on the sensor, so the scene has no radiance; give it on the scene",
            key="spectral",
        )
    line_nm = light.ends_nm[:1] if light.is_one_line else None
    if wavelength_nm is None:
        nodes = line_nm or USUAL_NM
    else:
        nodes = tuple(wavelength_nm)
        check_wavelengths(nodes, "spectral_nm")
        if line_nm and nodes != line_nm:
            raise InvalidValueError(
                f"the light has one wavelength, {line_nm[0]:g} nm; leave spectral_nm out", key="spectral_nm"
            )
    irradiance = light.irradiance_at(np.array(nodes))
    everywhere = np.broadcast_to(np.uint8(0), (grid.rows, grid.cols))

    def bands(k: int, take: Callable[[F32], None]) -> float:
        line, white = np.array([nodes[k]]), np.ones((1, 1))
        glare = veil.light(scene, white, line, tolerance)[0]

        def radiance(band: F64) -> None:
            # Errors within the tolerance may make black negative.
            np.maximum(band, 0.0, out=band)
            band += glare
            band *= irradiance[k] / math.pi
            take(band.astype(np.float32))

        rendering = render_channels(
            scene,
            system,
            grid,
            response=veil.spared(white, line),
            wavelength_nm=line,
            channel=everywhere,
            tolerance=tolerance,
            method=method,
            strict=strict,
            take=radiance,
        )
        return rendering.error_estimate

    return SpectralCube(nodes, "W.m^-2.sr^-1" if line_nm else "W.m^-2.sr^-1.nm^-1", bands)
