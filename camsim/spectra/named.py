"""Curves by name: reflectances, illuminants, camera sensitivities and the eye, from colour-science.

Where each data set comes from and under which licence: DATA_LICENSES.md.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Mapping
from typing import Any, Literal, TypeVar

from camsim.errors import UnknownNameError
from camsim.spectra.colour_science import colour_science
from camsim.spectra.curve import Curve

# The 24 patches of ISO 17321-1 go by their bare names; the other charts by "chart/patch". Ohta's chart holds
# the same numbers as ISO 17321-1, so it is left out.
_BARE_CHART = "ISO 17321-1"
_CHARTS = (_BARE_CHART, "BabelColor Average", "PMC")
_T = TypeVar("_T")

_LETTERS = {"red": "R", "green": "G", "blue": "B"}


def reflectance_names() -> tuple[str, ...]:
    """Return the names of all reflectances; the 24 ColorChecker patches of ISO 17321-1 come first.

    >>> reflectance_names()[:3]
    ('dark skin', 'light skin', 'blue sky')
    """
    return tuple(_reflectances())


def reflectance(name: str) -> Curve:
    """Return a reflectance by name: "dark skin", "white 9.5", "BabelColor Average/cyan", "PMC/Banana" …

    A surface goes on beyond its table, so the ends are held.

    >>> reflectance("white 9.5").wavelength_nm[0], reflectance("white 9.5").values[0]
    (380.0, 0.153)
    """
    return _find("reflectance", name, _reflectances())


def illuminant_names() -> tuple[str, ...]:
    """Return the names of all illuminants: A, D50 … D75, E, FL1 … FL3.15, HP1 …, LED-B1 … and more."""
    return tuple(_illuminants())


def illuminant(name: str) -> Curve:
    """Return the relative spectral power of a CIE or ISO illuminant; F2 is the same as FL2.

    >>> float(illuminant("D65").at(560.0))
    100.0
    """
    return _find("illuminant", re.sub(r"^F(?=\d)", "FL", name), _illuminants())


def sensitivity_names() -> tuple[str, ...]:
    """Return the names of the cameras whose measured sensitivities are known."""
    return tuple(_sensitivities())


def sensitivities(name: str) -> dict[str, Curve]:
    """Return a camera's curves by channel letter, relative, as responses per unit radiant energy.

    >>> sorted(sensitivities("Nikon 5100 (NPL)"))
    ['B', 'G', 'R']
    """
    return dict(_find("sensitivity", name, _sensitivities()))


@functools.cache
def photopic_observer() -> Curve:
    """Return V(λ) of the CIE 1924 photopic observer, 360–830 nm in steps of 1 nm; 1 at 555 nm."""
    return _curve(colour_science().SDS_LEFS["CIE 1924 Photopic Standard Observer"], "V(λ), CIE 1924", "zero")


@functools.cache
def _reflectances() -> Mapping[str, Curve]:
    curves = {}
    for chart in _CHARTS:
        for patch, data in colour_science().SDS_COLOURCHECKERS[chart].items():
            # "white 9.5 (.05 D)": the density in brackets is no part of a name that people type.
            bare = re.sub(r" \(.* D\)$", "", patch)
            name = bare if chart == _BARE_CHART else f"{chart}/{bare}"
            curves[name] = _curve(data, name, "hold")
    return curves


@functools.cache
def _illuminants() -> Mapping[str, Curve]:
    return {name: _curve(data, name, "zero") for name, data in colour_science().SDS_ILLUMINANTS.items()}


@functools.cache
def _sensitivities() -> Mapping[str, Mapping[str, Curve]]:
    cameras = {}
    for camera, data in colour_science().MSDS_CAMERA_SENSITIVITIES.items():
        channels = data.to_sds()
        cameras[camera] = {
            _LETTERS[label]: _curve(channel, f"{camera} {_LETTERS[label]}", "zero")
            for label, channel in zip(data.labels, channels, strict=True)
        }
    return cameras


def _find(kind: str, name: str, known: Mapping[str, _T]) -> _T:
    if name not in known:
        raise UnknownNameError(kind, name, known)
    return known[name]


def _curve(data: Any, name: str, outside: Literal["zero", "hold"]) -> Curve:
    return Curve(tuple(data.wavelengths.tolist()), tuple(data.values.tolist()), name, outside)
