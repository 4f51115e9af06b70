"""``camsim expose``: given light (an array, a render or a photograph) through a sensor into raw files."""

from __future__ import annotations

import dataclasses
import json
import os
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

import typer

from camsim.cli.options import AllowOddCfa, Changes, Compress, Force, Quiet, Sensors
from camsim.core.garbage import look_in_new
from camsim.errors import CamsimError, InputError, InvalidValueError

if TYPE_CHECKING:
    from camsim.camera.frame import Frame, Product
    from camsim.camera.sensor import Sensor
    from camsim.cli.outputs import Output
    from camsim.sensor.exposure import Exposure

_MOST_FAULTS = 8


def expose(
    light: Annotated[
        str,
        typer.Argument(metavar="LIGHT", help="NPY, NPZ, EXR, TIFF, PNG, JPEG, ENVI, MATLAB, or a folder of them."),
    ],
    sensor: Annotated[str, typer.Option("--sensor", metavar="NAME", help="A sensor, by its name or file.")],
    sensors: Sensors = None,
    changes: Changes = None,
    unit: Annotated[
        str | None,
        typer.Option(
            "--as",
            metavar="UNIT",
            help="Of its numbers: electrons, photons, irradiance, reflectance or srgb; left out: as the file says.",
        ),
    ] = None,
    outputs: Annotated[
        list[str] | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE[:PRODUCT]",
            help="A file to write; the suffix chooses its format. Repeatable; LIGHT.dng when left out. Of a folder "
            "each light's name goes before the suffix: FILE-NAME.dng.",
        ),
    ] = None,
    iso: Annotated[float | None, typer.Option("--iso", metavar="N", help="The base ISO when left out.")] = None,
    time_s: Annotated[
        str | None,
        typer.Option(
            "--time",
            metavar="SECONDS|auto",
            help="auto puts a reflectance of 1 at 80 % of white, and is meant when left out; of other units 0.01.",
        ),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", metavar="N", min=0, help="Seed of the noise.")] = 0,
    wavelengths: Annotated[
        str | None, typer.Option("--wavelengths", metavar="A,B,…|FIRST:LAST:STEP", help="Of the planes, nm.")
    ] = None,
    illuminant: Annotated[
        str, typer.Option("--light", metavar="NAME", help="What lights a reflectance: an illuminant.")
    ] = "D65",
    lux: Annotated[float, typer.Option("--lux", metavar="LUX", help="On the sensor, from a reflectance of 1.")] = 10.0,
    per_photosite: Annotated[
        int, typer.Option("--per-photosite", metavar="K", min=1, help="Samples along the side of a photosite.")
    ] = 1,
    layer: Annotated[
        str | None, typer.Option("--layer", metavar="NAME", help="Of an EXR of several; an array of NPZ or MATLAB.")
    ] = None,
    no_noise: Annotated[bool, typer.Option("--no-noise", help="Without any noise, and without dark current.")] = False,
    allow_odd_cfa: AllowOddCfa = False,
    compress: Compress = False,
    force: Force = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON; of a folder a list.")] = False,
    quiet: Quiet = False,
) -> None:
    """Expose a sensor to your light: no lens, no scene, nothing resampled."""
    began_s = time.perf_counter()
    from camsim.camera.given_light import Unit
    from camsim.camera.sensor import Sensor
    from camsim.cli import outputs as outputs_of
    from camsim.cli.report import print_report
    from camsim.cli.take import as_json_of, compression_faults, odd_cfa_of, with_files
    from camsim.core.typed import known_name
    from camsim.files import save
    from camsim.files.atomic import together
    from camsim.files.light_file import read_light
    from camsim.spectra.light import Light

    files = _files(light)
    several = Path(light).is_dir()
    texts = [text for file in files for text in _named(outputs or (), file, several=several)]
    checked, errors = outputs_of.check(texts, force=force)
    errors += compression_faults(checked) if compress else []
    if errors:
        displayed = [str(error) for error in errors[:_MOST_FAULTS]]
        more = [f"… and {len(errors) - len(displayed)} more"] if len(errors) > len(displayed) else []
        raise CamsimError("\n".join([*displayed, *more]))
    known: Any = None if unit is None else known_name("unit", unit, get_args(Unit), "--as")
    body = Sensor.from_yaml(sensor, overrides=changes or (), sensors=sensors or ())
    if warning := odd_cfa_of(tuple(body.cfa.pattern), checked, allowed=allow_odd_cfa):
        print(f"camsim: warning: {warning}", file=sys.stderr)
    perfect = Light(illuminant, illuminance_lux=lux, at="sensor")
    each, nodes_nm = len(checked) // len(files), _wavelengths(wavelengths)
    exposure = _exposure(body, iso, time_s)
    look_in_new()
    stated: list[tuple[str, Frame, list[Output], dict[str, float]]] = []
    with together():
        for number, file in enumerate(files):
            image = read_light(file, unit=known, wavelength_nm=nodes_nm, per_photosite=per_photosite, layer=layer)
            mine = checked[number * each : (number + 1) * each]
            products: set[Product] = {output.product for output in mine}
            shot = body.shot(
                image, light=perfect, exposure=exposure(image.unit), seed=seed, frame_number=number, noise=not no_noise
            )
            frame = shot.frame(products=products)
            written_s = time.perf_counter()
            for output in mine:
                how = {"allow_odd_cfa": allow_odd_cfa, "compress": compress}
                save(frame, output.path, product=output.product, force=True, **how)
            seconds = {**frame.report.seconds, "write": time.perf_counter() - written_s}
            stated.append((file, _without_photosites(frame), mine, seconds))
    total_s, trees = time.perf_counter() - began_s, []
    for file, frame, mine, seconds in stated:
        frame = dataclasses.replace(frame, report=with_files(frame, mine))
        if not quiet and not several:
            print_report(frame, mine, seconds, total_s, verbose=False)
        elif not quiet:
            print(f"{file}: {', '.join(output.path for output in mine)}", file=sys.stderr)
            for note in frame.report.notes:
                print(f"  note: {note}", file=sys.stderr)
        trees.append(as_json_of(frame, mine, seconds, total_s))
    if as_json:
        print(json.dumps(trees if several else trees[0], indent=2, ensure_ascii=False))


