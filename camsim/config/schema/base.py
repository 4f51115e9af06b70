"""What all tables of the schema share."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag

from camsim.marks import Called
from camsim.typed import Fraction, NonNegative, Positive


class Table(BaseModel):
    """A YAML table: every key is known, every value has its own type, none is NaN or infinite."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)

    source: str | None = Field(default=None, description="where the numbers come from, for people to read")

    @classmethod
    def contradictions(cls, table: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
        """Yield (key, message) for keys that do not go together; types and ranges need not be right yet."""
        yield from ()


@dataclass(frozen=True, slots=True)
class Makes:
    """Which stage of the camera a key makes: ``make`` of its value (never None) and of the values of ``also``.

    field : the camera's
    also  : other keys of the same table
    """

    field: str
    make: Callable[..., Any]
    also: tuple[str, ...] = ()


def _form(value: Any) -> str:
    """Tell the alternatives of a value apart by what it looks like, so that only one of them complains."""
    if isinstance(value, Mapping | BaseModel):
        return "table"
    if isinstance(value, list | tuple):
        return "list"
    return "word" if isinstance(value, str) else "number"


by_form = Discriminator(_form)

Letter: TypeAlias = Annotated[str, Field(pattern="^[A-Za-z]$", description="a channel, one letter")]


class Curve(Table):
    """A tabulated spectrum, straight between its points."""

    wavelength_nm: list[Positive] = Field(min_length=2, description="increasing, nm")
    values: list[NonNegative] = Field(min_length=2, description="one for each wavelength")
    outside: Literal["zero", "hold"] | None = Field(
        default=None,
        description="beyond the table: 0, or the value at its nearer end; must be said when light lies there, else 0",
    )


class Fractions(Table):
    """A tabulated fraction (reflectance, transmission), straight between its points."""

    wavelength_nm: list[Positive] = Field(min_length=2, description="increasing, nm")
    values: list[Fraction] = Field(min_length=2, description="fractions, one for each wavelength")
    outside: Literal["zero", "hold"] = Field(
        default="hold", description="beyond the table: 0, or the value at its nearer end"
    )


class FilterCurve(Table):
    """The fraction that a filter lets through, straight between its points."""

    wavelength_nm: list[Positive] = Field(min_length=2, description="increasing, nm")
    values: list[Fraction] = Field(min_length=2, description="fractions, one for each wavelength")
    outside: Literal["zero", "hold"] | None = Field(
        default=None,
        description="beyond the table: 0, or the value at its nearer end; must be said when light lies there, else 0",
    )


class LightTable(Table):
    """A tabulated spectrum of a light, straight between its points and dark beyond them."""

    wavelength_nm: list[Positive] = Field(min_length=2, description="increasing, nm")
    values: list[NonNegative] = Field(min_length=2, description="relative power per nm, one for each wavelength")


Point: TypeAlias = Annotated[tuple[float, float], Called("a point [x, y]")]
Name: TypeAlias = Annotated[str, Field(min_length=1), Called("a name")]
Reflectance: TypeAlias = Annotated[
    Annotated[Fraction, Tag("number")] | Annotated[Name, Tag("word")] | Annotated[Fractions, Tag("table")],
    by_form,
]
Transmission: TypeAlias = Annotated[Annotated[Fraction, Tag("number")] | Annotated[Fractions, Tag("table")], by_form]
Filter: TypeAlias = Annotated[Annotated[Fraction, Tag("number")] | Annotated[FilterCurve, Tag("table")], by_form]
