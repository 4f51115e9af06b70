"""Curves by name: reflectances, illuminants, camera sensitivities and observers, from colour-science.

Where each data set comes from and under which licence: DATA_LICENSES.md.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Mapping
from typing import Any, Literal, TypeVar

import numpy as np

from camsim.core.arrays import F64
from camsim.core.typed import check
from camsim.errors import UnknownNameError
from camsim.spectra.cached import cached
from camsim.spectra.colour_science import colour_science
from camsim.spectra.curve import Curve

# The 24 patches of ISO 17321-1 have plain names; other charts "chart/patch". Ohta's chart holds
# the same numbers as ISO 17321-1, so it is left out.
_BARE_CHART = "ISO 17321-1"
_CHARTS = (_BARE_CHART, "BabelColor Average", "PMC")
_DAYLIGHTS = {"D50": 5000.0, "D55": 5500.0, "D60": 6000.0, "D65": 6500.0, "D75": 7500.0}
_T = TypeVar("_T")
_Table = tuple[list[float], list[float]]  # wavelengths, values

_LETTERS = {"red": "R", "green": "G", "blue": "B"}


def reflectance_names() -> tuple[str, ...]:
    """Return the names of all reflectances; the 24 ColorChecker patches of ISO 17321-1 come first.

    >>> reflectance_names()[:3]
    ('dark skin', 'light skin', 'blue sky')
    """
    return tuple(_reflecting())


def reflectance(name: str) -> Curve:
    """Return a reflectance by name: "dark skin", "white 9.5", "BabelColor Average/cyan", "PMC/Banana" …

    A surface goes on beyond its table, so the ends are held.

    >>> reflectance("white 9.5").wavelength_nm[0], reflectance("white 9.5").values[0]
    (380.0, 0.153)
    """
    return _reflectance(check(name, str, "name"))


@functools.cache
def _reflectance(name: str) -> Curve:
    return _curve(_find("reflectance", name, _reflecting()), name, "hold")


def illuminant_names() -> tuple[str, ...]:
    """Return the names of all illuminants: A, D50 … D75, E, FL1 … FL3.15, HP1 …, LED-B1 … and more."""
    return tuple(_lights())


@functools.cache
def illuminant(name: str) -> Curve:
    """Return the relative spectral power of a CIE or ISO illuminant; F2 is the same as FL2.

    Tables end at 780 nm mostly. A goes on to 1100 nm by the formula that defines it, D50 to D75 to 830 nm by CIE 15's
    daylight components, where those end.

    >>> float(illuminant("D65").at(560.0))
    100.0
    """
    name = re.sub(r"^F(?=\d)", "FL", name)
    return _curve(_find("illuminant", name, _lights()), name, "zero")


def sensitivity_names() -> tuple[str, ...]:
    """Return the names of the cameras whose measured sensitivities are known."""
    return tuple(_responses())


def sensitivities(name: str) -> dict[str, Curve]:
    """Return a camera's curves by channel letter, relative, as responses per unit radiant energy.

    >>> sorted(sensitivities("Nikon 5100 (NPL)"))
    ['B', 'G', 'R']
    """
    channels = _find("sensitivity", check(name, str, "name"), _responses())
    return {letter: _curve(table, f"{name} {letter}", "zero") for letter, table in channels.items()}


@functools.cache
def photopic_observer() -> Curve:
    """Return V(λ) of the CIE 1924 photopic observer, 360–830 nm in steps of 1 nm; 1 at 555 nm."""
    return _curve(_observer(), "V(λ), CIE 1924", "zero")


@cached
def _observer() -> _Table:
    return _table(colour_science().SDS_LEFS["CIE 1924 Photopic Standard Observer"])


@cached
def _reflecting() -> dict[str, _Table]:
    tables = {}
    for chart in _CHARTS:
        for patch, data in colour_science().SDS_COLOURCHECKERS[chart].items():
            # "white 9.5 (.05 D)": the density in brackets is not part of the name.
            bare = re.sub(r" \(.* D\)$", "", patch)
            name = bare if chart == _BARE_CHART else f"{chart}/{bare}"
            tables[name] = _table(data)
    return tables


@cached
def _lights() -> dict[str, _Table]:
    tables = {name: _table(data) for name, data in colour_science().SDS_ILLUMINANTS.items()}
    tables["A"] = _continued(tables["A"], np.arange(785.0, 1101.0, 5.0), illuminant_a)
    for name, nominal_k in _DAYLIGHTS.items():
        tables[name] = _continued(tables[name], np.arange(785.0, 831.0, 5.0), _daylight(nominal_k))
    return tables


def illuminant_a(wavelength_nm: F64) -> F64:
    """Return CIE standard illuminant A, 100 at 560 nm (CIE 15: c₂ = 1.435e7 nm K at 2848 K).

    >>> illuminant_a(np.array([560.0])).tolist()
    [100.0]
    """
    c2_over_t_nm = 1.435e7 / 2848.0
    power: F64 = (
        100.0 * (560.0 / wavelength_nm) ** 5 * (np.expm1(c2_over_t_nm / 560.0) / np.expm1(c2_over_t_nm / wavelength_nm))
    )
    return power


def _daylight(nominal_k: float) -> Callable[[F64], F64]:
    """Return the daylight phase of a nominal colour temperature, by CIE 15's components (300 to 830 nm)."""
    colour = colour_science()
    # The D illuminants were named before c₂ went from 1.4380 to 1.4388 cm K.
    data = colour.sd_CIE_illuminant_D_series(colour.temperature.CCT_to_xy_CIE_D(nominal_k * 1.4388 / 1.4380))

    def at(wavelength_nm: F64) -> F64:
        power: F64 = np.interp(wavelength_nm, data.wavelengths, data.values)
        return power

    return at


def _continued(table: _Table, wavelength_nm: F64, formula: Callable[[F64], F64]) -> _Table:
    """Append a formula's values at wavelengths beyond a table's last."""
    more_nm = wavelength_nm[wavelength_nm > table[0][-1]]
    return [*table[0], *more_nm.tolist()], [*table[1], *formula(more_nm).tolist()]


@cached
def _responses() -> dict[str, dict[str, _Table]]:
    return {
        camera: {_LETTERS[label]: _table(channel) for label, channel in zip(data.labels, data.to_sds(), strict=True)}
        for camera, data in colour_science().MSDS_CAMERA_SENSITIVITIES.items()
    }


def _find(kind: str, name: str, known: Mapping[str, _T]) -> _T:
    if name not in known:
        raise UnknownNameError(kind, name, known, key="name")
    return known[name]


def _table(data: Any) -> _Table:
    return data.wavelengths.tolist(), data.values.tolist()


def _curve(table: _Table, name: str, outside: Literal["zero", "hold"]) -> Curve:
    wavelength_nm, values = table
    return Curve(tuple(wavelength_nm), tuple(values), name, outside)
