"""Lens files from Zemax prescriptions: read, validated, traced, and written only if readable again."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from camsim.config import lens_glass
from camsim.config.lens_rays import NEAR_AXIS, Lens, Prescription, Surface, or_aim
from camsim.config.lens_tables import Traced, lens_file
from camsim.core.note import Note
from camsim.errors import InputError

UNITS_MM = {"MM": 1.0, "CM": 10.0, "IN": 25.4, "METER": 1000.0}  # as Zemax writes them
ANGLES, PARAXIAL_HEIGHTS, REAL_HEIGHTS = "0", "2", "3"
FIELDS = {"1": "object heights", "4": "theodolite angles"}
RIMS = {
    "OBSC": "an obstruction",
    "SQAP": "a rectangular aperture",
    "SQOB": "a rectangular obstruction",
    "ELAP": "an elliptical aperture",
    "ELOB": "an elliptical obstruction",
    "SPID": "a spider",
    "USAP": "an aperture by points",
    "USOB": "an obstruction by points",
}  # allowed for a surface, without effect on rays
VIGNETTING = ("VDXN", "VDYN", "VCXN", "VCYN")  # factors of each field: shifts of its pupil, compressions
ENCODINGS = ("utf-16", "utf-8", "iso-8859-1")
ASPHERES = {"STANDARD": 0, "EVENASPH": 2, "ODDASPHE": 1}  # powers of r from one PARM to the next
FAR_MM = 1e9  # an object at this distance counts as at infinity
SEEN_UM = (0.38, 0.78)
MIDDLE_NM = 550.0
WIDEST_DEG = 89.0
SCANNED = 179  # angles scanned for an image height

MODEL = "1"  # behind a glass's name: by its index and Abbe number
Operands = list[list[str]]


def import_zemax(file: Path, *, field_deg: float | None = None, field_mm: float | None = None) -> str:
    """Return the text of the lens file of a Zemax prescription; see ``trace_zemax``."""
    return trace_zemax(file, field_deg=field_deg, field_mm=field_mm).text


def trace_zemax(file: Path, *, field_deg: float | None = None, field_mm: float | None = None) -> Traced:
    """Trace a Zemax prescription; raises InputError where it cannot be read, or where a lens file cannot hold it.

    field_deg, field_mm : the largest field, an angle or a height in the image, in place of the file's own
    """
    stated, full, notes = read_zemax(file, field_deg=field_deg, field_mm=field_mm)
    return lens_file(stated, full, name=file.stem, source=f"traced from {file.name}", notes=notes)


def read_zemax(
    file: Path, *, field_deg: float | None = None, field_mm: float | None = None
) -> tuple[Prescription, float, list[Note]]:
    """Return the lens of a Zemax prescription, its largest field in radians, and notes."""
    if not file.is_file():
        raise InputError(f"no such file: {str(file)!r}")
    head, surfaces = _read(file)
    stated, notes = _prescription(head, surfaces, file.name)
    stated = _stopped(stated, file.name, notes)
    lens = stated.of_wavelengths((stated.middle_nm,))
    fields = _fields(head)
    if field_deg is not None:
        full = math.radians(field_deg)
    elif field_mm is not None:
        full = _angle_of(lens, field_mm, file.name)
    else:
        full = _angle(lens, head, max(math.hypot(x, y) for x, y, *_ in fields), file.name)
    if any(any(factors) for _, _, *factors in fields):
        stated = dataclasses.replace(stated, vignetting=_vignetting(lens, head, fields, file.name))
        text = "the pupil is that of the file's vignetting factors, linear between its fields"
        notes.append(Note("vignetting-factors", text, "VDXN"))
    return stated, full, notes


def _read(file: Path) -> tuple[Operands, list[Operands]]:
    """Return the words of each line of a Zemax file: of its head, and of each surface."""
    content = file.read_bytes()
    for encoding in ENCODINGS:
        try:
            lines = [line.split() for line in content.decode(encoding).splitlines()]
        except UnicodeError:
            continue
        blocks: list[Operands] = [[]]
        for words in filter(None, lines):
            if words[0] == "SURF":
                blocks.append([])
            blocks[-1].append(words)
        if len(blocks) > 1:
            return blocks[0], blocks[1:]
    raise InputError(f"{file.name!r} has no surface (SURF); give a sequential Zemax prescription, a .zmx file")


def _values(operands: Operands, key: str) -> list[str]:
    """Return the words after an operand's last occurrence; none if it does not occur."""
    return next((words[1:] for words in reversed(operands) if words[0] == key), [])


