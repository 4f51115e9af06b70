"""Options shared by several commands."""

from __future__ import annotations

import difflib
from typing import Annotated, Any, TypeAlias

import typer

SensorName: TypeAlias = Annotated[
    str | None, typer.Option("--sensor", metavar="NAME", help="A sensor (name or file) instead of the scene's.")
]
Sensors: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--sensors",
        metavar="DIR",
        help="A folder to look for sensors in by name, before those of CAMSIM_PATH and beside the scene; repeatable.",
    ),
]
Changes: TypeAlias = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change one value, such as exposure.iso=800; repeatable."),
]
Workers: TypeAlias = Annotated[
    int | None,
    typer.Option("--workers", metavar="N", min=0, help="Processes of one core each; 0: this one, with all cores."),
]
Scheduler: TypeAlias = Annotated[
    str | None,
    typer.Option("--scheduler", metavar="tcp://…", help="A dask scheduler whose workers see the same folder."),
]

AsJson: TypeAlias = Annotated[bool, typer.Option("--json", help="Print everything as JSON on stdout.")]
Force: TypeAlias = Annotated[bool, typer.Option("--force", help="Overwrite files that exist.")]
Quiet: TypeAlias = Annotated[bool, typer.Option("-q", "--quiet", help="Print errors only.")]
AllowOddCfa: TypeAlias = Annotated[
    bool, typer.Option("--allow-odd-cfa", help="Write a DNG even of a filter array that raw developers misread.")
]
Compress: TypeAlias = Annotated[
    bool, typer.Option("--compress", help="Write DNGs as lossless JPEG, about half the size (package imagecodecs).")
]
CfaOf: TypeAlias = Annotated[
    str | None,
    typer.Option("--cfa", metavar="RGGB", help="The filter array of files that do not say it; mono for none."),
]
LightName: TypeAlias = Annotated[
    str,
    typer.Option(
        "--light", metavar="NAME|FILE.csv", help="Light on the chart: an illuminant, or its measured power over nm."
    ),
]
Corners: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--corners",
        metavar="R,C,R,C,R,C,R,C",
        help="Row and column of the middles of the patches dark skin, bluish green, black and white; left out: found.",
    ),
]
ChartName: TypeAlias = Annotated[
    str,
    typer.Option(
        "--chart", metavar="NAME", help="Measured reflectances of the patches: ISO 17321-1 or BabelColor Average."
    ),
]

_ALIKE = 0.85
"""Similarity above which an unknown option is a typo; below, it may be a setting."""


def say_how_to_set(error: Any) -> None:
    """If an unknown option has the name of a YAML key, add to the error's message how to set that key."""
    option, context = str(error.option_name), error.ctx
    possible = error.possibilities or ()
    alike = difflib.get_close_matches(option, possible, n=1, cutoff=_ALIKE)
    begun = any(known.startswith(option) for known in possible)
    if alike or begun or context is None or not any(given.name == "changes" for given in context.command.params):
        return
    from camsim.config.near import place_of

    if place := place_of(option.lstrip("-").partition("=")[0]):
        error.message, error.possibilities = f"No such option: {option}; write --set {place}=VALUE", None