def _without_photosites(frame: Frame) -> Frame:
    """Return a frame without its arrays, so that only one light of a folder is in memory."""
    import numpy as np

    none = np.empty((0, frame.shape[1]))
    return dataclasses.replace(
        frame, mosaic=none.astype(np.uint16), electrons=none, mean_electrons=none, truth=None,
        channel_index=none.astype(np.uint8), passed_rows=frame.shape[0],
    )  # fmt: skip


def _files(light: str) -> list[str]:
    """Return the files of light: one, or those of a folder by name."""
    from camsim.files.picture_samples import READERS

    if not Path(light).is_dir():
        return [light]
    found = sorted(path for path in Path(light).iterdir() if path.suffix.lower() in READERS and path.is_file())
    if not found:
        raise InputError(f"{light!r} holds no light; there are no files of the kinds {', '.join(READERS)}")
    return [str(path) for path in found]


def _named(outputs: Sequence[str], file: str, *, several: bool) -> list[str]:
    """Return the outputs of one light; of several, with the light's name before the suffix."""
    from camsim.files.naming import split_product

    name = Path(file).stem
    if not outputs:
        return [f"{name}.dng"]
    if not several:
        return list(outputs)
    parts = [(*os.path.splitext(path), product) for path, product in map(split_product, outputs)]
    return [f"{stem}-{name}{suffix}" + (f":{product}" if product else "") for stem, suffix, product in parts]


def _wavelengths(text: str | None) -> list[float] | None:
    """Return the wavelengths of ``400,410,420`` or ``400:700:10``, the last included."""
    if text is None:
        return None
    try:
        if ":" not in text:
            return [float(word) for word in text.split(",")]
        first, last, step = (float(word) for word in text.split(":"))
        count = (last - first) / step
        if not 0 < count < 10_000 or abs(count - round(count)) > 1e-9:
            raise ValueError
        return [first + step * number for number in range(round(count) + 1)]
    except (ValueError, ZeroDivisionError):
        message = f"must be wavelengths in nm such as 400,500,600 or 400:700:10 (a whole number of steps), not {text!r}"
        raise InvalidValueError(message, key="--wavelengths") from None


def _exposure(body: Sensor, iso: float | None, time_s: str | None) -> Callable[[Any], Exposure]:
    """Return a function from light to its exposure time and ISO."""
    from camsim.camera.sensor import usual_exposure
    from camsim.core.words import number_hint

    seconds: float | Literal["auto"] | None = None
    if time_s is not None and time_s != "auto":
        try:
            seconds = float(time_s)
        except ValueError:
            message = f"must be seconds or auto, not {time_s!r}{number_hint(time_s)}"
            raise InvalidValueError(message, key="--time") from None
    elif time_s is not None:
        seconds = "auto"
    return lambda unit: usual_exposure(body.adc.base_iso if iso is None else iso, unit, seconds)
