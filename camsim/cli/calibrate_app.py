"""``camsim calibrate``: profiles of real cameras from their own frames."""

from __future__ import annotations

from typing import Annotated

import typer

from camsim.cli.calibrate_colour import calibrate_colour
from camsim.cli.options import AsJson, CfaOf, Force

calibrate_app = typer.Typer(no_args_is_help=True, help="Make a sensor file of your own camera from its frames.")


@calibrate_app.callback()
def _calibrate() -> None:
    """Make a sensor file of your own camera from its frames."""


calibrate_app.command("colour")(calibrate_colour)


@calibrate_app.command("noise")
def calibrate_noise(
    folder: Annotated[
        str,
        typer.Argument(
            metavar="FOLDER", help="Raw files: flats and darks of one camera, of any ISO settings and times."
        ),
    ],
    output: Annotated[
        str | None, typer.Option("-o", "--output", metavar="CAMERA.yaml", help="The sensor file to write.")
    ] = None,
    hot: Annotated[
        str | None,
        typer.Option("--hot", metavar="HOT.csv", help="List hot photosites by place here, not by their law in -o."),
    ] = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Show what each frame is taken for, and calibrate nothing.")
    ] = False,
    check: Annotated[
        str | None,
        typer.Option(
            "--check", metavar="CAMERA.yaml", help="Take the same frames with this sensor, and lay both side by side."
        ),
    ] = None,
    name: Annotated[str | None, typer.Option("--name", help="What the camera is called.")] = None,
    pitch_um: Annotated[
        float | None, typer.Option("--pitch-um", metavar="UM", help="Between photosites, where no file says it.")
    ] = None,
    cfa: CfaOf = None,
    window: Annotated[
        int, typer.Option("--window", metavar="N", help="Photosites along a side of the middle that is measured.")
    ] = 1024,
    seed: Annotated[int, typer.Option("--seed", metavar="N", help="Of the frames that --check takes.")] = 1,
    as_json: AsJson = False,
    plot: Annotated[
        str | None,
        typer.Option("--plot", metavar="FILE.png|svg", help="Draw fits, residuals, spectra, histograms (matplotlib)."),
    ] = None,
    force: Force = False,
) -> None:
    """Make a sensor file of flats and darks: gain, noise and patterns of your camera, each with its error."""
    from camsim.cli.calibrate_noise import CalibrationRequest, calibrate

    calibrate(
        CalibrationRequest(
            folder=folder, output=output, hot=hot, dry_run=dry_run, check=check, name=name, pitch_um=pitch_um, cfa=cfa,
            window=window, seed=seed, as_json=as_json, plot=plot, force=force,
        )
    )  # fmt: skip
