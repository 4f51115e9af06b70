"""Charts as tables of a scene file: every key is a parameter of the chart's function."""

import functools
import inspect
import operator
import types
from collections.abc import Callable
from typing import Annotated, Any, Literal, TypeAlias, Union, get_args, get_origin

from pydantic import Field, create_model

from camsim.config.schema.base import Point, Reflectance, Table, ToldBy
from camsim.core.typed import Point as ParameterPoint
from camsim.scene.charts import KNOWN, meanings, parameters
from camsim.spectra import curve

LENGTH = "_um"
"""How parameters end that a file gives in the scene's unit, without this."""


def key_of(parameter: str) -> str:
    """Return what a file calls a chart's parameter.

    >>> key_of("radius_um"), key_of("rim_lp_per_mm")
    ('radius', 'rim_lp_per_mm')
    """
    return parameter.removesuffix(LENGTH)


def _table(name: str, draw: Callable[..., Any]) -> type[Table]:
    defaults, meaning = inspect.signature(draw).parameters, meanings(draw)
    fields: dict[str, Any] = {
        "kind": (Literal["chart"], Field(description="which shape")),
        "name": (Literal[name], Field(description="which chart")),
    }
    for parameter, kind in parameters(draw).items():
        default = defaults[parameter].default
        said = meaning[parameter] + (", in the scene's unit" if parameter.endswith(LENGTH) else "")
        given = {} if default is inspect.Parameter.empty else {"default": default}
        fields[key_of(parameter)] = (_in_files(kind), Field(description=said, **given))
    title = "".join(word.capitalize() for word in name.split("-"))
    sentence = (inspect.getdoc(draw) or "").split("\n\n")[0]
    made: type[Table] = create_model(f"{title}Chart", __base__=Table, __doc__=sentence, **fields)
    return made


def _in_files(kind: Any) -> Any:
    """Return the type that a parameter has in files: lists for tuples, and reflectances by name too."""
    if kind == curve.Reflectance:
        return Reflectance
    if kind == ParameterPoint:
        return Point
    origin, members = get_origin(kind), get_args(kind)
    if origin is Annotated:
        bare, *limits = members
        return Annotated[_in_files(bare), *limits]
    if origin is tuple and members[-1:] == (...,):
        return list[_in_files(members[0])]  # type: ignore[misc]
    if origin in (Union, types.UnionType):
        # A reflectance is a union itself, of which None may have become a member.
        if set(get_args(curve.Reflectance)) < set(members):
            return Reflectance | None
        return functools.reduce(operator.or_, map(_in_files, members))
    return kind


def is_of_reflectances(kind: Any) -> bool:
    """Return whether a parameter is a reflectance, or a list of them."""
    return set(get_args(curve.Reflectance)) <= set(get_args(kind)) or any(map(is_of_reflectances, get_args(kind)))


CHART_TABLES: dict[str, type[Table]] = {name: _table(name, draw) for name, draw in KNOWN.items()}

Chart: TypeAlias = Annotated[  # type: ignore[valid-type]
    functools.reduce(operator.or_, CHART_TABLES.values()), ToldBy("name")
]
