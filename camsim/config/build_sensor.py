"""Sensor files to a camera: with ``build`` the conversion of the schema's tables to stages."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from camsim.camera.camera import Camera
from camsim.config import build_optics, schema
from camsim.config.tree import KeyPath
from camsim.config.validated import Validated
from camsim.errors import InputError
from camsim.optics import Lens
from camsim.sensor.adc import Adc
from camsim.sensor.cfa import GREENS, Cfa
from camsim.sensor.measured_matrix import MeasuredMatrix
from camsim.sensor.quantum_efficiency import QuantumEfficiency
from camsim.spectra import named
from camsim.spectra.curve import Curve, Spectrum

SensorDocument: TypeAlias = Validated[schema.SensorFile]


_VALIDATED_TOGETHER = (("charge", "defects"), ("charge", "dark_frames"), ("readout", "dual_gain"))
"""Tables and keys that the camera validates together with other parts."""


def camera(sensor: SensorDocument, lens: Lens | None) -> Camera | None:
    """Make the camera of a sensor file; None when a part of it is wrong (the document has the faults)."""
    cfa = _cfa(sensor)
    quantum_efficiency = _quantum_efficiency(sensor, cfa)
    filters, photosite = filters_at(sensor, ("filters",)), build_optics.photosite(sensor)
    olpf, adc = build_optics.olpf(sensor), _adc(sensor)
    matrices = _colour_matrices(sensor)
    charge, readout = _stages(sensor, "charge", schema.Charge), _stages(sensor, "readout", schema.Readout)
    model = sensor.model
    if model is None or lens is None or cfa is None or quantum_efficiency is None or adc is None:
        return None
    if filters is None or matrices is None or photosite is None or charge is None or readout is None:
        return None
    return sensor.build(
        (),
        lambda: Camera(
            name=model.name,
            serial=model.serial,
            rows=model.frame.rows,
            cols=model.frame.cols,
            pitch_um=model.frame.pitch_um,
            lens=lens,
            olpf=olpf,
            photosite=photosite,
            cfa=cfa,
            quantum_efficiency=quantum_efficiency,
            colour_matrices=matrices,
            filters=filters,
            adc=adc,
            **charge,
            **readout,
        ),
        keys={name: (table, name) for table, name in _VALIDATED_TOGETHER},
    )


def _colour_matrices(sensor: SensorDocument) -> tuple[MeasuredMatrix, ...] | None:
    """Make the measured matrices; None when one of them is wrong."""
    given = sensor.value(("colour_matrices",))
    made = [_colour_matrix(sensor, index) for index in range(len(given) if isinstance(given, list) else 0)]
    whole = tuple(matrix for matrix in made if matrix is not None)
    return whole if len(whole) == len(made) else None


def _colour_matrix(sensor: SensorDocument, index: int) -> MeasuredMatrix | None:
    path: KeyPath = ("colour_matrices", index)
    table = sensor.part(path, schema.MeasuredMatrix)
    if table is None:
        return None
    return sensor.build(
        path,
        lambda: MeasuredMatrix(light=table.light, white_xyz=table.white_xyz, camera_to_xyz=table.camera_to_xyz),
    )


def filters_at(document: Validated[Any], path: KeyPath) -> tuple[Spectrum, ...] | None:
    """Make the list of filters at ``path``; None when one of them is wrong."""
    given = document.value(path)
    made = [_filter(document, (*path, index)) for index in range(len(given) if isinstance(given, list) else 0)]
    whole = tuple(spectrum for spectrum in made if spectrum is not None)
    return whole if len(whole) == len(made) else None


def _filter(document: Validated[Any], path: KeyPath) -> Spectrum | None:
    value = document.value(path)
    if isinstance(value, dict):
        table = document.part(path, schema.FilterCurve)
        return None if table is None else document.build(path, lambda: curve_of(table))
    return float(value) if isinstance(value, int | float) else None


def curve_of(table: schema.Curve | schema.Fractions | schema.FilterCurve) -> Curve:
    """Make the curve of a table of points."""
    return Curve(table.wavelength_nm, table.values, "", table.outside)


def _adc(sensor: SensorDocument) -> Adc | None:
    readout = sensor.part(("readout",), schema.Readout)
    if readout is None:
        return None
    curve = readout.companding
    if curve and len(curve.codes) != len(curve.linear_dn):
        message = f"{len(curve.codes)} of them for {len(curve.linear_dn)} linear_dn; give one for each"
        sensor.refuse(("readout", "companding", "codes"), message)
        return None
    return sensor.build(
        ("readout",),
        lambda: Adc(
            bit_depth=readout.bit_depth,
            black_level_dn=readout.black_level_dn,
            black_offsets_dn=tuple(tuple(row) for row in readout.black_offsets_dn or [[0]]),
            electrons_per_dn=readout.electrons_per_dn,
            base_iso=readout.base_iso,
            gain_at_iso=tuple((each.iso, each.electrons_per_dn) for each in readout.gain_at_iso),
            code_step_dn=readout.code_step_dn,
            companding=tuple(zip(curve.linear_dn, curve.codes, strict=True)) if curve else (),
        ),
    )


def _stages(sensor: SensorDocument, key: str, kind: type[schema.Table]) -> Mapping[str, Any] | None:
    """Make the stages of a table by the camera's names, as its keys say; None when one of them is wrong."""
    if sensor.value((key,)) is None:
        return {}
    table = sensor.part((key,), kind)
    if table is None:
        return None
    made = {}
    for name, field in kind.model_fields.items():
        for makes in (mark for mark in field.metadata if isinstance(mark, schema.Makes)):
            made[makes.field] = _stage(sensor, key, table, (name, *makes.also), makes)
    return made


