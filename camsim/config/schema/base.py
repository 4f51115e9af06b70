"""What all tables of the schema share."""

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, TypeAlias, get_args

from pydantic import BaseModel, ConfigDict, Discriminator, Field, GetJsonSchemaHandler, Tag
from pydantic.fields import FieldInfo
from pydantic_core import core_schema

from camsim.core.annotations import Called
from camsim.core.typed import Count, Fraction, NonNegative, Positive


class Table(BaseModel):
    """A YAML table: every key is known, every value has its own type, none is NaN or infinite.

    A table as the default of a key is made by ``model_construct``, which builds no validator on import. Annotations are
    not deferred in the schema (``from __future__``): pydantic would compile each of them again.
    """

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)

    source: str | None = Field(default=None, description="where the numbers come from, for people to read")

    alternatives: ClassVar[tuple[tuple[str, ...], ...]] = ()
    """Keys of which one is given: ``--set`` of one takes those away that a file has."""

    @classmethod
    def contradictions(cls, table: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
        """Yield (key, message) for keys that do not go together; types and ranges need not be right yet."""
        yield from ()

    @classmethod
    def fields(cls) -> Mapping[str, FieldInfo]:
        """Return the definition of each key, even if its type is defined later in the module, as groups hold groups.

        Such a table is built here, not on import, which would take longer than reading a capture.
        """
        if not cls.__pydantic_fields_complete__:
            cls.model_rebuild()
        return cls.model_fields

    @classmethod
    def can_contradict(cls) -> bool:
        """Whether the table, or a base of it, has rules on keys that do not go together."""
        return any("contradictions" in vars(table) for table in cls.mro() if table is not Table)


@dataclass(frozen=True, slots=True)
class Makes:
    """The stage of the camera that a key makes: ``make`` is called with its value (never None) and those of ``also``.

    field : the camera's
    also  : other keys of the same table
    reads : keys to the name of another file, from the value: ``make`` is given its path as well, None
            without a name
    """

    field: str
    make: Callable[..., Any]
    also: tuple[str, ...] = ()
    reads: tuple[str, ...] | None = None


@dataclass(frozen=True, slots=True)
class ToldBy:
    """Annotation of a union of tables of which a key tells which one a value is.

    The validator of a table is built when a file first has one: to build those of all shapes takes longer than to read
    a scene.
    """

    key: str

    def __get_pydantic_core_schema__(self, union: Any, _: Any) -> core_schema.CoreSchema:
        """Return the schema of a value that is one of the tables."""
        choices: dict[Any, core_schema.CoreSchema] = {}
        for member in get_args(union):
            if among := get_args(member):  # charts, of one kind, are told apart by name
                tables, by_name = among
                first, schema = get_args(tables)[0], by_name.__get_pydantic_core_schema__(tables, _)
            else:
                first, schema = member, _when_needed(member)
            choices |= dict.fromkeys(get_args(first.model_fields[self.key].annotation), schema)
        return core_schema.tagged_union_schema(choices, self.key)

    def __get_pydantic_json_schema__(self, schema: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Return the JSON Schema, which has each table whole, but those of which this is a part."""
        tables = set(_tables(schema)) - _STATED
        _STATED.update(tables)
        try:
            return handler(_whole(schema, tables))
        finally:
            _STATED.difference_update(tables)


_STATED: set[type[Table]] = set()


def _when_needed(table: type[Table]) -> core_schema.CoreSchema:
    # Values are lists for tuples, which strict pydantic accepts in JSON only.
    return core_schema.no_info_plain_validator_function(
        lambda value: table.model_validate_json(json.dumps(value)), metadata={"table": table}
    )


def _tables(schema: Any) -> Iterator[type[Table]]:
    for choice in schema["choices"].values():
        if "choices" in choice:
            yield from _tables(choice)
        else:
            yield choice["metadata"]["table"]


def _whole(schema: Any, tables: set[type[Table]]) -> Any:
    if "choices" in schema:
        return schema | {"choices": {tag: _whole(choice, tables) for tag, choice in schema["choices"].items()}}
    table = schema["metadata"]["table"]
    table.model_rebuild()
    whole = table.__pydantic_core_schema__
    inner = whole["schema"] if whole["type"] == "definitions" else whole
    return whole if table in tables else core_schema.definition_reference_schema(inner["ref"])


def _form(value: Any) -> str:
    """Select one alternative of a value by its form, so that only this one reports faults."""
    if isinstance(value, Mapping | BaseModel):
        return "table"
    if isinstance(value, list | tuple):
        return "list"
    return "word" if isinstance(value, str) else "number"


by_form = Discriminator(_form)

Letter: TypeAlias = Annotated[str, Field(pattern="^[A-Za-z]$", description="a channel, one letter")]


Name: TypeAlias = Annotated[str, Field(min_length=1), Called("a name")]
Column: TypeAlias = Annotated[Annotated[Name, Tag("word")] | Annotated[Count, Tag("number")], by_form]

LISTS = ("wavelength_nm", "values")
"""The points of a curve."""


def _of_numbers_or_a_file(schema: dict[str, Any]) -> None:
    """Add to the JSON Schema that a file stands for both lists."""
    schema["required"] = [key for key in schema["required"] if key not in LISTS]
    schema["anyOf"] = [{"required": list(LISTS)}, {"required": ["csv"]}]


class Tabulated(Table):
    """A curve by its points, given directly or in a CSV file."""

    model_config = ConfigDict(json_schema_extra=_of_numbers_or_a_file)

    wavelength_nm: list[Positive] = Field(min_length=2, description="increasing, nm")
    values: list[NonNegative] = Field(min_length=2, description="one for each wavelength")
    csv: Name | None = Field(default=None, description="instead of both: a CSV file in this file's folder")
    column: Column | None = Field(
        default=None, description="its name or number there; not needed where the file has two columns"
    )


class Curve(Tabulated):
    """A tabulated spectrum, straight between its points."""

    outside: Literal["zero", "hold"] | None = Field(
        default=None,
        description="beyond the table: 0, or the value at its nearer end; must be said when light lies there, else 0",
    )


class Fractions(Tabulated):
    """A tabulated fraction (reflectance, transmission), straight between its points."""

    values: list[Fraction] = Field(min_length=2, description="fractions, one for each wavelength")
    outside: Literal["zero", "hold"] = Field(
        default="hold", description="beyond the table: 0, or the value at its nearer end"
    )


class FilterCurve(Tabulated):
    """The fraction that a filter lets through, straight between its points."""

    values: list[Fraction] = Field(min_length=2, description="fractions, one for each wavelength")
    outside: Literal["zero", "hold"] | None = Field(
        default=None,
        description="beyond the table: 0, or the value at its nearer end; must be said when light lies there, else 0",
    )


class LightTable(Tabulated):
    """A tabulated spectrum of a light, straight between its points and dark beyond them."""

    values: list[NonNegative] = Field(min_length=2, description="relative power per nm, one for each wavelength")


Point: TypeAlias = Annotated[tuple[float, float], Called("a point [x, y]")]
Reflectance: TypeAlias = Annotated[
    Annotated[Fraction, Tag("number")] | Annotated[Name, Tag("word")] | Annotated[Fractions, Tag("table")],
    by_form,
]
Transmission: TypeAlias = Annotated[Annotated[Fraction, Tag("number")] | Annotated[Fractions, Tag("table")], by_form]
Filter: TypeAlias = Annotated[Annotated[Fraction, Tag("number")] | Annotated[FilterCurve, Tag("table")], by_form]
