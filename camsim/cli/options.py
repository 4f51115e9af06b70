"""Options that several commands have."""

from __future__ import annotations

from typing import Annotated, TypeAlias

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