def _number(operands: Operands, key: str, place: int = 0, otherwise: float = 0.0) -> float:
    values = _values(operands, key)
    return float(values[place].replace(",", ".")) if len(values) > place else otherwise


def _prescription(head: Operands, blocks: list[Operands], name: str) -> tuple[Prescription, list[Note]]:
    """Return the lens, and notes."""
    if (mode := (_values(head, "MODE") or ["SEQ"])[0]) != "SEQ":
        raise InputError(f"{name!r} is of mode {mode}; save it as a sequential system (MODE SEQ)")
    unit = (_values(head, "UNIT") or ["MM"])[0].upper()
    if unit not in UNITS_MM:
        raise InputError(f"{name!r} has lengths in {unit!r}; save it in one of {', '.join(UNITS_MM)} (UNIT)")
    mm = UNITS_MM[unit]
    if _number(head, "GFAC", 0) and _number(head, "GFAC", 1):
        raise InputError(f"{name!r} has an apodised pupil (GFAC); lens files are of evenly lit ones: clear it")
    distance = (_values(blocks[0], "DISZ") or ["INFINITY"])[0]
    if distance != "INFINITY" and abs(float(distance)) * mm < FAR_MM:
        raise InputError(
            f"{name!r} has its object at a finite distance; lens files are of a scene far away: "
            "save it with the object at infinity (DISZ INFINITY of SURF 0), in focus there"
        )
    image = len(blocks) - 1
    if image < 2:
        raise InputError(f"{name!r} has {len(blocks)} surfaces; a lens has some between object and image")
    if (_values(blocks[image], "TYPE") or ["STANDARD"])[0] != "STANDARD" or _number(blocks[image], "CURV"):
        radius = mm / (_number(blocks[image], "CURV") or math.inf)
        raise InputError(
            f"{name!r} has a curved image surface (SURF {image}, radius {radius:.4g} mm), and sensors are flat; "
            "give it no curvature (CURV 0), and the lens its best focus there"
        )
    notes: list[Note] = []
    makers = _values(head, "GCAT")
    surfaces = [_surface(number, one, mm, makers, name, notes) for number, one in enumerate(blocks[1:image], start=1)]
    if not any(surface.stop for surface in surfaces):
        raise InputError(f"{name!r} has no aperture stop (STOP); mark the surface that is it")
    middle_nm = _primary_nm(head)
    if not SEEN_UM[0] <= middle_nm / 1e3 <= SEEN_UM[1]:
        text = f"primary wavelength {middle_nm:g} nm, which is not seen: {MIDDLE_NM:g} nm in its place"
        notes.append(Note("wavelength-not-seen", text, "PWAV"))
        middle_nm = MIDDLE_NM
    aim = _number(head, "RAIM", 1) != 0.0
    if not aim:
        text = "rays fill the paraxial entrance pupil, for the file does not aim them at the stop (RAIM 0 0)"
        notes.append(Note("paraxial-pupil", text, "RAIM"))
    aperture = _aperture(head, blocks, mm, name)
    return Prescription(surfaces=tuple(surfaces), aperture=aperture, aim=aim, middle_nm=middle_nm), notes


def _aperture(head: Operands, blocks: list[Operands], mm: float, name: str) -> tuple[str, float]:
    if any(words[0] == "FLOA" for words in head):
        [stop] = [one for one in blocks if any(words[0] == "STOP" for words in one)][:1]
        found = ("stop", mm * _number(stop, "DIAM"))
    elif any(words[0] == "ENPD" for words in head):
        found = ("EPD", mm * _number(head, "ENPD"))
    else:
        found = ("FNO", _number(head, "FNUM"))
    if not found[1] > 0.0:
        raise InputError(
            f"{name!r} has no aperture that is taken; give its entrance pupil's diameter (ENPD), its f-number "
            "(FNUM), or its stop's radius (FLOA, and DIAM of the stop)"
        )
    return found


def _primary_nm(head: Operands) -> float:
    """Return the primary wavelength; files have them one a line, or all in one."""
    each = {int(values[0]): 1e3 * float(values[1]) for key, *values in head if key == "WAVM"}
    each = each or {k: 1e3 * float(value) for k, value in enumerate(_values(head, "WAVL"), start=1)}
    return each.get(int(_number(head, "PWAV", otherwise=1.0)), MIDDLE_NM)


