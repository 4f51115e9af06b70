"""``{commands}`` is the reference of the command line, from the Typer application itself."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import typer
from docutils import nodes
from sphinx.util.docutils import SphinxDirective


def commands(command: Any, path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield every command with its path, groups before what is in them."""
    yield path, command
    for name, inside in getattr(command, "commands", {}).items():
        yield from commands(inside, (*path, name))


def markdown() -> Iterator[str]:
    """Yield the reference, line by line."""
    from camsim.cli.app import app

    for path, command in commands(typer.main.get_command(app), ("camsim",)):
        if hasattr(command, "commands"):
            continue
        context = command.make_context(" ".join(path), [], resilient_parsing=True)
        yield from (f"## {' '.join(path)}", "", (command.help or "").replace("\b", ""), "", "```text")
        yield from (" ".join([*path, *command.collect_usage_pieces(context)]), "```", "")
        yield from ("| option | value | meaning |", "|---|---|---|")
        for option in command.get_params(context):
            yield _row(option)
        yield ""


def _row(option: Any) -> str:
    is_argument = option.param_type_name == "argument"
    value = option.metavar or option.type_descriptor.annotation.__name__
    names = value if is_argument else ", ".join(option.opts)
    takes = "" if is_argument or getattr(option, "is_flag", False) else f"`{value}`"
    default = option.default
    shown = "" if default in (None, False, (), []) or callable(default) or option.required else f" Default: {default}."
    needed = " Required." if option.required else ""
    cells = [f"`{names}`", takes, f"{option.help or ''}{shown}{needed}"]
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


class Commands(SphinxDirective):
    """The reference as if it stood on the page."""

    def run(self) -> list[nodes.Node]:
        return self.parse_text_to_nodes("\n".join(markdown()), allow_section_headings=True)


def setup(app: Any) -> dict[str, bool]:
    app.add_directive("commands", Commands)
    return {"parallel_read_safe": True}