def _stage(sensor: SensorDocument, key: str, table: schema.Table, names: Sequence[str], makes: schema.Makes) -> Any:
    """Make a stage of the keys of a table; None if its main key, the first one, is empty."""
    values = [getattr(table, name) for name in names]
    if values[0] is None:
        return None
    if makes.reads is not None:
        named = (key, names[0], *makes.reads)
        return sensor.build((key, names[0]), lambda: makes.make(*values, _named_file(sensor, named)))
    if not dataclasses.is_dataclass(makes.make):
        return sensor.build((key, names[0]), lambda: makes.make(*values))
    parameters = [field.name for field in dataclasses.fields(makes.make)]
    keys: dict[str, KeyPath] = {parameter: (name,) for parameter, name in zip(parameters, names, strict=False)}
    return sensor.build((key,), lambda: makes.make(*values), keys=keys)


def _named_file(sensor: SensorDocument, path: KeyPath) -> Path | None:
    """Return the path in a key: under the sensor file's folder, or for an override relative to the working directory.

    None if there is no path.
    """
    name, folder = sensor.value(path), sensor.document.folder
    if not isinstance(name, str):
        return None
    node = sensor.document.find(path)
    if node is None or not node.place.line:
        return Path(name)
    if not (folder / name).resolve().is_relative_to(folder.resolve()):
        raise InputError(f"{name!r} lies outside this file's folder; put it there", key=str(path[-1]))
    return folder / name


def _cfa(sensor: SensorDocument) -> Cfa | None:
    path: KeyPath = ("cfa",)
    table = sensor.part(path, schema.Table)
    return None if table is None else sensor.build(path, lambda: _array(table))


def _array(table: schema.Table) -> Cfa:
    if isinstance(table, schema.BayerCfa):
        return Cfa.bayer(table.pattern)
    if isinstance(table, schema.QuadBayerCfa):
        return Cfa.quad_bayer(table.pattern, table.group)
    if isinstance(table, schema.NamedCfa):
        return Cfa.named(table.kind)
    assert isinstance(table, schema.LetterCfa)
    return Cfa(tuple(table.pattern))


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
    """Make the curves by letter; None if one of them is wrong or there are none."""
    given = sensor.value(path)
    if isinstance(given, str):
        return sensor.build(path, lambda: named.sensitivities(given))
    if not isinstance(given, dict):
        return None
    curves = {GREENS.get(letter, letter): _letter_curve(sensor, (*path, letter)) for letter in given}
    if len(curves) < len(given):
        sensor.refuse(path, "has G beside Gr, or g beside Gb, which are one; leave one of them out")
        return None
    whole = {letter: curve for letter, curve in curves.items() if curve is not None}
    return whole if whole and len(whole) == len(curves) else None


def _letter_curve(sensor: SensorDocument, path: KeyPath) -> Curve | None:
    table = sensor.part(path, schema.Curve)
    return None if table is None else sensor.build(path, lambda: curve_of(table))
