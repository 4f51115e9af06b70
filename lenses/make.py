"""Write the shipped lenses: ``python lenses/make.py`` (needs the extra ``lens``). Prescriptions stand here.

A surface is (radius mm, thickness mm, glass behind it or None, whether it is the stop). Both prescriptions are textbook
forms as optiland 0.6's samples have them (MIT licence, optiland/samples/objectives.py), with glasses of its catalogue.
"""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import Any, NamedTuple

from optiland.optic import Optic

from camsim.config.lens_import import lens_file, surfaces

FLAT = math.inf
SOURCE = "prescription of optiland 0.6's samples (MIT licence), traced with optiland by lenses/make.py"


class Prescription(NamedTuple):
    """A lens: what its file says first, aperture as optiland has it, half the field in degrees, and surfaces."""

    comment: str
    aperture: tuple[str, float]
    half_deg: float
    surfaces: tuple[tuple[Any, ...], ...]


LENSES = {
    "cooke-triplet": Prescription(
        "Cooke triplet, 50 mm f/5, 40° of field: three glasses, strong towards the corners",
        ("EPD", 10.0),
        20.0,
        (
            (22.01359, 3.25896, ("SK16", "hikari"), False),
            (-435.76044, 6.00755, None, False),
            (-22.21328, 0.99997, ("F2", "schott"), False),
            (20.29192, 4.75041, None, True),
            (79.68360, 2.95208, ("SK16", "hikari"), False),
            (-18.39533, 42.20778, None, False),
        ),
    ),
    "double-gauss": Prescription(
        "Double Gauss, 100 mm f/5, 28° of field: sharp in the middle, curved towards the corners",
        ("imageFNO", 5.0),
        14.0,
        (
            (56.20238, 8.75, "N-SSK2", False),
            (152.28580, 0.5, None, False),
            (37.68262, 12.5, "N-SK2", False),
            (FLAT, 3.8, ("F5", "schott"), False),
            (24.23130, 16.369445, None, False),
            (FLAT, 13.747957, None, True),
            (-28.37731, 3.8, ("F5", "schott"), False),
            (FLAT, 11.0, "N-SK16", False),
            (-37.92546, 0.5, None, False),
            (177.41176, 7.0, "N-SK16", False),
            (-79.41143, 61.487536, None, False),
        ),
    ),
}
PERFECT = """# Perfect lens, f/5.6: no aberration anywhere, no distortion, even light.
camsim: lens/1
name: perfect
source: diffraction alone; to compare others with
f_number: 5.6
wavelength_nm: [550] # of one wavelength: the same path differences at all
height_um: [0, 30000]
zernike: [4]
waves: [[[0], [0]]]
"""


def optic_of(prescription: Prescription) -> Optic:
    """Return a lens to trace rays through."""
    optic = Optic()
    optic.surfaces.add(index=0, radius=FLAT, thickness=FLAT)
    surfaces(optic, prescription.surfaces)
    optic.set_aperture(aperture_type=prescription.aperture[0], value=prescription.aperture[1])
    optic.fields.set_type(field_type="angle")
    for share in (0.0, 1.0):
        optic.fields.add(y=share * prescription.half_deg)
    optic.wavelengths.add(value=0.55, is_primary=True)
    return optic


if __name__ == "__main__":
    folder = Path(__file__).parent
    (folder / "perfect.yaml").write_text(PERFECT, encoding="utf-8")
    for name, prescription in LENSES.items():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            text = lens_file(optic_of(prescription), name=name, source=SOURCE, comment=prescription.comment)
        (folder / f"{name}.yaml").write_text(text, encoding="utf-8")
        print(f"{name}: {len(text)} characters")
