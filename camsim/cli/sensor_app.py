"""``camsim sensor``: sensor files from published measurements."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from camsim.cli.options import Force, Sensors

sensor_app = typer.Typer(no_args_is_help=True, help="Sensor files from measured sensitivities.")


@sensor_app.callback()
def _sensor() -> None:
    """Sensor files from measured sensitivities."""


@sensor_app.command("import")
def import_sensor(
    file: Annotated[
        str,
        typer.Argument(
            metavar="FILE",
            help="Sensitivities: rawtoaces .json, 28 cameras' .txt, ISETCam .mat, quantum efficiencies in .csv.",
        ),
    ],
    output: Annotated[str, typer.Option("-o", "--output", metavar="SENSOR.yaml", help="The sensor file to write.")],
    sensor: Annotated[str, typer.Option("--sensor", metavar="NAME", help="Whose other figures it has.")],
    camera: Annotated[str | None, typer.Option("--camera", metavar="NAME", help="Of a file with several.")] = None,
    sensors: Sensors = None,
    force: Force = False,
) -> None:
    """Write a sensor file with the measured sensitivities of a camera, and all else of another sensor."""
    from camsim.cli.new import check_yaml_output
    from camsim.cli.sensor_text import Base, efficiency_text, written
    from camsim.files.camera_curves import camera_of

    check_yaml_output(output, force=force)
    base = Base.of(sensor, sensors or ())
    found = camera_of(Path(file), camera)
    parts = {
        "name": f'name: "{found.name}"' if '"' not in found.name and "\\" not in found.name else "",
        "quantum_efficiency": efficiency_text(
            found.curves, per=found.per, peak=None if found.absolute else base.peak, source=found.source
        ),
        "colour_matrices": "",
    }
    if found.whole:
        parts["filters"] = ""
    made = written(output, base, parts)
    ends = [nm for curve in found.curves.values() for nm in (curve.wavelength_nm[0], curve.wavelength_nm[-1])]
    stated = f"{', '.join(found.curves)} per {found.per} from {min(ends):g} to {max(ends):g} nm"
    scale = (
        "absolute" if found.absolute else f"relative, {base.peak:g} electrons per photon at the highest, of {sensor}"
    )
    print(f"{output}: {found.name}: {stated}; {scale}")
    print(f"{output}: all else is of {made.rows} × {made.cols} photosites, {sensor}")
