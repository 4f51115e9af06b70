"""``camsim calibrate``: sensor files from a real camera's frames."""

from __future__ import annotations

import typer

from camsim.cli.calibrate_colour import calibrate_colour

calibrate_app = typer.Typer(no_args_is_help=True, help="A sensor file from a real camera's frames.")


@calibrate_app.callback()
def _calibrate() -> None:
    """A sensor file from a real camera's frames."""


calibrate_app.command("colour")(calibrate_colour)
