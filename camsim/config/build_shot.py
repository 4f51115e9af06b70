"""Files of captures without a lens (``lens: none``) to the light on a sensor."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any, TypeAlias

from camsim.camera.camera import Camera
from camsim.camera.given_light import GivenLight
from camsim.camera.sensor import Sensor, usual_exposure
from camsim.camera.shot import Shot
from camsim.config import build, library, schema
from camsim.config.validated import Validated
from camsim.sensor.exposure import Exposure
from camsim.spectra.light import Light

ShotDocument: TypeAlias = Validated[schema.ShotFile]


def shot(
    document: ShotDocument, camera: Camera | None, frame: schema.SensorFrame | None, seed: int | None
) -> Shot | None:
    """Make the light on a sensor; None if any part is wrong (the document has the faults)."""
    image, region = _image(document), build.region(document, frame)
    light, model = _light(document), document.model
    if model is None or camera is None or image is None or light is None or document.faults:
        return None
    sensor = Sensor(**{field.name: getattr(camera, field.name) for field in dataclasses.fields(Sensor)})
    return document.build(
        (),
        lambda: Shot(
            camera=sensor,
            image=image,
            light=light,
            exposure=_exposure(model.exposure, sensor, image),
            seed=model.noise.seed if seed is None else seed,
            frame_number=model.noise.frame_number,
            region=region,
            noise=model.noise.enabled,
            colour_matrix=model.files.colour_matrix,
        ),
        keys={
            **dict.fromkeys(("image", "samples", "unit", "wavelength_nm", "per_photosite"), ("light",)),
            **dict.fromkeys(("time_s", "iso"), ("exposure",)),
        },
    )


def _image(document: ShotDocument) -> GivenLight | None:
    table = document.part(("light",), schema.CustomLight)
    file = document.document.find(("light", "file"))
    if table is None or file is None:
        return None

    def read() -> GivenLight:
        from camsim.files.light_file import read_light

        # Paths in overrides are relative to the user's working directory.
        one = Path(table.file) if not file.place.line else library.in_folder(document.document.folder, table.file)
        return read_light(
            one,
            unit=table.unit,
            wavelength_nm=table.wavelength_nm,
            per_photosite=table.per_photosite,
            layer=table.layer,
        )

    return document.build(("light",), read)


def _light(document: ShotDocument) -> Light | None:
    table = document.part(("light",), schema.CustomLight)
    if table is None:
        return None
    return document.build(
        ("light",),
        lambda: Light(table.illuminant, illuminance_lux=table.illuminance_lux, at="sensor"),
        keys={"spectrum": ("illuminant",), "name": ("illuminant",)},
    )


def _exposure(table: schema.CustomExposure, sensor: Sensor, image: GivenLight) -> Exposure:
    usual = usual_exposure(sensor.adc.base_iso if table.iso is None else table.iso, image.unit, table.time_s)
    stated: dict[str, Any] = {"datetime": table.datetime, "temperature_c": table.temperature_c}
    return dataclasses.replace(usual, **stated)
