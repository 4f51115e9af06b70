"""Lens files from prescriptions: rays are traced by optiland, and what they tell is kept as numbers."""

from __future__ import annotations

import json
import math
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from camsim.arrays import F64
from camsim.errors import InputError
from camsim.optics.zernike import orders

WAVELENGTHS_NM = (380.0, 410.0, 440.0, 470.0, 500.0, 530.0, 560.0, 590.0, 620.0, 650.0, 690.0, 740.0, 780.0)
HEIGHTS = 13  # along the radius
TERMS = 36  # OSA/ANSI 0 to 35: order 7
POWERS = 6  # of the square of the height, in a distortion
RINGS = 15  # of rays over the pupil
LIT_RAYS = 4000  # that light is counted by, of equal areas of the pupil
GOLDEN = math.pi * (3.0 - math.sqrt(5.0))  # angle from each to the next, which leaves no place of the pupil out
LIT_STEP = 2e-4  # of the field, over which the sky is compared with where it falls
BRIGHTER = 1e-3  # of the axis's light, above which light off the axis is refused and not taken for rounding
SMALLEST_WAVES = 5e-5  # of a coefficient that is kept anywhere
UNITS_MM = {"MM": 1.0, "CM": 10.0, "IN": 25.4, "METER": 1000.0}  # as Zemax writes them
SAME = 1e-7  # of the focal length: rays that fall as near to their twins are of a system of revolution
FIELDS = {"1": "object heights", "2": "paraxial image heights", "3": "real image heights", "4": "theodolite angles"}
RIMS = {
    "OBSC": "an obstruction",
    "SQAP": "a rectangular aperture",
    "SQOB": "a rectangular obstruction",
    "ELAP": "an elliptical aperture",
    "ELOB": "an elliptical obstruction",
    "SPID": "a spider",
    "USAP": "an aperture by points",
    "USOB": "an obstruction by points",
}  # that a surface may have, and that optiland passes over
VIGNETTING = ("VDXN", "VDYN", "VCXN", "VCYN")  # factors of each field, by its number
ENCODINGS = ("utf-16", "utf-8", "iso-8859-1")  # in optiland's order
ABSENT = "lens import needs optiland, which is not installed; pip install 'camsim-spectral[lens]'"


def import_zemax(file: Path, *, middle_nm: float = 550.0) -> str:
    """Return the lens file of a Zemax prescription; raises InputError where it cannot be read."""
    try:
        from optiland.fileio import load_zemax_file
    except ImportError:
        raise InputError(ABSENT) from None
    if not file.is_file():
        raise InputError(f"no such file: {str(file)!r}")
    lines = _lines(file)
    unit_mm = _unit_mm(lines, file.name)
    try:
        _judge_rims(lines, file.name)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            optic = load_zemax_file(str(file))
            _open_stop(optic, lines)
            _judge(optic, file.name)
            if unit_mm != 1.0:
                _scale(optic, unit_mm, file.name)
            return lens_file(optic, name=file.stem, source=f"traced from {file.name} by optiland", middle_nm=middle_nm)
    except InputError:
        raise
    except Exception as error:
        raise InputError(f"optiland cannot trace {file.name!r}: {error}; it takes sequential .zmx files") from error


def _lines(file: Path) -> list[list[str]]:
    """Return the words of each line of a Zemax file that has any."""
    content = file.read_bytes()
    for encoding in ENCODINGS:
        try:
            lines = [line.split() for line in content.decode(encoding).splitlines()]
        except UnicodeError:
            continue
        if any(words and words[0] == "SURF" for words in lines):
            return [words for words in lines if words]
    return []


def _unit_mm(lines: list[list[str]], name: str) -> float:
    """Return the lens unit, mm; raises InputError where it, or what fields are given by, is not taken.

    optiland does not read the unit, and traces any field as if it were an angle.
    """
    operands = {words[0]: words[1:] for words in lines}
    unit = (operands.get("UNIT") or ["MM"])[0].upper()
    if unit not in UNITS_MM:
        raise InputError(f"{name!r} has lengths in {unit!r}; save it in one of {', '.join(UNITS_MM)} (UNIT)")
    kind = (operands.get("FTYP") or ["0"])[0]
    if kind != "0":
        raise InputError(
            f"{name!r} has fields by {FIELDS.get(kind, 'another kind')} (FTYP {kind}); "
            "lenses are traced by the angle: save it with fields as angles (FTYP 0, YFLN in degrees)"
        )
    return UNITS_MM[unit]


