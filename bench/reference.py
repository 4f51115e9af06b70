"""The pages of docs/reference from the code, for readers on the web and on disk: ``python -m bench.reference``.

Each name of Python gets its signature, its methods and its first sentence; each command all of its options,
those of many commands told once. The site shows the whole documentation of a name below that, where the pages name it.
"""

from __future__ import annotations

import enum
import inspect
import operator
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer

import camsim
from camsim.cli.app import app
from camsim.optics import protocols
from camsim.scene.gradients import Gradient
from camsim.scene.primitives import Paints
from camsim.scene.raster import Field

PAGES = sorted((Path(__file__).parents[1] / "docs" / "reference").glob("*.md"))
_NAMED = re.compile(r"^\.\. auto\w+:: camsim\.([\w.]+)$", re.MULTILINE)
_PLACE = re.compile(r"(?<=<!-- names -->\n).*?(?=<!-- /names -->)", re.DOTALL)
_LONGEST_DEFAULT = 24  # characters
_LONG = re.compile(r"--[\w-]+")
_COMMON = 2  # commands with an option of the same words, which is then told once
_BASES = [kind for kind in vars(protocols).values() if inspect.isclass(kind)]
_BASES += [camsim.ElectronicStage, Paints, Field, Gradient]
_OF_BASES = {key for kind in _BASES for key in vars(kind)}  # told once, of the base or protocol


def written(page: str) -> str:
    """Return a page with its names as the code has them; a page without a place for them as it is."""
    named = _NAMED.findall(page)
    lines = ["| name | |", "|---|---|", *map(_of_python, named)] if named else [*_of_commands()]
    return _PLACE.sub(lambda _: "\n".join(lines) + "\n", page)


def _of_python(name: str) -> str:
    value = operator.attrgetter(name)(camsim)
    methods = [f"`{key}{_signature(member)}`" for key, member in _methods(value)] if inspect.isclass(value) else []
    also = f" Methods: {', '.join(methods)}." if methods else ""
    return f"| `camsim.{name}{_signature(value)}` | {_first(inspect.getdoc(value) or '')}{_cell(also)} |"


def _methods(value: type) -> Iterator[tuple[str, Any]]:
    for key, member in vars(value).items():
        function = member.__func__ if isinstance(member, classmethod | staticmethod) else member
        of_base = key in _OF_BASES and value not in _BASES
        if not key.startswith("_") and inspect.isfunction(function) and not of_base:
            yield key, function


def _signature(value: Any) -> str:
    """Return what a call takes, without types: names end in their units.

    >>> _signature(camsim.Airy)
    '(*, f_number, transmission=1.0)'
    """
    if inspect.isclass(value) and (issubclass(value, enum.Enum) or getattr(value, "_is_protocol", False)):
        return ""
    words, star = [], False
    for parameter in inspect.signature(value).parameters.values():
        if parameter.name in ("self", "cls"):
            continue
        if parameter.kind is parameter.KEYWORD_ONLY and not star:
            star = True
            words.append("*")
        default = "" if parameter.default is parameter.empty else repr(parameter.default)
        default = default if len(default) <= _LONGEST_DEFAULT and "<" not in default else "…"
        mark = {parameter.VAR_POSITIONAL: "*", parameter.VAR_KEYWORD: "**"}.get(parameter.kind, "")
        words.append(f"{mark}{parameter.name}{default and '='}{default}")
    return f"({', '.join(words)})"


def _of_commands() -> Iterator[str]:
    options: dict[tuple[str, ...], list[str]] = {}
    helps: dict[tuple[str, ...], str] = {}
    for path, command in _commands(typer.main.get_command(app), ("camsim",)):
        context = command.make_context(" ".join(path), [], resilient_parsing=True)
        options[path] = [_option(option) for option in command.get_params(context) if "--help" not in option.opts]
        helps[path] = (command.help or "").replace("\b", "").strip()
    counts = Counter(line for lines in options.values() for line in lines)
    common = [line for line, count in counts.most_common() if count >= _COMMON and line.startswith("| `-")]
    yield from ("## Options of many commands", "", "| option | meaning |", "|---|---|", *common, "")
    for path, lines in options.items():
        also = ", ".join(f"`{_LONG.findall(line)[0]}`" for line in lines if line in common)
        one = [line for line in lines if line not in common]
        yield from (f"## {' '.join(path)}", "", helps[path], "", "| option | meaning |", "|---|---|", *one, "")
        yield from (f"Also {also}.", "") if also else ()


def _commands(command: Any, path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Any]]:
    for name, inside in getattr(command, "commands", {}).items():
        yield from _commands(inside, (*path, name))
    if not hasattr(command, "commands"):
        yield path, command


def _option(option: Any) -> str:
    is_argument = option.param_type_name == "argument"
    value = option.metavar or option.type_descriptor.annotation.__name__
    takes = "" if is_argument or getattr(option, "is_flag", False) else f" {value}"
    argument = value if option.required else f"[{value}]"
    names = argument if is_argument else ", ".join(option.opts) + takes
    default = option.default
    displayed = (
        "" if default in (None, False, (), []) or callable(default) or option.required else f" Default: {default}."
    )
    return f"| `{_cell(names)}` | {_cell(option.help or '')}{_cell(displayed)} |"


def _first(stated: str) -> str:
    """Return the first paragraph of a docstring as a cell of a table.

    >>> _first("Return ``a | b``\\n  or c.\\n\\nMore.")
    'Return `a \\\\| b` or c.'
    """
    return _cell(" ".join(stated.partition("\n\n")[0].split()).replace("``", "`"))


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


if __name__ == "__main__":
    for path in PAGES:
        path.write_text(written(path.read_text(encoding="utf-8")), encoding="utf-8")
