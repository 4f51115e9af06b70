"""Curve: a tabulated spectrum, and Spectrum: a curve or one number for every wavelength."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Literal, Protocol, Self, TypeAlias

import numpy as np
from annotated_types import Ge, Le

from camsim.core import notebook
from camsim.core.annotations import After, Called, Hinted
from camsim.core.arrays import F64
from camsim.core.typed import Count, Fraction, NonNegative, Number, Positive, Several, check, validate
from camsim.core.words import LIGHT_NM, brief, wavelength_hint
from camsim.errors import InvalidValueError

Wavelength: TypeAlias = Annotated[float, Ge(LIGHT_NM[0]), Le(LIGHT_NM[1]), Hinted(wavelength_hint)]
"""Nanometres."""


@dataclass(frozen=True, slots=True)
class Curve:
    """A curve through tabulated points, straight in between.

    wavelength_nm : (n,) strictly increasing, at least two
    values        : (n,) finite, not negative; the unit is the user's affair (a reflectance, W/m²/nm, …)
    name          : name of the curve in reports; two curves that differ in name only are not equal
    outside       : beyond the table: "zero", or "hold" to keep the first and the last value. None goes by what the
                    curve is of: reflectances and transmissions of a lens are held, lights are dark, and filters and
                    quantum efficiencies must say it when light lies there

    >>> red = Curve((600.0, 700.0), (0.1, 0.8), outside="hold")
    >>> red.at(np.array([500.0, 650.0, 900.0]))
    array([0.1 , 0.45, 0.8 ])
    """

    wavelength_nm: Several[Positive]
    values: Several[NonNegative]
    name: str = ""
    outside: Literal["zero", "hold"] | None = None

    if TYPE_CHECKING:

        def __init__(
            self,
            wavelength_nm: Several[Number],
            values: Several[Number],
            name: str = "",
            outside: Literal["zero", "hold"] | None = None,
        ) -> None: ...

    __repr__ = brief

    def __post_init__(self) -> None:
        validate(self)
        what = f"Curve {self.name!r}" if self.name else "Curve"
        if len(self.wavelength_nm) != len(self.values):
            raise InvalidValueError(
                f"{len(self.values)} for {len(self.wavelength_nm)} wavelengths; every point has one of each",
                key="values",
                stage=what,
            )
        if len(self.values) < 2:
            raise InvalidValueError(
                "a curve needs at least 2 points; write a number for a flat one", key="values", stage=what
            )
        for before, after in pairwise(self.wavelength_nm):
            if after <= before:
                raise InvalidValueError(
                    f"{after:g} nm follows {before:g} nm; wavelengths must increase, each given once",
                    key="wavelength_nm",
                    stage=what,
                )
        if self.wavelength_nm[-1] < LIGHT_NM[0]:
            raise InvalidValueError(ends_where_no_light_is(self.wavelength_nm[-1]), key="wavelength_nm", stage=what)

    def _repr_html_(self) -> str:
        points = f"{len(self.values)} from {self.wavelength_nm[0]:g} to {self.wavelength_nm[-1]:g} nm"
        highest = max(self.values)
        peak = f"{highest:.4g} at {self.wavelength_nm[int(np.argmax(self.values))]:g} nm"
        beyond = {"zero": "0", "hold": "as at the ends", None: "goes by what it is of"}[self.outside]
        rows = [("points", points), ("highest", peak), ("beyond", beyond)]
        return notebook.table(rows, self.name or "Curve") + notebook.line(self.wavelength_nm, self.values)

    @classmethod
    def from_csv(
        cls,
        path: str | os.PathLike[str],
        *,
        column: str | int | None = None,
        outside: Literal["zero", "hold"] | None = None,
        name: str = "",
    ) -> Self:
        """Return the curve of a column of a CSV file.

        column : name in the header, or number (the file's first column is 1); not needed if there are two columns

        Cells are separated by semicolons, tabs, commas or spaces; the header may name nm, µm or Å and %; what else may
        stand in a file is said in docs/curves.md. What cannot be read is refused in one sentence with its line.
        """
        check(path, str | os.PathLike, "path", "Curve.from_csv")
        chosen = check(column, Count | str | None, "column", "Curve.from_csv")
        from camsim.spectra.csv_table import read_points  # imported here, as few curves are read

        wavelength_nm, values = read_points(path, chosen)
        return cls(wavelength_nm, values, name, outside)

    def at(self, wavelength_nm: F64) -> F64:
        """Return the values at ``wavelength_nm`` (any shape)."""
        beyond = None if self.outside == "hold" else 0.0
        values: F64 = np.interp(wavelength_nm, self.wavelength_nm, self.values, left=beyond, right=beyond)
        return values

    def going_on(self, outside: Literal["zero", "hold"]) -> Curve:
        """Return the curve with ``outside`` set to this; the curve itself if its ``outside`` is already set."""
        return self if self.outside is not None else dataclasses.replace(self, outside=outside)


Spectrum: TypeAlias = float | Curve

NumberOrCurve: TypeAlias = Number | Curve
"""Type accepted by constructors."""


def ends_where_no_light_is(last_nm: float) -> str:
    """Return the fault of a table whose last wavelength is too short for light: most likely its unit is not nm."""
    return f"ends at {last_nm:g} nm, where there is no light; give nm{wavelength_hint(last_nm)}"


def check_wavelengths(each_nm: Iterable[float], key: str) -> None:
    """Raise InvalidValueError for the first number that is not a wavelength of light in nm."""
    for nm in each_nm:
        if not LIGHT_NM[0] <= nm <= LIGHT_NM[1]:
            usual = f"give nm, {LIGHT_NM[0]:g} … {LIGHT_NM[1]:g}"
            raise InvalidValueError(f"{nm:g} is not a wavelength of light; {usual}{wavelength_hint(nm)}", key=key)


def _of_fractions(curve: Curve) -> Curve:
    """Raise for a curve above 1, which would create light."""
    highest = max(curve.values)
    if highest > 1.0:
        where = curve.wavelength_nm[int(np.argmax(curve.values))]
        raise InvalidValueError(f"the curve is {highest:g} at {where:g} nm; must be fractions from 0 to 1")
    return curve


def _held(curve: Curve) -> Curve:
    return curve.going_on("hold")


Filter: TypeAlias = Fraction | Annotated[Curve, After(_of_fractions)]
"""Transmission of a filter."""

Transmission: TypeAlias = Fraction | Annotated[Curve, After(_of_fractions), After(_held)]
"""Transmission of a lens; constant outside its table."""

Reflectance: TypeAlias = (
    Fraction | Annotated[Curve, After(_of_fractions), After(_held), Called("a Curve", "reflectance('orange') is one")]
)
"""Reflectance of a surface; constant outside its table."""


class Tabulated(Protocol):
    """Protocol of objects with values over wavelength."""

    def at(self, wavelength_nm: F64) -> F64:
        """Return the values at ``wavelength_nm`` (any shape)."""
        ...


def spectrum_at(spectrum: float | Tabulated, wavelength_nm: F64) -> F64:
    """Return a spectrum's values at ``wavelength_nm``; a number is constant.

    >>> spectrum_at(0.18, np.array([450.0, 550.0]))
    array([0.18, 0.18])
    """
    if isinstance(spectrum, float | int):
        return np.full(np.shape(wavelength_nm), float(spectrum))
    return spectrum.at(wavelength_nm)