def _judge_rims(lines: list[list[str]], name: str) -> None:
    """Raise InputError where the pupil is cut by what optiland does not know, or by factors in place of rims."""
    for operand, *values in lines:
        if operand in RIMS:
            raise InputError(
                f"{name!r} has {RIMS[operand]} ({operand}), and rays are stopped by circles alone; "
                "save it with circular apertures that are open in the middle (CLAP 0 RADIUS), or none"
            )
        if operand in VIGNETTING and any(float(value) != 0.0 for value in values):
            raise InputError(
                f"{name!r} has vignetting factors ({operand}), which are of its own fields and of no other; "
                "clear them and give the surfaces that cut light their apertures (CLAP 0 RADIUS)"
            )


def _open_stop(optic: Any, lines: list[list[str]]) -> None:
    """Open a stop that the pupil floats by as wide as the file says.

    DIAM is half of a diameter, which optiland takes for the whole one.
    """
    if optic.aperture.ap_type != "float_by_stop_size":
        return
    surfaces: list[dict[str, list[str]]] = []
    for operand, *values in lines:
        if operand == "SURF":
            surfaces.append({})
        elif surfaces:
            surfaces[-1][operand] = values
    half = next(float(surface["DIAM"][0]) for surface in surfaces if "STOP" in surface and "DIAM" in surface)
    optic.set_aperture("float_by_stop_size", 2.0 * half)


def _judge(optic: Any, name: str) -> None:
    if not optic.object_surface.is_infinite:
        raise InputError(
            f"{name!r} has its object at a finite distance; lens files are of a scene far away: "
            "save it with the object at infinity (DISZ INFINITY of SURF 0), in focus there"
        )
    if not float(optic.fields.max_field) > 0.0:
        raise InputError(f"{name!r} has no field but the axis; give it the largest one, an angle (YFLN in degrees)")
    _judge_round(optic, name)
    passes, _ = _lit(optic, 0.0, optic.primary_wavelength * 1e3)
    if not passes.all():
        raise InputError(
            f"{name!r} has apertures that stop {100.0 * (1.0 - passes.mean()):.2g} % of the axis's light, so its pupil "
            "is not the circle of its f-number; open them, or give it a smaller entrance pupil (ENPD)"
        )


def _judge_round(optic: Any, name: str) -> None:
    """Raise InputError where rays that are turned about the axis do not fall where the others do, turned."""
    along, across = np.array([0.0, 0.7, 0.0, -0.4]), np.array([0.0, 0.0, 0.7, 0.5])
    fallen = []
    for x, y in ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)):
        rays = optic.trace_generic(
            np.full(along.size, 0.7 * x),
            np.full(along.size, 0.7 * y),
            x * along - y * across,
            y * along + x * across,
            optic.primary_wavelength,
        )
        # Turned back, to where the field lies along x.
        fallen.append(complex(x, -y) * (np.asarray(rays.x) + 1j * np.asarray(rays.y)))
    if max(np.nanmax(np.abs(own - fallen[0])) for own in fallen[1:]) > SAME * abs(float(optic.paraxial.f2())):
        raise InputError(
            f"{name!r} has rays that fall elsewhere when they are turned about the axis; lens files are of systems "
            "that are the same all round: leave out tilts, decentres and toroids"
        )


def _scale(optic: Any, unit_mm: float, name: str) -> None:
    """Make lengths mm of a lens in other units."""
    focal = float(optic.paraxial.f2())
    optic.updater.scale_system(unit_mm)
    if not math.isclose(float(optic.paraxial.f2()), unit_mm * focal, rel_tol=1e-9):
        raise InputError(f"{name!r} has surfaces that cannot be scaled to mm; save it in mm (UNIT MM)")


