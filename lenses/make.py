"""Write the shipped lenses: ``python lenses/make.py`` (needs the extra ``lens``). Prescriptions stand here.

A surface is (radius mm, thickness mm, glass behind it or None, whether it is the stop); a glass a name and whose it
is, or (index at 587.56 nm, Abbe number); an asphere has (conic constant, coefficients of r³, r⁴, …) besides, mm. The
triplet and the double Gauss are textbook forms as optiland 0.6's samples have them (MIT licence,
optiland/samples/objectives.py), with glasses of its catalogue. The mobile lens is the published example of US patent
7,535,658 (2009) as the documentation of ray-optics has it (BSD-3-Clause, "Cell Phone Camera Lens"), whose K is the
conic constant and 1; rays that are printed there fall within 1e-5 mm of these (tests/clients/test_optiland.py).
Of its plastics index and Abbe number are known.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, NamedTuple

from camsim.config.lens_glass import Index, by_name, by_numbers
from camsim.config.lens_rays import Prescription, Surface
from camsim.config.lens_tables import lens_file

FLAT = math.inf
OF_OPTILAND = "prescription of optiland 0.6's samples (MIT licence), traced by lenses/make.py"
OF_A_PATENT = "published example of US patent 7,535,658, traced by lenses/make.py"


class Told(NamedTuple):
    """A lens: what its file says first, aperture as ``Prescription``'s, half the field in degrees, surfaces, source."""

    comment: str
    aperture: tuple[str, float]
    half_deg: float
    surfaces: tuple[tuple[Any, ...], ...]
    source: str = OF_OPTILAND


LENSES = {
    "cooke-triplet": Told(
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
    "double-gauss": Told(
        "Double Gauss, 100 mm f/5, 28° of field: sharp in the middle, curved towards the corners",
        ("FNO", 5.0),
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
    "mobile": Told(
        "Mobile lens, 5.6 mm f/3.5, 64° of field: four plastic aspheres and a cover, waves all over the frame",
        ("FNO", 3.5),
        31.76,
        (
            (FLAT, 0.0, None, True),
            (
                1.962,
                1.19,
                (1.471, 76.6),
                False,
                (1.153, (-1.895e-2, 2.426e-2, -5.123e-2, 8.371e-4, 7.850e-3, 4.091e-3, -7.732e-3, -4.265e-3)),
            ),
            (
                33.398,
                0.93,
                None,
                False,
                (39.18, (-4.966e-3, -1.434e-2, -6.139e-3, -9.284e-5, 6.438e-3, -5.72e-3, -2.385e-2, 1.108e-2)),
            ),
            (
                -2.182,
                0.75,
                (1.603, 27.5),
                False,
                (1.105, (-4.388e-2, -2.555e-2, 5.16e-2, -4.307e-2, -2.831e-2, 3.162e-2, 4.630e-2, -4.877e-2)),
            ),
            (
                -6.367,
                0.1,
                None,
                False,
                (2.382, (-1.131e-1, -7.863e-2, 1.094e-1, 6.228e-3, -2.216e-2, -5.89e-3, 4.123e-3, 1.041e-3)),
            ),
            (
                5.694,
                0.89,
                (1.510, 56.2),
                False,
                (-222.1, (-7.876e-2, 7.02e-2, 1.575e-3, -9.958e-3, -7.322e-3, 6.914e-4, 2.54e-3, -7.65e-4)),
            ),
            (
                9.192,
                0.16,
                None,
                False,
                (-0.0669, (9.694e-3, -2.516e-3, -3.606e-3, -2.497e-4, -6.84e-4, -1.414e-4, 2.932e-4, -7.284e-5)),
            ),
            (
                1.674,
                0.85,
                (1.510, 56.2),
                False,
                (-8.617, (7.429e-2, -6.933e-2, -5.811e-3, 2.396e-3, 2.100e-3, -3.119e-4, -5.552e-5, 7.969e-6)),
            ),
            (
                1.509,
                0.70,
                None,
                False,
                (-3.707, (1.767e-3, -4.652e-2, 1.625e-2, -3.522e-3, -7.106e-4, 3.825e-4, 6.271e-5, -2.631e-5)),
            ),
            (FLAT, 0.40, (1.516, 64.1), False),
            (FLAT, 0.64, None, False),
        ),
        OF_A_PATENT,
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


def prescription_of(lens: Told) -> Prescription:
    """Return a lens to trace rays through."""
    surfaces = []
    for radius, thickness, glass, stop, *asphere in lens.surfaces:
        conic, coefficients = asphere[0] if asphere else (0.0, ())
        surfaces.append(
            Surface(
                curvature_per_mm=1.0 / radius,
                conic=conic,
                powers=tuple(enumerate(coefficients, start=3)),
                thickness_mm=thickness,
                index=index_of(glass),
                stop=stop,
            )
        )
    return Prescription(surfaces=tuple(surfaces), aperture=lens.aperture)


def index_of(glass: Any) -> Index | None:
    """Return the index behind a surface, None of air."""
    if glass is None:
        return None
    if isinstance(glass, tuple) and isinstance(glass[0], float):
        return by_numbers(*glass)
    name, *makers = glass if isinstance(glass, tuple) else (glass, "schott")
    return by_name(name, makers)[0]


if __name__ == "__main__":
    folder = Path(__file__).parent
    (folder / "perfect.yaml").write_text(PERFECT, encoding="utf-8")
    for name, lens in LENSES.items():
        traced = lens_file(
            prescription_of(lens), math.radians(lens.half_deg), name=name, source=lens.source, comment=lens.comment
        )
        (folder / f"{name}.yaml").write_text(traced.text, encoding="utf-8")
        print(f"{name}: {traced.told}")
