"""Glasses of prescriptions: by name from optiland's catalogue, by numbers from index and Abbe number."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Sequence
from importlib import resources
from typing import Any

import numpy as np

from camsim.core.arrays import F64
from camsim.errors import InputError

PLACEHOLDER = (1.5, 40.0)  # written by Zemax with every catalogue glass
SEEN_UM = (0.44, 0.65)  # range required of measurements, which are extrapolated to 380 and 780 nm
SAME_INDEX = 2e-4  # glasses of one name from several makers that differ by less count as equal
NEAR_INDEX = 2e-3  # tolerance between a catalogue's index and the file's to identify a glass
ROUNDED_INDEX = 1e-4  # tolerance within which the file's index is a rounded catalogue value
OPAQUE = 1e-4  # extinction at which a millimetre absorbs nine tenths of the light
MIDDLE_UM, D_UM = 0.55, 0.5875618
ALIASES = {  # of Zemax's catalogues MISC and INFRARED, and what stands in their place: the first, or what is nearer
    "ACRYLIC": ("organic/(C5H8O2)n - poly(methyl methacrylate)/Sultanova.yml",),
    "PMMA": ("organic/(C5H8O2)n - poly(methyl methacrylate)/Sultanova.yml",),
    "POLYCARB": ("organic/(C16H14O3)n - polycarbonate/Sultanova.yml",),
    "POLYSTYR": ("organic/(C8H8)n - polystyren/Sultanova.yml",),
    "E48R": ("other/commercial plastics/ZeonexE48R/Sultanova.yml",),
    "ZEONEX_E48R": ("other/commercial plastics/ZeonexE48R/Sultanova.yml",),
    "SILICA": ("main/SiO2/Malitson.yml",),
    "F_SILICA": ("main/SiO2/Malitson.yml",),
    "CAF2": ("main/CaF2/Malitson.yml", "main/CaF2/Daimon-20.yml"),
    "GERMANIUM": ("main/Ge/Aspnes.yml",),
}
BY_NUMBERS = {"COC": (1.5333, 56.2)}  # data sheet of TOPAS 5013
ABSENT = "lens import needs optiland, which is not installed; pip install 'camsim-spectral[lens]'"

Index = Callable[[F64], F64]


def by_numbers(nd: float, vd: float) -> Index:
    """Return the index of a glass by its index at 587.56 nm and its Abbe number (Buchdahl's dispersion)."""
    try:
        from optiland import materials
    except ImportError:
        raise InputError(ABSENT) from None
    made: Any = materials.AbbeMaterial
    return _index(made(nd, vd, model="buchdahl"))


def by_name(
    name: str, makers: Sequence[str] = (), stated: tuple[float, float] | None = None, *, where: str = ""
) -> tuple[Index, str]:
    """Return a glass's index, and a note unless it is the catalogue's glass of this name.

    makers : catalogues named by a file; if none, all are searched
    stated : index at 587.56 nm and Abbe number given with the name, to identify a near glass of a catalogue
    where  : prefix of error messages
    """
    stated = None if stated is None or stated[0] <= 1.0 else stated
    if name.startswith("___") and stated is not None:
        return by_numbers(*stated), ""
    if code := re.fullmatch(r"(\d{3})[.]?(\d{3})", name):
        return by_numbers(1.0 + float(code[1]) / 1e3, float(code[2]) / 10.0), f"{name} read as a code of six digits"
    found, note = _candidates(name.upper(), makers), ""
    materials = {maker: _material(file, name, where) for maker, file in found}
    if makers and found and found[0][0] not in ("", *(one.upper() for one in makers)):
        note = f"{name} of {found[0][0]}"
    if found and found[0][1].endswith(f"N-{name.upper()}.yml"):
        note = f"{name} taken as N-{name.upper()}"
    if stated is not None:
        near = {maker: abs(_at(one, D_UM) - stated[0]) for maker, one in materials.items()}
        best = min(near, key=near.__getitem__, default=None)
        if best is not None and near[best] < NEAR_INDEX:
            if near[best] > ROUNDED_INDEX:
                note = f"{name} of the catalogue, index {_at(materials[best], D_UM):.5f}; the file has {stated[0]:.5f}"
            return _index(materials[best]), note
        return by_numbers(*stated), f"{name} by the file's own index {stated[0]:g} and Abbe number {stated[1]:g}"
    if not materials and name.upper() in BY_NUMBERS:
        nd, vd = BY_NUMBERS[name.upper()]
        return by_numbers(nd, vd), f"{name} by index {nd:g} and Abbe number {vd:g}"
    if not materials:
        raise InputError(
            f"{where}glass {name!r}, which is in no catalogue of optiland's; write its index at 587.56 nm and its Abbe "
            f"number in its place (GLAS ___BLANK 1 0 1.5168 64.17), or six digits such as 517642"
        )
    indices = [_at(one, MIDDLE_UM) for one in materials.values()]
    if max(indices) - min(indices) > SAME_INDEX:
        raise InputError(
            f"{where}glass {name!r}, which is another one by {', '.join(materials)}; name whose it is (GCAT "
            f"{next(iter(materials))})"
        )
    return _index(next(iter(materials.values()))), note


def _candidates(name: str, makers: Sequence[str]) -> list[tuple[str, str]]:
    """Return makers and files of glasses of exactly this name, from the named makers if any."""
    try:
        from optiland.materials.registry import MaterialRegistry
    except ImportError:
        raise InputError(ABSENT) from None
    if name in ALIASES:
        return [("", ALIASES[name][0]), *((file, file) for file in ALIASES[name][1:])]
    rows = MaterialRegistry.instance().built_in_df
    names = rows.filename_no_ext.str.upper()
    rows = rows[(rows.group == "glass") & names.isin([name, f"N-{name}"])].drop_duplicates("filename")
    every = {str(file): str(file).split("/")[1].upper() for file in rows.filename}
    exact = [(maker, file) for file, maker in every.items() if not file.upper().endswith(f"/N-{name}.YML")]
    newer = [(maker, file) for file, maker in every.items() if (maker, file) not in exact and maker == "SCHOTT"]
    wanted = [maker.upper() for maker in makers]
    of_makers = sorted((one for one in exact if one[0] in wanted), key=lambda one: wanted.index(one[0]))
    if of_makers:
        return of_makers[:1]
    return newer if newer and ("SCHOTT" in wanted or not exact) else exact


def _material(file: str, name: str, where: str) -> Any:
    from optiland.materials.material_file import MaterialFile

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        material = MaterialFile(str(resources.files("optiland.database").joinpath("data-nk", file)))
        dark = material._k is not None and float(np.ravel(material.k(MIDDLE_UM))[0]) > OPAQUE
    if dark:
        raise InputError(f"{where}{name!r}, which no visible light passes; camsim renders 380 to 780 nm")
    low, high = _known_um(material)
    if low > SEEN_UM[0] or high < SEEN_UM[1]:
        raise InputError(
            f"{where}glass {name!r}, which is known from {low:g} to {high:g} µm; camsim renders 380 to 780 nm"
        )
    return material


def _known_um(material: Any) -> tuple[float, float]:
    """Return the range of wavelengths of a known index."""
    stated = material._formula_wavelength_range if material._n is None else material._n_wavelength
    return (0.0, 99.0) if stated is None else (float(np.min(stated)), float(np.max(stated)))


def _at(material: Any, um: float) -> float:
    return float(np.ravel(material.n(um))[0])


def _index(material: Any) -> Index:
    def index(nm: F64) -> F64:
        return np.array([_at(material, float(one) / 1e3) for one in np.ravel(nm)])

    return index
