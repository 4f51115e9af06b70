"""``camsim calibrate colour``: colours of a sensor file from a photograph of a chart."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from camsim.cli.options import AsJson, CfaOf, ChartName, Corners, Force, LightName, Sensors

if TYPE_CHECKING:
    from camsim.cli.sensor_text import Base
    from camsim.measure import Picture
    from camsim.measure.colour import ColourCalibration


def calibrate_colour(
    chart: Annotated[
        str, typer.Argument(metavar="CHART", help="A raw file of a ColorChecker: a maker's, DNG, NPY, TIFF …")
    ],
    light: LightName,
    output: Annotated[str, typer.Option("-o", "--output", metavar="SENSOR.yaml", help="The sensor file to write.")],
    sensor: Annotated[
        str | None,
        typer.Option("--sensor", metavar="NAME", help="Whose other figures it has; left out: the raw file's, typical."),
    ] = None,
    sensors: Sensors = None,
    corners: Corners = None,
    reflectances: ChartName = "ISO 17321-1",
    cameras: Annotated[
        list[str] | None,
        typer.Option(
            "--cameras",
            metavar="FILE",
            help="Measured cameras (as of camsim sensor import) among which the nearest is looked for; repeatable.",
        ),
    ] = None,
    pitch_um: Annotated[
        float | None, typer.Option("--pitch", metavar="UM", min=0.1, max=100.0, help="Of photosites, without --sensor.")
    ] = None,
    cfa: CfaOf = None,
    as_json: AsJson = False,
    force: Force = False,
) -> None:
    """Measure colour matrix, white balance and sensitivities of a camera from a ColorChecker; write a sensor file."""
    from camsim.cli.measure_colour import corners_of, light_of
    from camsim.cli.new import check_yaml_output
    from camsim.cli.sensor_text import Base, efficiency_text, matrices_text, written
    from camsim.errors import InvalidValueError
    from camsim.files.camera_curves import read_cameras
    from camsim.measure import read_picture
    from camsim.measure.colour import calibrate_colour as calibrated

    check_yaml_output(output, force=force)
    if sensor is not None and pitch_um is not None:
        raise InvalidValueError("is the sensor's; leave it out with --sensor", key="--pitch")
    base = None if sensor is None else Base.of(sensor, sensors or ())
    known = [camera for file in cameras or () for camera in read_cameras(Path(file))]
    picture = read_picture(chart, cfa=cfa)
    found = calibrated(picture, light_of(light), corners=corners_of(corners), chart=reflectances, cameras=known)
    base = base or _skeleton(picture, pitch_um)
    others = [matrix for matrix in base.matrices if matrix.light != found.matrix.light]
    curves, per = found.nearest.curves, found.nearest.per
    if found.measured:
        curves, per = found.smooth.curves, "energy"
        source = f"smooth curves from the chart {found.file} under {found.light}"
    else:
        source = f"of {found.nearest.name}, each channel scaled to the white of the chart {found.file}"
    comments = {found.light: _comments(found)}
    written(
        output,
        base,
        {
            "quantum_efficiency": efficiency_text(
                curves, per=per, peak=base.peak, source=source, comment=[found.sensitivities]
            ),
            "colour_matrices": matrices_text([*others, found.matrix], comments),
            # The photograph was taken through them, so the curves include them.
            "filters": "",
        },
    )
    if as_json:
        print(json.dumps({**found.as_dict(), "output": output}, indent=2, ensure_ascii=False))
        return
    _print(found)
    if base.camera is not None and base.camera.crosstalk is not None:
        print("note: the chart's colours hold the sensor's crosstalk, and charge.crosstalk acts once more")
    print(f"{output}: camsim capture SCENE --sensor {output} uses it, camsim validate {output} checks it")


def _comments(found: ColourCalibration) -> list[str]:
    mean = found.as_dict()["delta_e_2000_mean"]
    sigma = ", ".join("[" + ", ".join(f"{value:.2g}" for value in row) + "]" for row in found.sigma)
    lines = [
        f"from {found.file}, {found.chart}: ΔE2000 in the mean {mean['after']:.2f}, of patches left out of the fit "
        f"{mean['left_out']:.2f}"
        + ("" if mean["before"] is None else f"; by the file's own matrix {mean['before']:.2f}")
    ]
    return [*lines, f"standard errors of camera_to_xyz: {sigma}"]


def _print(found: ColourCalibration) -> None:
    from camsim.cli.tables import print_table

    before = found.delta_e_before
    rows = [
        (
            name,
            "" if before is None else _number(before[k]),
            _number(found.delta_e_after[k]),
            _number(found.delta_e_left_out[k]),
        )
        for k, name in enumerate(found.patches)
    ]
    print_table(
        f"{found.file}: ΔE2000 under {found.light}, {found.chart}",
        ("patch", "before (the file's matrix)", "after", "left out of the fit"),
        rows,
    )
    mean = found.as_dict()["delta_e_2000_mean"]
    first = "the file states no matrix" if mean["before"] is None else f"before {mean['before']:.2f}"
    print(f"mean: {first}, after {mean['after']:.2f}, left out of the fit {mean['left_out']:.2f}")
    red, _, blue = found.white_balance
    print(f"white balance: R/G {red:.4f}, B/G {blue:.4f} of a perfect diffuser")
    for row, sigma in zip(found.matrix.camera_to_xyz, found.sigma, strict=True):
        print("  " + "  ".join(f"{value:9.5f} ± {off:.5f}" for value, off in zip(row, sigma, strict=True)))
    print(f"sensitivities: {found.sensitivities}")
    for name in found.clipped:
        print(f"left out: {name}: clipped; expose less")


def _number(value: float) -> str:
    return f"{value:.2f}" if value == value else ""


def _skeleton(picture: Picture, pitch_um: float | None) -> Base:
    """Return a sensor from the metadata of a raw file."""
    from camsim.cli.sensor_text import Base, skeleton
    from camsim.errors import InvalidValueError

    planes = picture.planes
    step = max(planes, key=lambda plane: plane.step).step
    letters = {plane.first: plane.name[0] for plane in planes}
    white = [plane.white for plane in planes if plane.white is not None]
    if len({plane.step for plane in planes}) > 1 or len(letters) != step[0] * step[1] or not white:
        message = f"{picture.name} is no mosaic of codes; give the sensor whose other figures the file is to have"
        raise InvalidValueError(message, key="--sensor")
    pattern = ["".join(letters[row, col] for col in range(step[1])) for row in range(step[0])]
    noted = picture.noted
    return Base(
        text=skeleton(
            name=(noted.camera if noted is not None else "") or Path(picture.name).stem,
            rows=picture.shape[0],
            cols=picture.shape[1],
            pitch_um=picture.pitch_um if pitch_um is None else pitch_um,
            pattern=pattern,
            black=sum(plane.black for plane in planes) / len(planes),
            white=min(white),
            iso=None if noted is None else noted.iso,
        )
    )
