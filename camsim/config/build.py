"""Scene files to stages: with ``build_sensor`` the only modules that depend on both schema and stages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

from camsim.camera.camera import Camera
from camsim.camera.window import Region
from camsim.config import build_optics, build_picture, schema
from camsim.config.build_sensor import filters_at
from camsim.config.build_shapes import shape_at, spectrum_at
from camsim.config.lengths import SceneDocument
from camsim.config.tree import KeyPath
from camsim.config.validated import Validated
from camsim.optics import Lens
from camsim.scene import Picture, Scene, Shape
from camsim.sensor.exposure import Exposure
from camsim.sensor.falloff import Cos4Falloff, Falloff, RadialFalloff
from camsim.spectra import named
from camsim.spectra.curve import Curve, Spectrum
from camsim.spectra.light import Light

Progress: TypeAlias = Callable[[str, float], None]


@dataclass(frozen=True, kw_only=True)
class Mount:
    """The parts of a scene file in front of a sensor."""

    lens: Lens
    magnification: float
    filters: tuple[Spectrum, ...]
    falloff: Falloff | None
    veiling_glare: Spectrum

    def on(self, camera: Camera) -> Camera:
        """Return the camera with these parts in front of it; its own filters stay, behind the new ones."""
        return camera.replace(
            lens=self.lens,
            magnification=self.magnification,
            filters=(*self.filters, *camera.filters),
            falloff=self.falloff,
            veiling_glare=self.veiling_glare,
        )


def mount(scene: SceneDocument) -> Mount | None:
    """Make the lens of a scene file and everything mounted on it."""
    transmission = spectrum_at(scene, ("lens", "transmission"), names=False)
    filters = filters_at(scene, ("lens", "filters"))
    glare = spectrum_at(scene, ("lens", "veiling_glare"), names=False)
    table = scene.part(("lens",), schema.MountTable)
    if table is None or filters is None:
        return None
    whole = 1.0 if transmission is None else transmission
    lens = build_optics.lens(scene, table, whole)
    falloff = scene.build(("lens", "falloff"), lambda: _falloff(table.falloff))
    if lens is None or (table.falloff is not None and falloff is None):
        return None
    return Mount(
        lens=lens,
        magnification=table.magnification,
        filters=filters,
        falloff=falloff,
        veiling_glare=0.0 if glare is None else glare,
    )


def _falloff(table: schema.Cos4Falloff | schema.RadialFalloff | None) -> Falloff | None:
    if table is None:
        return None
    if isinstance(table, schema.Cos4Falloff):
        return Cos4Falloff(exit_pupil_mm=table.exit_pupil_mm)
    return RadialFalloff(radius_mm=tuple(table.radius_mm), values=tuple(table.values))


def light(scene: SceneDocument) -> Light | None:
    """Make the light of a scene file."""
    name = scene.value(("light", "illuminant"))
    if isinstance(name, str) and scene.build(("light", "illuminant"), lambda: named.illuminant(name)) is None:
        return None
    table = scene.part(("light",), schema.Light)
    if table is None or any(schema.Light.contradictions(scene.value(("light",)))):
        return None
    curve: Curve | None = None
    if (one := table.table) is not None:
        curve = scene.build(("light", "table"), lambda: Curve(tuple(one.wavelength_nm), tuple(one.values)))
        if curve is None:
            return None
    return scene.build(
        ("light",),
        lambda: Light(
            table.illuminant if curve is None else curve,
            line_nm=table.line_nm,
            width_nm=table.width_nm,
            blackbody_k=table.blackbody_k,
            illuminance_lux=table.illuminance_lux,
            irradiance_w_per_m2=table.irradiance_w_per_m2,
            luminance_cd_per_m2=table.luminance_cd_per_m2,
            at=table.at,
        ),
        keys={"spectrum": ("illuminant",) if curve is None else ("table",)},
    )


def exposure(scene: SceneDocument) -> Exposure | None:
    """Make the exposure of a scene file."""
    table = scene.part(("exposure",), schema.Exposure)
    if table is None:
        return None
    return scene.build(
        ("exposure",),
        lambda: Exposure(
            time_s=table.time_s, iso=table.iso, datetime=table.datetime, temperature_c=table.temperature_c
        ),
    )


def region(scene: Validated[Any], frame: schema.SensorFrame | None) -> Region | None:
    """Make the window of a scene file; it must be inside the sensor's frame (if known)."""
    table = scene.part(("region",), schema.Region) if scene.value(("region",)) is not None else None
    if table is None:
        return None
    for index, (key, size, most) in enumerate(
        (
            ("rows", table.rows, frame.rows if frame else table.rows),
            ("cols", table.cols, frame.cols if frame else table.cols),
        )
    ):
        if size > most:
            scene.refuse(("region", key), f"is {size}; the sensor has {most} {key}")
        elif table.origin is not None and frame is not None and table.origin[index] + size > most:
            last = table.origin[index] + size - 1
            scene.refuse(
                ("region", "origin"),
                f"puts the last of the {key} at {last}; the sensor's are 0 to {most - 1}",
            )
    return Region(rows=table.rows, cols=table.cols, origin=table.origin)


def scene_content(scene: SceneDocument, frame: schema.SensorFrame | None) -> Scene | None:
    """Make the scene; if the frame is unknown, only to find the scene's faults."""
    units_um = {"um": 1.0, "mm": 1000.0}
    if frame is not None:
        units_um |= {"pixel": frame.pitch_um, "frame": frame.rows * frame.pitch_um}
    unit_um = units_um.get(str(scene.value(("scene", "unit"))), 1.0)
    background = spectrum_at(scene, ("scene", "background", "reflectance"))
    tables = scene.value(("scene", "shapes"))
    shapes = [
        None if scene.full else _placed(scene, ("scene", "shapes", index), unit_um)
        for index in range(len(tables) if isinstance(tables, list) else 0)
    ]
    whole = [shape for shape in shapes if shape is not None]
    if background is None or len(whole) < len(shapes):
        return None
    return scene.build(("scene",), lambda: Scene(background=background, shapes=whole))


def _placed(scene: SceneDocument, path: KeyPath, unit_um: float) -> Shape | Picture | None:
    if isinstance(table := scene.value(path), dict) and table.get("kind") == "picture":
        return build_picture.picture(scene, path, unit_um)
    return shape_at(scene, path, unit_um)
