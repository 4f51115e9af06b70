"""Scene files to stages: with ``build_sensor`` the one place that knows both schema and stages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from camsim.camera import Camera
from camsim.config import build_optics, build_picture, schema
from camsim.config.build_sensor import curve_of, filters_at
from camsim.config.judged import Judged
from camsim.config.tree import KeyPath
from camsim.errors import CamsimError
from camsim.optics import Lens
from camsim.scene import Disc, Picture, Polygon, Rectangle, Scene
from camsim.sensor.exposure import Exposure
from camsim.sensor.falloff import Cos4Falloff, Falloff, RadialFalloff
from camsim.spectra import named
from camsim.spectra.curve import Curve, Spectrum
from camsim.spectra.light import Light
from camsim.window import Region

SceneDocument: TypeAlias = Judged[schema.SceneFile]
Progress: TypeAlias = Callable[[str, float], None]

# What a faulty spectrum counts as, so that its shape can still be looked at; nothing is rendered then.
_ANY_SPECTRUM = 0.5

# Lengths of a shape, which a file gives in the scene's unit.
_LENGTHS: dict[str, KeyPath] = {f"{key}_um": (key,) for key in ("points", "width", "height", "centre", "radius")}


@dataclass(frozen=True, kw_only=True)
class Mount:
    """What a scene file puts in front of a sensor."""

    lens: Lens
    magnification: float
    filters: tuple[Spectrum, ...]
    falloff: Falloff | None

    def on(self, camera: Camera) -> Camera:
        """Return the camera with this in front of it; its own filters stay, behind these."""
        return camera.replace(
            lens=self.lens,
            magnification=self.magnification,
            filters=(*self.filters, *camera.filters),
            falloff=self.falloff,
        )


def mount(scene: SceneDocument) -> Mount | None:
    """Make the lens of a scene file and everything that is on it."""
    transmission = _spectrum(scene, ("lens", "transmission"), names=False)
    filters = filters_at(scene, ("lens", "filters"))
    table = scene.part(("lens",), schema.LensTable)
    if table is None or filters is None:
        return None
    whole = 1.0 if transmission is None else transmission
    lens = build_optics.lens(scene, table, whole)
    falloff = scene.build(("lens", "falloff"), lambda: _falloff(table.falloff))
    if lens is None or (table.falloff is not None and falloff is None):
        return None
    return Mount(lens=lens, magnification=table.magnification, filters=filters, falloff=falloff)


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
    if (own := table.table) is not None:
        curve = scene.build(("light", "table"), lambda: Curve(tuple(own.wavelength_nm), tuple(own.values)))
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


def region(scene: SceneDocument, frame: schema.SensorFrame | None) -> Region | None:
    """Make the window of a scene file; it must lie inside the sensor's frame (when that is known)."""
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


def scene_content(scene: SceneDocument, pitch_um: float | None) -> Scene | None:
    """Make what is in front of the camera; without a known pitch only to find its faults."""
    unit_um = {"pixel": pitch_um, "um": 1.0, "mm": 1000.0}.get(str(scene.value(("scene", "unit")))) or 1.0
    background = _spectrum(scene, ("scene", "background", "reflectance"))
    tables = scene.value(("scene", "shapes"))
    shapes = [
        None if scene.full else _shape(scene, ("scene", "shapes", index), unit_um)
        for index in range(len(tables) if isinstance(tables, list) else 0)
    ]
    whole = [shape for shape in shapes if shape is not None]
    if background is None or len(whole) < len(shapes):
        return None
    return scene.build(("scene",), lambda: Scene(background=background, shapes=whole))


def _shape(scene: SceneDocument, path: KeyPath, unit_um: float) -> Polygon | Rectangle | Disc | Picture | None:
    if (scene.value(path) or {}).get("kind") == "picture":
        return build_picture.picture(scene, path, unit_um)
    reflectance = _spectrum(scene, (*path, "reflectance"))
    spectrum = _ANY_SPECTRUM if reflectance is None else reflectance
    table = scene.part(path, schema.Table)

    def make(scale: float) -> Polygon | Rectangle | Disc | None:
        if isinstance(table, schema.Polygon):
            points_um = tuple((x * scale, y * scale) for x, y in table.points)
            return Polygon(points_um=points_um, reflectance=spectrum)
        if isinstance(table, schema.Rectangle):
            return Rectangle(
                width_um=table.width * scale,
                height_um=table.height * scale,
                centre_um=(table.centre[0] * scale, table.centre[1] * scale),
                rotate_deg=table.rotate_deg,
                reflectance=spectrum,
            )
        if isinstance(table, schema.Disc):
            centre_um = (table.centre[0] * scale, table.centre[1] * scale)
            return Disc(radius_um=table.radius * scale, centre_um=centre_um, reflectance=spectrum)
        return None

    try:
        return make(unit_um)
    except CamsimError:
        # The numbers of a message are to be those of the file: its unit, not µm.
        in_its_unit = scene.build(path, lambda: make(1.0), keys=_LENGTHS)
        return in_its_unit and scene.build(path, lambda: make(unit_um), keys=_LENGTHS)


def _spectrum(scene: SceneDocument, path: KeyPath, *, names: bool = True) -> Spectrum | None:
    """Make a reflectance (which may have a name) or a transmission of whatever stands at ``path``."""
    value = scene.value(path)
    if names and isinstance(value, str):
        return scene.build(path, lambda: named.reflectance(value))
    if isinstance(value, dict):
        table = scene.part(path, schema.Fractions)
        return None if table is None else scene.build(path, lambda: curve_of(table))
    return float(value) if isinstance(value, int | float) else None