def _surface(number: int, one: Operands, mm: float, makers: Sequence[str], name: str, notes: list[Note]) -> Surface:
    """Return a surface; raises InputError unless it is rotationally symmetric and supported."""
    kind = (_values(one, "TYPE") or ["STANDARD"])[0]
    parameters = {int(values[0]): float(values[1]) for key, *values in one if key == "PARM" and len(values) > 1}
    if kind == "COORDBRK" and not any(parameters.get(k, 0.0) for k in range(1, 6)):
        kind, parameters = "STANDARD", {}
    if kind in ("COORDBRK", "TOROIDAL", "TILTSURF", "BICONICX", "IRREGULA"):
        raise InputError(
            f"{name!r} has a surface that is not the same all round the axis (SURF {number}, TYPE {kind}); lens files "
            "are of systems that are: leave out tilts, decentres and toroids"
        )
    if kind not in ASPHERES:
        raise InputError(
            f"{name!r} has a surface of a type that rays are not traced through (SURF {number}, TYPE {kind}); "
            f"those that are: {', '.join(ASPHERES)}"
        )
    for key, *values in one:
        if key in RIMS:
            raise InputError(
                f"{name!r} has {RIMS[key]} ({key} of SURF {number}), and rays are stopped by circles alone; "
                "save it with circular apertures that are open in the middle (CLAP 0 RADIUS), or none"
            )
        if key in ("OBDC", "SDEC") and any(float(value) for value in values[:2]):
            raise InputError(f"{name!r} has a decentred aperture ({key} of SURF {number}); centre it")
    rim_mm = math.inf
    for key in ("CLAP", "FLAP"):
        if _number(one, key, 0):
            raise InputError(
                f"{name!r} has an aperture with a covered middle ({key} of SURF {number}), and rays are stopped by "
                "circles alone; save it with circular apertures that are open in the middle (CLAP 0 RADIUS), or none"
            )
        rim_mm = min(rim_mm, mm * _number(one, key, 1, math.inf))
    powers = [(ASPHERES[kind] * k, value * mm ** (1 - ASPHERES[kind] * k)) for k, value in parameters.items() if value]
    if kind == "STANDARD":
        powers = []
    if any(power < 2 for power, _ in powers):
        raise InputError(f"{name!r} has a cone (PARM 1 of SURF {number}), whose tip no ray is traced through")
    glass = _values(one, "GLAS")
    mirror = bool(glass) and glass[0].upper() == "MIRROR"
    index = None
    if glass and not mirror:
        stated = (float(glass[3].replace(",", ".")), float(glass[4].replace(",", "."))) if len(glass) > 4 else None
        if stated == lens_glass.PLACEHOLDER and glass[1] != MODEL:
            stated = None
        where = f"{name!r} has at SURF {number} the "
        index, text = lens_glass.by_name(glass[0], makers, stated, where=where)
        if text and (note := Note("glass", text, glass[0])) not in notes:
            notes.append(note)
    distance = (_values(one, "DISZ") or ["0"])[0]
    if distance == "INFINITY" or not math.isfinite(float(distance)):
        raise InputError(f"{name!r} has an infinite distance behind SURF {number}; give it a length (DISZ)")
    return Surface(
        curvature_per_mm=_number(one, "CURV") / mm,
        conic=_number(one, "CONI"),
        powers=tuple(powers),
        thickness_mm=mm * float(distance),
        index=index,
        mirror=mirror,
        rim_mm=rim_mm,
        stop=any(words[0] == "STOP" for words in one),
    )


def _stopped(stated: Prescription, name: str, notes: list[Note]) -> Prescription:
    """Return the lens with the aperture that limits the axial beam as its stop; raises InputError if it is afocal."""
    lens = stated.of_wavelengths((stated.middle_nm,))
    if not math.isfinite(lens.focal_mm) or abs(lens.focal_mm) > FAR_MM or not math.isfinite(lens.radius_mm):
        raise InputError(f"{name!r} has no focal length: light of a far point leaves it as parallel as it came")
    radius = np.linspace(0.0, 1.0, 501)
    [axis] = lens.beams([0.0], np.stack([radius, 0.0 * radius]))
    if axis.passes[0].all():
        return stated
    open_to = max(int(np.argmin(axis.passes[0])) - 1, 1)
    places = np.array([[radius[open_to]], [0.0]])

    def share(number: int) -> float:
        alone = [dataclasses.replace(one, rim_mm=one.rim_mm if k == number else math.inf) for k, one in rims]
        [beam] = dataclasses.replace(lens, surfaces=tuple(alone)).beams([0.0], places)
        return float(beam.share[0, 0])

    rims = list(enumerate(stated.surfaces))
    first = max(range(len(rims)), key=share)
    text = f"the aperture of SURF {first + 1} is taken for the stop, as it stops more of the axis's light"
    notes.append(Note("other-stop", text, f"SURF {first + 1}"))
    surfaces = [
        dataclasses.replace(one, stop=k == first, rim_mm=min(one.rim_mm, lens.stop_mm) if one.stop else one.rim_mm)
        for k, one in rims
    ]
    return dataclasses.replace(stated, surfaces=tuple(surfaces), aperture=("stop", surfaces[first].rim_mm))