def lens_file(optic: Any, *, name: str, source: str, comment: str = "", middle_nm: float = 550.0) -> str:
    """Return the text of a lens file, traced through an optiland ``Optic`` with fields given by angle.

    The field runs along +x to the optic's largest; heights are those of the middle wavelength's chief ray.
    """
    f_number, focal_mm = (np.ravel(value).item() for value in (optic.paraxial.FNO(), optic.paraxial.f2()))
    full_deg = float(optic.fields.max_field)
    shares = np.linspace(0.0, 1.0, HEIGHTS)
    ideal_mm = np.abs(focal_mm) * np.tan(np.radians(full_deg * shares))
    chief_mm = np.array([[_chief(optic, h, nm) for h in shares] for nm in WAVELENGTHS_NM])
    middle_mm = np.array([_chief(optic, h, middle_nm) for h in shares])
    side = math.copysign(1.0, middle_mm[-1])
    light = _light(optic, shares, np.abs(middle_mm), middle_nm)
    if light.max() > 1.0 + BRIGHTER:
        brightest = int(light.argmax())
        raise InputError(
            f"{name!r} gives {light[brightest]:.4g} of the axis's light {full_deg * shares[brightest]:.4g}° from it, "
            "and relative_illumination is at most 1; give it a smaller field"
        )
    waves = np.array([[_zernike(optic, side * h, nm) for h in shares] for nm in WAVELENGTHS_NM])
    indices = [j for j in range(1, TERMS) if orders(j)[1] >= 0 and np.abs(waves[:, :, j]).max() > SMALLEST_WAVES]
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
        ("relative_illumination", _rounded(np.minimum(light, 1.0), 5)),
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


def _light(optic: Any, shares: F64, height_mm: F64, wavelength_nm: float) -> F64:
    """Return the irradiance of an even sky at heights on the flat sensor, over that on the axis.

    What comes from a ring of the sky, cos θ·dΩ for each part of the pupil that is open there, falls into a ring of the
    sensor, however sharp it is there: its light's middle is followed, which coma takes away from the chief ray.
    """
    full = math.radians(float(optic.fields.max_field))
    places, light = np.empty_like(shares), np.empty_like(shares)
    for k, share in enumerate(shares):
        inner, outer = max(share - LIT_STEP, 0.0), min(share + LIT_STEP, 1.0)
        traced = [_lit(optic, near, wavelength_nm) for near in (inner, share, outer)]
        passes = np.all([own for own, _ in traced], axis=0)
        if not passes.any():
            raise InputError(f"no light passes {math.degrees(full * share):.4g}° from the axis; give a smaller field")
        from_mm, places[k], to_mm = (abs(x[passes].mean()) for _, x in traced)
        sky = math.sin(full * outer) ** 2 - math.sin(full * inner) ** 2
        light[k] = passes.mean() * sky / (to_mm**2 - from_mm**2)
    mirrored = np.concatenate([-places[:0:-1], places]), np.concatenate([light[:0:-1], light])
    shown: F64 = CubicSpline(*mirrored)(height_mm)
    relative: F64 = shown / shown[0]
    return relative


def _lit(optic: Any, share: float, wavelength_nm: float) -> tuple[npt.NDArray[np.bool_], F64]:
    """Return which of the rays all over the pupil pass, and x of where they fall in the image, mm."""
    number = np.arange(LIT_RAYS // 2)
    radius, angle = np.sqrt((number + 0.5) / number.size), GOLDEN * number
    # Each with its opposite: what is out of focus has its middle where it is.
    along, across = np.outer([1.0, -1.0], radius * np.cos(angle)), np.outer([1.0, -1.0], radius * np.sin(angle))
    rays = optic.trace_generic(
        np.full(along.size, share), np.zeros(along.size), along.ravel(), across.ravel(), wavelength_nm / 1e3
    )
    x = np.asarray(rays.x, float)
    return np.isfinite(x) & (np.asarray(rays.i) > 0.0), x


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
