"""Schema to stages: the one place that knows both."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import TypeAlias

from camsim.camera import Camera, Region
from camsim.config import schema
from camsim.config.judged import Judged
from camsim.config.tree import KeyPath
from camsim.errors import InvalidValueError
from camsim.frame import Frame
from camsim.optics import Airy, FourSpotOlpf, SquarePhotosite
from camsim.scene import Disc, Polygon, Rectangle, Scene
from camsim.sensor.adc import Adc
from camsim.sensor.cfa import Cfa
from camsim.sensor.colour_matrix import MatrixOf
from camsim.sensor.exposure import Exposure
from camsim.sensor.noise import DarkCurrent, Dsnu, FullWell, Prnu, ReadNoise
from camsim.sensor.quantum_efficiency import QuantumEfficiency
from camsim.spectra import named
from camsim.spectra.curve import Curve, Spectrum
from camsim.spectra.light import Light

SceneDocument: TypeAlias = Judged[schema.SceneFile]
SensorDocument: TypeAlias = Judged[schema.SensorFile]
Progress: TypeAlias = Callable[[str, float], None]

# What a faulty spectrum counts as, so that its shape can still be looked at; nothing is rendered then.
_ANY_SPECTRUM = 0.5


@dataclass(frozen=True, kw_only=True)
class Setup:
    """A capture that is ready to be taken: everything ``Camera.expose`` needs."""

    name: str
    camera: Camera
    scene: Scene
    light: Light
    exposure: Exposure
    region: Region | None
    tolerance: float
    noise: bool
    seed: int
    colour_matrix: MatrixOf = "standard"

    @property
    def exposure_time_s(self) -> float:
        """The exposure time, found when it is "auto"."""
        return self.camera.exposure_time_s(self.light, self.exposure)

    def expose(self, *, products: Collection[str] = ("mosaic",), progress: Progress | None = None) -> Frame:
        """Take the picture."""
        return self.camera.expose(
            self.scene,
            light=self.light,
            exposure=self.exposure,
            seed=self.seed,
            region=self.region,
            products=products,
            tolerance=self.tolerance,
            noise=self.noise,
            colour_matrix=self.colour_matrix,
            scene_name=self.name,
            progress=progress,
        )


def camera(sensor: SensorDocument, lens: Airy | None) -> Camera | None:
    """Make the camera of a sensor file; None when a part of it is wrong (the document has the faults)."""
    cfa = _cfa(sensor)
    quantum_efficiency = _quantum_efficiency(sensor, cfa)
    readout = sensor.part(("readout",), schema.Readout)
    adc = None
    if readout is not None:
        adc = sensor.build(
            ("readout",),
            lambda: Adc(
                bit_depth=readout.bit_depth,
                black_level_dn=readout.black_level_dn,
                electrons_per_dn=readout.electrons_per_dn,
                base_iso=readout.base_iso,
            ),
        )
    model = sensor.model
    if model is None or lens is None or cfa is None or quantum_efficiency is None or adc is None:
        return None
    charge, read_noise_e = model.charge, model.readout.read_noise_e
    return sensor.build(
        (),
        lambda: Camera(
            name=model.name,
            serial=model.serial,
            rows=model.frame.rows,
            cols=model.frame.cols,
            pitch_um=model.frame.pitch_um,
            lens=lens,
            olpf=None if model.olpf is None else FourSpotOlpf(split_um=model.olpf.split_um),
            photosite=SquarePhotosite.from_fill_factor(
                pitch_um=model.frame.pitch_um, fill_factor=model.photosite.fill_factor
            ),
            cfa=cfa,
            quantum_efficiency=quantum_efficiency,
            prnu=None if charge.prnu is None else Prnu(charge.prnu),
            dark_current=(
                None if charge.dark_current_e_per_s is None else DarkCurrent(charge.dark_current_e_per_s)
            ),
            full_well=None if charge.full_well_e is None else FullWell(charge.full_well_e),
            dsnu=None if charge.dsnu_e is None else Dsnu(charge.dsnu_e),
            read_noise=None if read_noise_e is None else ReadNoise(read_noise_e),
            adc=adc,
        ),
    )


def lens(scene: SceneDocument) -> Airy | None:
    """Make the lens of a scene file."""
    transmission = _spectrum(scene, ("lens", "transmission"), names=False)
    table = scene.part(("lens",), schema.AiryLens)
    if table is None:
        return None
    whole = 1.0 if transmission is None else transmission
    return scene.build(("lens",), lambda: Airy(f_number=table.f_number, transmission=whole))


def light(scene: SceneDocument) -> Light | None:
    """Make the light of a scene file."""
    name = scene.value(("light", "illuminant"))
    if isinstance(name, str):
        scene.build(("light", "illuminant"), lambda: named.illuminant(name))
    table = scene.part(("light",), schema.Light)
    if table is None or (table.illuminant is None) == (table.line_nm is None):
        return None
    return scene.build(
        ("light",),
        lambda: Light(table.illuminant, line_nm=table.line_nm, illuminance_lux=table.illuminance_lux),
    )


def exposure(scene: SceneDocument) -> Exposure | None:
    """Make the exposure of a scene file."""
    table = scene.part(("exposure",), schema.Exposure)
    if table is None:
        return None
    return scene.build(
        ("exposure",), lambda: Exposure(time_s=table.time_s, iso=table.iso, datetime=table.datetime)
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
        _shape(scene, ("scene", "shapes", index), unit_um)
        for index in range(len(tables) if isinstance(tables, list) else 0)
    ]
    whole = [shape for shape in shapes if shape is not None]
    if background is None or len(whole) < len(shapes):
        return None
    return scene.build(("scene",), lambda: Scene(background=background, shapes=whole))


def _shape(scene: SceneDocument, path: KeyPath, unit_um: float) -> Polygon | Rectangle | Disc | None:
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
    except InvalidValueError:
        # The numbers of a message are to be those of the file: its unit, not µm.
        return scene.build(path, lambda: make(1.0)) and scene.build(path, lambda: make(unit_um))


def _spectrum(scene: SceneDocument, path: KeyPath, *, names: bool = True) -> Spectrum | None:
    """Make a reflectance (which may have a name) or a transmission of whatever stands at ``path``."""
    value = scene.value(path)
    if names and isinstance(value, str):
        return scene.build(path, lambda: named.reflectance(value))
    if isinstance(value, dict):
        table = scene.part(path, schema.Fractions)
        return None if table is None else scene.build(path, lambda: _curve(table))
    return float(value) if isinstance(value, int | float) else None


def _curve(table: schema.Curve | schema.Fractions, name: str = "") -> Curve:
    return Curve(tuple(table.wavelength_nm), tuple(table.values), name, table.outside)


def _cfa(sensor: SensorDocument) -> Cfa | None:
    bayer = sensor.part(("cfa",), schema.BayerCfa)
    if bayer is not None:
        return sensor.build(("cfa",), lambda: Cfa.bayer(bayer.pattern))
    return None if sensor.part(("cfa",), schema.MonoCfa) is None else Cfa.mono()


def _quantum_efficiency(sensor: SensorDocument, cfa: Cfa | None) -> QuantumEfficiency | None:
    path: KeyPath = ("quantum_efficiency",)
    curves = _curves(sensor, (*path, "curves"))
    if curves is None:
        return None
    if cfa is not None and (missing := [letter for letter in cfa.channels if letter not in curves]):
        there = ", ".join(curves)
        sensor.refuse((*path, "curves"), f"no curve for {', '.join(missing)} of the cfa; there are {there}")
        return None
    table = sensor.part(path, schema.QuantumEfficiency)
    if table is None:
        return None
    return sensor.build(
        path,
        lambda: QuantumEfficiency(tuple(curves.items()), table.per, table.peak, table.source or ""),
    )


def _curves(sensor: SensorDocument, path: KeyPath) -> dict[str, Curve] | None:
    """Make the curves by letter; None when one of them is wrong or none is there."""
    given = sensor.value(path)
    if isinstance(given, str):
        return sensor.build(path, lambda: named.sensitivities(given))
    if not isinstance(given, dict):
        return None
    curves = {letter: _letter_curve(sensor, (*path, letter)) for letter in given}
    whole = {letter: curve for letter, curve in curves.items() if curve is not None}
    return whole if whole and len(whole) == len(curves) else None


def _letter_curve(sensor: SensorDocument, path: KeyPath) -> Curve | None:
    table = sensor.part(path, schema.Curve)
    return None if table is None else sensor.build(path, lambda: _curve(table))