def _fields(head: Operands) -> list[list[float]]:
    """Return x and y of the file's fields, in the file's unit, and the vignetting factors of each."""
    count = int(_number(head, "FTYP", 2, 0.0)) or None  # later entries are leftovers of other fields

    def of(key: str, older: str) -> list[float]:
        return [float(value) for value in (_values(head, key) or _values(head, older))[:count]]

    columns = [of(f"{axis}FLN", f"{axis}FLD") for axis in "XY"] + [of(key, key) for key in VIGNETTING]
    return [list(row) for row in itertools.zip_longest(*columns, fillvalue=0.0)] or [[0.0] * len(columns)]


def _vignetting(
    lens: Lens, head: Operands, fields: list[list[float]], name: str
) -> tuple[tuple[float, float, float, float], ...]:
    """Return ``Prescription.vignetting``; raises InputError if it is not rotationally symmetric."""
    rows = {0.0: (0.0, 0.0, 0.0)}
    for number, (x, y, *factors) in enumerate(fields, start=1):
        shift_x, shift_y, less_x, less_y = factors
        along, across = ((shift_y, less_y), (shift_x, less_x)) if y else ((shift_x, less_x), (shift_y, less_y))
        one = math.copysign(1.0, x + y) * along[0], along[1], across[1]
        at = _angle(lens, head, math.hypot(x, y), name) if x or y else 0.0
        even = (x and y) or at == 0.0
        if across[0] or (even and (along[0] or along[1] != across[1])) or (at and rows.get(at, one) != one):
            raise InputError(
                f"{name!r} has vignetting factors that are not the same all round the axis (VDXN, VDYN, VCXN, VCYN of "
                f"field {number}), and lens files are of systems that are; clear them and give the surfaces that cut "
                "light their apertures (CLAP 0 RADIUS)"
            )
        rows[at] = one
    return tuple((at, *rows[at]) for at in sorted(rows))


def _angle(lens: Lens, head: Operands, field: float, name: str) -> float:
    """Return a field of a file as an angle, radians."""
    kind = (_values(head, "FTYP") or [ANGLES])[0]
    if kind in FIELDS:
        raise InputError(
            f"{name!r} has fields by {FIELDS[kind]} (FTYP {kind}); give the largest one, --field DEGREES or --field-mm "
            "HEIGHT in the image, or save it with fields as angles (FTYP 0, YFLN in degrees)"
        )
    if not field > 0.0:
        raise InputError(
            f"{name!r} has no field but the axis; give the largest one: --field DEGREES, or --field-mm HEIGHT in the "
            "image"
        )
    if kind == ANGLES:
        return math.radians(field)
    field_mm = field * UNITS_MM[(_values(head, "UNIT") or ["MM"])[0].upper()]
    if kind == PARAXIAL_HEIGHTS:
        [near] = lens.beams([NEAR_AXIS], np.empty((2, 0)))
        return math.atan(field_mm / abs(float(near.chief_mm[0])) * math.tan(NEAR_AXIS))
    return _angle_of(lens, field_mm, name)


def _angle_of(lens: Lens, height_mm: float, name: str) -> float:
    """Return the angle whose chief ray has a given image height, radians."""
    none = np.empty((2, 0))
    angles = np.radians(np.linspace(0.0, WIDEST_DEG, SCANNED))
    heights = np.abs([float(beam.chief_mm[0]) for beam in lens.beams(angles.tolist(), none)])
    beyond = np.flatnonzero(heights >= height_mm)
    stop = int(beyond[0]) if beyond.size else 0
    if not stop or not np.isfinite(heights[:stop]).all():
        reached = float(np.nanmax(heights))
        raise InputError(
            f"{name!r} has no chief ray that falls {height_mm:g} mm from the axis; those that are found reach "
            f"{reached:.4g} mm: {or_aim(lens.aim)}give it a smaller field, such as --field-mm {0.95 * reached:.3g}"
        )
    low, high = float(angles[stop - 1]), float(angles[stop])
    while high - low > 1e-10:
        middle = 0.5 * (low + high)
        [_, beam] = lens.beams([float(angles[stop - 1]), middle], none)
        low, high = (middle, high) if abs(float(beam.chief_mm[0])) < height_mm else (low, middle)
    return 0.5 * (low + high)
