"""Lens files from prescriptions: rays are traced by optiland, and what they tell is kept as numbers."""

from __future__ import annotations

import json
import math
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from camsim.arrays import F64
from camsim.errors import InputError
from camsim.optics.zernike import orders

WAVELENGTHS_NM = (380.0, 410.0, 440.0, 470.0, 500.0, 530.0, 560.0, 590.0, 620.0, 650.0, 690.0, 740.0, 780.0)
HEIGHTS = 13  # along the radius
TERMS = 36  # OSA/ANSI 0 to 35: order 7
POWERS = 6  # of the square of the height, in a distortion
RINGS = 15  # of rays over the pupil
RIM_RAYS = 96  # whose directions bound the cone of light
SMALLEST_WAVES = 5e-5  # of a coefficient that is kept anywhere
ABSENT = "lens import needs optiland, which is not installed; pip install 'camsim-spectral[lens]'"


def import_zemax(file: Path, *, middle_nm: float = 550.0) -> str:
    """Return the lens file of a Zemax prescription; raises InputError where it cannot be read."""
    try:
        from optiland.fileio import load_zemax_file
    except ImportError:
        raise InputError(ABSENT) from None
    if not file.is_file():
        raise InputError(f"no such file: {str(file)!r}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            optic = load_zemax_file(str(file))
            return lens_file(optic, name=file.stem, source=f"traced from {file.name} by optiland", middle_nm=middle_nm)
    except Exception as error:
        raise InputError(f"optiland cannot trace {file.name!r}: {error}; it takes sequential .zmx files") from error


def lens_file(optic: Any, *, name: str, source: str, comment: str = "", middle_nm: float = 550.0) -> str:
    """Return the text of a lens file, traced through an optiland ``Optic`` with fields given by angle.

    The field runs along +x to the optic's largest; heights are those of the middle wavelength's chief ray.
    """
    f_number, focal_mm = float(optic.paraxial.FNO()), float(optic.paraxial.f2())
    full_deg = float(optic.fields.max_field)
    shares = np.linspace(0.0, 1.0, HEIGHTS)
    ideal_mm = np.abs(focal_mm) * np.tan(np.radians(full_deg * shares))
    chief_mm = np.array([[_chief(optic, h, nm) for h in shares] for nm in WAVELENGTHS_NM])
    middle_mm = np.array([_chief(optic, h, middle_nm) for h in shares])
    side = math.copysign(1.0, middle_mm[-1])
    waves = np.array([[_zernike(optic, side * h, nm) for h in shares] for nm in WAVELENGTHS_NM])
    indices = [j for j in range(1, TERMS) if orders(j)[1] >= 0 and np.abs(waves[:, :, j]).max() > SMALLEST_WAVES]
    cone = np.array([_cone(optic, h, middle_nm) for h in shares])
    middle_um, lateral_um = 1e3 * np.abs(middle_mm), 1e3 * (side * chief_mm - np.abs(middle_mm))
    # Distortion is told of ideal heights, all else of heights in the image: a polynomial in the square lies between.
    square = (ideal_mm / ideal_mm[-1]) ** 2
    powers = np.stack([square**k for k in range(1, POWERS + 1)], axis=1)
    fraction = np.abs(middle_mm[1:]) / ideal_mm[1:] - 1.0
    fitted = np.linalg.lstsq(powers[1:], fraction, rcond=None)[0]
    here = (np.abs(middle_mm) / ideal_mm[-1]) ** 2
    distortion = sum(own * here**k for k, own in enumerate(fitted, start=1))
    table = waves[:, :, indices]
    on_axis = [k for k, j in enumerate(indices) if orders(j)[1]]
    table[:, 0, on_axis] = 0.0
    lateral_um[:, 0] = 0.0
    rows: list[tuple[str, Any]] = [
        ("wavelength_nm", list(WAVELENGTHS_NM)),
        ("height_um", _rounded(middle_um, 3)),
        ("zernike", indices),
        ("distortion", _rounded(distortion, 7)),
        ("relative_illumination", _rounded(np.minimum(cone / cone[0], 1.0), 5)),
    ]
    lines = [f"# {comment or name}.", "camsim: lens/1", f"name: {json.dumps(name)}", f"source: {json.dumps(source)}"]
    lines.append(f"f_number: {round(f_number, 4)}")
    lines += [f"{key}: {json.dumps(values)}" for key, values in rows]
    lines += ["lateral_colour_um:", *(f"  - {json.dumps(_rounded(row, 4))}" for row in lateral_um)]
    lines += ["waves: # for each wavelength, for each height, of each Zernike"]
    for of_wavelength in table:
        rows_of = [json.dumps(_rounded(row, 5)) for row in of_wavelength]
        lines += [f"  {'- ' if k == 0 else '  '}- {row}" for k, row in enumerate(rows_of)]
    return "\n".join(lines) + "\n"


def _rounded(values: F64, digits: int) -> list[float]:
    return [float(v) + 0.0 for v in np.round(values, digits).tolist()]


def _chief(optic: Any, share: float, wavelength_nm: float) -> float:
    """Return x of the chief ray in the image, mm."""
    rays = optic.trace_generic(float(share), 0.0, 0.0, 0.0, wavelength_nm / 1e3)
    return float(np.asarray(rays.x).ravel()[0])


def _zernike(optic: Any, share: float, wavelength_nm: float) -> F64:
    """Return coefficients in waves about the chief ray, with camsim's sign.

    optiland's path difference grows where camsim's falls: its rays fall at −2N·∂W/∂x.
    """
    from optiland.wavefront import ZernikeOPD

    fitted = ZernikeOPD(
        optic,
        (float(share), 0.0),
        wavelength_nm / 1e3,
        num_rings=RINGS,
        zernike_type="standard",
        num_terms=TERMS,
    )
    return -np.array(fitted.coeffs, float)


def _cone(optic: Any, share: float, wavelength_nm: float) -> float:
    """Return the area in direction cosines of the light that falls on the image: its irradiance, of an even scene."""
    angle = 2.0 * np.pi * np.arange(RIM_RAYS) / RIM_RAYS
    field = np.full(RIM_RAYS, float(share))
    rays = optic.trace_generic(field, 0.0 * field, np.cos(angle), np.sin(angle), wavelength_nm / 1e3)
    along, across = np.asarray(rays.L), np.asarray(rays.M)
    return 0.5 * abs(float(np.sum(along * np.roll(across, -1) - np.roll(along, -1) * across)))


def surfaces(optic: Any, prescription: Sequence[tuple[Any, ...]]) -> None:
    """Add surfaces to an empty optic: (radius mm, thickness mm, glass or None, whether it is the stop) each.

    A glass by numbers is (index at 587.56 nm, Abbe number). An asphere has (conic constant, coefficients of r³, r⁴, …)
    besides, mm.
    """
    from optiland.materials import AbbeMaterial

    for index, (radius, thickness, glass, stop, *asphere) in enumerate(prescription, start=1):
        more: dict[str, Any] = {} if glass is None else {"material": glass}
        if isinstance(glass, tuple) and isinstance(glass[0], float):
            more["material"] = AbbeMaterial(*glass, model="buchdahl")
        for conic, coefficients in asphere:
            more |= {"surface_type": "odd_asphere", "conic": conic, "coefficients": [0.0, 0.0, *coefficients]}
        optic.surfaces.add(index=index, radius=radius, thickness=thickness, is_stop=stop, **more)
    optic.surfaces.add(index=len(prescription) + 1)
